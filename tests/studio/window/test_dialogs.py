"""The name that is written is the one that was asked about, and nothing is replaced unasked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from studio import dialogs
from studio.settings import Settings

NO, YES = QMessageBox.StandardButton.No, QMessageBox.StandardButton.Yes


class Answers:
    """Answers both questions and counts how often the second is asked."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, parent: QWidget, folder: Path) -> None:
        self.typed, self.used, self.button, self.asked = "", "", NO, 0
        self._parent, self._folder = parent, folder
        answer = lambda *_args: (str(folder / self.typed) if self.typed else "", self.used)  # noqa: E731
        monkeypatch.setattr(QFileDialog, "getSaveFileName", answer)
        monkeypatch.setattr(QMessageBox, "exec", lambda _box: self._press())

    def _press(self) -> int:
        self.asked += 1
        return self.button.value

    def save(self, typed: str, file_filter: str, used: str = "") -> str | None:
        """Return the name that is to be written when ``typed`` was typed."""
        self.typed, self.used, self.asked = typed, used, 0
        settings = Settings(self._folder / "s.ini")
        path = dialogs.save_file(self._parent, settings, "Save", "x", file_filter)
        return None if path is None else path.name


@pytest.fixture
def answers(qtbot: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Answers:
    parent = QWidget()
    qtbot.addWidget(parent)
    return Answers(monkeypatch, parent, tmp_path)


def test_an_ending_is_put_behind_the_name_and_takes_nothing_away(answers: Answers) -> None:
    assert answers.save("take.01", dialogs.PROJECT_FILTER) == "take.01.qface"
    assert answers.save("take.QFACE", dialogs.PROJECT_FILTER) == "take.QFACE"
    assert answers.save("face", dialogs.FACE_FILTER) == "face.glb"
    assert answers.save("face.v2", dialogs.FACE_FILTER, "Wavefront OBJ (*.obj)") == "face.v2.obj"
    assert answers.save("face.obj", dialogs.FACE_FILTER, "glTF binary (*.glb)") == "face.obj"
    assert answers.save("", dialogs.FACE_FILTER) is None
    assert answers.asked == 0


def test_a_file_that_the_ending_leads_to_is_asked_about(answers: Answers, tmp_path: Path) -> None:
    (tmp_path / "face.glb").touch()
    (tmp_path / "take.qface").touch()
    answers.button = NO
    assert answers.save("face", dialogs.FACE_FILTER) is None and answers.asked == 1
    answers.button = YES
    assert answers.save("face", dialogs.FACE_FILTER) == "face.glb" and answers.asked == 1
    assert answers.save("face.glb", dialogs.FACE_FILTER) == "face.glb" and answers.asked == 0
    assert answers.save("take.01", dialogs.PROJECT_FILTER) == "take.01.qface" and answers.asked == 0
