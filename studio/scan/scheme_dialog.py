"""The fiducial-scheme editor over the window: what is saved in it becomes one step of the history."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QDialog, QMessageBox, QVBoxLayout, QWidget

from engine.errors import InputError
from engine.landmarks import LandmarkScheme, LandmarkSet
from studio import dialogs
from studio.project.document import Project, ScanItem
from studio.project.schemes import present, resolved, users_of
from studio.scan import edits
from studio.scan.commands import SetLandmarks, SetScheme
from studio.scan.context import ScanContext
from studio.scan.job import SCHEMES, item_scheme, scheme_of, template_for, template_of
from studio.scan.scheme_commands import PutScheme, RemoveScheme
from widgets import theme
from widgets.scan.scheme_editor import OfferedScheme, SchemeEditor, SchemeResult

SIZE = QSize(1208, 728)
TOML_FILTER = "Fiducial scheme (*.toml)"


class SchemeDialog(QDialog):
    """Window-modal; Esc cancels, and asks first where edits would be lost."""

    def __init__(self, context: ScanContext, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Fiducial scheme")
        self._context, self._scan_id = context, context.scan_id
        self.editor = SchemeEditor(template_of(), self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.editor)
        self.editor.finished.connect(self._finish)
        self.editor.remove_requested.connect(self._remove)
        self.editor.import_requested.connect(self._import)
        self.editor.export_requested.connect(self._export)
        self.editor.cancelled.connect(self.reject)
        item = self._item
        self._offer(item.scheme if item is not None else SCHEMES[0])
        self.editor.table.setFocus()
        room = self.screen().availableSize()
        wanted = QSize(theme.px(SIZE.width()), theme.px(SIZE.height()))
        self.resize(wanted.boundedTo(QSize(room.width() - 48, room.height() - 48)))

    def reject(self) -> None:
        """Close; edits that would be lost are asked about."""
        if self.editor.has_changes and not self._may_discard():
            return
        super().reject()

    def _may_discard(self) -> bool:
        buttons = QMessageBox.StandardButton
        box = QMessageBox(
            QMessageBox.Icon.Question,
            "Fiducial scheme",
            f"Discard the changes to scheme {self.editor.draft.name}?",
            buttons.Discard | buttons.Cancel,
            self,
        )
        box.setDefaultButton(buttons.Cancel)
        answer = box.exec()
        box.deleteLater()
        return buttons(answer) == buttons.Discard

    @property
    def _item(self) -> ScanItem | None:
        """The scan that was in view when the dialog was opened; others may come into view behind it."""
        project, scan_id = self._context.project, self._scan_id
        return project.scan(scan_id) if scan_id is not None and scan_id in project else None

    def _offer(self, show: str) -> None:
        project, item = self._context.project, self._item
        own = [OfferedScheme(s, False, tuple(users_of(project, s.name))) for s in project.schemes.values()]
        self.editor.set_schemes([*(OfferedScheme(scheme_of(name), True) for name in SCHEMES), *own], show)
        name, scheme = ("", "") if item is None else (item.name, item.scheme)
        self.editor.set_scan(name, scheme, len(project.scans))

    def _finish(self, result: SchemeResult) -> None:
        try:
            apply_result(self._context, result, self._scan_id)
        except InputError as error:
            self.editor.tell(str(error))
            return
        if result.use or not self._context.project.scans or result.replaces == self._used():
            self.accept()
        else:
            self._offer(result.scheme.name)

    def _used(self) -> str | None:
        item = self._item
        return None if item is None else item.scheme

    def _remove(self, name: str) -> None:
        try:
            self._context.session.stack.push(RemoveScheme(self._context.project, name))
        except InputError as error:
            self.editor.tell(str(error))
            return
        item = self._item
        self._offer(item.scheme if item is not None else SCHEMES[0])

    def _import(self) -> None:
        from engine.files.scheme import read_scheme

        settings = self._context.session.settings
        path = dialogs.open_file(self, settings, "Import scheme", TOML_FILTER)
        if path is None:
            return
        try:
            scheme = read_scheme(path)
            template_of().with_scheme(scheme)
            self.editor.take(scheme)
        except InputError as error:
            subject = error.subject if error.subject.startswith(str(path)) else f"{path}, {error.subject}"
            self.editor.tell(str(InputError(subject, error.problem, error.remedy)))

    def _export(self, scheme: LandmarkScheme) -> None:
        from engine.files.scheme import write_scheme

        settings = self._context.session.settings
        path = dialogs.save_file(self, settings, "Export scheme", f"{scheme.name}.toml", TOML_FILTER)
        if path is None:
            return
        try:
            write_scheme(Path(path), scheme)
        except InputError as error:
            self.editor.tell(str(error))
            return
        self.editor.show_message(f"Wrote {path}", "dim")


def apply_result(context: ScanContext, result: SchemeResult, scan_id: str | None) -> None:
    """Put what came of the editing into the project as one step; new points are proposed where five are placed.

    ``scan_id`` is the scan that a scheme is used on, the one that was in view when it was asked for.

    Raises
    ------
    InputError
        When the scheme cannot be put, or the scan is gone; nothing has changed then.
    """
    project, stack, scheme = context.project, context.session.stack, result.scheme
    if result.use and (scan_id is None or scan_id not in project):
        raise InputError("scan", "is not in the project any more", "close this and choose another")
    put = PutScheme(project, scheme, result.replaces, result.renames) if result.changed else None
    users = [item.id for item in project.scans if result.replaces is not None and item.scheme == result.replaces]
    takers = [item.id for item in project.scans if result.use and (result.everywhere or item.id == scan_id)]
    edit = present(project, ()) if put is None else put.edit
    proposed: dict[str, tuple[LandmarkSet, LandmarkSet]] = {}
    for user in dict.fromkeys((*users, *takers)):
        item = project.scan(user)
        name, landmarks = edit.scans.get(user, (item.scheme, item.landmarks))
        item = replace(item, scheme=scheme.name if user in takers else name, landmarks=landmarks)
        after = _with_proposals(project, resolved(edit.schemes, item))
        if after != landmarks:
            proposed[user] = landmarks, after
    switched = [user for user in takers if edit.scans.get(user, (project.scan(user).scheme,))[0] != scheme.name]
    if put is None and not switched and not proposed:
        return
    stack.beginMacro(f"{'Use' if takers else 'Change' if result.replaces else 'Add'} scheme {scheme.name}")
    try:
        if put is not None:
            stack.push(put)
        for user in switched:
            stack.push(SetScheme(project, user, scheme.name))
        for user, (before, after) in proposed.items():
            stack.push(SetLandmarks(project, user, before, after))
    finally:
        stack.endMacro()


def _with_proposals(project: Project, item: ScanItem) -> LandmarkSet:
    from engine.scan.warp import propose_fiducials

    image, scheme = project.range_image(item.id), item_scheme(item)
    template = template_for(None, scheme)
    return edits.with_proposals(
        item.landmarks,
        item.landmarks,
        scheme,
        (image.width, image.height),
        lambda known: propose_fiducials(template, scheme.name, known),
    )


def open_scheme_editor(context: ScanContext, parent: QWidget) -> SchemeDialog:
    """Show the editor over a window and return at once."""
    dialog = SchemeDialog(context, parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
    return dialog
