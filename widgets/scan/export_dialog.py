"""The dialog that exports a face: format, file, what will be in it, and the command that writes the same."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from widgets.parts.command_line import CommandLine
from widgets.parts.form_dialog import FormDialog
from widgets.parts.path_field import PathField
from widgets.parts.section import DimLabel
from widgets.parts.segments import Segments

FACE_FILTER = "glTF binary (*.glb);;Wavefront OBJ (*.obj)"
FORMATS = {".glb": "GLB", ".obj": "OBJ"}
_UNITS = {".glb": "metres, one file", ".obj": "millimetres, with material and texture beside it"}


@dataclass(frozen=True)
class FaceContents:
    """What a face's file will hold: counts, the texture's width and height (none without a colour picture)."""

    vertices: int
    triangles: int
    texture: tuple[int, int] | None

    def text(self) -> str:
        """Return it in words."""
        picture = (
            "no texture: the scan has no colour"
            if self.texture is None
            else "texture {} \u00d7 {}".format(*self.texture)
        )
        return f"{self.vertices} vertices, {self.triangles} triangles, normals, {picture}"

    def bytes(self, ending: str) -> int:
        """Return about how large the files will be together."""
        # GLB: position, normal, texture place, source vertex and three indices of 4 bytes; OBJ: lines of text.
        mesh = (
            self.vertices * 36 + self.triangles * 12 if ending == ".glb" else self.vertices * 78 + self.triangles * 48
        )
        return mesh + (0 if self.texture is None else round(1.6 * self.texture[0] * self.texture[1]))


class ExportDialog(FormDialog):
    """Asks where a face goes and says when it shall be written; it closes when it is told that all is well.

    Parameters
    ----------
    contents : FaceContents
    path : Path
        What is proposed.
    command : callable
        ``command(path)`` returns the command line that writes the same file.
    files : callable
        ``files(path)`` returns all files that an export to ``path`` writes.

    Signals
    -------
    export_requested(Path)
        To be written there; what is there may be replaced.
    """

    export_requested = Signal(object)

    def __init__(
        self,
        contents: FaceContents,
        path: Path,
        command: Callable[[Path], str],
        files: Callable[[Path], Sequence[Path]],
        note: str = "",
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Export face", "Export", parent)
        self.setObjectName("export_dialog")
        self._contents, self._make_command, self._files = contents, command, files
        self.format = Segments(list(FORMATS.items()), name="Format")
        self.format_note = DimLabel("")
        self.path = PathField("Export face", FACE_FILTER)
        self.path.set_path(path)
        self.command = CommandLine()
        self.size_label = DimLabel("")
        self.add_row("&File", self.path)
        self.add_row("For&mat", self.format)
        self.form.addRow("", self.format_note)
        self.form.addRow("Contents", DimLabel(contents.text()))
        self.form.addRow("Size", self.size_label)
        self.add_row("Comm&and", self.command)
        if note:
            self.form.addRow("", DimLabel(note))
        self.path.changed.connect(self._on_path)
        self.format.chosen.connect(self._on_format)
        self.primary.clicked.connect(self._export)
        self._on_path()
        self.path.field.setFocus()
        self.path.field.selectAll()

    @property
    def ending(self) -> str:
        """``.glb`` or ``.obj``."""
        return self.format.current

    def _on_path(self, _text: str = "") -> None:
        self.forget()
        ending = Path(self.path.field.text().strip()).suffix.lower()
        if ending in FORMATS:
            self.format.set_current(ending)
        self._show()

    def _on_format(self, ending: str) -> None:
        path = Path(self.path.field.text().strip())
        if path.suffix.lower() in FORMATS:
            self.path.set_path(path.with_suffix(ending))
        self._show()

    def _show(self) -> None:
        path = self.path.path(self.ending)
        self.format_note.setText(_UNITS[self.ending])
        self.size_label.setText(f"about {self._contents.bytes(self.ending) / 1e6:.1f} MB")
        self.command.set_command("" if path is None else self._make_command(path), "Name the file first")

    def _export(self) -> None:
        path = self.path.path(self.ending)
        if path is None:
            self.tell("Name the file first.")
        elif self.may_replace(self._files(path)):
            self.export_requested.emit(path)
