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

SOLID, OUTSIDE = "3-D", "outside"


class CloudPanel(QWidget):
    """Frames as points over the first axes, with the directions of shapes.

    The view ``outside`` is that of figure 1: the ground is the plane of the first two axes, the height is what no axis
    holds. A hand shape rises from the ground, and its quasi-eigen shape is its shadow.

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
        keys = (SOLID, *PLANES, OUTSIDE)
        self.view = Segments([(key, key) for key in keys], name="Axes shown")
        for key in PLANES:
            self.view.set_tip(key, f"The plane of the axes {key.replace(' · ', ' and ')}")
        self.view.set_tip(SOLID, "Three axes, to be turned by hand")
        self.view.set_tip(OUTSIDE, "Axes 1 and 2, and upwards what no axis holds (Kim & Ko 2007, figure 1)")
        self._points: FloatArray | None = None
        self._frames: FloatArray | None = None
        self._points_outside: FloatArray | None = None
        self._directions: dict[str, FloatArray] = {}
        self._outside: FloatArray | None = None
        self._names: tuple[str, ...] = ()
        self._origin = np.zeros(3)
        self._current: str | None = None
        row = QHBoxLayout()
        row.setContentsMargins(8, 4, 8, 4)
        row.setSpacing(8)
        row.addWidget(self.view)
        row.addWidget(ShyLabel("mm over all vertices", theme.TABLE_PX), 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(row)
        column.addWidget(self.canvas, 1)
        self.view.chosen.connect(self._look)
        self.canvas.turned.connect(self._turned)
        self.canvas.point_chosen.connect(self.frame_chosen)
        theme.signals.changed.connect(self._show)
        ready = lambda: "" if self.canvas.points is not None else "there is no basis yet"  # noqa: E731
        picture.offer(self.canvas, "cloud", "cloud of the frames", ready=ready)
        self._allow()

    def set_cloud(
        self, points: FloatArray | None, frames: FloatArray | None = None, outside: FloatArray | None = None
    ) -> None:
        """Show frames.

        Parameters
        ----------
        points : (F, k) float, or None
            Coordinates on the first axes, mm.
        frames : (F,) float, optional
            Their numbers; 0.. without.
        outside : (F,) float, optional
            How far each frame lies from all axes, mm; 0 without.
        """
        self._points, self._frames, self._points_outside = points, frames, outside
        self._show_points()

    def set_directions(
        self,
        directions: Mapping[str, FloatArray],
        names: Sequence[str] = (),
        origin: FloatArray | None = None,
        outside: FloatArray | None = None,
    ) -> None:
        """Show where shapes point.

        Parameters
        ----------
        directions : mapping of str to (n, k) float
            Basis -> coordinates on the axes, mm. Rows of ``hand`` and ``quasi_eigen`` are the shapes, rows of ``pca``
            one standard deviation along each axis. Without ``hand`` the hand shapes have the coordinates of the
            quasi-eigen ones, which is what projecting means.
        names : sequence of str
            Of the shapes.
        origin : (k,) float, optional
            Coordinates of the neutral face, where the shapes begin; the mean of the frames without.
        outside : (n,) float, optional
            How far each hand shape lies from all axes, mm: the length of its residual.
        """
        self._directions = {key: _three(rows) for key, rows in directions.items()}
        self._names, self._outside = tuple(names), outside
        self._origin = np.zeros(3) if origin is None else _three(np.asarray(origin)[None])[0]
        self._allow()
        self._show()

    def set_current(self, name: str | None) -> None:
        """Single out a shape; the others are dimmed."""
        self._current = name
        self._show()

    def set_frame(self, frame: int) -> None:
        """Ring a frame, from 0."""
        self.canvas.set_ring(frame)

    @property
    def _is_outside(self) -> bool:
        return self.view.current == OUTSIDE

    def _allow(self) -> None:
        self.view.set_available(OUTSIDE, self._outside is not None, "what lies outside the axes is not known yet")
        if self._outside is None and self._is_outside:
            self.view.set_current(SOLID)
            self._look(SOLID)

    def _look(self, key: str) -> None:
        names = ("axis 1", "outside", "axis 2") if key == OUTSIDE else ("axis 1", "axis 2", "axis 3")
        if names != self.canvas.names:
            self.canvas.set_names(*names)
            self._show_points()
            self._show()
        self.canvas.look(*PLANES.get(key, START))

    def _turned(self) -> None:
        if not self._is_outside:
            self.view.set_current(SOLID)

    def _show_points(self) -> None:
        points = self._points
        if points is not None and self._is_outside:
            out = np.zeros(len(points)) if self._points_outside is None else np.asarray(self._points_outside)
            flat = _three(points)
            points = np.stack([flat[:, 0], out, flat[:, 1]], axis=1)
        self.canvas.set_points(points, self._frames)

    def _placed(self, row: FloatArray, outside: float = 0.0) -> FloatArray:
        return np.array([row[0], outside, row[1]]) if self._is_outside else row

    def _show(self) -> None:
        arrows: list[Arrow] = []
        singled = self._current in self._names
        known = dict(self._directions)
        if self._is_outside and "hand" not in known and "quasi_eigen" in known:
            known["hand"] = known["quasi_eigen"]
        tail = self._placed(self._origin)
        for k, tip in enumerate(known.get("pca", ())[: 2 if self._is_outside else 3]):
            arrows.append(Arrow(f"axis {k + 1}", np.zeros(3), self._placed(tip), ROLES["pca"], dashed=True))
        for basis in ("hand", "quasi_eigen"):
            for k, row in enumerate(known.get(basis, ())):
                name = self._names[k] if k < len(self._names) else str(k + 1)
                out = float(self._outside[k]) if basis == "hand" and self._outside is not None else 0.0
                faint = name != self._current and singled
                arrows.append(Arrow(name, tail, self._placed(row, out), ROLES[basis], faint=faint))
        words = {**BASES, "pca": "PCA, 1 std. dev."}
        self.canvas.set_arrows(arrows, [(words[basis], pen_of(basis)) for basis in BASES if basis in known])

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(theme.px(296), theme.px(280))

    def minimumSizeHint(self) -> QSize:
        """Return the least that can be turned."""
        return QSize(theme.px(232), theme.px(44))


def _three(rows: FloatArray) -> FloatArray:
    made = np.zeros((len(rows), 3))
    made[:, : min(3, np.shape(rows)[1])] = np.asarray(rows)[:, :3]
    return made
