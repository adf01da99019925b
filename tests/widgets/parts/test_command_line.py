"""The line with a command shows exactly what is copied, quoted so that a shell splits it back into the same words."""

from __future__ import annotations

import shlex

from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest

from widgets.parts.command_line import CommandLine

WORDS = st.lists(st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp")), max_size=12))


def test_the_button_copies_what_is_shown(qtbot) -> None:
    line = CommandLine()
    qtbot.addWidget(line)
    QGuiApplication.clipboard().setText("before")
    line.set_command(["quasiface", "scan", "fit", "my scan.json", "--out", "it's.glb"])
    with qtbot.waitSignal(line.copied) as copied:
        QTest.mouseClick(line.button, Qt.MouseButton.LeftButton)
    text = QGuiApplication.clipboard().text()
    assert text == line.field.text() == line.command == copied.args[0]
    assert shlex.split(text) == ["quasiface", "scan", "fit", "my scan.json", "--out", "it's.glb"]
    line.set_command(text)
    assert line.command == text, "a line that is quoted already stays as it is"


def test_without_a_command_it_says_why_and_copies_nothing(qtbot) -> None:
    line = CommandLine()
    qtbot.addWidget(line)
    line.set_command(["quasiface"])
    QGuiApplication.clipboard().setText("before")
    line.set_command("", "choose a file first")
    assert line.field.placeholderText() == "choose a file first" and not line.field.text()
    assert not line.button.isEnabled() and "choose a file first" in line.button.toolTip()
    QTest.mouseClick(line.button, Qt.MouseButton.LeftButton)
    line.copy()
    assert QGuiApplication.clipboard().text() == "before"


def test_the_field_cannot_be_typed_into(qtbot) -> None:
    line = CommandLine()
    qtbot.addWidget(line)
    line.set_command(["quasiface", "demo"])
    line.show()
    QTest.keyClicks(line.field, "x")
    assert line.field.text() == line.command == "quasiface demo"


@settings(max_examples=60, deadline=None)
@given(words=WORDS)
def test_a_shell_splits_the_line_into_the_same_words(qapp, words) -> None:
    line = CommandLine()
    line.set_command(words)
    assert shlex.split(line.command) == words
    line.deleteLater()
