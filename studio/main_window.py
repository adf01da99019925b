"""The one window: top bar, docks around a work zone, status line; it knows stages, not what they do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QEvent, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QCloseEvent, QKeyEvent, QKeySequence, QShortcut, QStatusTipEvent
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QApplication,
    QDockWidget,
    QLineEdit,
    QMainWindow,
    QMenu,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from engine.errors import InputError
from studio import dialogs
from studio.actions import MENUS, Actions
from studio.drops import DropTarget
from studio.file_guard import FileGuard
from studio.history import HistoryView, TaskList
from studio.message_bar import MessageBar
from studio.navigation_keys import NavigationKeys
from studio.pictures import Pictures
from studio.recovery_keeper import RecoveryKeeper
from studio.restore import offer_lost
from studio.session import Session
from studio.settings import Settings
from studio.stage_bar import TopBar
from studio.stages import STAGES, DockSpec, StageView
from studio.status_line import StatusLine
from studio.tasks import describe
from studio.window_files import FileActions
from studio.window_habits import WindowHabits
from widgets import text_scale, theme
from widgets.parts.titles import DockTitle

LEFT, RIGHT = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
BOTTOM = Qt.DockWidgetArea.BottomDockWidgetArea
WIDTHS = {LEFT: 232, RIGHT: 296}
SIDE_GROWTH = 0.6
"""Share of a larger text that the side docks take from the work zone."""
FIRST_SIZE = QSize(1440, 900)


class MainWindow(QMainWindow):
    """The window of the studio.

    Parameters
    ----------
    settings : Settings
        What is remembered between sessions.

    Notes
    -----
    The window is painted before 3-D is loaded: `painted` is emitted once after the first paint, `views_ready` when
    the 3-D views of the stage are there.
    """

    painted = Signal()
    views_ready = Signal()
    stage_shown = Signal(str)
    """Another stage is in view (its id)."""

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        self.setObjectName("main_window")
        self.settings = settings
        self.session = Session(settings, self)
        self.actions_ = Actions(self)
        self.message = MessageBar(self)
        self.status = StatusLine(self)
        self.top = TopBar(self)
        self.docks: dict[str, QDockWidget] = {}
        self._titles: dict[str, DockTitle] = {}
        self._was_painted = False
        self._closed = False
        self._hidden: list[QDockWidget] = []
        self._menus: dict[str, QAction] = {}
        self._window_menu: QMenu | None = None
        self._docks_end: QAction | None = None
        self._build_frame()
        self.files = FileActions(self)
        self._drops = DropTarget(self)
        self.recovery = RecoveryKeeper(self.session)
        self.guard = FileGuard(self)
        self.habits = WindowHabits(self)
        self._bind_actions()
        self.stages: dict[str, StageView] = {}
        self._build_stages()
        self.pictures = Pictures(self)
        self.pictures.bind(self.actions_)
        self._build_common_docks()
        self._build_menus()
        self._navigation = NavigationKeys(settings, self.actions_, self)
        self.arrange()
        self.habits.furnish()
        self.session.message.connect(self.message.tell)
        self.session.noted.connect(self.status.note)
        self.session.title_changed.connect(self._show_title)
        self.session.replaced.connect(self.message.withdraw)
        self.session.stack.indexChanged.connect(self._on_history)
        theme.signals.changed.connect(self._on_theme)
        self._on_theme()
        self._show_title()
        self.actions_.refresh()

    # -- building --------------------------------------------------------------------------------------------

    def _build_frame(self) -> None:
        self.resize(FIRST_SIZE)
        self.setMinimumSize(1024, 640)
        self.setContentsMargins(4, 0, 4, 0)
        self.setDockOptions(QMainWindow.DockOption.AllowNestedDocks | QMainWindow.DockOption.AllowTabbedDocks)
        self.setCorner(Qt.Corner.BottomLeftCorner, BOTTOM)
        self.setCorner(Qt.Corner.BottomRightCorner, BOTTOM)
        self.setMenuWidget(self.top)
        self.setStatusBar(self.status)
        self.status.follow(self.session.tasks)
        self.status.cancel_clicked.connect(self._cancel_oldest)
        self.status.tasks_clicked.connect(lambda: self.show_dock("tasks"))
        self._stack = QStackedWidget(self)
        centre = QWidget(self)
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.message)
        column.addWidget(self._stack, 1)
        self.setCentralWidget(centre)

    def _bind_actions(self) -> None:
        bind, stack = self.actions_.bind, self.session.stack
        bind("edit.undo", stack.undo, lambda: "" if stack.canUndo() else "there is no step to take back")
        bind("edit.redo", stack.redo, lambda: "" if stack.canRedo() else "no step was taken back")
        bind("help.about", self._about)
        bind("file.quit", self.close)
        self.files.bind(self.actions_)

    def _build_stages(self) -> None:
        for stage in STAGES:
            self.top.add_stage(stage.id, stage.title)
        self._stage_id = STAGES[0].id
        self.actions_.set_stage(self._stage_id)
        self._create_stage(self._stage_id)
        self.top.select(self._stage_id)
        self.top.stage_chosen.connect(self.show_stage)

    def _create_stage(self, stage_id: str) -> None:
        stage = next(stage for stage in STAGES if stage.id == stage_id)
        self.actions_.owner = stage_id
        try:
            view = stage.create(self)
        finally:
            self.actions_.owner = ""
        self.stages[stage_id] = view
        self._stack.addWidget(view.centre)
        for spec in view.docks:
            dock = self.add_dock(spec)
            if self._window_menu is not None:
                self._add_dock_toggle(self._window_menu, dock, self._docks_end)

    def _build_common_docks(self) -> None:
        history = HistoryView(self.session.stack, self)
        self.add_dock(DockSpec("history", "History", history, RIGHT, 200)).hide()
        self.add_dock(DockSpec("tasks", "Tasks", TaskList(self.session.tasks, self), RIGHT, 160)).hide()
        self.add_dock(DockSpec("log", "Log", self.habits.log.view, BOTTOM, 160)).hide()

    def add_dock(self, spec: DockSpec) -> QDockWidget:
        """Put a widget into a dock with our title bar."""
        dock = QDockWidget(spec.title, self)
        dock.setObjectName(f"dock_{spec.id}")
        dock.setWidget(spec.widget)
        title = DockTitle(spec.title, "", dock)
        for icon, action_id in spec.buttons:
            action = self.actions_[action_id]
            title.add_button(icon, action.toolTip()).clicked.connect(action.trigger)
        dock.setProperty("share", 0 if spec.tab else spec.size)  # a tab has the room of the dock it lies behind
        self.addDockWidget(spec.area, dock)
        if spec.tab:
            self.tabifyDockWidget(self.docks[spec.tab], dock)
        self.docks[spec.id] = dock
        self._titles[spec.id] = title
        return dock

    def _build_menus(self) -> None:
        for name in MENUS:
            menu = QMenu(name, self.top.menus)
            menu.setToolTipsVisible(True)
            group = None
            for number, action in self.actions_.in_menu(name):
                if group is not None and number != group:
                    menu.addSeparator()
                if number == 10 and name == "Window" and action.objectName() == "window.save_layout":
                    self._add_dock_toggles(menu)
                menu.addAction(action)
                if action.objectName() == "file.open":
                    self.files.add_recent_menu(menu)
                if action.objectName() == "window.save_layout":
                    self.habits.add_layout_menu(menu)
                group = number
            entry = self._menus[name] = self.top.menus.addMenu(menu)
            key = QShortcut(QKeySequence(f"Alt+{name[0]}"), self)  # a mnemonic would be underlined all the time
            key.activated.connect(lambda entry=entry: self.top.menus.setActiveAction(entry))
            menu.aboutToShow.connect(self.actions_.refresh)
        for action_id in ("edit.undo", "edit.redo"):
            self.top.add_button(self.actions_[action_id])
        self._show_menus()

    def _show_menus(self) -> None:
        """Show the menu of the stage in view alone of those that are named after a stage."""
        for stage in STAGES:
            if stage.title in self._menus:
                self._menus[stage.title].setVisible(stage.id == self._stage_id)

    def _add_dock_toggles(self, menu: QMenu) -> None:
        for dock in self.docks.values():
            self._add_dock_toggle(menu, dock)
        self._docks_end = menu.addSeparator()
        self._window_menu = menu

    def _add_dock_toggle(self, menu: QMenu, dock: QDockWidget, before: QAction | None = None) -> None:
        action: QAction = dock.toggleViewAction()
        action.setStatusTip(f"Show or hide {dock.windowTitle()}")
        menu.insertAction(before, action) if before is not None else menu.addAction(action)

    # -- layout ----------------------------------------------------------------------------------------------

    def arrange(self) -> None:
        """Give the docks the breadth and the shares they have at first."""
        self.widen_sides()
        for area in WIDTHS:
            shown = [dock for dock in self._docks_in(area) if not dock.isHidden() and dock.property("share")]
            shares = [int(dock.property("share")) for dock in shown]
            self.resizeDocks(shown, shares, Qt.Orientation.Vertical)

    def widen_sides(self) -> None:
        """Give the side docks the breadth that the text needs."""
        for area, width in WIDTHS.items():
            wide = round(width * (1 + (text_scale.factor() - 1) * SIDE_GROWTH))
            docks = self._docks_in(area)
            self.resizeDocks(docks, [wide] * len(docks), Qt.Orientation.Horizontal)

    def _docks_in(self, area: Qt.DockWidgetArea) -> list[QDockWidget]:
        return [dock for dock in self.docks.values() if self.dockWidgetArea(dock) == area]

    @property
    def stage(self) -> StageView:
        """The stage in view."""
        return self.stages[self._stage_id]

    @property
    def stage_id(self) -> str:
        """The id of the stage in view."""
        return self._stage_id

    def show_stage(self, stage_id: str) -> None:
        """Bring another stage into view, with its docks as they were left."""
        if stage_id == self._stage_id:
            return
        self.habits.layouts.leave(self._stage_id)
        for spec in self.stage.docks:
            self.docks[spec.id].hide()
        self.actions_.set_stage(stage_id)
        first = stage_id not in self.stages
        if first:
            self._create_stage(stage_id)
            self._navigation.wear()
        self._stage_id = stage_id
        self.top.select(stage_id)
        self._stack.setCurrentWidget(self.stage.centre)
        for spec in self.stage.docks:
            self.docks[spec.id].show()
        self.arrange()
        self.habits.layouts.enter(stage_id, first)
        self._show_menus()
        self.stage.came_into_view()
        self.stage_shown.emit(stage_id)
        self.actions_.refresh()

    def hide_other_docks(self) -> None:
        """Hide the docks of the stages that are not in view: an arrangement may have brought them back."""
        for stage_id, stage in self.stages.items():
            if stage_id != self._stage_id:
                for spec in stage.docks:
                    self.docks[spec.id].hide()

    def show_dock(self, dock_id: str) -> None:
        """Show a dock and bring it to the front."""
        dock = self.docks[dock_id]
        dock.show()
        dock.raise_()

    def hide_docks(self, hidden: bool) -> None:
        """Hide every dock, or bring back those that were hidden so."""
        if hidden:
            self._hidden = [dock for dock in self.docks.values() if not dock.isHidden() and not dock.isFloating()]
        for dock in self._hidden:
            dock.setVisible(not hidden)

    def set_dock_note(self, dock_id: str, note: str) -> None:
        """Write a dim note beside the title of a dock."""
        if dock_id in self._titles:
            self._titles[dock_id].set_note(note)

    def set_stage_state(self, stage_id: str, state: str, reason: str) -> None:
        """Show the state of a stage on its tab."""
        self.top.set_state(stage_id, state, reason)

    # -- what happens ----------------------------------------------------------------------------------------

    def attempt(self, deed: Callable[..., object], *values: object) -> bool:
        """Call ``deed(*values)``; input errors and file errors become a message. Returns whether it went well."""
        try:
            deed(*values)
        except (InputError, OSError) as error:
            self.message.tell("error", describe(error))
            return False
        return True

    def open_project(self, path: Path) -> bool:
        """Open a project file, or say why not."""
        return self.files.open_path(path)

    def _on_theme(self) -> None:
        self.actions_["view.dark"].setChecked(theme.current().is_dark)
        self.actions_.refresh_icons()
        self.status.refresh_theme()
        self.message.refresh_theme()
        self.top.refresh_theme()

    def _on_history(self, _index: int) -> None:
        self.message.clear()
        self.actions_.refresh()

    def _show_title(self) -> None:
        name, dirty = self.session.name, self.session.is_dirty
        self.top.set_project(name, dirty)
        self.setWindowTitle(f"{name}[*] - Quasiface Studio")
        self.setWindowModified(dirty)
        self.actions_.refresh()

    def _cancel_oldest(self) -> None:
        if self.session.tasks.active:
            self.session.tasks.cancel(self.session.tasks.active[0])

    def _about(self) -> None:
        self.message.tell("info", dialogs.about_text())

    # -- events ----------------------------------------------------------------------------------------------

    def event(self, event: QEvent) -> bool:
        """Show what an action does while the mouse is over it, and leave editing keys to a field that is edited."""
        if isinstance(event, QStatusTipEvent):
            self.status.set_hint(event.tip())
            return True
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            editing = isinstance(QApplication.focusWidget(), (QLineEdit, QAbstractSpinBox))
            if editing and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Delete):
                event.accept()
                return True
        painted = event.type() == QEvent.Type.Paint
        handled = super().event(event)
        if painted and not self._was_painted:
            self._was_painted = True
            QTimer.singleShot(0, self._after_first_paint)
        return handled

    def _after_first_paint(self) -> None:
        if self._closed:
            return
        self.painted.emit()
        offer_lost(self)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about unsaved changes, then let go of everything."""
        if self._closed or not self.files.may_discard():
            event.setAccepted(self._closed)
            return
        self._closed = True
        self.habits.remember()
        theme.signals.changed.disconnect(self._on_theme)
        self._navigation.close()
        self.pictures.close()
        for stage in self.stages.values():
            stage.close()
        self.settings.save()
        self.session.close()
        self.habits.close()
        self.guard.close()  # after the tasks: one of them may still be writing
        self.recovery.close()
        event.accept()
