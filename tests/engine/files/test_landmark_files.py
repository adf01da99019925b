"""Landmarks of every format come back bit by bit, real files are read, and hostile ones are refused in a line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.landmarks import read_landmarks, write_landmarks

DATA = Path(__file__).resolve().parents[4] / "shared" / "data"
VIDEO = DATA / "video" / "expressions_sad_to_laughing_points68.csv"
JAMES = DATA / "meshes" / "james.ljson"

PLACE = st.floats(-1e7, 1e7)
NAME = st.text(st.characters(codec="utf-8", categories=("L", "N", "P", "S")), min_size=1, max_size=12)
QUIET = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def usable(names: list[str]) -> bool:
    return all(name.isprintable() and name.strip() == name and not name.startswith("#") for name in names)


@QUIET
@given(
    data=st.data(),
    names=st.lists(NAME, min_size=1, max_size=8, unique=True).filter(usable),
    width=st.sampled_from((2, 3)),
)
@pytest.mark.parametrize("ending", [".csv", ".ljson", ".json", ".pts"])
def test_points_and_names_come_back_bit_by_bit(
    tmp_path: Path, ending: str, data: Any, names: list[str], width: int
) -> None:
    width = 2 if ending == ".json" else width
    rows = st.lists(PLACE, min_size=width, max_size=width)
    points = np.array(data.draw(st.lists(rows, min_size=len(names), max_size=len(names))))
    path = tmp_path / f"points{ending}"
    origin = data.draw(st.sampled_from((None, 0, 0.5, 1))) if ending in (".csv", ".pts") else None
    write_landmarks(path, points, names, (640, 480), origin)
    back = read_landmarks(path, origin=origin)
    assert np.array_equal(back.points, points)
    if ending != ".pts":
        assert back.labels == tuple(names)
    assert back.image_size == ((640, 480) if ending == ".json" else None)


@pytest.mark.parametrize("ending", [".csv", ".ljson"])
def test_holes_stay_holes(tmp_path: Path, ending: str) -> None:
    points = np.array([[1.25, 2.5], [np.nan, np.nan], [0.1, 1e-9]])
    write_landmarks(tmp_path / f"a{ending}", points, ["eye.0", "eye.1", "chin"])
    back = read_landmarks(tmp_path / f"a{ending}")
    assert np.array_equal(back.points, points, equal_nan=True) and back.present == 2
    assert back.labels == ("eye.0", "eye.1", "chin")
    with pytest.raises(InputError, match=r"cannot leave them out; write \.ljson"):
        write_landmarks(tmp_path / "a.pts", points, ["0", "1", "2"])
    assert not (tmp_path / "a.pts").exists()


def test_pts_counts_from_one_and_ljson_has_rows_first(tmp_path: Path) -> None:
    (tmp_path / "a.pts").write_text("version: 1\nn_points: 2\n{\n1 1\n640 480.5\n}\n")
    assert read_landmarks(tmp_path / "a.pts").points.tolist() == [[0, 0], [639, 479.5]]
    assert read_landmarks(tmp_path / "a.pts", origin=0).points.tolist() == [[1, 1], [640, 480.5]]
    assert read_landmarks(tmp_path / "a.pts", origin=0.5).points.tolist() == [[0.5, 0.5], [639.5, 480]]
    write_landmarks(tmp_path / "b.ljson", np.array([[7.0, 3.0]]), ["chin"])
    value = json.loads((tmp_path / "b.ljson").read_text())
    assert value["version"] == 3 and value["groups"]["LJSON"]["landmarks"]["points"] == [[3.0, 7.0]]


def test_three_versions_of_ljson_say_the_same(tmp_path: Path) -> None:
    points: list[Any] = [[10, 1], [20, 2], None, [40, 4]]
    labels = [{"label": "eye", "mask": [0, 1]}, {"label": "lip", "mask": [2]}, {"label": "all", "mask": [0, 1, 2, 3]}]
    group = {"labels": labels, "landmarks": {"points": [p or [None, None] for p in points], "connectivity": [[0, 1]]}}
    versions = {
        1: {"version": 1, "groups": [
            {"label": "eye", "landmarks": [{"point": points[0]}, {"point": points[1]}], "connectivity": [[0, 1]]},
            {"label": "lip", "landmarks": [{"point": None}]},
            {"label": "3", "landmarks": [{"point": points[3]}]},
        ]},
        2: {"version": 2, **group},
        3: {"version": 3, "groups": {"first": group, "second": {**group, "labels": []}}},
    }  # fmt: skip
    for version, value in versions.items():
        path = tmp_path / f"v{version}.ljson"
        path.write_text(json.dumps(value))
        file = read_landmarks(path)
        assert file.labels == ("eye.0", "eye.1", "lip", "3"), version
        expected = np.array([[1, 10], [2, 20], [np.nan, np.nan], [4, 40]])
        assert np.array_equal(file.points, expected, equal_nan=True), version
    assert file.groups == ("first", "second") and "first of 2" in " ".join(file.remarks)
    assert read_landmarks(tmp_path / "v3.ljson", "second").labels == ("0", "1", "2", "3")
    with pytest.raises(InputError, match="no group 'third'; choose one of: first, second"):
        read_landmarks(tmp_path / "v3.ljson", "third")
    (tmp_path / "renamed.json").write_text(json.dumps(versions[2]))
    assert read_landmarks(tmp_path / "renamed.json").labels == ("eye.0", "eye.1", "lip", "3")


TABLES = {
    "name,x,y\nchin,1.5,2\nnose,,\n": (("chin", "nose"), [[1.5, 2], [np.nan, np.nan]], ("",)),
    "x;y;label\n1.5;2;chin\nNA;3;nose\n": (("chin", "nose"), [[1.5, 2], [np.nan, np.nan]], ("",)),
    "name\tx\ty\tz\nchin\t1\t2\t3\n": (("chin",), [[1, 2, 3]], ("",)),
    "frame,chin_x,chin_y,nose_x,nose_y,note\n7,1,2,3,4,yes\n9,5,6,7,8,no\n": (
        ("chin", "nose"), [[1, 2], [3, 4]], ("7", "9"),
    ),
    "image,x0,y0,x1,y1\na.png,1,2,3,4\n": (("0", "1"), [[1, 2], [3, 4]], ("a.png",)),
    "frame, x_1, x_0, y_1, y_0\n1, 3, 1, 4, 2\n": (("0", "1"), [[1, 2], [3, 4]], ("1",)),
    "5,1,2,3,4\n6,5,6,7,8\n": (("0", "1"), [[1, 2], [3, 4]], ("5", "6")),
    "1,2,3,4\n": (("0", "1"), [[1, 2], [3, 4]], ("0",)),
    "1,2\n3,4\n": (("0", "1"), [[1, 2], [3, 4]], ("",)),
    '"name","x","y"\r\n"le ""ft"", x",1,2\r\n': (('le "ft", x',), [[1, 2]], ("",)),
}  # fmt: skip


@pytest.mark.parametrize("text", TABLES)
def test_tables_are_told_apart(tmp_path: Path, text: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text, newline="")
    labels, points, groups = TABLES[text]
    file = read_landmarks(path)
    assert (file.labels, file.groups) == (labels, groups)
    assert np.array_equal(file.points, np.array(points), equal_nan=True)
    last = read_landmarks(path, groups[-1]) if groups != ("",) else file
    assert last.group == groups[-1] and (len(groups) < 2 or last.points[0, 0] == 5)


BAD = {
    "comma.csv": ("name;x;y\nchin;1,5;2,5\n", "decimal comma; export the table with decimal points"),
    "bare_comma.csv": ("1,5;2,5;3,5\n", "decimal comma"),
    "columns.csv": ("name,age\nchin,3\n", "no columns of points"),
    "one.csv": ("name\nchin\n", "one column"),
    "twice.csv": ("name,x,y\nchin,1,2\nchin,1,2\n", "names 'chin' twice"),
    "short.csv": ("name,x,y\nchin,1\n", "line 2: has 2 cells"),
    "word.csv": ("name,x,y\nchin,1,hello\n", "line 2: 'hello' is not a number"),
    "under.csv": ("name,x,y\nchin,1_0,2\n", "not a number"),
    "arabic.csv": ("name,x,y\nchin,١,2\n", "not a number"),
    "far.csv": ("name,x,y\nchin,1e300,2\n", "is no place"),
    "inf.csv": ("name,x,y\nchin,inf,2\n", "is no place"),
    "quote.csv": ('name,x,y\n"chin,1,2\n', "is not a table"),
    "binary.csv": ("\0\0\0", "is not text"),
    "latin.csv": (b"name,x,y\nk\xe4se,1,2\n", "is not UTF-8"),
    "empty.csv": ("\n\n", "has no rows"),
    "header.csv": ("name,x,y\n", "no points"),
    "count.pts": ("version: 1\nn_points: 3\n{\n1 1\n}\n", "n_points: names 3 points, 1 are there"),
    "huge.pts": ("version: 1\nn_points: 999999999999\n{\n1 1\n}\n", "n_points: is '999999999999'"),
    "open.pts": ("version: 1\nn_points: 1\n{\n1 1\n", "no end"),
    "none.pts": ("version: 1\nn_points: 1\n", "no points: '{' is missing"),
    "version.pts": ("version: 7\nn_points: 1\n{\n1 1\n}\n", "version: is '7'"),
    "uneven.pts": ("n_points: 2\n{\n1 1\n1 2 3\n}\n", "line 4: '1 2 3' has 3 numbers"),
    "comma.pts": ("n_points: 1\n{\n1,5 2,5\n}\n", "decimal comma"),
    "text.pts": ("hello\n", "no line of a .pts header"),
    "version.ljson": ('{"version": 4, "groups": {}}', "version: is 4"),
    "array.ljson": ("[1]", "holds no JSON object"),
    "mask.ljson": (
        '{"version": 2, "labels": [{"label": "a", "mask": [9]}], "landmarks": {"points": [[1, 2]]}}',
        "names point 9 of 1",
    ),
    "mixed.ljson": ('{"version": 2, "landmarks": {"points": [[1, 2], [1, 2, 3]]}}', "some have two"),
    "nulls.ljson": ('{"version": 2, "landmarks": {"points": [null, null]}}', "has no points"),
    "string.ljson": ('{"version": 2, "landmarks": {"points": [["1", 2]]}}', "landmarks.points.0"),
    "deep.ljson": ("[" * 100_000, "is not JSON"),
    "groups.ljson": ('{"version": 3, "groups": {}}', "groups"),
    "format.xyz": ("1 2 3", "no ending that tells the format"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_refused_in_a_line_that_names_them(tmp_path: Path, name: str) -> None:
    content, expected = BAD[name]
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as caught:
        read_landmarks(path)
    text = str(caught.value)
    assert expected in text and name in text and "\n" not in text, text


@QUIET
@given(data=st.binary(max_size=300), ending=st.sampled_from((".csv", ".pts", ".ljson", ".json")))
def test_any_bytes_are_read_or_refused(tmp_path: Path, data: bytes, ending: str) -> None:
    path = tmp_path / f"any{ending}"
    path.write_bytes(data)
    try:
        file = read_landmarks(path)
    except InputError:
        return
    assert len(file.points) == len(file.labels)


@QUIET
@given(
    cut=st.floats(0, 1),
    flip=st.integers(0, 255),
    at=st.floats(0, 0.999),
    ending=st.sampled_from((".csv", ".pts", ".ljson")),
)
def test_damaged_files_are_read_or_refused(tmp_path: Path, cut: float, flip: int, at: float, ending: str) -> None:
    path = tmp_path / f"damaged{ending}"
    write_landmarks(path, np.arange(12.0).reshape(6, 2), ["a.0", "a.1", "b", "c", "d", "5"])
    data = bytearray(path.read_bytes())
    data[int(at * len(data))] ^= flip
    path.write_bytes(bytes(data[: max(1, int(cut * len(data)))]))
    try:
        file = read_landmarks(path)
    except InputError as error:
        assert "\n" not in str(error)
        return
    assert len(file.points) == len(file.labels)


@pytest.mark.skipif(not JAMES.exists(), reason="the trial mesh is not beside the project")
def test_the_trial_mesh_has_its_points_in_space() -> None:
    file = read_landmarks(JAMES)
    assert (file.dimension, file.present, file.group) == (3, 68, "LJSON")
    raw = json.loads(JAMES.read_text())["groups"]["LJSON"]
    assert np.array_equal(file.points, np.array(raw["landmarks"]["points"]))
    masks = {label["label"]: label["mask"] for label in raw["labels"]}
    assert file.labels[masks["leye"][3]] == "leye.3" and file.labels[masks["mouth"][19]] == "mouth.19"


@pytest.mark.skipif(not VIDEO.exists(), reason="the trial video's points are not beside the project")
def test_the_trial_video_has_a_row_for_every_fourth_frame() -> None:
    file = read_landmarks(VIDEO, "8")
    table = np.loadtxt(VIDEO, delimiter=",")
    assert file.groups == tuple(str(int(frame)) for frame in table[:, 0])
    assert np.array_equal(file.points, table[2, 1:].reshape(-1, 2)) and len(file.labels) == 68
