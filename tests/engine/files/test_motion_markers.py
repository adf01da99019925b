"""Markers from C3D, TRC and tables: the planted positions come back, gaps are gaps, bad files name the line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.motion import read_motion
from engine.motion import MarkerClip
from tests.engine.files import motion_samples as samples
from tests.engine.files.refusals import refused

CAPTURES = Path("../shared/data/captures")
SAMPLE = Path("resources/sample/performance/speech_emotion.c3d")


def gappy(seed: int = 1) -> np.ndarray:
    clip = samples.performance(30, seed)
    clip[3:7, 2] = np.nan
    clip[20, 5] = np.nan
    return clip


def check(found, clip: np.ndarray, atol: float = 0.0) -> None:
    assert isinstance(found.data, MarkerClip)
    assert found.data.labels == samples.LABELS
    assert found.gaps == int(np.isnan(clip[..., 0]).sum())
    np.testing.assert_allclose(found.data.positions, clip, rtol=0, atol=atol, equal_nan=True)


@pytest.mark.parametrize("processor", ["intel", "mips", "dec"])
@pytest.mark.parametrize("scale", [0.01, -0.01])
@pytest.mark.parametrize("analog", [0, 3])
def test_c3d_of_every_form(tmp_path, processor, scale, analog):
    clip = gappy()
    (tmp_path / "m.c3d").write_bytes(samples.c3d_bytes(clip, scale=scale, processor=processor, analog=analog))
    found = read_motion(tmp_path / "m.c3d")
    check(found, clip, 0.0051 if scale > 0 else 1e-5)
    assert (found.fps, found.unit, found.kind) == (120.0, "mm", "markers")


def test_c3d_agrees_with_the_library(tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    (tmp_path / "m.c3d").write_bytes(samples.c3d_bytes(gappy()))
    for path in (tmp_path / "m.c3d", SAMPLE):
        other = ezc3d.c3d(str(path))
        theirs = other["data"]["points"][:3].transpose(2, 1, 0)
        found = read_motion(path)
        assert tuple(other["parameters"]["POINT"]["LABELS"]["value"]) == found.data.labels
        assert other["header"]["points"]["frame_rate"] == found.fps
        np.testing.assert_allclose(found.data.positions, theirs, rtol=1e-6, equal_nan=True)


def test_c3d_that_the_library_writes(tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    clip = gappy()
    made = ezc3d.c3d()
    made["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    made["parameters"]["POINT"]["RATE"]["value"] = [100]
    made["parameters"]["POINT"]["LABELS"]["value"] = list(samples.LABELS)
    made["data"]["points"] = np.vstack([clip.transpose(2, 1, 0), np.ones((1, *clip.shape[1::-1]))])
    made.write(str(tmp_path / "m.c3d"))
    found = read_motion(tmp_path / "m.c3d")
    check(found, clip, 1e-4)
    assert found.fps == 100


def test_c3d_with_more_frames_than_its_first_block_can_count(tmp_path):
    clip = np.tile(samples.performance(30), (2300, 1, 1))
    count = np.array([len(clip)], "<f4").tobytes()
    data = samples.c3d_bytes(clip, last=65535, extra=[(b"LONG_FRAMES", b"\4\0" + count)])
    (tmp_path / "m.c3d").write_bytes(data)
    assert len(read_motion(tmp_path / "m.c3d").data) == 69_000


@pytest.mark.parametrize("unit", ["mm", "cm", "m"])
def test_trc_in_every_unit(tmp_path, unit):
    clip = gappy()
    factor = {"mm": 1, "cm": 10, "m": 1000}[unit]
    (tmp_path / "m.trc").write_text(samples.trc_text(clip / factor, unit=unit))
    found = read_motion(tmp_path / "m.trc")
    check(found, clip, 1e-9)
    assert (found.fps, found.unit) == (60.0, unit)


@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
@pytest.mark.parametrize("form", ["_x", ".X", ":x", "rows"])
@pytest.mark.parametrize("gap", ["NA", "NaN", ""])
def test_tables_of_every_form(tmp_path, separator, form, gap):
    clip = gappy()
    (tmp_path / "m.csv").write_text(samples.marker_text(clip, separator=separator, form=form, gap=gap))
    found = read_motion(tmp_path / "m.csv")
    check(found, clip)
    assert found.fps == 120


def test_tables_parted_by_blanks_with_decimal_commas_and_of_windows(tmp_path):
    clip = gappy()
    (tmp_path / "a.csv").write_text(samples.marker_text(clip, separator=" "))
    (tmp_path / "b.csv").write_text(samples.marker_text(clip, separator=";", comma=True))
    (tmp_path / "c.csv").write_bytes(samples.marker_text(clip).replace("\n", "\r\n").encode("utf-16"))
    for name in "abc":
        check(read_motion(tmp_path / f"{name}.csv"), clip)
    assert any("decimal commas" in line for line in read_motion(tmp_path / "b.csv").warnings)


def test_a_table_of_many_head_lines_takes_its_labels_from_the_line_that_tells_markers_apart(tmp_path):
    lines = [
        "Format Version,1.23,Take,of today", "", ",Type,Marker,Marker,Marker,Marker,Marker,Marker",
        ",Name,face:a,face:a,face:a,face:b,face:b,face:b", ",ID,1F,1F,1F,2A,2A,2A",
        ",,Position,Position,Position,Position,Position,Position", "Frame,Time (Seconds),X,Y,Z,X,Y,Z",
        "0,0.00,1,2,3,90,5,6", "1,0.01,1,2,3,90,5,6",
    ]  # fmt: skip
    (tmp_path / "m.csv").write_text("\n".join(lines) + "\n")
    found = read_motion(tmp_path / "m.csv", unit="mm", up="y", forward="z")
    assert found.data.labels == ("a", "b")
    assert found.fps == 100
    np.testing.assert_array_equal(found.data.positions[1], [[1, 2, 3], [90, 5, 6]])


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data(), separator=st.sampled_from(",;\t"), form=st.sampled_from(["_x", ".X", "rows"]))
def test_any_numbers_come_back_bit_by_bit(tmp_path, data, separator, form):
    number = st.floats(-1e6, 1e6, allow_nan=False).map(lambda value: value + 0.0)
    shape = (data.draw(st.integers(2, 5)), data.draw(st.integers(1, 4)), 3)
    values = data.draw(st.lists(number, min_size=int(np.prod(shape)), max_size=int(np.prod(shape))))
    clip = np.array(values).reshape(shape)
    labels = tuple(f"p {k}" for k in range(shape[1]))
    (tmp_path / "m.csv").write_text(samples.marker_text(clip, labels, separator=separator, form=form))
    found = read_motion(tmp_path / "m.csv", unit="mm", up="y", forward="z", fps=50)
    np.testing.assert_array_equal(found.data.positions, clip)


def test_without_time_the_rate_is_a_guess_that_is_told(tmp_path):
    (tmp_path / "m.csv").write_text(samples.marker_text(gappy(), fps=None))
    found = read_motion(tmp_path / "m.csv")
    assert found.fps == 30
    assert "fps" in found.guessed
    assert "30 frames a second assumed" in found.assumed
    asked = read_motion(tmp_path / "m.csv", fps=100)
    assert asked.fps == 100
    assert "fps" not in asked.guessed


ROTATIONS = [(up, forward) for up in ("y", "z") for forward in ("x", "-x", "y", "-y", "z", "-z") if forward[-1] != up]


@pytest.mark.parametrize(("up", "forward"), ROTATIONS)
def test_axes_are_found_and_obeyed(tmp_path, up, forward):
    """The sample's clip in any frame is recognised; and what is asked for is done whatever the points look like."""
    from engine.files.motion_axes import axes_rotation

    clip = read_motion(SAMPLE).data.positions[::200]
    turned = clip @ axes_rotation(up, forward)
    labels = read_motion(SAMPLE).data.labels
    (tmp_path / "m.csv").write_text(samples.marker_text(turned, labels))
    for options in ({}, {"up": up, "forward": forward}):
        found = read_motion(tmp_path / "m.csv", **options)
        assert (found.up, found.forward) == (up, forward)
        np.testing.assert_allclose(found.data.positions, clip, atol=1e-9)
        assert ("up" in found.guessed) == (not options)


@pytest.mark.parametrize(("factor", "unit"), [(1, "mm"), (0.1, "cm"), (0.001, "m")])
def test_a_unit_that_nobody_names_makes_a_face_as_large_as_faces_are(tmp_path, factor, unit):
    clip = gappy()
    (tmp_path / "m.csv").write_text(samples.marker_text(clip * factor))
    found = read_motion(tmp_path / "m.csv")
    assert found.unit == unit
    assert "unit" in found.guessed
    assert unit in found.assumed
    np.testing.assert_allclose(found.data.positions, clip, atol=1e-9)


def test_another_unit_than_a_face_fits_is_obeyed_with_a_warning(tmp_path):
    (tmp_path / "m.csv").write_text(samples.marker_text(gappy()))
    found = read_motion(tmp_path / "m.csv", unit="cm")
    assert any("rather mm" in line for line in found.warnings)


def test_real_markers_with_half_of_them_gaps():
    if not CAPTURES.exists():
        pytest.skip("the captures of others are not here")
    found = read_motion(CAPTURES / "markers_16_subject01.csv")
    assert found.data.positions.shape == (1714, 16, 3)
    rows = (CAPTURES / "markers_16_subject01.csv").read_text().splitlines()[1:]
    missing = sum(cell in ("", "NA") for row in rows for cell in row.split(";")[1:49:3])
    assert found.gaps == missing > 10_000
    assert (found.up, found.forward) == ("y", "z")
    assert {"unit", "fps"} <= set(found.guessed)


def test_markers_that_are_never_seen_are_left_out_and_named(tmp_path):
    clip = gappy()
    clip[:, 4] = np.nan
    (tmp_path / "m.trc").write_text(samples.trc_text(clip))
    found = read_motion(tmp_path / "m.trc")
    assert found.unseen == ("nose",)
    assert "nose" not in found.data.labels
    assert any("nose" in line for line in found.warnings)


GOOD = samples.marker_text(samples.performance(4))


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("m.csv", GOOD + "5,0.1,1,2\n", "line 6: has 4 cells"),
        ("m.csv", GOOD + GOOD.splitlines()[-1] + ",9\n", "line 6"),
        ("m.csv", GOOD.replace("chin_x", "nose_x"), "nose_x"),
        ("m.csv", GOOD.replace("3,0.01", "3,0.01x"), "line 4"),
        ("m.csv", samples.marker_text(np.full((3, 9, 3), np.nan)), "none of its markers"),
        ("m.csv", "a,b\n1,2\n", "no columns of markers"),
        ("m.csv", GOOD.splitlines()[0] + "\n", "no rows"),
        ("m.trc", samples.trc_text(samples.performance(3)).replace("60\t60\t3", "0\t0\t3"), "frame rate of 0"),
        ("m.trc", samples.trc_text(samples.performance(3), ["a"] * 9), "'a'|a twice|the marker a"),
        ("m.trc", samples.trc_text(samples.performance(3)).replace("\t3\t9\t", "\t3\t8\t"), "announces 8"),
        ("m.trc", samples.trc_text(samples.performance(3)) + "4\t0\t1\n", "line 10"),
    ],
)
def test_bad_tables_name_what_is_wrong_and_where(tmp_path, name, text, words):
    import re

    (tmp_path / name).write_text(text)
    message = refused(read_motion, tmp_path / name)
    assert name in message
    assert re.search(words, message), message


def test_frame_rate_0_can_be_overruled(tmp_path):
    (tmp_path / "m.c3d").write_bytes(samples.c3d_bytes(samples.performance(3), fps=0))
    assert "frame rate of 0" in refused(read_motion, tmp_path / "m.c3d")
    assert read_motion(tmp_path / "m.c3d", fps=90).fps == 90
    with pytest.raises(InputError, match="frame rate"):
        read_motion(tmp_path / "m.c3d", fps=0)
