"""What goes wrong is said in one line with what to do, and the project is as it was."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

import resources
from studio.tasks import TaskState
from tests.journeys.driver import Hand, bare_scan, truth


def bad_files(folder: Path) -> dict[str, Path]:
    """Write files of every kind of wrong."""
    sample = resources.sample_path("subject")
    depth = (sample / "base_depth.png").read_bytes()
    (folder / "cut_depth.png").write_bytes(depth[: len(depth) // 2])
    text = (sample / "base.json").read_text()
    files = {
        "cut": (folder / "cut.json", text.replace("base_depth.png", "cut_depth.png")),
        "absent image": (folder / "absent.json", text),
        "not json": (folder / "broken.json", '{"depth": '),
        "empty": (folder / "empty.ply", ""),
        "absurd header": (
            folder / "absurd.ply",
            "ply\nformat ascii 1.0\nobj_info num_cols 999999999\nobj_info num_rows 999999999\n"
            "element vertex 999999999\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        ),
        "wrong magic": (folder / "wrong.npz", "this is not an archive"),
    }
    for path, content in files.values():
        path.write_text(content)
    np.savez(folder / "hollow.npz", points=np.full((8, 8, 3), np.nan))
    np.savez(folder / "pickled.npz", points=np.array([{"a": 1}], dtype=object))
    return {name: path for name, (path, _) in files.items()} | {
        "no valid pixel": folder / "hollow.npz",
        "pickle": folder / "pickled.npz",
    }


def test_bad_scans_give_a_message_and_change_nothing(hand: Hand, tmp_path: Path) -> None:
    hand.choose("scan.add", bare_scan("base"))
    hand.click(*truth()["forehead"])
    scans, count = hand.window.session.project.scans, hand.window.session.stack.count()
    for name, path in bad_files(tmp_path).items():
        hand.window.message.clear()
        hand.choose("scan.add", path)
        message = hand.window.message
        assert message.kind == "error" and message.isVisible(), name
        text = message.text.text()
        assert path.stem.split("_")[0] in text and ";" in text and "\n" not in text, (name, text)
        assert "Error" not in text and "Traceback" not in text, (name, text)
        assert hand.window.session.project.scans == scans and hand.window.session.stack.count() == count
    hand.click(*truth()["brow_left_outer"])
    assert not hand.window.message.isVisible()


def test_bad_projects_and_fiducials_give_a_message_and_change_nothing(hand: Hand, tmp_path: Path) -> None:
    hand.choose("scan.add", bare_scan("base"))
    hand.choose("file.save_as", tmp_path / "good.qface")
    project = hand.window.session.project
    (tmp_path / "bad.qface").write_bytes((tmp_path / "good.qface").read_bytes()[:3000])
    (tmp_path / "text.qface").write_text("not a project")
    for name in ("bad.qface", "text.qface"):
        hand.choose("file.open", tmp_path / name)
        assert hand.window.message.kind == "error" and name in hand.window.message.text.text()
        assert hand.window.session.project is project and not hand.window.isWindowModified()
    fiducials = {
        "outside.json": '{"image_size": [640, 480], "points": {"chin": [5, 5000]}}',
        "twice.json": '{"image_size": [640, 480], "points": {"chin": [5, 5], "chin": [6, 6]}}',
        "unknown.json": '{"image_size": [640, 480], "points": {"elbow": [5, 5]}}',
    }
    for name, text in fiducials.items():
        (tmp_path / name).write_text(text)
        hand.choose("scan.import", tmp_path / name)
        assert hand.window.message.kind == "error" and name in hand.window.message.text.text(), name
        assert not hand.landmarks.points and not hand.window.isWindowModified()


def test_fiducials_go_out_and_come_back(hand: Hand, tmp_path: Path) -> None:
    hand.choose("scan.add", bare_scan("base"))
    hand.choose("scan.import", resources.sample_path("subject", "base_fiducials.json"))
    placed = hand.landmarks
    assert len(placed.points) == 20
    hand.choose("scan.export", tmp_path / "out.json")
    hand.window.session.stack.undo()
    assert not hand.landmarks.points
    hand.choose("scan.import", tmp_path / "out.json")
    assert hand.landmarks == placed


def test_points_at_one_place_say_so_and_lose_nothing(hand: Hand) -> None:
    hand.choose("scan.add", bare_scan("base"))
    for name in ("forehead", "brow_left_outer", "brow_left_inner"):
        hand.click(*truth()[name])
    hand.stage.editor.place("brow_right_inner", *place_of(hand, "brow_left_inner"))
    hand.rest()
    assert "brow_left_inner and brow_right_inner" in hand.window.status.text.text()
    assert len(hand.landmarks.points) == 4


def place_of(hand: Hand, name: str) -> tuple[float, float]:
    return hand.landmarks[name].x, hand.landmarks[name].y


def test_a_task_is_cancelled_in_the_middle_and_leaves_no_trace(
    hand: Hand, monkeypatch: pytest.MonkeyPatch, qtbot: Any
) -> None:
    from studio.scan import files

    inside, go_on, ended = threading.Event(), threading.Event(), threading.Event()
    real = files.load_scan

    def slow(wanted: Any, progress: Any) -> Any:
        inside.set()
        go_on.wait(20)
        try:
            return real(wanted, progress)
        finally:
            ended.set()

    monkeypatch.setattr(files, "load_scan", slow)
    hand.act("scan.sample")
    qtbot.waitUntil(inside.is_set, timeout=20_000)
    qtbot.waitUntil(hand.window.status.cancel.isVisible, timeout=20_000)
    (task,) = hand.window.session.tasks.active
    QTest.mouseClick(hand.window.status.cancel, Qt.MouseButton.LeftButton)
    go_on.set()
    qtbot.waitUntil(ended.is_set, timeout=20_000)
    hand.rest()
    assert task.state is TaskState.CANCELLED
    assert hand.window.session.project.scans == () and hand.window.session.stack.count() == 0
    assert not hand.window.status.cancel.isVisible()
