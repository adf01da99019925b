"""A section of a panel: a heading that folds what is below it, and rows of name and value."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from widgets import theme

HEADING_HEIGHT = 24


class SectionHeading(QWidget):
    """The line a section is folded with: chevron, semibold name, dim note at the right.

    Signals
    -------
    toggled(bool)
        Whether the section is open now.
    """

    toggled = Signal(bool)

    def __init__(self, title: str, note: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title, self._note, self._open = title, note, True
        theme.fix(self, height=HEADING_HEIGHT)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName(f"{title}, section")
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        theme.signals.changed.connect(self.update)

    @property
    def is_open(self) -> bool:
        """Whether the section shows its rows."""
        return self._open

    def set_note(self, note: str) -> None:
        """Show another note at the right."""
        self._note = note
        self.update()

    def set_open(self, is_open: bool) -> None:
        """Open or fold the section."""
        if is_open != self._open:
            self._open = is_open
            self.toggled.emit(is_open)
            self.update()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Fold or open."""
        if event.button() == Qt.MouseButton.LeftButton:
            self.set_open(not self._open)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Fold or open with the space bar."""
        if event.key() == Qt.Key.Key_Space:
            self.set_open(not self._open)
        else:
            super().keyPressEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the line above, the chevron and both texts."""
        current = theme.current()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(QRect(0, 0, self.width(), 1), current.colour("window"))
        middle = 1 + self.height() / 2
        pen = QPen(current.colour("accent" if self.hasFocus() else "dim"), 1.35)
        pen.setCapStyle(Qt.PenCapStyle.RoundCap)
        painter.setPen(pen)
        marks = ((-3.0, -1.6), (0.0, 1.4), (3.0, -1.6)) if self._open else ((-1.5, -3.0), (1.5, 0.0), (-1.5, 3.0))
        unit = self.height() / HEADING_HEIGHT
        painter.drawPolyline(QPolygonF([QPointF((11.5 + x) * unit, middle + y * unit) for x, y in marks]))
        box = QRect(theme.px(22), 1, self.width() - theme.px(22) - 8, self.height())
        painter.setFont(theme.font(bold=True))
        painter.setPen(current.colour("text"))
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter, self._title)
        painter.setFont(theme.font())
        painter.setPen(current.colour("dim"))
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight, self._note)


class Section(QWidget):
    """A heading with rows below it.

    Parameters
    ----------
    title, note : str
        Name, and a dim note at the right of the heading.
    """

    def __init__(self, title: str, note: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.heading = SectionHeading(title, note, self)
        self._body = QWidget(self)
        self._rows: dict[str, tuple[QHBoxLayout, QLabel]] = {}
        self._frames: dict[str, QWidget] = {}
        self.rows = QVBoxLayout(self._body)
        self.rows.setContentsMargins(8, 0, 8, 8)
        self.rows.setSpacing(0)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.heading)
        column.addWidget(self._body)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self.heading.toggled.connect(self._body.setVisible)

    def set_note(self, note: str) -> None:
        """Show another note at the right of the heading."""
        self.heading.set_note(note)

    def add_value(self, name: str) -> ValueLabel:
        """Add a row of 22 px with a dim name and return the label of its value."""
        value = ValueLabel()
        value.setAccessibleName(name)
        self._add_row(name, value, 22)
        return value

    def add_input(self, name: str, widget: QWidget) -> None:
        """Add a row of 28 px with a dim name and an input beside it."""
        widget.setAccessibleName(widget.accessibleName() or name)
        self._add_row(name, widget, 28)

    def share_row(self, name: str, widget: QWidget) -> None:
        """Put a widget into a row that `add_value` made, to be shown in place of its value."""
        row, label = self._rows[name]
        row.addWidget(widget, 1)
        label.setBuddy(widget)

    def show_row(self, name: str, shown: bool) -> None:
        """Show a row, or leave it out."""
        self._frames[name].setVisible(shown)

    def rename_row(self, name: str, text: str) -> None:
        """Let the row that was added as ``name`` read ``text``."""
        self._rows[name][1].setText(text)

    def add_widget(self, widget: QWidget) -> None:
        """Add a widget over the whole width."""
        self.rows.addWidget(widget)

    def _add_row(self, name: str, widget: QWidget, height: int) -> None:
        row = QWidget()
        theme.fix(row, height=height)
        line = QHBoxLayout(row)
        line.setContentsMargins(0, 0, 0, 0)
        line.setSpacing(0)
        label = DimLabel(name)
        theme.fix(label, width=80)
        label.setBuddy(widget)
        line.addWidget(label)
        line.addWidget(widget, 1)
        self.rows.addWidget(row)
        self._rows[name] = line, label
        self._frames[name] = row


class DimLabel(QLabel):
    """A label in the dim colour, in whichever theme; ``pixels`` high."""

    def __init__(self, text: str = "", pixels: int = 12, *, role: str = "dim", bold: bool = False) -> None:
        super().__init__(text)
        self._role, self._pixels, self._bold = role, pixels, bold
        self.setTextFormat(Qt.TextFormat.PlainText)
        theme.signals.changed.connect(self._tint)
        self._tint()

    def set_role(self, role: str) -> None:
        """Use another colour role."""
        self._role = role
        self._tint()

    def _tint(self) -> None:
        weight = 600 if self._bold else 400
        colour = getattr(theme.current(), self._role)
        self.setStyleSheet(f"color: {colour}; font-size: {theme.px(self._pixels)}px; font-weight: {weight};")


class ShyLabel(DimLabel):
    """A dim label that is not shown at all where it does not fit, rather than cut."""

    def minimumSizeHint(self) -> QSize:
        """Return no width: others need the room more."""
        return QSize(0, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the text if all of it has room."""
        if self.width() >= self.sizeHint().width():
            super().paintEvent(event)


class ValueLabel(QWidget):
    """A value that is cut in the middle where it does not fit, and then shown whole in the tooltip.

    Signals
    -------
    clicked()
        Where `make_link` was called: by mouse, Space or Enter.
    """

    clicked = Signal()

    def __init__(self, text: str = "") -> None:
        super().__init__()
        self._text, self._is_link = text, False
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        theme.signals.changed.connect(self.update)

    @property
    def text(self) -> str:
        """The whole value."""
        return self._text

    def make_link(self) -> None:
        """Let the value be clicked, and show that it can be."""
        self._is_link = True
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Take a click on a link."""
        inside = self.rect().contains(event.position().toPoint())
        if self._is_link and inside and event.button() == Qt.MouseButton.LeftButton:
            self.clicked.emit()
        else:
            super().mouseReleaseEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Keep the press on a link, so that its release comes here."""
        if not self._is_link:
            super().mousePressEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Follow a link by keys."""
        if self._is_link and event.key() in (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.clicked.emit()
        else:
            super().keyPressEvent(event)

    def set_text(self, text: str, tip: str = "") -> None:
        """Show another value; ``tip`` says more."""
        self._text, self._tip = text, tip
        self.setToolTip(tip or text)
        self.setAccessibleDescription(text)
        self.update()

    def sizeHint(self) -> QSize:
        """Return a modest width: the row decides."""
        return QSize(theme.px(60), theme.px(20))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the value."""
        painter = QPainter(self)
        font = theme.font()
        font.setUnderline(self._is_link)
        painter.setFont(font)
        painter.setPen(theme.current().colour("accent_text" if self._is_link and self.hasFocus() else "text"))
        text = QFontMetrics(theme.font()).elidedText(self._text, Qt.TextElideMode.ElideMiddle, self.width())
        painter.drawText(QRectF(self.rect()), Qt.AlignmentFlag.AlignVCenter, text)
