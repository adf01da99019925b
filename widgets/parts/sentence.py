"""A sentence of a few lines at most, as high as it needs to be; cut ones are whole in their tooltip."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QResizeEvent, QTextLayout, QTextOption
from PySide6.QtWidgets import QSizePolicy, QWidget

from widgets import theme


class Sentence(QWidget):
    """Words that are wrapped.

    Parameters
    ----------
    most : int
        Lines at most.
    """

    def __init__(self, most: int = 3, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._text, self._tip, self._role, self._most = "", "", "text", most
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        theme.signals.changed.connect(self._fit)

    def text(self) -> str:
        """Return the whole sentence."""
        return self._text

    def set_text(self, text: str, tip: str = "", role: str = "text") -> None:
        """Say something else; ``tip`` says more."""
        self._text, self._tip, self._role = text, tip, role
        self.setAccessibleName(text)
        self._fit()

    @property
    def lines(self) -> list[str]:
        """What each line reads at the present width."""
        layout = QTextLayout(self._text, theme.font())
        option = QTextOption()
        option.setWrapMode(QTextOption.WrapMode.WrapAtWordBoundaryOrAnywhere)
        layout.setTextOption(option)
        layout.beginLayout()
        pieces: list[tuple[int, int]] = []
        while (line := layout.createLine()).isValid():
            line.setLineWidth(max(1, self.width()))
            pieces.append((line.textStart(), line.textLength()))
        layout.endLayout()
        shown = [self._text[start : start + length] for start, length in pieces[: self._most]]
        if len(pieces) > self._most:
            rest = self._text[pieces[self._most - 1][0] :]
            shown[-1] = QFontMetrics(theme.font()).elidedText(rest, Qt.TextElideMode.ElideRight, self.width())
        return shown

    def _fit(self) -> None:
        lines = self.lines
        cut = " ".join(line.strip() for line in lines) != " ".join(self._text.split())
        self.setToolTip("\n".join(x for x in (self._text if cut else "", self._tip) if x))
        self.setFixedHeight(QFontMetrics(theme.font()).lineSpacing() * max(1, len(lines)) + 2)
        self.update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Wrap anew."""
        super().resizeEvent(event)
        if event.size().width() != event.oldSize().width():
            self._fit()

    def sizeHint(self) -> QSize:
        """Return the present height."""
        return QSize(theme.px(160), self.height())

    def minimumSizeHint(self) -> QSize:
        """Return no width: the words wrap."""
        return QSize(theme.px(60), QFontMetrics(theme.font()).lineSpacing())

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the lines."""
        painter, font = QPainter(self), theme.font()
        metrics = QFontMetrics(font)
        painter.setFont(font)
        painter.setPen(theme.current().colour(self._role))
        for k, line in enumerate(self.lines):
            painter.drawText(QPointF(0, 1 + metrics.ascent() + k * metrics.lineSpacing()), line)
