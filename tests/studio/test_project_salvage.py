"""Of a damaged project what can be read is read, what is lost is counted, and the file itself is not touched."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.npz import read_npz, write_npz
from engine.landmarks import LandmarkSet
from engine.scan.range_image import RangeImage
from studio.project import store
from studio.project.document import Project, ScanItem, SourceInfo
from studio.project.keys import content_key
from studio.project.migrations import write_header
from studio.project.salvage import salvage

NAMES = ("one", "two", "three", "four")


def scan_of(seed: int) -> RangeImage:
    points = np.random.default_rng(seed).normal(size=(60, 50, 3)) - [0, 0, 600]
    return RangeImage(points, None, None)


@pytest.fixture
def four(tmp_path: Path) -> Path:
    """A project of four scans with two fiducials each; the last one was read from a file that is still there."""
    project = Project()
    for k, name in enumerate(NAMES):
        scan = scan_of(k)
        source = SourceInfo(width=50, height=60)
        if name == "four":
            write_npz(tmp_path / "four.npz", scan)
            scan = read_npz(tmp_path / "four.npz").scan
            source = SourceInfo(str(tmp_path / "four.npz"), width=50, height=60)
        points = LandmarkSet.placed({"chin": (10.0 + k, 50.0), "nose_tip": (20.5, 30.25)})
        item = ScanItem(f"scan-{k}", name, content_key(scan), source=source, landmarks=points)
        project.insert_scan(k, item, scan)
    return store.save(project, tmp_path / "four.qface")


def header_of(path: Path) -> dict[str, Any]:
    with closing(sqlite3.connect(path)) as connection:
        return json.loads(connection.execute("SELECT value FROM project WHERE key = 'header'").fetchone()[0])


def lose_image(path: Path, index: int) -> None:
    """Flip one byte in the middle of a range image."""
    key = header_of(path)["scans"][index]["image"]["points"]
    with closing(sqlite3.connect(path)) as connection:
        ((data,),) = connection.execute("SELECT data FROM chunks WHERE key = ?", (key,)).fetchall()
    whole = path.read_bytes()
    part = data[20_000:20_064]
    assert whole.count(part) == 1
    path.write_bytes(whole.replace(part, bytes([part[0] ^ 1]) + part[1:]))


def test_a_whole_file_is_salvaged_whole(four: Path) -> None:
    found = salvage(four)
    assert found.project.scans == store.load(four).scans and found.lost == () and (found.whole, found.total) == (4, 4)
    assert found.project.path is None, "the file is never saved over"


def test_one_lost_image_costs_one_image_and_no_fiducial(four: Path) -> None:
    scans = store.load(four).scans
    lose_image(four, 1)
    before = four.read_bytes()
    with pytest.raises(InputError, match=r"four\.qface, scan 'two': array .* is damaged"):
        store.load(four)
    found = salvage(four)
    assert four.read_bytes() == before
    assert [item.name for item in found.project.scans] == list(NAMES) and (found.whole, found.total) == (3, 4)
    assert [item.landmarks for item in found.project.scans] == [item.landmarks for item in scans]
    (lost,) = found.lost
    assert lost.startswith("the range image of two, its fiducials are kept")
    assert found.summary.startswith("3 of 4 scans are whole; lost: the range image of two")
    empty = found.project.range_image(scans[1].id)
    assert (empty.width, empty.height) == (50, 60) and np.isfinite(empty.points).all(-1).sum() == 1
    for index in (0, 2, 3):
        same = found.project.range_image(scans[index].id).points
        assert same.tobytes() == store_points(index, four)


def store_points(index: int, path: Path) -> bytes:
    scan = read_npz(path.with_name("four.npz")).scan if index == 3 else scan_of(index)
    return scan.points.tobytes()


def test_a_lost_image_is_read_from_its_source_again(four: Path) -> None:
    scans = store.load(four).scans
    lose_image(four, 3)
    found = salvage(four)
    assert found.lost == () and found.project.scans == scans and found.whole == 4
    write_npz(four.with_name("four.npz"), scan_of(9))
    assert salvage(four).whole == 3, "another scan under the same name is not believed"


def test_a_bad_field_costs_its_scan_and_is_named(four: Path) -> None:
    fields = header_of(four)
    fields["scans"][2]["landmarks"]["chin"]["state"] = "lost"
    with closing(sqlite3.connect(four)) as connection:
        write_header(connection, json.dumps(fields))
        connection.commit()
    with pytest.raises(InputError, match=r"four\.qface.*scans.*chin"):
        store.load(four)
    found = salvage(four)
    assert [item.name for item in found.project.scans] == ["one", "two", "four"] and found.total == 4
    (lost,) = found.lost
    assert "three" in lost and "chin" in lost


def test_a_flipped_digit_is_told(four: Path) -> None:
    data = four.read_bytes()
    assert data.count(b'"y":30.25') == 4
    four.write_bytes(data.replace(b'"y":30.25', b'"y":31.25', 1))
    found = salvage(four)
    assert found.whole == 4 and "look at the fiducials" in found.summary


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75, 0.95])
def test_of_a_file_that_was_cut_off_all_fiducials_are_left(four: Path, share: float) -> None:
    scans, data = store.load(four).scans, four.read_bytes()
    four.with_name("four.npz").unlink()
    four.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(InputError, match="is cut off"):
        store.load(four)
    found = salvage(four)
    assert [item.landmarks for item in found.project.scans] == [item.landmarks for item in scans]
    assert found.whole == 4 - len(found.lost) and found.whole <= 4 * share + 1 and (share < 0.75 or found.whole >= 2)


def test_what_is_no_project_or_newer_is_refused_as_before(four: Path, tmp_path: Path) -> None:
    (tmp_path / "text.qface").write_text("not a project" * 100)
    with pytest.raises(InputError, match="is not a Quasiface Studio project"):
        salvage(tmp_path / "text.qface")
    with closing(sqlite3.connect(four)) as connection:
        connection.execute("PRAGMA user_version = 99")
    with pytest.raises(InputError, match="newer version"):
        salvage(four)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.integers(0, 10**6), st.integers(1, 255)), min_size=1, max_size=60), st.floats(0.05, 1.0))
def test_any_damage_is_an_input_error_or_a_counted_loss(
    four: Path, tmp_path: Path, flips: list[tuple[int, int]], share: float
) -> None:
    data = bytearray(four.read_bytes())
    for at, value in flips:
        data[at % len(data)] ^= value
    damaged = tmp_path / "damaged.qface"
    damaged.write_bytes(data[: int(share * len(data))])
    try:
        found = salvage(damaged)
    except InputError as error:
        assert "damaged.qface" in str(error)
        return
    assert found.project.scans and found.whole <= found.total <= 4
    assert found.whole == found.total or found.lost
