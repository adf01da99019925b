"""From a scan file to its fitted face without the mouse: every key goes to what has the focus."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QMenu, QWidget

import resources
from engine.landmarks import LandmarkState
from studio.overview import OverviewDialog
from tests.journeys.driver import Hand, truth

PLAIN, SHIFT, CTRL, ALT = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.AltModifier,
)
FIVE = ("forehead", "brow_left_outer", "brow_left_inner", "brow_right_inner", "brow_right_outer")


def key(code: Qt.Key, modifier: Qt.KeyboardModifier = PLAIN, times: int = 1) -> None:
    """Press a key where the focus is."""
    for _ in range(times):
        focus = QApplication.focusWidget()
        assert focus is not None, "nothing has the keys"
        QTest.keyClick(focus, code, modifier)


def steer(hand: Hand, x: float, y: float) -> None:
    """Move the crosshair to an image position, to a tenth of a pixel, by arrow keys alone."""
    key(Qt.Key.Key_Right)
    cross = hand.canvas.keys.cross
    assert cross is not None
    for way, (less, more) in (
        (x - cross.x(), (Qt.Key.Key_Left, Qt.Key.Key_Right)),
        (y - cross.y(), (Qt.Key.Key_Up, Qt.Key.Key_Down)),
    ):
        tenths = round(abs(way) * 10)
        for modifier, count in ((SHIFT, tenths // 100), (PLAIN, tenths % 100 // 10), (CTRL, tenths % 10)):
            key(more if way > 0 else less, modifier, count)


def go_to(hand: Hand, wanted: QWidget) -> None:
    """Cycle through the zones until a widget has the keys."""
    for _ in range(12):
        if QApplication.focusWidget() is wanted:
            return
        key(Qt.Key.Key_F6)
    raise AssertionError(f"F6 never comes to {wanted.objectName()}")


@pytest.fixture
def bare_scan(tmp_path: Path) -> Path:
    """A scan of the sample without its fiducials."""
    for name in ("base.json", "base_colour.png", "base_depth.png"):
        shutil.copy(resources.sample_path("subject", name), tmp_path / name)
    return tmp_path / "base.json"


def test_a_scan_becomes_a_face_by_keys_alone(hand: Hand, bare_scan: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    window = hand.window
    assert QApplication.focusWidget() is not None
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_a, **_k: (str(bare_scan), ""))
    monkeypatch.setattr(QFileDialog, "getOpenFileNames", lambda *_a, **_k: ([str(bare_scan)], ""))
    key(Qt.Key.Key_I, CTRL)
    hand.rest()
    assert len(window.session.project.scans) == 1
    go_to(hand, hand.canvas)
    places = truth()
    for name in FIVE:
        assert hand.canvas.fiducials.current == name
        steer(hand, *places[name])
        key(Qt.Key.Key_Return)
        point = hand.landmarks[name]
        assert point.state is LandmarkState.PLACED
        assert (point.x, point.y) == pytest.approx(places[name], abs=0.051)
    hand.rest()
    key(Qt.Key.Key_Return, SHIFT)
    hand.rest()
    if window.actions_["scan.fit"].isEnabled():
        key(Qt.Key.Key_Return, CTRL)
        hand.rest()
    item = window.session.project.scans[0]
    assert window.session.project.state(item.id).kind == "fresh"
    assert hand.stage.shown is not None and hand.stage.shown.median_mm < 0.07
    for _ in range(30):
        if not window.session.stack.canUndo():
            break
        key(Qt.Key.Key_Z, CTRL)
    assert not window.session.project.scans


def test_the_whole_window_is_reached_by_f6_and_every_stop_shows_that_it_has_the_keys(hand: Hand) -> None:
    window = hand.window
    key(Qt.Key.Key_K, CTRL)
    dialog = window.findChild(OverviewDialog)
    assert dialog is not None
    hand.qtbot.waitUntil(lambda: QApplication.focusWidget() is dialog.panel.search, timeout=10_000)
    QTest.keyClicks(QApplication.focusWidget(), "open sample")
    key(Qt.Key.Key_Return)
    hand.rest()
    assert len(window.session.project.scans) == 6
    window.activateWindow()  # where no window manager does it after a dialog
    hand.qtbot.waitUntil(window.isActiveWindow, timeout=10_000)
    assert QApplication.focusWidget() is hand.canvas
    seen: list[Any] = []
    for _ in range(len(window.habits.zones.zones())):
        key(Qt.Key.Key_F6)
        seen.append(QApplication.focusWidget())
    assert len(set(map(id, seen))) == len(seen)
    scans = next(w for w in seen if w.accessibleName() == "Scans")
    assert hand.canvas in seen and hand.stage.centre.fiducials.table in seen
    key(Qt.Key.Key_F6, SHIFT, times=1 + seen[::-1].index(scans) - 1)
    assert QApplication.focusWidget() is scans
    key(Qt.Key.Key_Down)
    hand.rest()
    assert hand.stage.context.item.name == "car"


def test_menus_open_by_alt_and_close_by_escape(hand: Hand) -> None:
    for letter in "FEVSWH":
        key(getattr(Qt.Key, f"Key_{letter}"), ALT)
        menu = QApplication.activePopupWidget()
        assert isinstance(menu, QMenu) and menu.title()[0] == letter
        QTest.keyClick(menu, Qt.Key.Key_Escape)
        QTest.keyClick(menu, Qt.Key.Key_Escape)
        hand.qtbot.waitUntil(lambda: QApplication.activePopupWidget() is None)
