"""The widgets of the basis stage and where they stand; they know neither each other nor the project."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from studio.stages import DockSpec
from widgets import theme
from widgets.basis.advice_panel import AdvicePanel
from widgets.basis.cloud_panel import CloudPanel
from widgets.basis.eigen_panel import EigenPanel
from widgets.basis.error_panel import ErrorPanel
from widgets.basis.guide_panel import GuidePanel
from widgets.basis.inputs_panel import BasisInputsPanel
from widgets.basis.projection_panel import ProjectionPanel
from widgets.basis.shape_panel import ShapePanel
from widgets.basis.timeline_panel import TimelinePanel
from widgets.basis.views import BasisViews

LEFT, RIGHT = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
BOTTOM = Qt.DockWidgetArea.BottomDockWidgetArea


class Scrolled(QScrollArea):
    """The content of a dock that scrolls where the column is low; ``at_most``: never higher than the content."""

    def __init__(self, content: QWidget, *, at_most: bool = False) -> None:
        super().__init__()
        self._content, self._at_most = content, at_most
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setWidget(content)
        theme.signals.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        if self._at_most:
            self.setMaximumHeight(self._content.sizeHint().height())
        self.updateGeometry()

    def sizeHint(self) -> QSize:
        """Return the size of the content."""
        return self._content.sizeHint()

    def minimumSizeHint(self) -> QSize:
        """Return the breadth of the content and the height of two lines."""
        return QSize(self._content.minimumSizeHint().width(), theme.px(44))


class BasisWorkspace(QWidget):
    """The 3-D views, and the docks beside and below them.

    Attributes
    ----------
    views : BasisViews
        The centre; its graphics start after the first paint.
    inputs, shape, error, projection, advice, eigen, cloud, guide, timeline : QWidget
        The panels; ``shapes`` and ``motion`` are the parts of ``inputs``.
    docks : tuple of DockSpec
        What the window docks.
    zones : tuple of QWidget
        The parts that the keys go to one by one.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.views = BasisViews()
        self.inputs = BasisInputsPanel()
        self.shapes, self.motion = self.inputs.shapes, self.inputs.motion
        self.shape = ShapePanel()
        self.error = ErrorPanel()
        self.projection = ProjectionPanel()
        self.advice = AdvicePanel()
        self.eigen = EigenPanel()
        self.cloud = CloudPanel()
        self.guide = GuidePanel()
        self.timeline = TimelinePanel()
        self.docks = (
            DockSpec("shapes", "Shapes", self.inputs, LEFT, 604, (("plus", "basis.add_rig"),)),
            DockSpec("shape", "Shape", Scrolled(self.shape, at_most=True), RIGHT, 168),
            DockSpec("error", "Error α %", self.error, RIGHT, 240),
            DockSpec("projection", "Projection", Scrolled(self._below()), RIGHT, 244),
            DockSpec("eigenfaces", "Eigenfaces", self.eigen, RIGHT, 216, tab="projection"),
            DockSpec("cloud", "Cloud", self.cloud, RIGHT, 216, tab="projection"),
            DockSpec("guide", "Guide", self.guide, RIGHT, 216, tab="projection"),
            DockSpec("time", "Performance error", self.timeline, BOTTOM, 176),
        )
        self.zones: tuple[QWidget, ...] = (self.views,)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.views)

    def _below(self) -> QWidget:
        """Return the projection with the advice that follows from it."""
        pair = QWidget()
        pair.setAutoFillBackground(True)
        column = QVBoxLayout(pair)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.projection, 1)
        column.addWidget(self.advice)
        return pair
