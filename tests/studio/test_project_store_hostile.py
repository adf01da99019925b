"""Nothing that is not a whole and sound project file is believed."""

from __future__ import annotations

import io
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
from engine.scan.range_image import RangeImage
from studio.project import store
from studio.project.document import Project, array_key
from studio.project.migrations import write_header

Make = Callable[..., tuple[Project, str]]
Positions = dict[str, tuple[float, float]]


def _content(path: Path) -> tuple[Any, ...]:
    with closing(sqlite3.connect(path)) as connection:
        header = json.loads(connection.execute("SELECT value FROM project WHERE key = 'header'").fetchone()[0])
        return header, sorted(connection.execute("SELECT * FROM chunks"))


def change(path: Path, **edits: str) -> None:
    """Run SQL on a project file as somebody else would."""
    with closing(sqlite3.connect(path)) as connection:
        for sql in edits.values():
            connection.execute(sql)
        connection.commit()


def change_header(path: Path, edit: Callable[[dict[str, Any]], None]) -> None:
    with closing(sqlite3.connect(path)) as connection:
        fields = json.loads(connection.execute("SELECT value FROM project WHERE key = 'header'").fetchone()[0])
        edit(fields)
        write_header(connection, json.dumps(fields))
        connection.commit()


@pytest.mark.parametrize("share", [0.0, 0.001, 0.01, 0.3, 0.9, 0.999])
def test_a_file_that_is_cut_off_is_refused(saved: Path, share: float) -> None:
    data = saved.read_bytes()
    saved.write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError, match=r"empty|not a Quasiface|cut off"):
        store.load(saved)


def test_files_of_other_kinds_are_refused(tmp_path: Path) -> None:
    for data in (b"\x89PNG\r\n\x1a\n" + bytes(200), b"x" * 5000, b"SQLite format 3\0" + bytes(84)):
        (tmp_path / "other.qface").write_bytes(data)
        with pytest.raises(InputError, match="is not a Quasiface Studio project"):
            store.load(tmp_path / "other.qface")
    change(tmp_path / "foreign.qface", table="CREATE TABLE project (key TEXT, value TEXT)")
    with pytest.raises(InputError, match="is not a Quasiface Studio project"):
        store.load(tmp_path / "foreign.qface")
    for path in (tmp_path / "none.qface", tmp_path):
        with pytest.raises(InputError, match="cannot be opened"):
            store.load(path)


def test_damaged_pages_are_refused(saved: Path) -> None:
    data = bytearray(saved.read_bytes())
    data[4096:] = bytes(len(data) - 4096)
    saved.write_bytes(data)
    with pytest.raises(InputError, match=r"faces\.qface"):
        store.load(saved)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.integers(0, 3 * 4096), st.integers(0, 255)), min_size=1, max_size=30), st.integers(0, 3))
def test_flipped_bytes_are_an_input_error_or_harmless(
    saved: Path, tmp_path: Path, flips: list[tuple[int, int]], page: int
) -> None:
    data = bytearray(saved.read_bytes())
    for at, value in flips:
        data[(at + page * 4096) % len(data)] = value
    (tmp_path / "flipped.qface").write_bytes(data)
    try:
        store.load(tmp_path / "flipped.qface")
    except InputError as error:
        assert "flipped.qface" in str(error)


def test_a_view_in_the_place_of_a_table_is_refused(saved: Path) -> None:
    endless = (
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT 'header' AS key, i AS value FROM n"
    )
    change(saved, drop="DROP TABLE project", view=f"CREATE VIEW project AS {endless}")
    with pytest.raises(InputError, match="other tables"):
        store.load(saved)


def npy(array: Any, **more: Any) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array, **more)
    return buffer.getvalue()


HOSTILE: dict[str, Callable[[bytes], bytes | str]] = {
    "object array": lambda data: npy(np.array([{"a": 1}, None], dtype=object), allow_pickle=True),
    "structured type": lambda data: npy(np.zeros(3, dtype=[("x", "f8"), ("y", "O")]), allow_pickle=True),
    "text array": lambda data: npy(np.array(["a"])),
    "cut off": lambda data: data[:-1],
    "too long": lambda data: data + b"\0",
    "no header": lambda data: b"",
    "absurd shape": lambda data: data.replace(b"(", b"(9999999999, ", 1)[: len(data)],
    "negative shape": lambda data: npy(np.zeros((2, 2))).replace(b"(2, 2)", b"(-2,2)"),
    "header that never ends": lambda data: npy(np.zeros((2, 2))).replace(b"(2, 2)", b"((2,2,"),
    "column order": lambda data: npy(np.asfortranarray(np.zeros((2, 3)))),
    "big-endian": lambda data: npy(np.zeros(3, ">f8")),
    "a code, not a header": lambda data: data[:10] + b"__import__('os')".ljust(118) + data[128:],
    "other values": lambda data: data[:-8] + np.float64(1.0).tobytes(),
    "text": lambda data: "not a blob",
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_hostile_arrays_are_refused(saved: Path, kind: str) -> None:
    header, chunks = _content(saved)
    key = header["scans"][0]["image"]["depth"]
    (data,) = (data for k, _, data in chunks if k == key)
    with closing(sqlite3.connect(saved)) as connection:
        connection.execute("UPDATE chunks SET data = ? WHERE key = ?", (HOSTILE[kind](data), key))
        connection.commit()
    with pytest.raises(InputError, match=r"scan 'base': array .* (is damaged|is not plain numbers)"):
        store.load(saved)


def swap(path: Path, array: Any, *places: str) -> None:
    """Store another, well-formed array and let the header name it."""
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("INSERT INTO chunks VALUES (?, 0, ?)", (array_key(array), npy(array)))
        connection.commit()

    def edit(fields: dict[str, Any]) -> None:
        if places[0] == "fit":
            next(iter(fields["fits"].values()))[places[1]] = array_key(array)
        else:
            fields["scans"][0]["image"][places[1]] = array_key(array)

    change_header(path, edit)


@pytest.mark.parametrize(
    ("array", "places", "words"),
    [
        (np.zeros((3, 3)), ("image", "colour"), r"is float64 \(3, 3\)"),
        (np.zeros((2, 2, 3), np.uint8), ("image", "colour"), "colour image: is 2 x 2"),
        (np.full((200, 160), np.nan), ("image", "depth"), "no valid pixel"),
        (np.zeros(7), ("image", "depth"), r"is float64 \(7,\)"),
        (np.zeros((5, 3)), ("fit", "normals"), r"is float64 \(5, 3\)"),
        (np.full((4, 3), 10**9), ("fit", "faces"), "an index is outside"),
        (np.array([10**9]), ("fit", "folded_faces"), "folded face that is not there"),
        (np.full((4, 3), np.inf), ("fit", "vertices"), "fit m1-"),
    ],
)
def test_arrays_that_do_not_fit_together_are_refused(
    saved: Path, array: Any, places: tuple[str, str], words: str
) -> None:
    swap(saved, array, *places)
    with pytest.raises(InputError, match=words):
        store.load(saved)


def _set(*path: Any, value: Any) -> Callable[[dict[str, Any]], None]:
    def edit(fields: dict[str, Any]) -> None:
        for part in path[:-1]:
            fields = fields[part]
        fields[path[-1]] = value

    return edit


HEADERS: dict[str, tuple[Callable[[dict[str, Any]], None], str]] = {
    "unknown field": (_set("nonsense", value=1), "nonsense"),
    "levels": (_set("scans", 0, "options", "levels", value=99), r"scans\.0\.options\.levels: input should be less"),
    "state": (_set("scans", 0, "landmarks", "chin", "state", value="lost"), r"landmarks\.chin\.state"),
    "coordinate": (_set("scans", 0, "landmarks", "chin", "x", value="left"), r"landmarks\.chin\.x"),
    "no place": (_set("scans", 0, "landmarks", "chin", "x", value=None), "fiducial chin: has no finite place"),
    "outside": (_set("scans", 0, "landmarks", "chin", "x", value=1e6), "fiducial chin: lies at .* outside"),
    "point of no scheme": (_set("scans", 0, "landmarks", "ear", value={"x": 1, "y": 1, "state": "placed"}), "ear"),
    "name": (_set("scans", 0, "name", value="../../etc/passwd"), "cannot name a file"),
    "array key": (_set("scans", 0, "image", "depth", value="../x"), r"image\.depth"),
    "absent array": (_set("scans", 0, "image", "depth", value="0" * 64), "is not in it"),
    "no points": (_set("scans", 0, "image", "depth", value=None), "neither points nor depth"),
    "camera": (_set("scans", 0, "image", "camera", "fx", value=0), r"camera\.fx"),
    "scheme": (_set("scans", 0, "scheme", value="ajar"), r"scheme"),
    "not a list": (_set("scans", value={}), "scans"),
}


@pytest.mark.parametrize("kind", HEADERS)
def test_a_bad_header_names_its_field(saved: Path, kind: str) -> None:
    edit, words = HEADERS[kind]
    change_header(saved, edit)
    with pytest.raises(InputError, match=words) as caught:
        store.load(saved)
    assert str(saved) in str(caught.value) and "\n" not in str(caught.value)


def test_two_scans_of_one_name_or_id_are_refused(saved: Path) -> None:
    change_header(saved, lambda fields: fields["scans"].append({**fields["scans"][0], "id": "other"}))
    with pytest.raises(InputError, match="belongs to two scans"):
        store.load(saved)
    change_header(saved, lambda fields: fields["scans"][1].update(id=fields["scans"][0]["id"], name="car"))
    with pytest.raises(InputError, match="already"):
        store.load(saved)


def test_a_scan_that_is_not_the_one_that_was_fitted_shows_its_fit_as_stale(saved: Path, scan: RangeImage) -> None:
    depth = -scan.points[..., 2] + 1.0
    swap(saved, depth, "image", "depth")
    project = store.load(saved)
    assert project.state(project.scans[0].id).reason == "scan replaced"


@pytest.mark.parametrize("header", ["{", "[1]", '{"scans": [], "fits": {}', "null", ""])
def test_a_header_that_is_no_json_is_refused(saved: Path, header: str) -> None:
    with closing(sqlite3.connect(saved)) as connection:
        connection.execute("UPDATE project SET value = ?", (header,))
        connection.commit()
    with pytest.raises(InputError, match=r"faces\.qface"):
        store.load(saved)
    change(saved, delete="DELETE FROM project")
    with pytest.raises(InputError, match="has no header"):
        store.load(saved)
