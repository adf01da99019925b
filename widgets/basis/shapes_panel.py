"""The shapes of the hand-sculpted rig: found, renamed, reordered, mirrored, split, combined, mapped."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QItemSelection, QItemSelectionModel, QModelIndex, QPoint, QSize, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLineEdit, QMenu, QStackedLayout, QToolButton, QVBoxLayout, QWidget

from widgets import theme
from widgets.basis.shapes_table import ShapeRow
from widgets.basis.shapes_view import ShapesHeader, ShapesView
from widgets.basis.words import figure
from widgets.parts import picture
from widgets.parts.buttons import IconButton
from widgets.parts.empty import EmptyState
from widgets.parts.section import DimLabel

EDITS = {
    "mirror": ("Mirror left / right", "the shape of the other side, as a mirror shows it"),
    "split": ("Split left / right", "two shapes, one for each half of the face"),
    "combine": ("Combine into one", "one shape that is their sum"),
    "duplicate": ("Duplicate", "the same shape under another name"),
    "remove": ("Remove", "take the shapes out of the rig"),
}
"""What ``edit_requested`` may ask for: key -> what is read, what it does."""
MAPPINGS = {"arkit": "ARKit names…", "facs": "FACS action units…"}
"""What ``mapping_requested`` may ask for."""


class ShapesPanel(QWidget):
    """Find field, table and tools.

    Signals
    -------
    selected(str)
        The shape that is looked at.
    selection_changed(object)
        Tuple of the names of all shapes that are marked, in the order of the table.
    rename_requested(str, str)
        Name, and the new one.
    reorder_requested(object)
        Tuple of all names in the order wanted.
    edit_requested(str, object)
        One of ``EDITS``, and the tuple of the names of the shapes meant.
    mapping_requested(str)
        One of ``MAPPINGS``.
    add_requested()
        A rig is to be opened from a file.
    """

    selected = Signal(str)
    selection_changed = Signal(object)
    rename_requested = Signal(str, str)
    reorder_requested = Signal(object)
    edit_requested = Signal(str, object)
    mapping_requested = Signal(str)
    add_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self._rows: tuple[ShapeRow, ...] = ()
        self._current: str | None = None
        self._reasons: dict[str, str] = {}
        self._quiet = False
        self.find_field = QLineEdit()
        self.header = ShapesHeader()
        self.view = ShapesView(self)
        self.none_found = DimLabel("No shape has that in its name.", theme.TABLE_PX)
        self.more_button = IconButton("more", "What can be done with the marked shapes")
        self.empty = EmptyState(
            "No shapes yet",
            "The hand-sculpted rig: a neutral face and the shapes an artist sculpted, as GLB with morph targets, "
            "a folder of OBJ files or .npz. Drop it here.",
            (("Open rig…", "", True),),
        )
        self._offer = picture.offer(self.view, "shapes", "table of the shapes", table=self.cells, menu=False)
        self._arrange()
        self._connect()
        self._list()

    def _arrange(self) -> None:
        self.find_field.setPlaceholderText("Find")
        self.find_field.setAccessibleName("Find shapes")
        self.find_field.setClearButtonEnabled(True)
        self._loupe = self.find_field.addAction(theme.icon("loupe", "dim"), QLineEdit.ActionPosition.TrailingPosition)
        self.more_button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._menu = QMenu(self.more_button)
        self._menu.setToolTipsVisible(True)
        self._menu.aboutToShow.connect(lambda: self.fill_menu(self._menu))
        self.more_button.setMenu(self._menu)
        filled = QWidget()
        top = QHBoxLayout()
        top.setContentsMargins(8, 6, 6, 4)
        top.setSpacing(2)
        top.addWidget(self.find_field, 1)
        top.addWidget(self.more_button)
        self.none_found.setContentsMargins(8, 8, 8, 8)
        column = QVBoxLayout(filled)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(top)
        column.addWidget(self.header)
        column.addWidget(self.none_found)
        column.addWidget(self.view, 1)
        self._stack = QStackedLayout(self)
        self._stack.setContentsMargins(0, 0, 0, 0)
        self._stack.addWidget(self.empty)
        self._stack.addWidget(filled)

    def _connect(self) -> None:
        self.find_field.textChanged.connect(lambda _text: self._list())
        self.header.order_chosen.connect(lambda _order: self._list())
        self.view.shapes.renamed.connect(self.rename_requested)
        self.view.shapes.moved.connect(self._moved)
        self.view.selectionModel().currentChanged.connect(self._row_changed)
        self.view.selectionModel().selectionChanged.connect(self._marks_changed)
        self.view.menu_requested.connect(self._pop_up)
        self.view.remove_requested.connect(lambda: self._edit("remove"))
        self.empty.buttons[0].clicked.connect(self.add_requested)
        theme.signals.changed.connect(self._tint)

    # -- what is shown ---------------------------------------------------------------------------------------

    @property
    def rows(self) -> tuple[ShapeRow, ...]:
        """All shapes, in the order of the rig."""
        return self._rows

    @property
    def current(self) -> str | None:
        """Name of the shape that is looked at."""
        return self._current

    @property
    def note(self) -> str:
        """What stands beside the dock's name: how many there are."""
        return str(len(self._rows)) if self._rows else ""

    @property
    def selection(self) -> tuple[str, ...]:
        """Names of all shapes that are marked, in the order of the table."""
        rows = sorted(index.row() for index in self.view.selectedIndexes())
        return tuple(self.view.shapes.rows[row].name for row in rows)

    def set_shapes(self, rows: Sequence[ShapeRow]) -> None:
        """List shapes; marks stay where their shapes are still there."""
        self._rows = tuple(rows)
        if self._current not in [row.name for row in rows]:
            self._current = None
        self._list()

    def set_cosine_limit(self, limit: float) -> None:
        """Warn at shapes whose cosine to their hand shape lies below ``limit``."""
        self.view.shapes.limit = limit
        self.view.viewport().update()

    def set_current(self, name: str | None) -> None:
        """Mark the shape that is looked at, alone, without telling anybody."""
        if name == self._current and (name is None or name in self.selection):
            return
        self._current = name
        self._mark(() if name is None else (name,))

    def set_edit_available(self, kind: str, available: bool, reason: str = "") -> None:
        """Allow an edit or a mapping, or say why not."""
        self._reasons[kind] = "" if available else reason or "not just now"

    def edit_name(self, name: str) -> None:
        """Let the user type another name for a shape."""
        names = [row.name for row in self.view.shapes.rows]
        if name in names:
            self.view.edit(self.view.shapes.index(names.index(name)))

    def fill_menu(self, menu: QMenu) -> None:
        """Put into a menu what can be done with the marked shapes."""
        menu.clear()
        names = self.selection
        rename = menu.addAction("Rename\tF2")
        rename.triggered.connect(lambda: self.edit_name(self.selection[0]))
        rename.setEnabled(len(names) == 1)
        menu.addSeparator()
        for kind, (text, tip) in EDITS.items():
            action = menu.addAction(text + ("\tDel" if kind == "remove" else ""))
            self._allow(action, self._why_not(kind, names), tip)
            action.triggered.connect(lambda _on=False, kind=kind: self._edit(kind))
        menu.addSeparator()
        for key, text in MAPPINGS.items():
            action = menu.addAction(text)
            why = self._reasons.get(key, "") or ("" if self._rows else "open a rig first")
            self._allow(action, why, "which shapes stand for which names, and which are missing")
            action.triggered.connect(lambda _on=False, key=key: self.mapping_requested.emit(key))
        menu.addSeparator()
        picture.fill_menu(menu, self._offer)

    def cells(self) -> list[list[str]]:
        """Return the rows that are listed as cells, for a spreadsheet."""
        rows = [[r.name, figure(r.change_mm), figure(r.cosine)] for r in self.view.shapes.rows]
        return [["name", "change, RMS mm", "cosine"], *rows]

    # -- what is wanted --------------------------------------------------------------------------------------

    def _why_not(self, kind: str, names: tuple[str, ...]) -> str:
        if not names:
            return "mark a shape first"
        if kind == "combine" and len(names) < 2:
            return "mark two shapes or more, with Ctrl or Shift"
        if kind == "remove" and len(names) == len(self._rows):
            return "a rig keeps at least one shape"
        return self._reasons.get(kind, "")

    @staticmethod
    def _allow(action: QAction, why: str, tip: str) -> None:
        action.setEnabled(not why)
        action.setToolTip(why or tip)

    def _edit(self, kind: str) -> None:
        if not self._why_not(kind, self.selection):
            self.edit_requested.emit(kind, self.selection)

    def _moved(self, names: tuple[str, ...], before: int) -> None:
        order = [row.name for row in self._rows]
        moving = [name for name in names if name in order]
        kept = [name for name in order[:before] if name not in moving]
        rest = [name for name in order[before:] if name not in moving]
        wanted = (*kept, *moving, *rest)
        if moving and wanted != tuple(order):
            self.reorder_requested.emit(wanted)

    def _row_changed(self, index: QModelIndex) -> None:
        if self._quiet or not index.isValid():
            return
        name = self.view.shapes.rows[index.row()].name
        if name != self._current:
            self._current = self.view.delegate.current = name
            self.view.viewport().update()
            self.selected.emit(name)

    def _marks_changed(self, _now: QItemSelection, _before: QItemSelection) -> None:
        if not self._quiet:
            self.selection_changed.emit(self.selection)

    def _pop_up(self, place: QPoint) -> None:
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.setToolTipsVisible(True)
        self.fill_menu(menu)
        menu.popup(place)

    # -- listing ---------------------------------------------------------------------------------------------

    def _list(self) -> None:
        wanted, order = self.find_field.text().strip().lower(), self.header.order
        rows = [row for row in self._rows if wanted in row.name.lower()]
        if order == "name":
            rows.sort(key=lambda row: row.name.lower())
        elif order == "mm":
            rows.sort(key=lambda row: -_known(row.change_mm, 0.0))
        elif order == "cosine":
            rows.sort(key=lambda row: _known(row.cosine, 2.0))
        marked = self.selection
        self.view.shapes.may_move = not wanted and order == "rig"
        self._quiet = True
        self.view.shapes.show(rows)
        self._quiet = False
        there = {row.name for row in rows}
        self._mark([n for n in marked if n in there] or [n for n in [self._current] if n in there])
        self.none_found.setVisible(bool(self._rows) and not rows)
        self._stack.setCurrentIndex(1 if self._rows else 0)
        self.view.viewport().update()

    def _mark(self, names: Sequence[str | None]) -> None:
        self._quiet = True
        self.view.delegate.current = self._current
        places = {row.name: k for k, row in enumerate(self.view.shapes.rows)}
        model, flags = self.view.selectionModel(), QItemSelectionModel.SelectionFlag
        model.clearSelection()
        for name in names:
            if name in places:
                model.select(self.view.shapes.index(places[name]), flags.Select)
        if self._current in places:
            index = self.view.shapes.index(places[self._current])
            model.setCurrentIndex(index, flags.NoUpdate)
            self.view.scrollTo(index)
        self._quiet = False
        self.view.viewport().update()

    def _tint(self) -> None:
        self._loupe.setIcon(theme.icon("loupe", "dim"))
        self.view.scheduleDelayedItemsLayout()

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(232, 420)

    def minimumSizeHint(self) -> QSize:
        """Return the room for the find field and two rows."""
        return QSize(theme.px(180), theme.px(32 + 22 + 2 * 28))


def _known(value: float | None, otherwise: float) -> float:
    return otherwise if value is None or value != value else value
