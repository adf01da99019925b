"""A file of version 1, written by the program of that time, opens whole, is not touched, and is kept on saving."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.landmarks import LandmarkState
from studio.project import migrations, store
from studio.project.thumbnail import HEIGHT, WIDTH, picture_of, thumbnail_of

OLD = Path(__file__).parent / "data" / "version1.qface"


@pytest.fixture
def old(tmp_path: Path) -> Path:
    return Path(shutil.copy(OLD, tmp_path / "old.qface"))


def as_written(path: Path) -> dict[str, Any]:
    """Read the header as the file has it, past all of our code."""
    with closing(sqlite3.connect(path)) as connection:
        return json.loads(connection.execute("SELECT value FROM project WHERE key = 'header'").fetchone()[0])


def test_every_value_of_the_old_file_is_in_the_project(old: Path) -> None:
    before, written = old.read_bytes(), as_written(old)
    project = store.load(old)
    assert old.read_bytes() == before and list(old.parent.iterdir()) == [old]
    assert len(project.scans) == len(written["scans"]) == 2
    for item, then in zip(project.scans, written["scans"], strict=True):
        for name in ("id", "name", "word", "held", "scheme", "image_key"):
            assert getattr(item, name) == then[name], name
        for name, value in then["source"].items():
            assert getattr(item.source, name) == value, name
        for name, value in then["options"].items():
            assert getattr(item.options, name) == value, name
        assert set(item.landmarks.points) == set(then["landmarks"])
        for name, value in then["landmarks"].items():
            point = item.landmarks[name]
            assert (point.state, point.locked) == (value["state"], value["locked"])
            assert value["x"] is None or (point.x, point.y) == (value["x"], value["y"])
    base, other = project.scans
    assert base.landmarks["chin"].locked and other.landmarks["brow_left_outer"].state == LandmarkState.SKIPPED
    assert project.fit_key(base.id) == written["scans"][0]["fit"]
    assert project.fit(base.id).mesh.vertices.shape == (441, 3)


def test_what_was_fresh_is_fresh_and_survives_saving_in_the_present_version(old: Path, tmp_path: Path) -> None:
    project = store.load(old)
    assert [project.state(item.id).kind for item in project.scans] == ["fresh", "missing"]
    again = store.load(store.save(project, tmp_path / "new.qface"))
    assert again.scans == project.scans and again.state(again.scans[0].id).kind == "fresh"
    with closing(sqlite3.connect(tmp_path / "new.qface")) as connection:
        assert connection.execute("PRAGMA user_version").fetchone() == (migrations.version_now(),)
    for item in project.scans:
        one, two = project.range_image(item.id), again.range_image(item.id)
        assert one.points.tobytes() == two.points.tobytes() and one.camera == two.camera


def test_an_old_file_with_a_flipped_digit_cannot_be_told_but_a_new_one_can(old: Path, tmp_path: Path) -> None:
    """What version 2 is for; the old version is the control."""

    def flip(path: Path) -> None:
        data = path.read_bytes()
        assert data.count(b'"x":39.4375,"y":10.730252625') == 1
        path.write_bytes(data.replace(b'"x":39.4375,"y":10.730252625', b'"x":39.4375,"y":10.830252625'))

    new = store.save(store.load(old), tmp_path / "new.qface")
    flip(old)
    assert store.load(old).scans[0].landmarks["forehead"].y == 10.830252625
    flip(new)
    with pytest.raises(ValueError, match=r"new\.qface: is damaged \(its header is not as it was written\)"):
        store.load(new)


def test_the_picture_of_a_project_shows_its_fiducials_and_is_read_alone(old: Path, tmp_path: Path) -> None:
    project = store.load(old)
    base, other = project.scans
    png = picture_of(project, base.id)
    path = store.save(project, tmp_path / "new.qface", picture=png)
    assert thumbnail_of(path) == png and thumbnail_of(old) is None
    for absent in (tmp_path / "none.qface", tmp_path, Path(__file__)):
        assert thumbnail_of(absent) is None
    shown = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[..., ::-1].astype(int)
    assert shown.shape == (HEIGHT, WIDTH, 3)
    project.change_scan(base.id, landmarks=type(base.landmarks)({}))
    bare = cv2.imdecode(np.frombuffer(picture_of(project, base.id), np.uint8), cv2.IMREAD_COLOR)[..., ::-1].astype(int)
    orange = (shown[..., 0] > 200) & (abs(shown[..., 1] - 145) < 30) & (shown[..., 2] < 90) & (shown != bare).any(-1)
    assert cv2.connectedComponents(orange.astype(np.uint8))[0] - 1 in range(15, 22)  # 20 points, some of them touch
    assert picture_of(project, other.id) != picture_of(project, base.id)
    assert picture_of(type(project)()) is None
    data = bytearray(path.read_bytes())
    at = data.find(png[:16])
    data[at : at + 4] = b"JUNK"
    path.write_bytes(data)
    assert thumbnail_of(path) is None
