"""Names that cannot be files are refused in words, in the colours of the theme that is on."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication

from widgets import theme
from widgets.parts.form_dialog import FormDialog
from widgets.parts.path_field import PathField


def test_a_name_too_long_is_told_in_the_dialog_and_nothing_is_agreed(qtbot, tmp_path: Path) -> None:
    dialog = FormDialog("Export", "Write")
    qtbot.addWidget(dialog)
    assert not dialog.may_replace([tmp_path / f"{'z' * 300}.glb"])
    assert "cannot be written (File name too long)" in dialog.trouble.text()
    assert len(dialog.trouble.text()) < 150 and dialog.primary.text() == "Write"
    dialog.forget()
    assert dialog.may_replace([tmp_path / "face.glb"])
    (tmp_path / "face.glb").touch()
    assert not dialog.may_replace([tmp_path / "face.glb"]) and dialog.primary.text() == "Replace"
    assert dialog.may_replace([tmp_path / "face.glb"])


def test_what_is_wrong_keeps_its_colour_when_the_theme_changes(qtbot, qapp: QApplication) -> None:
    dialog = FormDialog("Export", "Write")
    qtbot.addWidget(dialog)
    assert theme.DARK.captured in dialog.trouble.styleSheet()
    theme.apply(qapp, theme.LIGHT)
    assert theme.LIGHT.captured in dialog.trouble.styleSheet()
    theme.apply(qapp, theme.DARK)


@pytest.mark.parametrize(
    ("text", "folder", "file"),
    [
        ("", None, None),
        ("/a/b/", Path("/a/b"), None),
        ("/a/b.v2", Path("/a/b.v2"), Path("/a/b.v2.pdf")),
        (" /a/b.PDF ", Path("/a/b.PDF"), Path("/a/b.PDF")),
        ("~nobody_of_this_name/x", Path("~nobody_of_this_name/x"), Path("~nobody_of_this_name/x.pdf")),
        ("~/x", Path.home() / "x", Path.home() / "x.pdf"),
    ],
)
def test_a_folder_is_taken_as_typed_and_a_file_gets_its_ending(
    qtbot, text: str, folder: Path | None, file: Path | None
) -> None:
    field = PathField("Report", "Report (*.pdf)")
    qtbot.addWidget(field)
    field.field.setText(text)
    assert field.folder() == folder and field.path(".pdf") == file
    field.field.setText("a\0b")
    assert field.folder() is None
