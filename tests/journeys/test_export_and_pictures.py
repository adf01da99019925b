"""A face is exported through its dialog, its command writes the same from a shell, and every view gives a picture."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication, QImage
from PySide6.QtTest import QTest

import resources
from engine.files.landmarks_json import write_fiducials
from studio.scan.edits import placed
from tests.journeys.driver import Hand
from widgets.parts import picture
from widgets.parts.picture_dialog import PictureDialog
from widgets.scan.export_dialog import ExportDialog


@pytest.fixture
def fitted(hand: Hand) -> Hand:
    """A window with one scan and its fresh face."""
    hand.choose("scan.add", resources.sample_path("subject", "too.json"))
    hand.stage.editor.set_scheme("open")
    from engine.files.landmarks_json import read_fiducials

    found = read_fiducials(resources.sample_path("subject", "too_fiducials.json"))
    hand.stage.editor.take(found.positions, "too_fiducials.json")
    hand.stage.editor.set_options({"levels": 1, "spike_mm": 3.5})
    hand.rest()
    return hand


def test_the_shown_command_writes_the_same_files_as_the_window(fitted: Hand, tmp_path: Path) -> None:
    context = fitted.stage.context
    fiducials = placed(context.landmarks, context.scheme)
    for ending in (".glb", ".obj"):
        ours, theirs = tmp_path / "window" / f"too{ending}", tmp_path / "shell" / f"too{ending}"
        for folder in (ours.parent, theirs.parent):
            folder.mkdir(exist_ok=True)
        write_fiducials(theirs.with_name("too_fiducials.json"), fiducials, (context.image.width, context.image.height))
        fitted.act("scan.export_face")
        (dialog,) = fitted.window.findChildren(ExportDialog)
        dialog.path.field.setText(str(theirs))
        assert dialog.ending == ending
        QTest.mouseClick(dialog.command.button, Qt.MouseButton.LeftButton)
        words = shlex.split(QGuiApplication.clipboard().text())
        assert words[0] == "quasiface"
        dialog.path.field.setText(str(ours.with_suffix("")) + ending)
        QTest.keyClick(dialog.path.field, Qt.Key.Key_Return)
        fitted.rest()
        ran = subprocess.run([sys.executable, "-m", "studio", *words[1:]], capture_output=True, text=True, timeout=100)
        assert ran.returncode == 0, ran.stderr
        assert ours.read_bytes() == theirs.read_bytes()
    names = {file.name for file in (tmp_path / "window").iterdir()}
    assert names == {"too.glb", "too.obj", "too.mtl", "too_texture.png"}
    for name in names:
        assert (tmp_path / "window" / name).read_bytes() == (tmp_path / "shell" / name).read_bytes(), name


def test_the_export_dialog_refuses_and_asks_inside_itself(fitted: Hand, tmp_path: Path) -> None:
    fitted.act("scan.export_face")
    (dialog,) = fitted.window.findChildren(ExportDialog)
    dialog.path.field.setText("")
    assert not dialog.command.command
    QTest.mouseClick(dialog.primary, Qt.MouseButton.LeftButton)
    assert dialog.isVisible() and dialog.trouble.text()
    dialog.path.field.setText(str(tmp_path / "nowhere" / "face.glb"))
    QTest.mouseClick(dialog.primary, Qt.MouseButton.LeftButton)
    assert dialog.isVisible() and "nowhere" in dialog.trouble.text()
    there = tmp_path / "face.glb"
    there.write_bytes(b"old")
    dialog.path.field.setText(str(tmp_path / "face"))
    QTest.mouseClick(dialog.primary, Qt.MouseButton.LeftButton)
    assert dialog.isVisible() and dialog.primary.text() == "Replace" and there.read_bytes() == b"old"
    QTest.mouseClick(dialog.primary, Qt.MouseButton.LeftButton)
    fitted.rest()
    assert there.read_bytes()[:4] == b"glTF"


def test_every_view_is_copied_and_saved_with_its_origin(fitted: Hand, tmp_path: Path) -> None:
    pictures = fitted.window.pictures
    made = picture.offer_of(fitted.stage.centre.views.viewer)
    assert made is not None
    fitted.stage.centre.views.viewer.plotter.setFocus()
    QGuiApplication.clipboard().clear()
    pictures.copy(made)
    assert QGuiApplication.clipboard().image().width() == fitted.stage.centre.views.viewer.width()
    fitted.act("view.picture")
    (dialog,) = fitted.window.findChildren(PictureDialog)
    assert dialog.path.field.text().startswith(str(Path.home())) or dialog.path.field.text().endswith(".png")
    dialog.path.field.setText(str(tmp_path / "too"))
    QTest.mouseClick(dialog.scale, Qt.MouseButton.LeftButton, pos=dialog.scale.box("2").center().toPoint())
    QTest.keyClick(dialog.path.field, Qt.Key.Key_Return)
    saved = QImage(str(tmp_path / "too.png"))
    assert saved.width() == dialog._offer.widget.width() * 2
    assert saved.text("Subject") == "too" and saved.text("View") and saved.text("Project")
    assert saved.width() / (saved.dotsPerMeterX() * 0.0254) == pytest.approx(saved.width() / 192, rel=1e-3)


def test_the_keys_follow_the_navigation_style_at_once(fitted: Hand) -> None:
    window, views = fitted.window, fitted.stage.centre.views
    window.settings["view/navigation"] = "blender"
    assert window.actions_.shortcut_text("view.frame") == "Home"
    fitted.key(Qt.Key.Key_1, Qt.KeyboardModifier.KeypadModifier)
    assert views.viewer.camera.GetDirectionOfProjection() == pytest.approx((0, 0, -1), abs=1e-6)
    fitted.key(Qt.Key.Key_1, Qt.KeyboardModifier.KeypadModifier | Qt.KeyboardModifier.ControlModifier)
    assert views.viewer.camera.GetDirectionOfProjection() == pytest.approx((0, 0, 1), abs=1e-6)
    fitted.key(Qt.Key.Key_5, Qt.KeyboardModifier.KeypadModifier)
    assert views.orthographic
    window.settings["view/navigation"] = "maya"
    fitted.stage.context.select_fiducial("nose_tip")
    before = fitted.canvas.zoom
    fitted.key(Qt.Key.Key_F)
    assert fitted.canvas.zoom > 1.5 * before, "F brings the fiducial near in this style"
    fitted.key(Qt.Key.Key_F)
    assert fitted.canvas.zoom == pytest.approx(before, rel=1e-6), "and again: everything"
    fitted.key(Qt.Key.Key_5, Qt.KeyboardModifier.KeypadModifier)
    assert views.orthographic, "a key of another style does nothing"
    window.settings["view/navigation"] = "studio"
    assert window.actions_.shortcut_text("view.frame") == "F"
