"""The bar at the top of the window: menus, one tab per stage, the project's name, undo and redo."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QAction, QColor, QFont, QFontMetrics, QPainter, QPaintEvent
from PySide6.QtWidgets import QAbstractButton, QHBoxLayout, QLabel, QMenuBar, QSizePolicy, QToolButton, QWidget

from widgets import theme
from widgets.parts.glyphs import draw_state_dot

BAR_HEIGHT = 40
TAB_PADDING = 16
DOT = 7


class StageTab(QAbstractButton):
    """A tab with the stage's name and a dot: ring for missing, amber for stale, green for fresh."""

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setText(title)
        self.setCheckable(True)
        self.setAutoExclusive(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self._state = "missing"

    @property
    def state(self) -> str:
        """``"missing"``, ``"stale"`` or ``"fresh"``."""
        return self._state

    def set_state(self, state: str, reason: str = "") -> None:
        """Show another state; ``reason`` becomes the tooltip."""
        self.setToolTip(f"{self.text()}: {state}" + (f", {reason}" if reason else ""))
        if state != self._state:
            self._state = state
            self.update()

    def sizeHint(self) -> QSize:
        """Return room for dot, text and padding at the height of the bar."""
        font = self.font()
        font.setWeight(QFont.Weight.DemiBold)
        width = QFontMetrics(font).horizontalAdvance(self.text())
        return QSize(2 * TAB_PADDING + theme.px(DOT) + 8 + width, theme.px(BAR_HEIGHT))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Paint ground, accent line, dot and text in the colours of the current theme."""
        colours = theme.current()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.isChecked():
            painter.fillRect(self.rect(), QColor(colours.panel))
            painter.fillRect(0, 0, self.width(), 2, QColor(colours.accent))
        elif self.underMouse() or self.hasFocus():
            painter.fillRect(self.rect(), QColor(colours.raised))
        dot = theme.px(DOT)
        draw_state_dot(painter, QPointF(TAB_PADDING + dot / 2, self.height() / 2), self._state, dot)
        font = self.font()
        font.setWeight(QFont.Weight.DemiBold if self.isChecked() else QFont.Weight.Normal)
        painter.setFont(font)
        painter.setPen(QColor(colours.text if self.isChecked() else colours.dim))
        box = QRectF(TAB_PADDING + dot + 8, 0, self.width(), self.height())
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, self.text())


class TopBar(QWidget):
    """Menus at the left, stage tabs, the project's name with undo and redo at the right."""

    stage_chosen = Signal(str)
    """The user wants another stage (its id)."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        theme.fix(self, height=BAR_HEIGHT)
        self.menus = QMenuBar(self)
        self.menus.setNativeMenuBar(False)
        self.menus.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)
        self.project = QLabel(self)
        self.project.setObjectName("project_name")
        self._tabs: dict[str, StageTab] = {}
        self._tab_row = QHBoxLayout()
        self._tab_row.setSpacing(0)
        self._buttons = QHBoxLayout()
        self._buttons.setSpacing(4)
        row = QHBoxLayout(self)
        row.setContentsMargins(4, 0, 8, 0)
        row.setSpacing(0)
        row.addWidget(self.menus, 0, Qt.AlignmentFlag.AlignVCenter)
        row.addSpacing(98)
        row.addLayout(self._tab_row)
        row.addStretch(1)
        row.addWidget(self.project)
        row.addSpacing(12)
        row.addLayout(self._buttons)

    def add_stage(self, stage_id: str, title: str) -> StageTab:
        """Add the tab of a stage."""
        tab = StageTab(title, self)
        tab.setObjectName(f"stage_{stage_id}")
        tab.clicked.connect(lambda: self.stage_chosen.emit(stage_id))
        self._tabs[stage_id] = tab
        self._tab_row.addWidget(tab)
        return tab

    def select(self, stage_id: str) -> None:
        """Mark the tab of the stage in view."""
        self._tabs[stage_id].setChecked(True)

    def set_state(self, stage_id: str, state: str, reason: str = "") -> None:
        """Show how far a stage is: missing, stale or fresh."""
        self._tabs[stage_id].set_state(state, reason)

    def add_button(self, action: QAction) -> QToolButton:
        """Add a 24 px button of an action at the right."""
        button = QToolButton(self)
        button.setDefaultAction(action)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
        theme.fix(button, 24, 24)
        theme.fix_icon(button, 16)
        button.setAutoRaise(True)
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._buttons.addWidget(button)
        return button

    def refresh_theme(self) -> None:
        """Take the colours of the current theme."""
        self.project.setStyleSheet(f"color: {theme.current().dim};")
        self.update()

    def set_project(self, name: str, dirty: bool) -> None:
        """Show the project's name, with a star while it has unsaved changes."""
        self.project.setText(f"{name} *" if dirty else name)
        self.project.setToolTip("Unsaved changes" if dirty else "Saved")
