"""Weight curves: Live Link Face, our own tables, and animated GLBs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as some_arrays
from scipy.interpolate import CubicHermiteSpline

from engine.files.motion import read_motion
from engine.files.weights_csv import read_weights, write_weights
from engine.motion import WeightCurves
from tests.engine.files import motion_samples as samples
from tests.engine.files.refusals import refused

LIVE_LINK = Path("../shared/data/captures/live_link_face_rom.csv")


@pytest.mark.parametrize(("fps", "base"), [(30, 60), (30, 30), (60, 60), (24, 24), (25, 25), (10, 60)])
def test_live_link_rate_comes_from_the_time_code(tmp_path, fps, base):
    (tmp_path / "m.csv").write_text(samples.live_link_text(90, fps=fps, base=base))
    found = read_motion(tmp_path / "m.csv")
    assert found.fps == fps
    assert found.dropped == 0
    assert found.data.names == ("EyeBlinkLeft", "JawOpen", "HeadYaw")
    np.testing.assert_allclose(found.data.weights[:, 1], np.arange(90) / 50, atol=1e-10)


def test_live_link_frames_that_are_skipped_are_counted_and_not_invented(tmp_path):
    (tmp_path / "m.csv").write_text(samples.live_link_text(90, skipped=(10, 40, 41)))
    found = read_motion(tmp_path / "m.csv")
    assert found.dropped == 3
    assert len(found.data) == 87
    assert any("skips 3" in line for line in found.warnings)


def test_live_link_over_midnight(tmp_path):
    lines = ["Timecode,BlendShapeCount,A"]
    lines += [f"23:59:59:{k:02d}.0,1,0" for k in range(0, 60, 2)] + [f"00:00:00:{k:02d}.0,1,0" for k in range(0, 60, 2)]
    (tmp_path / "m.csv").write_text("\n".join(lines))
    found = read_motion(tmp_path / "m.csv")
    assert (found.fps, found.dropped) == (30, 0)


def test_a_real_performance_of_a_phone():
    if not LIVE_LINK.exists():
        pytest.skip("the captures of others are not here")
    found = read_motion(LIVE_LINK)
    rows = LIVE_LINK.read_text().splitlines()
    assert found.fps == 30
    assert found.data.weights.shape == (4030, 61)
    np.testing.assert_array_equal(found.data.weights[-1], np.array(rows[4030].split(",")[2:], dtype=float))
    # From 13:13:04 and 31.652 frames of a 60th to 13:15:18 and 54.561: what is there and what was dropped fill it.
    assert (4029 + found.dropped) / 30 == pytest.approx(134 + (54.561 - 31.652) / 60, abs=0.05)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Timecode,BlendShapeCount,A\n00:00:01:01.0,1\n", "line 2: has 2 cells"),
        ("Timecode,BlendShapeCount,A\n00:00:01,1,0\n", "line 2: '00:00:01' is no time code"),
        ("Timecode,BlendShapeCount,A,A\n00:00:01:01.0,1,0,0\n", "names the shape A twice"),
        ("Timecode,BlendShapeCount,A\n00:00:01:01.0,1,0\n00:00:01:03.0,1,x\n", "line 3: 'x' is not a number"),
        ("Timecode,BlendShapeCount,A\n00:00:01:01.0,1,\n", "no row with all numbers"),
        ("frame,time_s,a\n1,0,0\n2,0.04,\n", "line 3: lacks a number"),
        ("frame,time_s,a\n1,0,0\n2,0.04,1,1\n", "line 3: has 4 cells"),
    ],
)
def test_bad_tables_of_weights_name_the_line(tmp_path, text, words):
    (tmp_path / "m.csv").write_text(text)
    assert words in refused(read_motion, tmp_path / "m.csv")


def test_times_that_leap_or_turn_are_counted_and_those_that_stand_still_say_nothing(tmp_path):
    times = [0, 0.01, 0.02, 0.5, 0.51, 0.40, 0.41, 0.42]
    (tmp_path / "m.csv").write_text("frame,time_s,a\n" + "".join(f"{k},{t},0\n" for k, t in enumerate(times)))
    found = read_motion(tmp_path / "m.csv")
    assert (found.fps, found.guessed) == (100, ())
    assert any("1 gap:" in line for line in found.warnings) and any("back 1 time:" in line for line in found.warnings)
    assert not read_motion(tmp_path / "m.csv", fps=30).warnings
    (tmp_path / "m.csv").write_text("frame,time_s,a\n1,0,0\n2,0,1\n")
    assert read_motion(tmp_path / "m.csv").guessed == ("fps",)


def test_live_link_within_one_second_has_no_rate(tmp_path):
    (tmp_path / "m.csv").write_text(
        "Timecode,BlendShapeCount,A\n" + "\n".join(f"10:00:00:{k:02d}.0,1,0" for k in range(20))
    )
    found = read_motion(tmp_path / "m.csv")
    assert (found.fps, found.guessed) == (30, ("fps",)) and "too short to tell" in found.assumed


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    weights=some_arrays.arrays(
        np.float64, st.tuples(st.integers(2, 6), st.integers(1, 4)), elements=st.floats(-1e9, 1e9, allow_subnormal=True)
    ),
    fps=st.sampled_from([24.0, 25.0, 30.0, 60.0, 119.5, 120.0]),
)
def test_weights_written_and_read_are_the_same_bit_by_bit(tmp_path, weights, fps):
    curves = WeightCurves(tuple(f"shape, {k}" for k in range(weights.shape[1])), weights, fps)
    write_weights(tmp_path / "w.csv", curves)
    for found in (read_weights(tmp_path / "w.csv").data, read_motion(tmp_path / "w.csv").data):
        np.testing.assert_array_equal(found.weights, curves.weights)
        assert (found.names, found.fps) == (curves.names, curves.fps)


def animated(tmp_path, *given, **options):
    (tmp_path / "m.glb").write_bytes(samples.animated_glb(*given, **options))
    return tmp_path / "m.glb"


def test_linear_keys_are_interpolated_at_the_rate_that_is_asked_for(tmp_path):
    keys, values = np.array([0.0, 0.5, 1.0]), np.array([[0, 1], [1, 0], [0.5, -1]])
    found = read_motion(animated(tmp_path, keys, values, ("a", "b")), fps=20)
    times = np.arange(21) / 20
    assert found.data.names == ("a", "b")
    for k in range(2):
        np.testing.assert_allclose(found.data.weights[:, k], np.interp(times, keys, values[:, k]), atol=1e-6)


def test_stepped_keys_hold_until_the_next_and_rounding_does_not_delay_them(tmp_path):
    keys, values = np.arange(13) / 24, np.arange(13.0)[:, None]
    found = read_motion(animated(tmp_path, keys, values, ("a",), form="STEP"))
    assert found.fps == 24
    np.testing.assert_array_equal(found.data.weights[:, 0], np.arange(13))
    twice = read_motion(tmp_path / "m.glb", fps=48)
    np.testing.assert_array_equal(twice.data.weights[:, 0], np.arange(25) // 2)


def test_cubic_keys_are_hermite_splines(tmp_path):
    rng = np.random.default_rng(3)
    keys = np.array([0.0, 0.25, 1.0, 1.5])
    values, arriving, leaving = rng.normal(size=(3, 4, 2))
    table = np.stack([arriving, values, leaving], axis=1)
    found = read_motion(animated(tmp_path, keys, table, ("a", "b"), form="CUBICSPLINE"), fps=40)
    times = np.clip(np.arange(61) / 40, None, 1.5)
    for left in range(3):
        inside = (times >= keys[left]) & (times <= keys[left + 1])
        pair = slice(left, left + 2)
        reference = CubicHermiteSpline(keys[pair], values[pair], np.stack([leaving[left], arriving[left + 1]]))
        np.testing.assert_allclose(found.data.weights[inside], reference(times[inside]), atol=1e-5)


def test_shapes_without_names_are_called_as_rigs_call_them(tmp_path):
    found = read_motion(animated(tmp_path, np.arange(3) / 30, np.zeros((3, 2)), None, targets=2))
    assert found.data.names == ("shape 1", "shape 2")
    assert found.fps == 30


def test_the_rig_inside_is_the_driver(tmp_path):
    from engine.files.rig import read_rig
    from engine.motion import driven_by

    keys = np.arange(3) / 30
    path = animated(tmp_path, keys, np.array([[0, 0], [1, 0], [0, 0.5]]), ("a", "b"))
    motion, unused, resting = driven_by(read_rig(path, unit="m").rig.basis, read_motion(path).data)
    assert unused == resting == ()
    # Each target moves vertex 1 by 0.2 m x 0.01 k along x.
    np.testing.assert_allclose(motion.displacements(0, 3)[:, 1, 0], [0, 2, 2], atol=1e-4)


def test_a_glb_without_animation_says_what_is_missing(tmp_path):
    data = samples.animated_glb(np.arange(2), np.zeros(2), ("a",)).replace(b'"weights"', b'"rotated"')
    (tmp_path / "m.glb").write_bytes(data)
    assert "no animation of weights" in refused(read_motion, tmp_path / "m.glb")


@pytest.mark.parametrize("fps", [24, 23.976, 119.5, 59.5, 33.3333, 2, 5000])
def test_an_animation_of_our_own_comes_back_frame_by_frame(tmp_path, fps):
    from engine.files.glb_rig_out import write_glb_rig
    from engine.mesh import TriangleMesh
    from engine.shapes import ExpressionBasis, Rig

    rng = np.random.default_rng(1)
    mesh = TriangleMesh(rng.normal(size=(4, 3)) * 50, np.array([[0, 1, 2], [0, 2, 3]]))
    basis = ExpressionBasis(mesh.vertices, ("a", "mean"), rng.normal(size=(2, 4, 3)), mean=rng.normal(size=(4, 3)))
    weights = rng.normal(size=(300, 2))
    write_glb_rig(tmp_path / "m.glb", Rig(mesh, basis), curves=WeightCurves(basis.names, weights, fps))
    found = read_motion(tmp_path / "m.glb")
    assert (found.fps, found.data.names, found.guessed) == (fps, ("a", "mean"), ())
    np.testing.assert_array_equal(found.data.weights, weights.astype(np.float32))


@pytest.mark.parametrize(("fps", "read"), [(119.5, 119.5), (24.01, 24), (33.3333, 33.3333), (2, 2)])
def test_even_keys_of_others_are_the_frames(tmp_path, fps, read):
    weights = np.random.default_rng(2).normal(size=(200, 2)).astype(np.float32)
    found = read_motion(animated(tmp_path, np.arange(200) / fps, weights, ("a", "b")))
    assert found.fps == pytest.approx(read, rel=1e-6)
    np.testing.assert_array_equal(found.data.weights, weights)
    assert ("measured" in found.assumed) == (fps == 24.01)
