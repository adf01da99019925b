"""A project file gives back exactly what was saved, in files of any age, and survives what fails."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.landmarks import Landmark, LandmarkSet, LandmarkState
from engine.scan.range_image import RangeImage
from studio.project import arrays, migrations, store
from studio.project.document import Project, ScanItem, new_id
from studio.scan.job import input_key, scheme_of
from studio.scan.options import FitOptions

Make = Callable[..., tuple[Project, str]]
Positions = dict[str, tuple[float, float]]


def same_arrays(a: Any, b: Any) -> bool:
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


names = st.sampled_from(scheme_of("open").names)
coordinates = st.floats(-0.5, 159.5)
landmarks = st.builds(
    LandmarkSet,
    st.dictionaries(
        names,
        st.one_of(
            st.builds(Landmark, coordinates, coordinates, st.sampled_from(LandmarkState), st.booleans()),
            st.builds(Landmark, state=st.sampled_from(LandmarkState), locked=st.booleans()).filter(
                lambda point: not point.is_set
            ),
        ),
    ),
)
texts = st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=20)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(landmarks, texts, texts, st.sampled_from(["closed", "open"]), st.floats(0.5, 50))
def test_every_small_value_comes_back(
    make_project: Make, tmp_path: Path, points: LandmarkSet, word: str, held: str, scheme: str, spike: float
) -> None:
    project, scan_id = make_project()
    options = FitOptions(levels=3, smooth=False, spike_mm=spike)
    project.change_scan(scan_id, landmarks=points, word=word, held=held, scheme=scheme, options=options)
    again = store.load(store.save(project, tmp_path / "small.qface"))
    assert again.scans == project.scans
    assert [again.state(item.id) for item in again.scans] == [project.state(item.id) for item in project.scans]


def test_scan_and_fit_come_back_bit_for_bit_and_fresh(
    make_project: Make, scan: RangeImage, fiducials: Positions, face, tmp_path: Path
) -> None:
    project, base = make_project(fiducials)
    project.put_fit(base, input_key(project.scan(base)), face)
    bare = RangeImage(scan.points + 0.125, None, None)
    project.insert_scan(1, ScanItem(new_id(), "bare", project.add_image(bare)))
    off_camera = RangeImage(scan.points + 1.0 / 3.0, scan.colour, scan.camera)
    project.insert_scan(2, ScanItem(new_id(), "off", project.add_image(off_camera)))

    again = store.load(store.save(project, tmp_path / "a.qface"))
    assert again.name == "a" and again.path == tmp_path / "a.qface"
    for item in project.scans:
        one, two = project.range_image(item.id), again.range_image(item.id)
        assert same_arrays(one.points, two.points) and one.camera == two.camera
        assert (one.colour is None) == (two.colour is None)
        assert one.colour is None or same_arrays(one.colour, two.colour)
    assert again.state(base).kind == "fresh"
    other = again.fit(base)
    for name in ("vertices", "faces", "uv", "uv_faces"):
        assert same_arrays(getattr(face.mesh, name), getattr(other.mesh, name))
    for name in ("normals", "pixels", "filled", "deviation_mm", "folded_faces"):
        assert same_arrays(getattr(face, name), getattr(other, name))
    for name in ("fiducial_residual_px", "folded_fiducials", "repair", "levels", "scheme"):
        assert getattr(face, name) == getattr(other, name)
    # A second saving writes the same content.
    assert _content(store.save(again, tmp_path / "b.qface")) == _content(tmp_path / "a.qface")


def test_a_stale_result_stays_stale_for_the_same_reason(
    make_project: Make, fiducials: Positions, face, tmp_path: Path
) -> None:
    project, scan_id = make_project(fiducials)
    first = project.scan(scan_id)
    project.put_fit(scan_id, input_key(first), face)
    project.change_scan(scan_id, landmarks=first.landmarks.moved("chin", 80.0, 170.0))
    again = store.load(store.save(project, tmp_path / "stale.qface"))
    assert again.state(scan_id) == project.state(scan_id)
    assert again.state(scan_id).reason == "fiducials moved"
    again.replace_scan(first)
    assert again.state(scan_id).kind == "fresh"


def test_a_seen_camera_makes_the_file_smaller_and_equal_arrays_are_stored_once(
    make_project: Make, scan: RangeImage, tmp_path: Path
) -> None:
    project, scan_id = make_project()
    one = store.save(project, tmp_path / "one.qface").stat().st_size
    assert one < scan.points.nbytes
    project.insert_scan(1, ScanItem(new_id(), "twin", project.scan(scan_id).image_key))
    two = store.save(project, tmp_path / "two.qface").stat().st_size
    assert two - one < 20_000


def test_large_arrays_are_cut_into_chunks_and_joined_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arrays, "CHUNK_BYTES", 1000)
    array = np.random.default_rng(0).normal(size=(37, 29))
    with closing(sqlite3.connect(":memory:")) as connection:
        migrations.migrate(connection)
        key = arrays.write_array(connection, array)
        sizes = [n for (n,) in connection.execute("SELECT length(data) FROM chunks ORDER BY part")]
        assert max(sizes) == 1000 and len(sizes) == -(-(array.nbytes + 128) // 1000)
        assert same_arrays(arrays.read_array(connection, key, "file"), array)


def test_the_old_file_survives_a_failing_save(saved: Path, make_project: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    before = saved.read_bytes()
    project, _ = make_project()

    def fail(*_: object) -> str:
        raise sqlite3.OperationalError("database or disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(store, "write_array", fail)
        with pytest.raises(InputError, match=r"faces\.qface: cannot be written \(database or disk is full\)"):
            store.save(project, saved)
    assert saved.read_bytes() == before and list(saved.parent.iterdir()) == [saved]
    assert project.path is None
    with pytest.raises(InputError, match="cannot be written"):
        store.save(project, saved / "below" / "a.qface")
    with pytest.raises(InputError, match="is a folder"):
        store.save(project, saved.parent)
    with pytest.raises(InputError, match="save it under a name"):
        store.save(project)
    assert store.load(store.save(project, saved)).scans == project.scans


def test_older_files_are_migrated_without_being_touched_and_newer_ones_refused(
    saved: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = saved.read_bytes()
    scans = store.load(saved).scans

    def notes(connection: sqlite3.Connection) -> None:
        connection.execute("CREATE TABLE notes (text TEXT)")
        for (header,) in connection.execute("SELECT value FROM project WHERE key = 'header'").fetchall():
            fields = json.loads(header)
            fields["scans"][0]["word"] = "migrated"
            migrations.write_header(connection, json.dumps(fields))

    with monkeypatch.context() as patch:
        patch.setattr(migrations, "MIGRATIONS", [*migrations.MIGRATIONS, notes])
        project = store.load(saved)
        assert [item.word for item in project.scans] == ["migrated"]
        assert saved.read_bytes() == before
        store.save(project, saved)
    with pytest.raises(InputError, match=r"newer version \(file version 4, this program reads 3\); update the program"):
        store.load(saved)
    assert [item.name for item in scans] == ["base"]


def _content(path: Path) -> tuple[Any, ...]:
    with closing(sqlite3.connect(path)) as connection:
        header = json.loads(connection.execute("SELECT value FROM project WHERE key = 'header'").fetchone()[0])
        return header, sorted(connection.execute("SELECT * FROM chunks"))
