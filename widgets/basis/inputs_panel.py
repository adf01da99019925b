"""What goes into a basis: the shapes above, the performance below."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from widgets.basis.motion_panel import MotionPanel
from widgets.basis.shapes_panel import ShapesPanel


class BasisInputsPanel(QWidget):
    """``shapes`` above, ``motion`` below; where the window is low, the lower part scrolls."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.shapes = ShapesPanel()
        self.motion = MotionPanel()
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setWidget(self.motion)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.shapes, 5)
        column.addWidget(area, 3)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(232, 604)

    def minimumSizeHint(self) -> QSize:
        """Return the least that can be worked with."""
        return QSize(200, 240)
