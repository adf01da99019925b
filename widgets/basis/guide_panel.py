"""The sculpting guide: a shape for every muscle, and which of them the rig has (Kim & Ko 2007, section 5.3)."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QRect, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QFontMetrics, QHelpEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QFrame, QScrollArea, QSizePolicy, QToolTip, QVBoxLayout, QWidget

from engine.basis.muscles import ChecklistEntry
from widgets import theme
from widgets.basis.words import DASH
from widgets.parts import picture
from widgets.parts.section import DimLabel
from widgets.parts.tables import HEADER_HEIGHT, ROW_HEIGHT, paint_header, paint_row

REGIONS = {"upper": "upper face", "lower": "lower face"}
MARK, UNITS = 24, 48


class _Checklist(QWidget):
    chosen = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[ChecklistEntry | str] = []
        self.current = -1
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName("Sculpting guide: a shape for every muscle")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        theme.signals.changed.connect(self.updateGeometry)
        theme.signals.changed.connect(self.update)

    def show_entries(self, entries: Sequence[ChecklistEntry]) -> None:
        self.lines, self.current = [], -1
        for region, title in REGIONS.items():
            inside = [entry for entry in entries if entry.element.region == region]
            if inside:
                self.lines += [f"{title}, {sum(e.found for e in inside)} of {len(inside)}", *inside]
        self.updateGeometry()
        self.update()

    def box(self, line: int) -> QRect:
        top = sum(self._height(k) for k in range(line))
        return QRect(0, top, self.width(), self._height(line))

    def _height(self, line: int) -> int:
        return theme.px(HEADER_HEIGHT if isinstance(self.lines[line], str) else ROW_HEIGHT)

    def _line_at(self, y: float) -> int:
        return next((k for k in range(len(self.lines)) if self.box(k).top() <= y <= self.box(k).bottom()), -1)

    def _choose(self, line: int) -> None:
        entry = self.lines[line] if 0 <= line < len(self.lines) else ""
        if isinstance(entry, ChecklistEntry):
            self.current = line
            self.setAccessibleDescription(self._words(entry))
            self.update()
            if entry.shapes:
                self.chosen.emit(entry.shapes[0])

    def _words(self, entry: ChecklistEntry) -> str:
        units = " + ".join(f"AU {unit}" for unit in entry.element.units)
        found = ", ".join(entry.shapes) or "no shape has a name that says it"
        return f"{entry.element.muscle} ({units})\n{entry.element.does}\nIn the rig: {found}"

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._choose(self._line_at(event.position().y()))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = {Qt.Key.Key_Up: -1, Qt.Key.Key_Down: 1}.get(Qt.Key(event.key()))
        if step is None:
            super().keyPressEvent(event)
            return
        goal = self.current + step
        while 0 <= goal < len(self.lines) and isinstance(self.lines[goal], str):
            goal += step
        self._choose(goal)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            line = self._line_at(event.pos().y())
            entry = self.lines[line] if line >= 0 else ""
            QToolTip.showText(event.globalPos(), self._words(entry) if isinstance(entry, ChecklistEntry) else "", self)
            return True
        return super().event(event)

    def cells(self) -> list[list[str]]:
        rows = [entry for entry in self.lines if isinstance(entry, ChecklistEntry)]
        made = [["region", "muscle", "action units", "shapes"]]
        for entry in rows:
            units = " ".join(map(str, entry.element.units))
            made.append([REGIONS[entry.element.region], entry.element.muscle, units, ", ".join(entry.shapes)])
        return made

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        for line, entry in enumerate(self.lines):
            box = self.box(line)
            if isinstance(entry, str):
                self._paint_head(painter, box, entry, first=line == 0)
            else:
                self._paint_entry(painter, box, line, entry)

    def _paint_head(self, painter: QPainter, box: QRect, title: str, *, first: bool) -> None:
        middle = Qt.AlignmentFlag.AlignVCenter
        paint_header(painter, box)
        painter.drawText(box.adjusted(8, 0, 0, 0), middle, title)
        if first:
            painter.drawText(box.adjusted(0, 0, -8, 0), middle | Qt.AlignmentFlag.AlignRight, "shapes")
            painter.drawText(self._unit_box(box), middle | Qt.AlignmentFlag.AlignRight, "AU")

    def _unit_box(self, box: QRect) -> QRect:
        right = box.right() + 1 - 8 - round(0.36 * box.width())
        return QRect(right - theme.px(UNITS), box.top(), theme.px(UNITS) - theme.px(8), box.height())

    def _paint_entry(self, painter: QPainter, box: QRect, line: int, entry: ChecklistEntry) -> None:
        current, px, middle = theme.current(), theme.px, Qt.AlignmentFlag.AlignVCenter
        right = Qt.AlignmentFlag.AlignRight
        paint_row(painter, box, line, line == self.current)
        edge = px(12)
        if entry.found:
            theme.icon("done", "fresh_text", 12).paint(painter, 8, box.top() + (box.height() - edge) // 2, edge, edge)
        painter.setFont(theme.font(theme.TABLE_PX))
        metrics = QFontMetrics(painter.font())
        units, numbers = self._unit_box(box), " ".join(map(str, entry.element.units))
        painter.setPen(current.colour("text" if entry.found else "dim"))
        room = units.right() - metrics.horizontalAdvance(numbers) - px(6) - px(MARK)
        name = QRect(px(MARK), box.top(), room, box.height())
        painter.drawText(name, middle, metrics.elidedText(entry.element.muscle, Qt.TextElideMode.ElideRight, room))
        painter.setPen(current.colour("dim"))
        painter.drawText(units, middle | right, numbers)
        more = f" + {len(entry.shapes) - 1}" if len(entry.shapes) > 1 else ""
        words = entry.shapes[0] + more if entry.shapes else DASH
        painter.setPen(current.colour("text" if entry.found else "dim"))
        left = units.right() + px(8)
        place = QRect(left, box.top(), box.right() + 1 - 8 - left, box.height())
        painter.drawText(place, middle | right, metrics.elidedText(words, Qt.TextElideMode.ElideMiddle, place.width()))

    def sizeHint(self) -> QSize:
        return QSize(theme.px(280), sum(self._height(k) for k in range(len(self.lines))))

    def minimumSizeHint(self) -> QSize:
        return QSize(theme.px(200), self.sizeHint().height())


class GuidePanel(QWidget):
    """A checklist of muscles: six above, twelve below, with the shapes whose names say them.

    Signals
    -------
    shape_chosen(str)
        The first shape found for the muscle clicked.
    """

    shape_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.checklist = _Checklist()
        self.empty = DimLabel("Which muscles the shapes of a rig stand for, and which are missing, appears here.")
        self.empty.setWordWrap(True)
        self.empty.setContentsMargins(8, 8, 8, 8)
        self.names = DimLabel("", theme.TABLE_PX, role="text")
        self.names.setWordWrap(True)
        self.names.setContentsMargins(8, 8, 8, 8)
        flags = Qt.TextInteractionFlag
        self.names.setTextInteractionFlags(flags.TextSelectableByMouse | flags.TextSelectableByKeyboard)
        self.names.hide()
        self._entries: tuple[ChecklistEntry, ...] = ()
        inside = QWidget()
        inner = QVBoxLayout(inside)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.setSpacing(0)
        inner.addWidget(self.empty)
        inner.addWidget(self.checklist)
        inner.addWidget(self.names)
        inner.addStretch(1)
        self._area = area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setWidget(inside)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(area)
        self.checklist.chosen.connect(self.shape_chosen)
        picture.offer(self.checklist, "guide", "sculpting guide", table=self.checklist.cells)
        self.set_checklist(())

    @property
    def note(self) -> str:
        """What stands beside the dock's name: how many muscles have a shape."""
        return f"{sum(e.found for e in self._entries)} of {len(self._entries)}" if self._entries else ""

    def set_checklist(self, entries: Sequence[ChecklistEntry]) -> None:
        """Show the muscles and the shapes found for them; none while there is no rig."""
        if tuple(entries) != self._entries:
            self._entries = tuple(entries)
            self.checklist.show_entries(entries)
        self.checklist.setVisible(bool(entries))
        self.empty.setVisible(not entries)

    def show_missing(self, scheme: str, missing: Sequence[str]) -> None:
        """List, to be copied, the names of a scheme that no shape stands for, and bring the list into view."""
        self.names.setText(f"No shape for these {len(missing)} names of {scheme}:\n{', '.join(missing)}")
        self.names.setVisible(bool(missing))
        QTimer.singleShot(0, self.names, lambda: self._area.ensureWidgetVisible(self.names, 0, 0))

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(theme.px(296), theme.px(240))

    def minimumSizeHint(self) -> QSize:
        """Return the room for a muscle: the rest scrolls."""
        return QSize(theme.px(232), theme.px(44))
