"""The picture behind the idea (Kim & Ko 2007, figure 1): frames as a cloud, and where the shapes point in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from engine.mesh import FloatArray
from widgets import theme
from widgets.basis.words import BASES, ROLES, pen_of
from widgets.canvases.cloud import PLANES, START, Arrow, CloudCanvas
from widgets.parts import picture
from widgets.parts.section import ShyLabel
from widgets.parts.segments import Segments

SOLID = "3-D"


class CloudPanel(QWidget):
    """Frames as points over the first axes, with the directions of shapes.

    Signals
    -------
    frame_chosen(int)
        The frame clicked, from 0.
    """

    frame_chosen = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.canvas = CloudCanvas(
            "The frames of the performance appear here as a cloud, and in it the directions of the shapes."
        )
        self.view = Segments([(SOLID, SOLID), *((key, key) for key in PLANES)], name="Axes shown")
        for key in PLANES:
            self.view.set_tip(key, f"The plane of the axes {key.replace(' · ', ' and ')}")
        self.view.set_tip(SOLID, "Three axes, to be turned by hand")
        self._directions: dict[str, FloatArray] = {}
        self._names: tuple[str, ...] = ()
        self._origin = np.zeros(3)
        self._current: str | None = None
        row = QHBoxLayout()
        row.setContentsMargins(8, 4, 8, 4)
        row.setSpacing(8)
        row.addWidget(self.view)
        row.addWidget(ShyLabel("mm, summed over the face", theme.TABLE_PX), 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(row)
        column.addWidget(self.canvas, 1)
        self.view.chosen.connect(self._look)
        self.canvas.turned.connect(lambda: self.view.set_current(SOLID))
        self.canvas.point_chosen.connect(self.frame_chosen)
        theme.signals.changed.connect(self._show)
        ready = lambda: "" if self.canvas.points is not None else "there is no basis yet"  # noqa: E731
        picture.offer(self.canvas, "cloud", "cloud of the frames", ready=ready)

    def set_cloud(self, points: FloatArray | None, frames: FloatArray | None = None) -> None:
        """Show coordinates (F, k) mm of frames on the first axes; ``frames`` (F,) are their numbers, 0.. without."""
        self.canvas.set_points(points, frames)

    def set_directions(
        self, directions: Mapping[str, FloatArray], names: Sequence[str] = (), origin: FloatArray | None = None
    ) -> None:
        """Show where shapes point.

        Parameters
        ----------
        directions : mapping of str to (n, k) float
            Basis -> coordinates on the axes, mm. Rows of ``hand`` and ``quasi_eigen`` are the shapes, rows of ``pca``
            one standard deviation along each axis.
        names : sequence of str
            Of the shapes.
        origin : (k,) float, optional
            Coordinates of the neutral face, where the shapes begin; the mean of the frames without.
        """
        self._directions = {key: _three(rows) for key, rows in directions.items()}
        self._names = tuple(names)
        self._origin = np.zeros(3) if origin is None else _three(np.asarray(origin)[None])[0]
        self._show()

    def set_current(self, name: str | None) -> None:
        """Single out a shape; the others are dimmed."""
        self._current = name
        self._show()

    def set_frame(self, frame: int) -> None:
        """Ring a frame, from 0."""
        self.canvas.set_ring(frame)

    def _look(self, key: str) -> None:
        self.canvas.look(*PLANES.get(key, START))

    def _show(self) -> None:
        arrows = []
        singled = self._current in self._names
        for basis in ("pca", "hand", "quasi_eigen"):
            for k, tip in enumerate(self._directions.get(basis, ())):
                if basis == "pca":
                    if k < 3:
                        arrows.append(Arrow(f"axis {k + 1}", np.zeros(3), tip, ROLES[basis], dashed=True))
                    continue
                name = self._names[k] if k < len(self._names) else str(k + 1)
                arrows.append(Arrow(name, self._origin, tip, ROLES[basis], faint=name != self._current and singled))
        known = [basis for basis in BASES if basis in self._directions]
        words = {**BASES, "pca": "PCA, 1 std. dev."}
        self.canvas.set_arrows(arrows, [(words[basis], pen_of(basis)) for basis in known])

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(theme.px(296), theme.px(280))

    def minimumSizeHint(self) -> QSize:
        """Return the least that can be turned."""
        return QSize(theme.px(232), theme.px(32 + 72))


def _three(rows: FloatArray) -> FloatArray:
    made = np.zeros((len(rows), 3))
    made[:, : min(3, np.shape(rows)[1])] = np.asarray(rows)[:, :3]
    return made
