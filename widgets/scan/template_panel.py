"""Which point comes next: a diagram of the template, the point's name and hint, and what can be done with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from PySide6.QtCore import QEvent, QLineF, QPointF, QSize, Qt, Signal
from PySide6.QtGui import QHelpEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QToolTip, QVBoxLayout, QWidget

from engine.landmarks import Landmark, LandmarkScheme, LandmarkSet, LandmarkState, Side
from engine.mesh import FloatArray, IntArray
from widgets import theme
from widgets.parts import picture
from widgets.parts.buttons import CopyButton, KeyButton
from widgets.parts.glyphs import Legend, draw_current, draw_landmark
from widgets.parts.section import DimLabel


class TemplateDiagram(QWidget):
    """The template drawn flat, its fiducials by state, the next one ringed.

    Signals
    -------
    selected(str)
        A fiducial was clicked.
    """

    selected = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("Diagram of the template")
        picture.offer(self, "template", "template diagram")
        self.setMinimumSize(100, 100)
        self.setMouseTracking(True)
        self._edges = np.zeros((0, 2), dtype=np.int64)
        self._vertices = np.zeros((0, 2))
        self._fiducials: dict[str, int] = {}
        self._scheme: LandmarkScheme | None = None
        self._landmarks = LandmarkSet({})
        self._current: str | None = None
        theme.signals.changed.connect(self.update)

    def set_template(self, edges: IntArray, vertices: FloatArray, fiducials: Mapping[str, int]) -> None:
        """Draw edges (E, 2) between vertices (V, 2), y down; ``fiducials`` names vertices."""
        self._edges, self._vertices = np.asarray(edges), np.asarray(vertices, dtype=np.float64)
        self._fiducials = dict(fiducials)
        self.update()

    def set_scheme(self, scheme: LandmarkScheme | None) -> None:
        """Take the scheme: it tells the sides."""
        self._scheme = scheme
        self.update()

    def set_landmarks(self, landmarks: LandmarkSet) -> None:
        """Show how far each fiducial is."""
        self._landmarks = landmarks
        self.update()

    def set_current(self, name: str | None) -> None:
        """Ring a fiducial."""
        self._current = name
        self.update()

    def place(self, name: str) -> QPointF:
        """Return where a fiducial is drawn, pixels of this widget."""
        return QPointF(*self._points()[self._fiducials[name]].tolist())

    def vertex(self, name: str | None) -> int | None:
        """Return the template's vertex that carries a fiducial."""
        return None if name is None else self._fiducials.get(name)

    def _points(self) -> FloatArray:
        low, high = self._vertices.min(axis=0), self._vertices.max(axis=0)
        room = np.array([self.width() - 12, self.height() - 12], dtype=np.float64)
        scale = float((room / np.maximum(high - low, 1e-9)).min())
        centre = np.array([self.width(), self.height()]) / 2
        return np.asarray((self._vertices - (low + high) / 2) * scale + centre)

    def _at(self, position: QPointF) -> str | None:
        if not len(self._vertices):
            return None
        reach = {name: (self.place(name) - position).manhattanLength() for name in self._names()}
        name = min(reach, key=reach.__getitem__, default=None)
        return name if name is not None and reach[name] < 10 else None

    def _names(self) -> tuple[str, ...]:
        return () if self._scheme is None else tuple(n for n in self._scheme.names if n in self._fiducials)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Choose a fiducial."""
        name = self._at(event.position())
        if event.button() == Qt.MouseButton.LeftButton and name is not None:
            self.selected.emit(name)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Show what can be clicked."""
        over = self._at(event.position())
        self.setCursor(Qt.CursorShape.PointingHandCursor if over else Qt.CursorShape.ArrowCursor)

    def event(self, event: QEvent) -> bool:
        """Name the fiducial under the mouse."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            name = self._at(QPointF(event.pos()))
            QToolTip.showText(event.globalPos(), f"{name}, vertex {self.vertex(name)}" if name else "", self)
            return True
        return super().event(event)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(208, 206)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the lines, then the fiducials."""
        if not len(self._vertices):
            return
        current = theme.current()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        points = self._points()
        painter.setPen(QPen(current.colour("dim", 0.45 if current.is_dark else 0.6), 0.8))
        painter.drawLines([QLineF(*line) for line in points[self._edges].reshape(-1, 4).tolist()])
        for name in self._names():
            assert self._scheme is not None
            side, point = self._scheme[name].side, self._landmarks[name]
            radius = (3.9 if point.state is LandmarkState.PROPOSED else 3.2) * theme.px(20) / 20
            draw_landmark(painter, self.place(name), point, side, palette=current, radius=radius, rim=False)
        if self._current in self._names():
            draw_current(painter, self.place(str(self._current)), palette=current, radius=0.4 * theme.px(20))


class TemplatePanel(QWidget):
    """The diagram, and beside it the next fiducial with its hint and buttons.

    Signals
    -------
    selected(str)
        A fiducial of the diagram was clicked.
    confirm_requested(str), skip_requested(str)
        The current fiducial is right where it is, or cannot be seen.
    confirm_all_requested()
        All proposed fiducials are right.
    """

    selected = Signal(str)
    confirm_requested = Signal(str)
    skip_requested = Signal(str)
    confirm_all_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.diagram = TemplateDiagram()
        self.step_label = DimLabel("", theme.TABLE_PX)
        self.name_label = DimLabel("", theme.NAME_PX, role="text", bold=True)
        self.vertex_button = CopyButton("Copy the number of the template's vertex")
        self.hint_label = DimLabel("")
        self.hint_label.setWordWrap(True)
        self.hint_label.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.hint_label.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)
        self.confirm_button = KeyButton("Confirm", "Enter", primary=True)
        self.skip_button = KeyButton("Skip", "S")
        self.confirm_all_button = KeyButton("Confirm all", "Shift+Enter")
        self._scheme: LandmarkScheme | None = None
        self._landmarks = LandmarkSet({})
        self._current: str | None = None
        self._arrange()
        self.diagram.selected.connect(self.selected)
        self.confirm_button.clicked.connect(lambda: self._current and self.confirm_requested.emit(self._current))
        self.skip_button.clicked.connect(lambda: self._current and self.skip_requested.emit(self._current))
        self.confirm_all_button.clicked.connect(self.confirm_all_requested)
        self._show()

    def _arrange(self) -> None:
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 0, 8, 8)
        row.setSpacing(8)
        row.addWidget(self.diagram, 45)
        side = QWidget()
        text = QVBoxLayout(side)
        text.setContentsMargins(0, 13, 0, 4)
        text.setSpacing(0)
        text.addWidget(self.step_label)
        text.addSpacing(3)
        self._line(text, (self.name_label, self.vertex_button), 8)
        text.addSpacing(4)
        text.addWidget(self.hint_label, 1)
        self._line(text, (self.confirm_button, self.skip_button), 4)
        text.addSpacing(8)
        self._line(text, (self.confirm_all_button,), 4)
        text.addSpacing(12)
        self._legends = _legends()
        self._line(text, self._legends, 10)
        row.addWidget(side, 50)

    @staticmethod
    def _line(column: QVBoxLayout, widgets: Sequence[QWidget], spacing: int) -> None:
        line = QHBoxLayout()
        column.addLayout(line)
        line.setSpacing(spacing)
        for widget in widgets:
            line.addWidget(widget)
        line.addStretch(1)

    def set_template(self, edges: IntArray, vertices: FloatArray, fiducials: Mapping[str, int]) -> None:
        """Draw edges (E, 2) between vertices (V, 2) in template units, y down; ``fiducials`` names vertices."""
        self.diagram.set_template(edges, vertices, fiducials)
        self._show()

    def set_scheme(self, scheme: LandmarkScheme | None) -> None:
        """Take the scheme: names, sides and hints."""
        self._scheme = scheme
        self.diagram.set_scheme(scheme)
        self._show()

    def set_landmarks(self, landmarks: LandmarkSet) -> None:
        """Show how far each fiducial is."""
        self._landmarks = landmarks
        self.diagram.set_landmarks(landmarks)
        self._show()

    def set_current(self, name: str | None) -> None:
        """Show which fiducial's turn it is."""
        self._current = name
        self.diagram.set_current(name)
        self._show()

    def _show(self) -> None:
        names = () if self._scheme is None else self._scheme.names
        proposed = self._landmarks.names(LandmarkState.PROPOSED, order=names)
        known = self._scheme is not None and self._current in self._scheme
        self.step_label.setText(self._step(names, proposed))
        vertex = self.diagram.vertex(self._current) if known else None
        self.vertex_button.set_value("vertex", "" if vertex is None else str(vertex))
        if known:
            assert self._scheme is not None
            self.name_label.setText(str(self._current))
            self.hint_label.setText(self._scheme[str(self._current)].hint)
        else:
            self.name_label.setText(self._heading(names)[0])
            self.hint_label.setText(self._heading(names)[1])
        point = self._landmarks[str(self._current)] if known else Landmark()
        if not known:
            reason = "No fiducial is chosen; press N for the next one"
        elif point.state is LandmarkState.PROPOSED:
            reason = ""
        elif point.state is LandmarkState.PLACED:
            reason = "It is placed already; press N for the next one"
        else:
            reason = "It has no place yet: click it in the picture"
        self.confirm_button.set_available(not reason, reason)
        can_skip = known and not point.locked and point.state is not LandmarkState.SKIPPED
        why = "It is locked" if point.locked else "It is skipped already" if known else "No fiducial is chosen"
        self.skip_button.set_available(can_skip, why)
        self.confirm_all_button.setText(f"Confirm all {len(proposed)}" if proposed else "Confirm all")
        self.confirm_all_button.updateGeometry()
        self.confirm_all_button.set_available(bool(proposed), "Nothing is proposed; place five points and the rest is")

    def _heading(self, names: tuple[str, ...]) -> tuple[str, str]:
        if not names:
            return "No scan chosen", "Add a scan, or choose one in the list."
        if self._landmarks.next_unfinished(names) is not None:
            return "No fiducial chosen", "Press N for the next one."
        skipped = len(self._landmarks.names(LandmarkState.SKIPPED, order=names))
        done = f"{len(names) - skipped} placed, {skipped} skipped" if skipped else f"All {len(names)} placed"
        return done, "Click a point to correct it; the arrow keys move it by a tenth of a pixel."

    def _step(self, names: tuple[str, ...], proposed: tuple[str, ...]) -> str:
        if self._current not in names:
            return ""
        number = names.index(str(self._current)) + 1
        state = self._landmarks[str(self._current)].state
        if state is LandmarkState.PROPOSED:
            return f"Next, {proposed.index(str(self._current)) + 1} of {len(proposed)} proposed"
        if state is LandmarkState.UNSET:
            return f"Next, {number} of {len(names)}"
        return f"{str(state).capitalize()}, {number} of {len(names)}"

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(446, 212)


def _legends() -> tuple[Legend, ...]:
    placed = LandmarkState.PLACED
    return (
        Legend("left", Landmark(state=placed), Side.LEFT),
        Legend("right", Landmark(state=placed), Side.RIGHT),
        Legend("proposed", Landmark(state=LandmarkState.PROPOSED), Side.MIDDLE),
        Legend("locked", Landmark(state=placed, locked=True), Side.MIDDLE),
    )
