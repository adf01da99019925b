"""The questions the window asks: which file, and what to do with unsaved changes."""

from __future__ import annotations

import re
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox, QWidget

from studio.settings import Settings

PROJECT_FILTER = "Quasiface project (*.qface)"
SCAN_FILTER = "Scans (*.json *.ply *.npz *.pcd *.abs *.abs.gz *.xyz *.asc *.txt *.obj *.glb);;All files (*)"
FACE_FILTER = "glTF binary (*.glb);;Wavefront OBJ (*.obj)"
PNG_FILTER = "PNG picture (*.png)"


def _folder(settings: Settings, name: str = "") -> str:
    folder = Path(settings["files/folder"])
    return str(folder / name) if folder.is_dir() and settings["files/folder"] else name


def open_file(parent: QWidget, settings: Settings, title: str, file_filter: str) -> Path | None:
    """Ask for a file that exists; None when the user thinks better of it."""
    name, _ = QFileDialog.getOpenFileName(parent, title, _folder(settings), file_filter)
    return _remember(settings, name)


def open_files(parent: QWidget, settings: Settings, title: str, file_filter: str) -> list[Path]:
    """Ask for one or several files that exist; none when the user thinks better of it."""
    names, _ = QFileDialog.getOpenFileNames(parent, title, _folder(settings), file_filter)
    return [path for path in (_remember(settings, name) for name in names) if path is not None]


def open_folder(parent: QWidget, settings: Settings, title: str) -> Path | None:
    """Ask for a folder that exists; None when the user thinks better of it."""
    name = QFileDialog.getExistingDirectory(parent, title, _folder(settings))
    if name:
        settings["files/folder"] = name
    return Path(name) if name else None


def save_file(parent: QWidget, settings: Settings, title: str, name: str, file_filter: str) -> Path | None:
    """Ask for a file to write; a name without an ending of ``file_filter`` gets that of the chosen one behind it.

    The dialog has asked about the name that was typed; what the ending makes of it is asked about here.
    """
    chosen, used = QFileDialog.getSaveFileName(parent, title, _folder(settings, name), file_filter)
    path = _remember(settings, chosen)
    if path is None or path.suffix.lower() in _endings(file_filter):
        return path
    named = path.with_name(path.name + _endings(used or file_filter)[0])
    return None if named.exists() and not ask_replace(parent, named) else named


def _endings(file_filter: str) -> list[str]:
    return re.findall(r"\*(\.\w+)", file_filter)


def _remember(settings: Settings, name: str) -> Path | None:
    if not name:
        return None
    path = Path(name)
    settings["files/folder"] = str(path.parent)
    return path


def ask_text(parent: QWidget, title: str, label: str, text: str) -> str:
    """Ask for a line of text; empty when the user thinks better of it."""
    answer, accepted = QInputDialog.getText(parent, title, label, text=text)
    return answer.strip() if accepted else ""


def ask_replace(parent: QWidget, path: Path) -> bool:
    """Ask whether a file that is there may be replaced."""
    box = QMessageBox(
        QMessageBox.Icon.Warning,
        "Replace file",
        f"{path.name} is already there. Replace it?",
        QMessageBox.StandardButton.Yes | QMessageBox.StandardButton.No,
        parent,
    )
    box.setDefaultButton(QMessageBox.StandardButton.No)
    answer = box.exec()
    box.deleteLater()
    return QMessageBox.StandardButton(answer) == QMessageBox.StandardButton.Yes


def ask_unsaved(parent: QWidget, name: str) -> str:
    """Ask what to do with unsaved changes: ``"save"``, ``"discard"`` or ``"cancel"``."""
    box = QMessageBox(
        QMessageBox.Icon.Question,
        "Unsaved changes",
        f"Save the changes to {name} first?",
        QMessageBox.StandardButton.Save | QMessageBox.StandardButton.Discard | QMessageBox.StandardButton.Cancel,
        parent,
    )
    box.setDefaultButton(QMessageBox.StandardButton.Save)
    answer = box.exec()
    box.deleteLater()
    names = {QMessageBox.StandardButton.Save: "save", QMessageBox.StandardButton.Discard: "discard"}
    return names.get(QMessageBox.StandardButton(answer), "cancel")


def about_text() -> str:
    """Return name, version and licence in one line."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        number = version("quasiface-studio")
    except PackageNotFoundError:
        number = "not installed"
    return f"Quasiface Studio {number}. Apache-2.0; the sample and its template are in the public domain."
