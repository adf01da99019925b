"""Six scans of a folder become six faces in a handful of clicks; what cannot be read costs nothing else."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

import resources
from engine.files.images import write_image
from engine.files.scan import read_scan
from engine.landmarks import LandmarkState
from studio.scan.job import scheme_of
from tests.engine.files.foreign import abs_bytes
from tests.journeys.driver import Hand, truth

WORDS = ("base", "car", "man", "she", "eel", "too")
CLICKS = 40


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder as a scanner leaves it: six packed ``.abs`` with their pictures, and nothing known about them."""
    place = tmp_path / "takes"
    place.mkdir()
    for number, word in enumerate(WORDS):
        scan = read_scan(resources.sample_path("subject", f"{word}.json")).scan
        (place / f"{number}_{word}.abs.gz").write_bytes(abs_bytes(scan, digits=4, packed=True))
        write_image(place / f"{number}_{word}.png", scan.colour)
    (place / "notes.pdf").write_bytes(b"%PDF")
    return place


class Counted:
    """Counts what a hand does."""

    def __init__(self, hand: Hand) -> None:
        self.hand, self.done = hand, 0

    def follow(self, hint: str) -> None:
        """Click on the next step in the status line, which must say so."""
        status = self.hand.window.status
        assert hint in status.text.text(), status.text.text()
        self.done += 1
        QTest.mouseClick(status.key, Qt.MouseButton.LeftButton)
        self.hand.rest()

    def click(self, x: float, y: float) -> None:
        self.done += 1
        self.hand.click(x, y)

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self.done += 1
        self.hand.press_move(start, end)
        self.hand.release(end)
        self.hand.rest()


@pytest.mark.timeout(240)
def test_six_scans_become_faces_in_forty_clicks(hand: Hand, folder: Path) -> None:
    """A drop, twenty clicks on the first scan, then what the status line offers: carry, look, correct one, confirm."""
    project, counted = hand.window.session.project, Counted(hand)
    hand.drop(folder)
    counted.done += 1
    assert [item.name for item in project.scans] == [f"{k}_{word}" for k, word in enumerate(WORDS)]
    for name in scheme_of("closed").names:
        counted.click(*truth("base")[name])
    hand.rest()
    assert project.state(project.scans[0].id).kind == "fresh"
    counted.follow("carry the fiducials of “0_base” to 5 other scans")
    assert [item.scheme for item in project.scans] == ["closed", *["open"] * 5]
    spare = (CLICKS - counted.done - 2 * 5) // 5
    assert spare >= 1
    for word in WORDS[1:]:
        counted.follow("go on with")
        item = hand.stage.context.item
        assert item.name.endswith(word)
        wrong = {
            name: np.hypot(*np.subtract((p.x, p.y), truth(word)[name])) for name, p in item.landmarks.points.items()
        }
        for name in sorted(wrong, key=lambda name: -wrong[name])[:spare]:
            point = item.landmarks[name]
            counted.drag((point.x, point.y), truth(word)[name])
        counted.follow("then confirm all")
    assert counted.done <= CLICKS
    for word, item in zip(WORDS, project.scans, strict=True):
        assert project.state(item.id).kind == "fresh", word
        face = project.fit(item.id)
        assert len(face.folded_faces) == 0, word
        assert np.nanmedian(np.abs(face.deviation_mm)) < 0.07
        away = [np.hypot(*np.subtract((p.x, p.y), truth(word)[name])) for name, p in item.landmarks.points.items()]
        assert np.median(away) < 1.5 and np.mean(away) < 3.0, (word, sorted(away))


@pytest.mark.timeout(180)
def test_one_undo_takes_the_proposals_of_all_scans_back(hand: Hand, folder: Path) -> None:
    project, names = hand.window.session.project, scheme_of("closed").names
    shutil.copy(resources.sample_path("subject", "base_fiducials.json"), folder / "0_base_fiducials.json")
    (folder / "7_broken.json").write_text('{"depth": "nothing.png", "unit_mm": 1}')
    hand.drop(folder)
    message = hand.window.message.text.text()
    assert "1 of 7" in message and "7_broken.json" in message
    base = project.scans[0]
    assert len(base.landmarks.names(LandmarkState.PLACED, order=names)) == 20
    before, steps = project.scans, hand.window.session.stack.count()
    hand.act("scan.carry_to_all")
    hand.rest()
    assert hand.window.session.stack.count() == steps + 1
    assert all(len(item.landmarks.points) == 26 for item in project.scans[1:])
    assert all(p.state == LandmarkState.PROPOSED for item in project.scans[1:] for p in item.landmarks.points.values())
    hand.act("edit.undo")
    hand.rest()
    assert project.scans == before


def test_a_folder_without_scans_says_so(hand: Hand, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    hand.drop(tmp_path / "empty")
    assert "empty holds no scan" in hand.window.message.text.text()
    picture = tmp_path / "holiday.jpeg"
    picture.write_bytes(b"x")
    hand.drop(picture)
    assert "holiday.jpeg" in hand.window.message.text.text()
    assert not hand.window.session.project.scans
