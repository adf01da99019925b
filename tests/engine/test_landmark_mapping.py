"""Mappings: shipped ones put points where anatomy says, inverses undo them, files come back, names are understood."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.errors import InputError
from engine.files.landmarks import read_landmarks
from engine.files.mapping import read_mapping, write_mapping
from engine.files.scheme import read_scheme
from engine.landmark_mapping import LandmarkMapping, apply_mapping, by_name, choose_mapping, invert_mapping
from engine.landmarks import LandmarkScheme
from engine.scan.landmark_pixels import looks_mirrored
from tests.engine.files.test_landmark_files import JAMES, VIDEO

RESOURCES = Path(__file__).resolve().parents[2] / "resources"
OPEN: LandmarkScheme = read_scheme(RESOURCES / "schemes" / "open.toml")
CLOSED: LandmarkScheme = read_scheme(RESOURCES / "schemes" / "closed.toml")
SHIPPED = {path.stem: read_mapping(path) for path in sorted((RESOURCES / "mappings").glob("*.toml"))}


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_mappings_name_known_fiducials_and_mirror_each_other(name: str) -> None:
    mapping = SHIPPED[name]
    assert mapping.name == name and mapping.count == len(mapping.labels)
    assert set(mapping.entries) == set(OPEN.names) - {"forehead"}
    used = [source for sources in mapping.entries.values() for source in set(sources)]
    assert len(set(used)) >= len(mapping.entries)


def faces() -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Return real points as (labels, pixels): y downwards, a mesh seen from the front."""
    found = {}
    if VIDEO.exists():
        file = read_landmarks(VIDEO)
        found["ibug68"] = file.labels, file.points
    if JAMES.exists():
        file = read_landmarks(JAMES)
        found["menpo_face"] = file.labels, file.points[:, :2] * (1, -1)
    return found


@pytest.mark.skipif(not (VIDEO.exists() and JAMES.exists()), reason="the trial data are not beside the project")
@pytest.mark.parametrize("name", SHIPPED)
def test_real_faces_are_mapped_as_a_face_is_made(name: str) -> None:
    labels, pixels = faces()[name]
    mapping, why = choose_mapping(SHIPPED.values(), labels, OPEN.names)
    assert mapping == SHIPPED[name] and why
    at = {n: np.array(p) for n, p in apply_mapping(mapping, pixels, labels, OPEN.names).positions.items()}
    assert len(at) == 25
    for left in (n for n in at if "left" in n):
        assert at[left][0] > at[left.replace("left", "right")][0], left  # the subject's left is on the picture's right
    for outer, inner in (("brow_left_outer", "brow_left_inner"), ("eye_left_outer", "eye_left_inner")):
        assert (
            at[outer][0] > at[inner][0]
            and at[outer.replace("left", "right")][0] < at[inner.replace("left", "right")][0]
        )
    order = ["eye_left_inner", "nose_tip", "lip_upper", "lip_upper_inner", "lip_lower", "chin"]
    heights = [at[n][1] for n in order]
    assert heights == sorted(heights)
    assert at["brow_left_inner"][1] < at["eye_left_inner"][1]
    mouth = at["mouth_left"][0] - at["mouth_right"][0]
    for side in ("jaw_left", "jaw_right"):
        assert abs(at[side][1] - at[side.replace("jaw", "mouth")][1]) < 0.3 * mouth, "level with the mouth"
    assert not looks_mirrored({n: tuple(p) for n, p in at.items()}, OPEN)


def test_a_mirrored_or_swapped_face_is_noticed_and_a_turned_one_is_not() -> None:
    mapping = by_name(OPEN.names, OPEN.names)
    points = {
        "eye_left_outer": (60.0, 10.0), "eye_right_outer": (20.0, 10.0), "mouth_left": (50.0, 50.0),
        "mouth_right": (30.0, 50.0), "chin": (40.0, 80.0),
    }  # fmt: skip
    assert len(mapping.entries) == 26
    assert not looks_mirrored(points, OPEN)
    assert looks_mirrored({n: (-x, y) for n, (x, y) in points.items()}, OPEN)
    assert looks_mirrored({n: (x, -y) for n, (x, y) in points.items()}, OPEN)
    for turn in (lambda x, y: (-x, -y), lambda x, y: (-y, x), lambda x, y: (y, -x)):
        assert not looks_mirrored({n: turn(x, y) for n, (x, y) in points.items()}, OPEN)
    assert not looks_mirrored({"chin": (1.0, 2.0)}, OPEN)


@pytest.mark.parametrize("name", SHIPPED)
def test_export_undoes_import(name: str) -> None:
    mapping = SHIPPED[name]
    planted = {
        n: (x, y) for n, (x, y) in zip(OPEN.names, np.random.default_rng(3).uniform(0, 400, (26, 2)), strict=True)
    }
    out = invert_mapping(mapping, planted)
    assert out.labels == mapping.labels and out.lost == ("forehead",) and out.holes == 68 - 25
    back = apply_mapping(mapping, out.points, out.labels, OPEN.names)
    assert back.unmapped == ("forehead",) and not back.absent
    for target, place in back.positions.items():
        assert place == pytest.approx(planted[target], abs=1e-12)
    without = invert_mapping(mapping, {n: p for n, p in planted.items() if n != "lip_lower"})
    assert without.lost == ("forehead", "chin"), "the chin's mean needs the lower lip"


def test_means_weights_and_what_lacks() -> None:
    mapping = LandmarkMapping("m", {"chin": (0, 0, 1), "nose_tip": ("2",), "mouth_left": (9,), "jaw_left": ("ear",)})
    points = np.array([[0.0, 3.0], [9.0, 0.0], [np.nan, np.nan]])
    mapped = apply_mapping(mapping, points, ("0", "1", "2"), CLOSED.names)
    assert mapped.positions == {"chin": (3.0, 2.0)}
    assert mapped.absent == {"nose_tip": "2", "mouth_left": "9", "jaw_left": "ear"}
    assert len(mapped.unmapped) == 16


def test_names_are_understood_in_any_spelling_and_doubt_is_left_to_the_user() -> None:
    said = {
        "LeftEyeOuter": "eye_left_outer", "eye.L.inner": "eye_left_inner", "pronasale": "nose_tip",
        "outer_right_eyebrow": "brow_right_outer", "left mouth corner": "mouth_left", "upper lip": "lip_upper",
        "JAW-R": "jaw_right", "endocanthion_right": "eye_right_inner", "alare left": "nose_left", "CHIN": "chin",
    }  # fmt: skip
    entries = by_name(list(said), OPEN.names).entries
    assert entries == {target: (label,) for label, target in said.items()}
    assert not by_name(["left eye outer", "EyeLeftOuter", "elbow", "left", ""], OPEN.names).entries
    # The plain name wins, and its namesake is not used for another.
    assert by_name(["chin", "Chin"], OPEN.names).entries == {"chin": ("chin",)}


def test_choice_prefers_names_then_labels_then_count() -> None:
    assert choose_mapping(SHIPPED.values(), CLOSED.names, CLOSED.names)[0].name == "by name"
    assert choose_mapping(SHIPPED.values(), tuple(map(str, range(68))), CLOSED.names)[0].name == "ibug68"
    assert choose_mapping(SHIPPED.values(), SHIPPED["menpo_face"].labels, CLOSED.names)[0].name == "menpo_face"
    nothing, _ = choose_mapping(SHIPPED.values(), tuple(map(str, range(5))), CLOSED.names)
    assert nothing.name == "by name" and not nothing.entries


@pytest.mark.parametrize("ending", [".toml", ".json"])
def test_mappings_come_back_as_they_were(tmp_path: Path, ending: str) -> None:
    strange = LandmarkMapping(
        "mine", {"chin": (1, 1, 'a."b"\\ ü'), "nose_tip": ("7",)}, 'with "quotes" \u007f', None, {}, "line"
    )
    for mapping in (*SHIPPED.values(), strange):
        write_mapping(tmp_path / f"m{ending}", mapping)
        assert read_mapping(tmp_path / f"m{ending}") == mapping


BAD = {
    "fiducials.chin": 'name = "a"\n[fiducials]\nchin = 1.5\n',
    "fiducials.jaw_left": 'name = "a"\n[fiducials]\njaw_left = []\n',
    "chin: there is no point 70": 'name = "a"\ncount = 68\n[fiducials]\nchin = 70\n',
    "labels: have 3 points of 4": 'name = "a"\ncount = 4\n[labels]\nx = 3\n[fiducials]\nchin = 1\n',
    "name": "[fiducials]\nchin = 1\n",
    "colour": 'name = "a"\ncolour = 1\n[fiducials]\nchin = 1\n',
    "TOML": "name = \n",
    "count": 'name = "a"\ncount = 99999999999999\n[fiducials]\n',
}


@pytest.mark.parametrize("field", BAD)
def test_bad_mappings_name_the_field(tmp_path: Path, field: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(BAD[field])
    with pytest.raises(InputError) as caught:
        read_mapping(path)
    assert field in str(caught.value) and "bad.toml" in str(caught.value) and "\n" not in str(caught.value)
