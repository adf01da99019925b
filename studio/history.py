"""Two lists every stage has: the steps that can be undone, and the tasks."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QShowEvent, QUndoStack
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QProgressBar,
    QSizePolicy,
    QToolButton,
    QUndoView,
    QVBoxLayout,
    QWidget,
)

from studio.tasks import Task, TaskRunner, TaskState
from widgets import theme


class HistoryView(QUndoView):
    """The steps of the project; a click goes back to one, or forward."""

    def __init__(self, stack: QUndoStack, parent: QWidget | None = None) -> None:
        super().__init__(stack, parent)
        self.setObjectName("history_view")
        self.setEmptyLabel("Project as opened")
        self.setToolTip("Click a step to go back to it")
        self.setStyleSheet("QUndoView::item { padding: 2px 8px; }")
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        stack.indexChanged.connect(self._show_present)

    def showEvent(self, event: QShowEvent) -> None:
        """Bring the present step into sight."""
        super().showEvent(event)
        self._show_present()

    def _show_present(self, _index: int = 0) -> None:
        if self.isVisible() and self.currentIndex().isValid():
            self.scrollTo(self.currentIndex())


class TaskRow(QWidget):
    """One task: title, step, progress, time left, and a button that cancels it."""

    cancel_clicked = Signal()

    def __init__(self, task: Task, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.title = QLabel(task.title, self)
        self.note = QLabel(self)
        self.note.setWordWrap(True)
        self.note.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
        self.note.setStyleSheet(f"color: {theme.current().dim};")
        self.bar = QProgressBar(self)
        theme.fix(self.bar, height=4)
        self.bar.setTextVisible(False)
        self.cancel = QToolButton(self)
        theme.fix(self.cancel, 20, 20)
        theme.fix_icon(self.cancel, 16)
        self.cancel.setAutoRaise(True)
        self.cancel.setIcon(theme.icon("close", "dim"))
        self.cancel.setToolTip("Cancel")
        self.cancel.clicked.connect(self.cancel_clicked)
        head = QHBoxLayout()
        head.addWidget(self.title, 1)
        head.addWidget(self.cancel)
        column = QVBoxLayout(self)
        column.setContentsMargins(8, 4, 4, 4)
        column.setSpacing(4)
        column.addLayout(head)
        column.addWidget(self.bar)
        column.addWidget(self.note)
        self.refresh(task)

    def refresh(self, task: Task) -> None:
        """Show where the task is now."""
        self.bar.setVisible(task.active)
        self.cancel.setVisible(task.active)
        self.bar.setValue(round(100 * task.fraction))
        self.note.setText(describe(task))
        self.setToolTip(task.error)


def describe(task: Task) -> str:
    """Return the state of a task in a few words."""
    if task.state is TaskState.FAILED:
        return f"failed: {task.error}"
    if task.state is not TaskState.RUNNING:
        return task.state.value
    left = task.seconds_left
    parts = [f"{round(100 * task.fraction)} %", task.text, "" if left is None else f"{left:.0f} s left"]
    return ", ".join(part for part in parts if part)


class TaskList(QListWidget):
    """The tasks of a runner, the newest first; quiet ones are left out."""

    def __init__(self, runner: TaskRunner, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("task_list")
        self.setSelectionMode(QListWidget.SelectionMode.NoSelection)
        self.setUniformItemSizes(False)
        self._runner = runner
        self._rows: dict[Task, tuple[QListWidgetItem, TaskRow]] = {}
        runner.changed.connect(self._on_changed)

    def _on_changed(self, task: Task) -> None:
        if task.quiet:
            return
        if task not in self._rows:
            item, row = QListWidgetItem(), TaskRow(task, self)
            row.cancel_clicked.connect(lambda: self._runner.cancel(task))
            self.insertItem(0, item)
            self.setItemWidget(item, row)
            self._rows[task] = (item, row)
            self._forget_old()
        item, row = self._rows[task]
        row.refresh(task)
        item.setSizeHint(row.sizeHint())

    def _forget_old(self) -> None:
        for task in [old for old in self._rows if not old.active][: max(0, len(self._rows) - 20)]:
            item, _row = self._rows.pop(task)
            self.takeItem(self.row(item))
