"""Fiducials as files: nothing is lost, nothing wrong gets in."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.landmarks_json import Fiducials, check_fiducials, read_fiducials, write_fiducials

NAMES = st.text(st.characters(categories=("L", "N", "P")), min_size=1, max_size=20)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
GOOD = '{"image_size": [640, 480], "points": {"chin": [1, 2.5]}}'


@given(positions=st.dictionaries(NAMES, st.tuples(NUMBERS, NUMBERS), max_size=8))
def test_round_trip_keeps_every_bit_and_the_order(tmp_path_factory, positions):
    path = tmp_path_factory.mktemp("f") / "f.json"
    write_fiducials(path, positions, (640, 480))
    found = read_fiducials(path)
    assert list(found.positions.items()) == list(positions.items())
    assert found.image_size == (640, 480)


def test_it_unpacks_as_a_pair(tmp_path):
    (tmp_path / "f.json").write_text(GOOD)
    positions, size = read_fiducials(tmp_path / "f.json")
    assert positions == {"chin": (1.0, 2.5)}
    assert size == (640, 480)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ('{"points": {}}', "image_size"),
        ('{"image_size": [640, 480]}', "points"),
        ('{"image_size": [640], "points": {}}', "image_size"),
        ('{"image_size": [640, 0], "points": {}}', "image_size"),
        ('{"image_size": [640, 480.5], "points": {}}', "image_size"),
        ('{"image_size": [640, 480], "points": [[1, 2]]}', "points"),
        ('{"image_size": [640, 480], "points": {"chin": [1]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, 2, 3]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, NaN]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, -Infinity]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, 1e999]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, "2"]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, true]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, null]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, 1' + "0" * 400 + "]}}", "chin"),
        ('{"image_size": [640, 480], "points": {"chin": [1, 1' + "0" * 5000 + "]}}", "f.json"),
        ('{"image_size": [640, 480], "points": {"chin": [1, 2], "chin": [1, 2]}}', "chin"),
        ('{"image_size": [640, 480], "points": {"a\\nb": [1, 2]}}', "name"),
        ("[]", "f.json"),
        ("", "empty"),
        ("{", "line 1"),
        ("[" * 100_000, "f.json"),
    ],
)
def test_what_is_wrong_is_named_in_one_line(tmp_path, text, word):
    (tmp_path / "f.json").write_text(text)
    with pytest.raises(InputError) as caught:
        read_fiducials(tmp_path / "f.json")
    assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_position_that_is_not_finite_is_not_written(tmp_path):
    with pytest.raises(InputError, match="fiducial chin"):
        write_fiducials(tmp_path / "f.json", {"chin": (float("nan"), 1.0)}, (4, 4))
    assert list(tmp_path.iterdir()) == []


def test_they_must_fit_scheme_and_picture():
    scheme = ("chin", "nose_tip")
    good = {"chin": (-0.5, 3.0), "nose_tip": (9.5, 4.5)}
    check_fiducials(Fiducials(good, (10, 5)), scheme, (10, 5))
    for positions, size, word in (
        ({"chin": (1.0, 1.0)}, (10, 5), "nose_tip is missing"),
        ({}, (10, 5), "chin, nose_tip are missing"),
        ({**good, "ear": (1.0, 1.0)}, (10, 5), "ear is not in the scheme"),
        ({**good, "chin": (9.6, 1.0)}, (10, 5), "chin is outside"),
        ({**good, "chin": (1.0, -0.6)}, (10, 5), "chin is outside"),
        (good, (20, 10), "20 x 10"),
    ):
        with pytest.raises(InputError, match=word) as caught:
            check_fiducials(Fiducials(positions, size), scheme, (10, 5), "f.json")
        assert str(caught.value).startswith("f.json")


def test_what_is_written_is_the_documented_form(tmp_path):
    write_fiducials(tmp_path / "f.json", {"chin": (1, 2.5)}, (640, 480))
    assert json.loads((tmp_path / "f.json").read_text()) == json.loads(GOOD)
