"""The fiducial-scheme editor: the template at the left, names and vertex numbers at the right."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QGuiApplication, QKeySequence, QShortcut
from PySide6.QtWidgets import QWidget

from engine.errors import InputError
from engine.landmarks import LandmarkScheme, Side
from engine.scan.scheme_vertices import side_of_vertex
from engine.scan.template import FaceTemplate
from engine.scheme_checks import Finding
from widgets.scan.scheme_draft import DraftHistory, SchemeDraft
from widgets.scan.scheme_editor_parts import EditorParts
from widgets.scan.template_chart import Ring


@dataclass(frozen=True)
class OfferedScheme:
    """A scheme that can be shown; one that is shipped cannot be changed. ``users`` names the scans that use it."""

    scheme: LandmarkScheme
    shipped: bool
    users: tuple[str, ...] = ()


@dataclass(frozen=True)
class SchemeResult:
    """What came of the editing.

    Parameters
    ----------
    scheme : LandmarkScheme
        As it is now.
    replaces : str or None
        The project's scheme whose place it takes; None for a new one, and for one that is shipped.
    renames : mapping of str to str
        New names of fiducials by their old ones.
    changed : bool
        Whether it has to be put into the project.
    use : bool
        Whether the scan in view is to use it.
    everywhere : bool
        Whether all other scans are to use it, too.
    """

    scheme: LandmarkScheme
    replaces: str | None
    renames: Mapping[str, str]
    changed: bool
    use: bool
    everywhere: bool


class SchemeEditor(EditorParts):
    """Shows one scheme at a time; all edits stay in here until they are saved, and Ctrl+Z takes them back.

    Signals
    -------
    finished(SchemeResult)
        Save, or use, what is shown.
    remove_requested(str)
        The project's scheme of this name is to go.
    import_requested(), export_requested(LandmarkScheme)
        A scheme from, to a TOML file.
    cancelled()
        Nothing is to be done.
    """

    finished = Signal(object)
    remove_requested = Signal(str)
    import_requested = Signal()
    export_requested = Signal(object)
    cancelled = Signal()

    def __init__(self, template: FaceTemplate, parent: QWidget | None = None) -> None:
        super().__init__(template, parent)
        self._template = template
        self._offered: dict[str, OfferedScheme] = {}
        self._scan, self._used, self._scans = "", "", 0
        self._replaces: str | None = None
        self._fixed = False
        self._base: SchemeDraft | None = None
        self._history: DraftHistory | None = None
        self._row = 0
        self._hovered = -1
        self._connect()

    def _connect(self) -> None:
        self.chart.vertex_clicked.connect(self._take_vertex)
        self.chart.vertex_hovered.connect(self._hover)
        self.table.selected.connect(self.choose_row)
        self.table.edited.connect(self._edit)
        self.table.move_requested.connect(self._move)
        self.table.delete_requested.connect(lambda: self._if_open(self._delete))
        self.add_button.clicked.connect(lambda: self._insert(self.draft.added(self._row)))
        self.copy_button.clicked.connect(lambda: self._insert(self.draft.duplicated(self._row)))
        self.delete_button.clicked.connect(lambda: self._if_open(self._delete))
        self.mirror_button.clicked.connect(lambda: self._if_open(self._mirror))
        self.up_button.clicked.connect(lambda: self._move(-1))
        self.down_button.clicked.connect(lambda: self._move(1))
        self.undo_button.clicked.connect(self.undo)
        self.redo_button.clicked.connect(self.redo)
        self.number_button.clicked.connect(self.copy_number)
        self.numbers.toggled.connect(self.chart.set_numbers)
        self.layout_choice.chosen.connect(lambda key: self._head(layout=key))
        self.name.textEdited.connect(lambda text: self._head(name=text))
        self.title.textEdited.connect(lambda text: self._head(title=text))
        self.choice.activated.connect(lambda _: self.show_scheme(str(self.choice.currentData())))
        self.duplicate_button.clicked.connect(self.duplicate)
        self.remove_button.clicked.connect(self._remove)
        self.import_button.clicked.connect(self.import_requested)
        self.export_button.clicked.connect(lambda: self.export_requested.emit(self.draft.scheme()))
        self.cancel_button.clicked.connect(self.cancelled)
        self.save_button.clicked.connect(lambda: self._finish(use=False))
        self.primary_button.clicked.connect(lambda: self._finish(use=True))
        for keys, deed in (("Ctrl+Z", self.undo), ("Ctrl+Shift+Z", self.redo)):
            shortcut = QShortcut(QKeySequence(keys), self, context=Qt.ShortcutContext.WidgetWithChildrenShortcut)
            shortcut.activated.connect(deed)

    # -- values -----------------------------------------------------------------------------------------------------

    @property
    def draft(self) -> SchemeDraft:
        """What is shown now."""
        assert self._history is not None
        return self._history.draft

    @property
    def row(self) -> int:
        """The row in hand."""
        return self._row

    @property
    def has_changes(self) -> bool:
        """Whether there is something that closing would lose."""
        return self._history is not None and not self._fixed and self.draft != self._base

    def set_scan(self, name: str, scheme: str, count: int) -> None:
        """Say which scan is in view (empty: none), which scheme it uses, and how many scans there are."""
        self._scan, self._used, self._scans = name, scheme, count
        self._show()

    def set_schemes(self, offered: Sequence[OfferedScheme], show: str) -> None:
        """Offer schemes and show one of them."""
        self._offered = {entry.scheme.name: entry for entry in offered}
        self.show_scheme(show)

    def show_scheme(self, name: str) -> None:
        """Show one of the offered schemes."""
        entry = self._offered[name]
        self._fixed, self._replaces = entry.shipped, None if entry.shipped else name
        self._begin(SchemeDraft.of(entry.scheme, self._template), is_new=False)

    def take(self, scheme: LandmarkScheme) -> None:
        """Show a scheme that is not in the project, as one to be added to it; a name that is taken gets a number."""
        self._fixed, self._replaces = False, None
        self._begin(SchemeDraft.of(replace(scheme, name=self._free(scheme.name)), self._template), is_new=True)

    def duplicate(self) -> None:
        """Go on with a copy of the scheme in view, under a name of its own."""
        self.take(replace(self.draft.scheme(), title=""))
        self.name.setFocus()
        self.name.selectAll()

    def tell(self, text: str) -> None:
        """Say what went wrong outside."""
        self.show_message(text, "stale_text")

    # -- deeds ------------------------------------------------------------------------------------------------------

    def choose_row(self, row: int) -> None:
        """Take a row in hand."""
        self._row = max(0, min(row, len(self.draft.rows) - 1))
        self._show()

    def undo(self) -> None:
        """Take back the last edit in here."""
        if self._history is not None:
            self._history.undo()
            self._show()

    def redo(self) -> None:
        """Do it again."""
        if self._history is not None:
            self._history.redo()
            self._show()

    def copy_number(self) -> None:
        """Put the vertex number on the clipboard."""
        if self.number.text().isdigit():
            QGuiApplication.clipboard().setText(self.number.text())
            self.show_message(f"Copied {self.number.text()}", "dim")

    def _begin(self, draft: SchemeDraft, is_new: bool) -> None:
        self._history, self._base = DraftHistory(draft), None if is_new else draft
        self._row = 0
        self._show()

    def _free(self, name: str) -> str:
        wanted, number = name, 2
        while name in self._offered:
            name, number = f"{wanted[:44]}_{number}", number + 1
        return name

    def _push(self, draft: SchemeDraft, field: str = "") -> None:
        if self._history is not None and not self._fixed:
            self._history.push(draft, field)
            self._show()

    def _head(self, **fields: str) -> None:
        field = next(iter(fields))
        self._push(replace(self.draft, **fields), "" if field == "layout" else field)  # type: ignore[arg-type]

    def _take_vertex(self, vertex: int) -> None:
        carried = self.draft.row_at(vertex, self._template)
        if carried is not None:
            self.choose_row(carried)
        elif self._fixed:
            self.show_message("This scheme comes with the program: duplicate it to change it", "dim")
        elif self.draft.rows:
            self._push(self.draft.placed(self._row, vertex, self._template))

    def _hover(self, vertex: int) -> None:
        self._hovered = vertex
        self._show_number()

    def _edit(self, row: int, field: str, text: str) -> None:
        draft = self.draft
        if field == "name":
            self._push(draft.renamed(row, text))
        elif field == "mirror":
            self._push(draft.mirrored_with(row, text))
        elif field != "vertex":
            self._push(draft.changed(row, **{field: Side(text) if field == "side" else text}))
        elif not text:
            self._push(draft.changed(row, vertex=None))
        elif text.isascii() and text.isdigit() and int(text) < len(self._template.mirror):
            self._push(draft.placed(row, int(text), self._template))
        else:
            last = len(self._template.mirror) - 1
            self.show_message(f"{text[:20]} is no vertex; give a number from 0 to {last}", "stale_text")

    def _insert(self, draft: SchemeDraft) -> None:
        if not self._fixed:
            self._row += 1 if len(draft.rows) > 1 else 0
            self._push(draft)
            self.table.edit_field(self._row, "name")

    def _delete(self) -> None:
        if self.draft.rows:
            draft, row = self.draft.deleted(self._row), self._row
            self._row = max(0, min(row, len(draft.rows) - 1))
            self._push(draft)

    def _mirror(self) -> None:
        try:
            self._push(self.draft.with_partner(self._row, self._template))
        except ValueError as error:
            self.show_message(f"{self.draft.marks[self._row].name} has no mirror: {error}", "stale_text")

    def _move(self, by: int) -> None:
        to = self._row + by
        if not self._fixed and 0 <= to < len(self.draft.rows):
            draft, self._row = self.draft.moved(self._row, to), to
            self._push(draft)

    def _remove(self) -> None:
        if self._replaces is not None:
            self.remove_requested.emit(self._replaces)

    def _if_open(self, deed: Callable[[], None]) -> None:
        if not self._fixed and self.draft.rows:
            deed()

    def _finish(self, use: bool) -> None:
        try:
            scheme = self.draft.scheme()
        except InputError as error:
            self.tell(str(error))
            return
        everywhere = use and not self.everywhere.isHidden() and self.everywhere.isChecked()
        renames = {} if self._replaces is None else self.draft.renames
        use = use and bool(self._scan)
        self.finished.emit(SchemeResult(scheme, self._replaces, renames, self.has_changes, use, everywhere))

    # -- showing ----------------------------------------------------------------------------------------------------

    def _show(self) -> None:
        if self._history is None:
            return
        draft, template = self.draft, self._template
        self._row = max(0, min(self._row, len(draft.rows) - 1))
        findings = draft.findings(template)
        vertices = [draft.vertex(row, template) for row in range(len(draft.rows))]
        self.chart.set_layout(draft.layout)
        rings = {v: Ring(m.name, m.side) for v, m in zip(vertices, draft.marks, strict=True) if v is not None}
        self.chart.set_rings(rings, vertices[self._row] if vertices else None)
        self.chart.set_read_only(self._fixed)
        self.table.show_draft(draft.marks, vertices, findings, self._row, self._fixed)
        self.show_head(draft.name, draft.title, draft.layout, self._fixed)
        entries = [(name, f"{name}, {len(entry.scheme)} points") for name, entry in self._offered.items()]
        is_new = not self._fixed and self._replaces is None
        self.show_choice([*entries, ("", f"{draft.name}, new")] if is_new else entries, self._replaces or draft.name)
        changed, errors = self.has_changes, [finding for finding in findings if finding.is_error]
        held = "Save or undo the changes first" if changed else ""
        self.choice.setEnabled(not changed)
        self.choice.setToolTip(held)
        broken = "This scheme is not right yet" if errors else ""
        self.duplicate_button.set_available(not held and not broken, held or broken)
        self.import_button.set_available(not held, held)
        self.export_button.set_available(not broken, broken)
        self.remove_button.set_available(*self._removable())
        self.show_tools(self._fixed, self._row, len(draft.rows), self._history.can_undo, self._history.can_redo)
        self._show_number()
        self._show_findings(findings)
        self._show_buttons(errors[0].text if errors else "")

    def _removable(self) -> tuple[bool, str]:
        if self._fixed:
            return False, "It comes with the program"
        if self._replaces is None:
            return False, "It is not in the project yet"
        users = self._offered[self._replaces].users
        return (False, f"Used by {', '.join(users[:3])}") if users else (True, "")

    def _show_number(self) -> None:
        draft, template = self.draft, self._template
        vertex = self._hovered if self._hovered >= 0 else draft.vertex(self._row, template) if draft.rows else None
        if vertex is None:
            self.show_vertex("", "Click its place on the template")
            return
        x, y = template.layout(draft.layout).vertices[vertex]
        carried = draft.row_at(vertex, template)
        name = draft.marks[carried].name if carried is not None else "free"
        mirror = int(template.mirror[vertex])
        where = side_of_vertex(template, vertex) if mirror == vertex else f"mirror {mirror}"
        self.show_vertex(str(vertex), f"{name}\n{x:.1f}, {y:.1f} in the template  ·  {where}")

    def _show_findings(self, findings: Sequence[Finding]) -> None:
        about = [finding for finding in findings if finding.row == self._row] or list(findings)
        if not about:
            names = f"{len(self.draft.rows)} fiducials"
            said = ", shipped with the program: duplicate it to change it" if self._fixed else ", nothing is wrong"
            self.show_message(names + said, "dim")
            return
        first = about[0]
        where = f"{self.draft.marks[first.row].name[:40]}: " if first.row is not None else ""
        more = f"  (+{len(findings) - 1})" if len(findings) > 1 else ""
        self.show_message(f"{where}{first.text}{more}", "stale_text" if first.is_error else "dim")

    def _show_buttons(self, error: str) -> None:
        used = bool(self._scan) and self._used == (self._replaces or ("" if not self._fixed else self.draft.name))
        using = bool(self._scan) and not used
        self.everywhere.setVisible(using and self._scans > 1)
        self.everywhere.setText(f"On all {self._scans} scans")
        self.primary_button.setText("Use scheme" if using else "Save changes")
        reason = error
        if not error and not using and not self.has_changes:
            reason = f"“{self._scan}” uses this scheme, and nothing has changed" if used else "Nothing has changed"
        self.primary_button.set_available(not reason, reason)
        self.save_button.setVisible(using and self.has_changes)
        self.save_button.set_available(not error, error)
