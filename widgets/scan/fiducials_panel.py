"""The fiducials as a table, with the tools that work on them."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QSize, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QToolButton, QVBoxLayout, QWidget

from engine.landmarks import Landmark, LandmarkScheme, LandmarkSet, LandmarkState
from widgets import theme
from widgets.parts.buttons import IconButton
from widgets.parts.landmark_table import LandmarkTable
from widgets.parts.segments import Segments
from widgets.scan.canvas_panel import ToolRow


class FiducialsPanel(QWidget):
    """Tool row and table of the fiducials (``table``).

    Signals
    -------
    selected(str)
        The user chose a fiducial.
    edited(str, float, float)
        The user typed another place, image pixels.
    unset_requested(str), lock_requested(str, bool)
        For the current fiducial.
    mirror_requested()
        Missing fiducials are to be proposed from the other side.
    carry_requested()
        The fiducials of the scan to carry from are to be proposed here.
    import_requested(), export_requested()
        Fiducials from, to a JSON file.
    scheme_editor_requested()
        The scheme is to be looked at or changed.
    """

    selected = Signal(str)
    edited = Signal(str, float, float)
    unset_requested = Signal(str)
    lock_requested = Signal(str, bool)
    mirror_requested = Signal()
    carry_requested = Signal()
    import_requested = Signal()
    export_requested = Signal()
    scheme_editor_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.table = LandmarkTable(self)
        self.tools = ToolRow(self, line=True)
        self.mirror_button = IconButton("mirror", "Propose missing points from the other side (M)")
        self.carry_button = IconButton("copy", "Propose the points of the scan under Carry from (C)")
        self.lock_button = IconButton("lock", "Lock the point, or unlock it (L)")
        self.delete_button = IconButton("close", "Unset the point (Del)")
        self.more_button = IconButton("more", "Import, export and fiducial scheme")
        self.filter = Segments([("all", "All"), ("proposed", "Proposed")], name="Points listed")
        self._scheme: LandmarkScheme | None = None
        self._landmarks = LandmarkSet({})
        self._current: str | None = None
        self._arrange()
        self._connect()
        self._show()

    def _arrange(self) -> None:
        row = self.tools.row
        for button in (self.mirror_button, self.carry_button, self.lock_button, self.delete_button):
            row.addWidget(button)
        self.tools.add_separator()
        row.addWidget(self.more_button)
        row.addStretch(1)
        row.addWidget(self.filter)
        self.filter.set_tip("proposed", "Only the points that wait to be confirmed")
        menu = QMenu(self.more_button)
        self.import_action = QAction("Import fiducials…", menu)
        self.export_action = QAction("Export fiducials…", menu)
        self.scheme_action = QAction("Fiducial scheme…", menu)
        menu.addActions([self.import_action, self.export_action, self.scheme_action])
        menu.setToolTipsVisible(True)
        self.more_button.setMenu(menu)
        self.more_button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.tools)
        column.addWidget(self.table, 1)

    def _connect(self) -> None:
        self.table.selected.connect(self._choose)
        self.table.edited.connect(self.edited)
        self.table.unset_requested.connect(self._unset)
        self.delete_button.clicked.connect(self._unset)
        self.lock_button.clicked.connect(self._lock)
        self.mirror_button.clicked.connect(self.mirror_requested)
        self.carry_button.clicked.connect(self.carry_requested)
        self.import_action.triggered.connect(self.import_requested)
        self.export_action.triggered.connect(self.export_requested)
        self.scheme_action.triggered.connect(self.scheme_editor_requested)
        self.filter.chosen.connect(lambda key: self.table.set_proposed_only(key == "proposed"))

    def set_scheme(self, scheme: LandmarkScheme | None) -> None:
        """List the fiducials of a scheme."""
        self._scheme = scheme
        self.table.set_scheme(scheme)
        self._show()

    def set_vertices(self, vertices: Mapping[str, int]) -> None:
        """Take the template's vertex of each fiducial."""
        self.table.set_vertices(vertices)

    def set_landmarks(self, landmarks: LandmarkSet) -> None:
        """Show where they are."""
        self._landmarks = landmarks
        self.table.set_landmarks(landmarks)
        self._show()

    def set_current(self, name: str | None) -> None:
        """Mark the fiducial whose turn it is."""
        self._current = name
        self.table.set_current(name)
        self._show()

    def set_carry_available(self, available: bool, reason: str = "") -> None:
        """Allow to carry over, or say why not."""
        self.carry_button.set_available(available, reason)

    @property
    def note(self) -> str:
        """What stands beside the dock's name: how many are placed, ``17 / 20``."""
        names = () if self._scheme is None else self._scheme.names
        return f"{len(self._landmarks.names(LandmarkState.PLACED, order=names))} / {len(names)}" if names else ""

    def _choose(self, name: str) -> None:
        self._current = name
        self._show()
        self.selected.emit(name)

    def _unset(self) -> None:
        point = self._point()
        if self._current is not None and not point.locked and point.state is not LandmarkState.UNSET:
            self.unset_requested.emit(self._current)

    def _lock(self) -> None:
        if self._current is not None:
            self.lock_requested.emit(self._current, not self._point().locked)

    def _point(self) -> Landmark:
        return Landmark() if self._current is None else self._landmarks[self._current]

    def _show(self) -> None:
        names = () if self._scheme is None else self._scheme.names
        point, known = self._point(), self._current in names
        proposed = len(self._landmarks.names(LandmarkState.PROPOSED, order=names))
        self.filter.set_text("proposed", f"Proposed {proposed}" if proposed else "Proposed")
        self.lock_button.set_icon_name("unlock" if point.locked else "lock")
        lockable = known and (point.locked or point.state is LandmarkState.PLACED)
        why = "Only a placed point can be locked" if known else "Choose a point first"
        self.lock_button.set_available(lockable, why)
        erasable = known and not point.locked and point.state is not LandmarkState.UNSET
        why = "It is locked" if point.locked else "It is not set" if known else "Choose a point first"
        self.delete_button.set_available(erasable, why)
        some = any(self._landmarks[n].is_set for n in names)
        self.mirror_button.set_available(some, "Place points on one side first")
        self.import_action.setEnabled(bool(names))
        self.import_action.setToolTip("" if names else "Choose a scan first")
        self.export_action.setEnabled(some)
        self.export_action.setToolTip("" if some else "No point is set yet")

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(296, 460)

    def minimumSizeHint(self) -> QSize:
        """Return the room for the tools and a few rows."""
        return QSize(self.tools.minimumSizeHint().width(), theme.px(32 + 22 + 100))
