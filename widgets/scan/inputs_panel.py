"""What goes in: the list of scans, and below it the source of the chosen one."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from widgets.scan.scan_list import ScanList
from widgets.scan.source_panel import SourcePanel


class InputsPanel(QWidget):
    """``scan_list`` above, ``source_panel`` below; where the window is low, the lower part scrolls."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.scan_list = ScanList()
        self.source_panel = SourcePanel()
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setWidget(self.source_panel)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.scan_list)
        column.addWidget(area, 1)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(232, 804)

    def minimumSizeHint(self) -> QSize:
        """Return the least that can be worked with."""
        return QSize(200, 320)
