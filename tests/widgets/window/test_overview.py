"""The overview: searched by words, moved through by keys, run by Enter; what cannot be run is not."""

from __future__ import annotations

from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from widgets.window.overview import Entry, Overview

ENTRIES = (
    Entry("File", "Open project", ("Ctrl+O",), "Open a .qface project", "file.open"),
    Entry("File", "Save", ("Ctrl+S",), "Save the project", "file.save", why="nothing has changed"),
    Entry("Scan", "Fit", ("Ctrl+Enter",), "Fit the template", "scan.fit"),
    Entry("In the picture", "Move a fiducial", ("Drag",)),
)


@pytest.fixture
def overview(qtbot: Any) -> Overview:
    overview = Overview(ENTRIES)
    qtbot.addWidget(overview)
    overview.resize(700, 400)
    overview.show()
    overview.search.setFocus()
    return overview


def test_all_entries_are_listed_and_the_first_that_can_run_is_marked(overview: Overview) -> None:
    assert overview.shown == ENTRIES
    assert overview.current == ENTRIES[0]


@pytest.mark.parametrize(
    ("words", "found"),
    [("proj", (0, 1)), ("ctrl+enter", (2,)), ("picture drag", (3,)), ("SAVE the", (1,)), ("zebra", ())],
)
def test_every_word_counts_in_text_sentence_group_or_keys(
    words: str, found: tuple[int, ...], overview: Overview
) -> None:
    QTest.keyClicks(overview.search, words)
    assert overview.shown == tuple(ENTRIES[k] for k in found)


def test_arrows_move_the_mark_without_leaving_the_search_and_enter_runs_it(overview: Overview) -> None:
    ran: list[str] = []
    overview.chosen.connect(ran.append)
    QTest.keyClick(overview.search, Qt.Key.Key_Down)
    assert overview.current == ENTRIES[1] and "nothing has changed" in overview.foot.text()
    QTest.keyClick(overview.search, Qt.Key.Key_Return)
    assert not ran
    QTest.keyClick(overview.search, Qt.Key.Key_Down)
    QTest.keyClick(overview.search, Qt.Key.Key_Return)
    assert ran == ["scan.fit"]
    QTest.keyClick(overview.search, Qt.Key.Key_PageDown)
    QTest.keyClick(overview.search, Qt.Key.Key_Return)
    assert overview.current == ENTRIES[3] and ran == ["scan.fit"]


def test_a_double_click_runs(overview: Overview) -> None:
    ran: list[str] = []
    overview.chosen.connect(ran.append)
    row = next(k for k in range(overview.list.count()) if overview.list.item(k).text() == "Fit")
    place = overview.list.visualItemRect(overview.list.item(row)).center()
    QTest.mouseClick(overview.list.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, place)
    QTest.mouseDClick(overview.list.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, place)
    assert ran == ["scan.fit"]


def test_the_mark_goes_to_the_first_that_can_run_when_the_search_changes(overview: Overview) -> None:
    QTest.keyClicks(overview.search, "s")
    assert overview.shown == (ENTRIES[1], ENTRIES[2]) and overview.current == ENTRIES[2]
    QTest.keyClicks(overview.search, "ave")
    assert overview.shown == (ENTRIES[1],) and overview.current == ENTRIES[1]
