"""The line at the bottom: the next missing step and its key, the state of the fit, the running task."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QSizePolicy, QStatusBar, QToolButton, QWidget

from studio.tasks import Task, TaskRunner, TaskState
from widgets import theme
from widgets.parts.glyphs import StateDot

LINE_HEIGHT = 24
TITLE_WIDTH = 168


class StatusLine(QStatusBar):
    """Left: what comes next and its key. Right: the fit, the running task with progress and cancel."""

    cancel_clicked = Signal()
    tasks_clicked = Signal()
    next_clicked = Signal()
    """The next step was clicked, to be done."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("status_line")
        theme.fix(self, height=LINE_HEIGHT)
        self.setSizeGripEnabled(False)
        self._next = ("", "")
        self._row = QWidget(self)
        self.head = QLabel("Next", self._row)
        self.head.setProperty("role", "accent")
        self.text = QLabel(self._row)
        self.text.setObjectName("next_step")
        self.text.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.key = QToolButton(self._row)
        self.key.setObjectName("key_badge")
        self.key.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.key.setCursor(Qt.CursorShape.PointingHandCursor)
        self.key.clicked.connect(self.next_clicked)
        self.text.installEventFilter(self)
        self.dot = StateDot(parent=self._row)
        self.fit = QLabel(self._row)
        self.task = QLabel(self._row)
        theme.fix(self.task, width=TITLE_WIDTH, height=LINE_HEIGHT - 2)  # of one size: its text moves nothing else
        self.task.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.progress = QProgressBar(self._row)
        theme.fix(self.progress, 64, 4)
        self.progress.setTextVisible(False)
        self.progress.setRange(0, 100)
        self.percent = QLabel(self._row)
        theme.fix(self.percent, width=38, height=LINE_HEIGHT - 2)
        self.percent.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.cancel = QToolButton(self._row)
        theme.fix(self.cancel, 18, 18)
        theme.fix_icon(self.cancel, 16)
        self.cancel.setAutoRaise(True)
        self.cancel.setToolTip("Cancel this task")
        self.cancel.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.cancel.clicked.connect(self.cancel_clicked)
        self.count = QToolButton(self._row)
        self.count.setAutoRaise(True)
        self.count.setToolTip("Show the tasks")
        self.count.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.count.clicked.connect(self.tasks_clicked)
        row = QHBoxLayout(self._row)
        row.setContentsMargins(8, 0, 8, 0)
        row.setSpacing(8)
        row.addWidget(self.head)
        row.addWidget(self.text, 0)
        row.addWidget(self.key)
        row.addStretch(1)
        for widget in (self.dot, self.fit, self.task, self.progress, self.percent, self.cancel, self.count):
            row.addWidget(widget)
        self.text.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Preferred)
        self.addWidget(self._row, 1)
        self._hover = False
        self._note = QTimer(self)
        self._note.setSingleShot(True)
        self._note.setInterval(4000)
        self._note.timeout.connect(lambda: self.set_hint(""))
        self.set_next("", "")
        self.set_fit("missing", "")
        self._show_task(None, 0)
        self.refresh_theme()

    def refresh_theme(self) -> None:
        """Take the colours of the current theme."""
        colours = theme.current()
        self.head.setStyleSheet(f"color: {colours.accent_text}; font-weight: 600;")
        self.key.setStyleSheet(
            f"QToolButton {{ background: {colours.raised}; border: 1px solid {colours.line}; border-radius: 3px;"
            f" padding: 0 5px; }} QToolButton:hover {{ border-color: {colours.accent}; }}"
        )
        for label in (self.fit, self.task, self.percent):
            label.setStyleSheet(f"color: {colours.dim};")
        self.count.setStyleSheet(f"color: {colours.dim}; border: none;")
        self.cancel.setIcon(theme.icon("close", "dim"))
        self.dot.update()

    def set_next(self, text: str, key: str) -> None:
        """Say what is the next step, and which key does it or leads there; nothing when ``text`` is empty."""
        self._next = (text, key)
        if not self._hover:
            self._show_next()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take a click on the next step as one on its key."""
        if event.type() == QEvent.Type.MouseButtonRelease and isinstance(event, QMouseEvent) and self.key.isVisible():
            inside = self.text.rect().contains(event.position().toPoint())
            if inside and event.button() == Qt.MouseButton.LeftButton:
                self.next_clicked.emit()
                return True
        return super().eventFilter(watched, event)

    def set_hint(self, text: str) -> None:
        """Say what the action under the mouse does, or show the next step again when ``text`` is empty."""
        self._hover = bool(text)
        if not text:
            self._show_next()
            return
        self.head.hide()
        self.key.hide()
        self.text.setText(text)

    def note(self, text: str) -> None:
        """Mention something in passing, for a few seconds."""
        self.set_hint(text)
        self._note.start()

    def set_fit(self, state: str, text: str) -> None:
        """Show the state of the current scan's fit in words and as a dot; hidden when ``text`` is empty."""
        self.dot.setVisible(bool(text))
        self.fit.setVisible(bool(text))
        self.dot.set_state(state)
        self.fit.setText(text)

    def follow(self, runner: TaskRunner) -> None:
        """Show what a runner is at."""
        runner.changed.connect(lambda _task: self._on_tasks(runner))

    def _on_tasks(self, runner: TaskRunner) -> None:
        active = runner.active
        running = next((task for task in active if task.state is TaskState.RUNNING), active[0] if active else None)
        self._show_task(running, len(active))

    def _show_task(self, task: Task | None, count: int) -> None:
        for widget in (self.task, self.progress, self.percent, self.cancel):
            if widget.isHidden() == (task is not None):
                widget.setVisible(task is not None)
        if self.count.isHidden() == (count > 1):
            self.count.setVisible(count > 1)
        if count > 1 and self.count.text() != f"{count} tasks":
            self.count.setText(f"{count} tasks")
        if task is None:
            return
        if self.task.toolTip() != task.title:
            self.task.setToolTip(task.title)
            room = self.task.width()
            self.task.setText(self.task.fontMetrics().elidedText(task.title, Qt.TextElideMode.ElideMiddle, room))
        done = round(100 * task.fraction)
        if done != self.progress.value() or not self.percent.text():
            self.progress.setValue(done)
            self.percent.setText(f"{done} %")

    def _show_next(self) -> None:
        text, key = self._next
        self.head.setVisible(bool(text))
        self.text.setText(text)
        self.key.setVisible(bool(key))
        self.text.setCursor(Qt.CursorShape.PointingHandCursor if key else Qt.CursorShape.ArrowCursor)
        self.key.setText(key)
