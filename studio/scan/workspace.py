"""The widgets of the scan stage and where they stand; they know neither each other nor the project."""

from __future__ import annotations

from PySide6.QtCore import QByteArray, Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow, QSplitter, QVBoxLayout, QWidget

from studio.stages import DockSpec
from widgets import theme
from widgets.parts.titles import DockTitle
from widgets.scan.canvas_panel import CanvasPanel
from widgets.scan.face_views import FaceViews
from widgets.scan.fiducials_panel import FiducialsPanel
from widgets.scan.fit_panel import FitPanel
from widgets.scan.inputs_panel import InputsPanel
from widgets.scan.template_panel import TemplatePanel

LEFT, RIGHT = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
BOTTOM = Qt.DockWidgetArea.BottomDockWidgetArea
TEMPLATE_HEIGHT = 240


class ScanWorkspace(QWidget):
    """The work zone: picture over template diagram at the left, 3-D at the right; and the docks beside it.

    Attributes
    ----------
    inputs, canvas_panel, template_panel, fiducials, fit : QWidget
        The panels.
    views : FaceViews
        The 3-D views; their graphics start after the first paint.
    docks : tuple of DockSpec
        What the window docks at its sides.
    template_dock : QDockWidget
        The diagram; it floats and closes like any dock, inside the work zone.
    zones : tuple of QWidget
        The parts that the keys go to one by one.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.inputs = InputsPanel()
        self.canvas_panel = CanvasPanel()
        self.template_panel = TemplatePanel()
        self.fiducials = FiducialsPanel()
        self.fit = FitPanel()
        self.views = FaceViews()
        self.docks = (
            DockSpec("scans", "Scans", self.inputs, LEFT, 832, (("plus", "scan.add"),)),
            DockSpec("fiducials", "Fiducials", self.fiducials, RIGHT, 488),
            DockSpec("fit", "Fit", self.fit, RIGHT, 340),
        )
        self.zones: tuple[QWidget, ...] = (self.canvas_panel, self.template_panel, self.views)
        self._images = QMainWindow(self, Qt.WindowType.Widget)
        self._images.setObjectName("image_zone")
        self._images.setCentralWidget(self.canvas_panel)
        self.template_dock = QDockWidget("Template", self._images)
        self.template_dock.setObjectName("dock_template")
        self.template_dock.setAllowedAreas(BOTTOM | Qt.DockWidgetArea.TopDockWidgetArea)
        self.template_dock.setWidget(self.template_panel)
        self.template_title = DockTitle("Template", "", self.template_dock)
        self._images.addDockWidget(BOTTOM, self.template_dock)
        self._splitter = QSplitter(Qt.Orientation.Horizontal, self)
        self._splitter.setHandleWidth(4)
        self._splitter.setChildrenCollapsible(False)
        self._splitter.addWidget(self._images)
        self._splitter.addWidget(self.views)
        self._splitter.setStretchFactor(0, 1)
        self._splitter.setStretchFactor(1, 1)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self._splitter)
        theme.signals.changed.connect(self._lay_out)
        self.reset()

    def _lay_out(self) -> None:
        layout = self._images.layout()
        if layout is not None:  # a window in a window does not notice by itself that its parts need less room
            layout.invalidate()
            layout.activate()

    def reset(self) -> None:
        """Share the room as at first: picture and 3-D alike, the diagram 240 high."""
        self.template_dock.setFloating(False)
        self.template_dock.show()
        self._splitter.setSizes([446, 446])
        self._images.resizeDocks([self.template_dock], [TEMPLATE_HEIGHT], Qt.Orientation.Vertical)

    def layout_state(self) -> QByteArray:
        """Return how the room is shared; empty while the picture is hidden."""
        return QByteArray() if self._images.isHidden() else self._splitter.saveState()

    def restore_layout(self, state: QByteArray) -> None:
        """Share the room as it was when ``state`` was taken."""
        if not state.isEmpty():
            self._splitter.restoreState(state)

    def show_views_alone(self, alone: bool) -> None:
        """Hide the picture beside the 3-D, or bring it back."""
        self._images.setVisible(not alone)
