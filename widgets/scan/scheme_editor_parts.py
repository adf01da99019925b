"""What the fiducial-scheme editor is made of, and where it stands; it decides nothing."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QCheckBox, QComboBox, QHBoxLayout, QLineEdit, QSizePolicy, QVBoxLayout, QWidget

from engine.scan.template import FaceTemplate
from widgets import theme
from widgets.parts.buttons import IconButton, KeyButton
from widgets.parts.section import DimLabel
from widgets.parts.segments import Segments
from widgets.scan.scheme_table import SchemeTable
from widgets.scan.template_chart import TemplateChart

NUMBER_PX = 28


class EditorParts(QWidget):
    """The widgets of the editor: ``chart`` at the left; scheme, table, number, message and buttons at the right."""

    def __init__(self, template: FaceTemplate, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.choice = QComboBox()
        self.choice.setAccessibleName("Scheme")
        self.duplicate_button = KeyButton("Duplicate")
        self.remove_button = IconButton("trash", "Take the scheme out of the project")
        self.import_button = KeyButton("Import…")
        self.export_button = KeyButton("Export…")
        self.name, self.title = QLineEdit(), QLineEdit()
        self.name.setAccessibleName("Name of the scheme")
        self.title.setAccessibleName("Title of the scheme")
        self.title.setPlaceholderText("What it is for")
        self.layout_choice = Segments([("closed", "Closed mouth"), ("open", "Open mouth")], name="Layout")
        self.numbers = QCheckBox("Vertex numbers")
        self.numbers.setToolTip("Write the number of every vertex beside it; zoom in with the wheel to read them")
        self.frame_button = IconButton("fit-view", "Show the whole template (F)")
        self.chart = TemplateChart(template)
        self.frame_button.clicked.connect(self.chart.fit_view)
        self.add_button = IconButton("plus", "Add a fiducial below the chosen one")
        self.copy_button = IconButton("copy", "Duplicate the fiducial")
        self.mirror_button = IconButton("mirror", "Mirror to other side: make its partner, or put it in its place")
        self.up_button = IconButton("chevron-down", "Earlier in the clicking order (Alt+Up)")
        self.down_button = IconButton("chevron-down", "Later in the clicking order (Alt+Down)")
        self.up_button.setArrowType(Qt.ArrowType.UpArrow)
        self.down_button.setArrowType(Qt.ArrowType.DownArrow)
        self.delete_button = IconButton("close", "Delete the fiducial (Del)")
        self.undo_button = IconButton("undo", "Undo in here (Ctrl+Z)")
        self.redo_button = IconButton("redo", "Redo in here (Ctrl+Shift+Z)")
        self.table = SchemeTable()
        self.number = DimLabel("", NUMBER_PX, role="text", bold=True)
        self.number.setAccessibleName("Vertex number")
        self.number.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.number_button = IconButton("copy", "Copy the vertex number")
        self.about = DimLabel("", theme.TABLE_PX)
        self.message = DimLabel("")
        self.message.setWordWrap(True)
        self.message.setAlignment(Qt.AlignmentFlag.AlignVCenter)
        self.everywhere = QCheckBox("")
        self.cancel_button = KeyButton("Cancel", "Esc")
        self.save_button = KeyButton("Save only")
        self.primary_button = KeyButton("Save changes", primary=True)
        self._arrange()

    def _arrange(self) -> None:
        left = QVBoxLayout()
        left.setSpacing(8)
        left.addLayout(_line(self.layout_choice, None, self.numbers, self.frame_button))
        left.addWidget(self.chart, 1)
        right = QVBoxLayout()
        right.setSpacing(8)
        self.choice.setMinimumContentsLength(14)
        self.choice.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        right.addLayout(
            _line(self.choice, self.duplicate_button, self.remove_button, None, self.import_button, self.export_button)
        )
        theme.fix(self.name, width=150)
        right.addLayout(_line(DimLabel("Name"), self.name, DimLabel("Title"), self.title))
        self._tools = (
            self.add_button, self.copy_button, self.mirror_button, self.up_button, self.down_button,
            self.delete_button,
        )  # fmt: skip
        right.addLayout(_line(*self._tools, None, self.undo_button, self.redo_button))
        right.addWidget(self.table, 1)
        theme.fix(self.number, width=72)
        right.addLayout(_line(self.number, self.number_button, self.about, None))
        self.message.setMinimumHeight(theme.px(32))
        right.addWidget(self.message)
        right.addLayout(_line(self.everywhere, None, self.cancel_button, self.save_button, self.primary_button))
        row = QHBoxLayout(self)
        row.setContentsMargins(16, 16, 16, 16)
        row.setSpacing(16)
        row.addLayout(left, 43)
        row.addLayout(right, 57)
        order = (
            self.choice, self.duplicate_button, self.remove_button, self.import_button, self.export_button, self.name,
            self.title, *self._tools, self.undo_button, self.redo_button, self.table, self.layout_choice, self.numbers,
            self.frame_button, self.chart, self.number_button, self.everywhere, self.cancel_button, self.save_button,
            self.primary_button,
        )  # fmt: skip
        for first, second in pairwise(order):
            QWidget.setTabOrder(first, second)

    def show_head(self, name: str, title: str, layout: str, fixed: bool) -> None:
        """Show what the scheme is called and which layout it stands on."""
        for field, text in ((self.name, name), (self.title, title)):
            field.setReadOnly(fixed)
            if field.text() != text:
                field.setText(text)
        self.layout_choice.set_current(layout)
        self.layout_choice.setEnabled(not fixed)

    def show_choice(self, entries: Sequence[tuple[str, str]], current: str) -> None:
        """Offer schemes by (name, text); the one without a name is new."""
        self.choice.clear()
        for name, text in entries:
            self.choice.addItem(text, name)
        self.choice.setCurrentIndex(max(self.choice.findData(current), self.choice.findData("")))

    def show_tools(self, fixed: bool, row: int, count: int, can_undo: bool, can_redo: bool) -> None:
        """Enable the tools of the table, or say why not."""
        why = "It comes with the program: duplicate it to change it" if fixed else ""
        for button in self._tools:
            button.set_available(not why, why)
        if not why:
            self.up_button.set_available(row > 0, "It is the first")
            self.down_button.set_available(row + 1 < count, "It is the last")
            for button in (self.copy_button, self.mirror_button, self.delete_button):
                button.set_available(count > 0, "There is none")
        self.undo_button.set_available(can_undo, "Nothing was done in here")
        self.redo_button.set_available(can_redo, "Nothing was undone in here")

    def show_vertex(self, number: str, about: str) -> None:
        """Show a vertex number, large, and what is known of it."""
        self.number.setText(number or "–")
        self.number_button.set_available(bool(number), "It has no vertex yet")
        self.about.setText(about)

    def show_message(self, text: str, role: str) -> None:
        """Say something in a colour role."""
        self.message.set_role(role)
        self.message.setText(text)


def _line(*widgets: QWidget | None) -> QHBoxLayout:
    """Return widgets side by side; None stands for the room between them."""
    line = QHBoxLayout()
    line.setSpacing(4)
    for widget in widgets:
        if widget is None:
            line.addStretch(1)
        else:
            line.addWidget(widget)
    return line
