"""The preferences as a panel, made of nothing but the declarations of the values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFrame,
    QHBoxLayout,
    QLineEdit,
    QListWidget,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from widgets import theme
from widgets.parts.buttons import IconButton
from widgets.parts.section import DimLabel
from widgets.window.value_input import ValueInput

WIDTH, HEIGHT, SECTIONS = 640, 460, 148


class Described(Protocol):
    """A remembered value as it is declared."""

    @property
    def key(self) -> str:
        """What it is kept under."""

    @property
    def type(self) -> type:
        """``bool``, ``int``, ``float`` or ``str``."""

    @property
    def default(self) -> Any:
        """What it is at first."""

    @property
    def title(self) -> str:
        """What people call it."""

    @property
    def section(self) -> str:
        """The heading it stands under."""

    @property
    def text(self) -> str:
        """A sentence that says what it is for."""

    @property
    def choices(self) -> tuple[Any, ...]:
        """The values it can take; empty where they are many."""

    @property
    def labels(self) -> tuple[str, ...]:
        """What people call the choices."""

    @property
    def minimum(self) -> float | None:
        """Least number."""

    @property
    def maximum(self) -> float | None:
        """Largest number."""

    @property
    def unit(self) -> str:
        """Written behind the number."""


class PreferenceRow(QWidget):
    """One value: title, control, the way back to the default, and the sentence below."""

    changed = Signal(str, object)
    reset_requested = Signal(str)

    def __init__(self, setting: Described, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setting = setting
        self.title = DimLabel(setting.title, role="text")
        self.input = ValueInput(setting)
        self.title.setBuddy(self.input.control)
        self.hint = DimLabel(setting.text, theme.TABLE_PX)
        self.hint.setWordWrap(True)
        self.reset = IconButton("reset", f"Reset {setting.title} to its default", edge=22, glyph=14)
        line = QHBoxLayout()
        line.setSpacing(8)
        line.addWidget(self.title, 1)
        line.addWidget(self.input)
        line.addWidget(self.reset)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 4, 0, 8)
        column.setSpacing(2)
        column.addLayout(line)
        column.addWidget(self.hint)
        self.input.changed.connect(lambda value: self.changed.emit(setting.key, value))
        self.reset.clicked.connect(lambda: self.reset_requested.emit(setting.key))

    def show_value(self, value: Any) -> None:
        """Show the value without telling anybody."""
        self.input.show_value(value)
        self.reset.set_available(value != self.setting.default, "It is the default")

    def matches(self, words: Sequence[str]) -> bool:
        """Return whether every word occurs in title, section, sentence or choices."""
        setting = self.setting
        text = " ".join((setting.title, setting.section, setting.text, *setting.labels)).lower()
        return all(word in text for word in words)


class PreferencesPanel(QWidget):
    """Sections at the left, their values at the right; the search looks through all of them.

    Parameters
    ----------
    settings : sequence of Described
        What is shown, in this order; values without a section are left out.

    Signals
    -------
    changed(str, object)
        Key and the value that the user wants.
    reset_requested(str)
        Key of a value that is to be its default again; empty for all.
    closed()
        The user has done.
    """

    changed = Signal(str, object)
    reset_requested = Signal(str)
    closed = Signal()

    def __init__(self, settings: Sequence[Described], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        shown = [setting for setting in settings if setting.section]
        self.search = QLineEdit()
        self.search.setPlaceholderText("Search the preferences")
        self.search.setAccessibleName("Search the preferences")
        self.search.setClearButtonEnabled(True)
        self.sections = QListWidget()
        self.sections.setAccessibleName("Sections")
        self.sections.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        theme.fix(self.sections, width=SECTIONS)
        self.sections.setStyleSheet("QListWidget::item { padding: 4px 8px; }")
        self.sections.setFont(theme.font())
        self.rows = {setting.key: PreferenceRow(setting) for setting in shown}
        self.headings: dict[str, DimLabel] = {}
        self.error = DimLabel("", role="captured")
        self.error.setWordWrap(True)
        self.nothing = DimLabel("No preference has these words.")
        self.reset_all = QPushButton("Reset all")
        self.reset_all.setToolTip("Put every preference back to its default; window layout and recent files stay")
        self.close_button = QPushButton("Close")
        self.close_button.setProperty("primary", True)
        self.close_button.setDefault(True)
        self._arrange(shown)
        self._connect()
        self.sections.setCurrentRow(0)
        self._filter()

    def _arrange(self, shown: Sequence[Described]) -> None:
        values = QWidget()
        values.setAutoFillBackground(True)
        column = QVBoxLayout(values)
        column.setContentsMargins(16, 0, 16, 8)
        column.setSpacing(0)
        column.addWidget(self.nothing)
        for section in dict.fromkeys(setting.section for setting in shown):
            self.sections.addItem(section)
            heading = self.headings[section] = DimLabel(section, theme.NAME_PX, role="text", bold=True)
            heading.setContentsMargins(0, 8, 0, 4)
            column.addWidget(heading)
            for setting in shown:
                if setting.section == section:
                    column.addWidget(self.rows[setting.key])
        column.addStretch(1)
        self.area = QScrollArea()
        self.area.setWidgetResizable(True)
        self.area.setFrameShape(QFrame.Shape.NoFrame)
        self.area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.area.setWidget(values)
        middle = QHBoxLayout()
        middle.setSpacing(8)
        middle.addWidget(self.sections)
        middle.addWidget(self.area, 1)
        buttons = QHBoxLayout()
        buttons.setSpacing(8)
        buttons.addWidget(self.reset_all)
        buttons.addWidget(self.error, 1)
        buttons.addWidget(self.close_button)
        box = QVBoxLayout(self)
        box.setContentsMargins(16, 16, 16, 16)
        box.setSpacing(8)
        box.addWidget(self.search)
        box.addLayout(middle, 1)
        box.addLayout(buttons)

    def _connect(self) -> None:
        for row in self.rows.values():
            row.changed.connect(self.changed)
            row.reset_requested.connect(self.reset_requested)
        self.reset_all.clicked.connect(lambda: self.reset_requested.emit(""))
        self.close_button.clicked.connect(self.closed)
        self.search.textChanged.connect(self._filter)
        self.sections.currentTextChanged.connect(self._filter)

    def show_value(self, key: str, value: Any) -> None:
        """Show a value; a key that is not shown is ignored."""
        if key in self.rows:
            self.rows[key].show_value(value)

    def tell(self, text: str) -> None:
        """Say why a value could not be taken; nothing when empty."""
        self.error.setText(text)

    def _filter(self) -> None:
        words = self.search.text().lower().split()
        section = self.sections.currentItem()
        chosen = "" if section is None else section.text()
        shown = set()
        for row in self.rows.values():
            seen = row.matches(words) if words else row.setting.section == chosen
            row.setVisible(seen)
            if seen:
                shown.add(row.setting.section)
        for name, heading in self.headings.items():
            heading.setVisible(name in shown)
        self.nothing.setVisible(not shown)
        self.sections.setEnabled(not words)
