"""Dense motion: PC2 and npz, mapped rather than read, and pairs files."""

from __future__ import annotations

import json
import tracemalloc

import numpy as np
import pytest

from engine.basis.markers import MarkerPair
from engine.errors import InputError
from engine.files.marker_pairs import read_marker_pairs
from engine.files.motion import read_motion
from tests.engine.files import motion_samples as samples
from tests.engine.files.refusals import refused

VERTICES = samples.performance(12).astype(np.float32)


@pytest.fixture(params=["pc2", "npz", "npz packed"])
def clip_file(request, tmp_path):
    if request.param == "pc2":
        data = samples.pc2_bytes(VERTICES)
    else:
        data = samples.npz_bytes("packed" in request.param, vertices=VERTICES, fps=np.float64(30))
    path = tmp_path / f"m.{request.param[:3]}"
    path.write_bytes(data)
    return path


def test_positions_come_back_bit_by_bit(clip_file):
    found = read_motion(clip_file, fps=30)
    np.testing.assert_array_equal(found.data.read(0, 12), VERTICES)
    np.testing.assert_array_equal(found.data.read(5, 7), VERTICES[5:7])
    motion = found.data.motion(VERTICES[0].astype(np.float64))
    np.testing.assert_allclose(motion.displacements(3, 4)[0], VERTICES[3] - VERTICES[0].astype(np.float64))


def test_unit_and_axes_are_obeyed_and_told(clip_file):
    found = read_motion(clip_file, unit="cm", up="z", forward="-y")
    x, y, z = VERTICES.astype(np.float64).transpose(2, 0, 1) * 10
    np.testing.assert_allclose(found.data.read(0, 12), np.stack([x, z, -y], axis=-1), atol=1e-9)
    neutral = found.data.read(0, 1)[0]
    np.testing.assert_allclose(found.data.motion(neutral).frame(4), found.data.read(4, 5)[0], atol=1e-9)
    assert "cm, as asked" in found.assumed
    assert "z up and -y forward, as asked" in found.assumed


def test_another_number_of_vertices_than_the_rig_is_refused_with_both_counts(clip_file):
    with pytest.raises(InputError, match=r"9 vertices, the rig 10"):
        read_motion(clip_file).data.motion(np.zeros((10, 3)))


@pytest.mark.parametrize("kind", ["pc2", "npz"])
def test_a_large_clip_is_not_read_into_memory(tmp_path, kind):
    vertices = np.tile(VERTICES, (100, 300, 1))
    data = samples.pc2_bytes(vertices) if kind == "pc2" else samples.npz_bytes(vertices=vertices, fps=30)
    (tmp_path / f"m.{kind}").write_bytes(data)
    tracemalloc.start()
    found = read_motion(tmp_path / f"m.{kind}")
    frame = found.data.read(1100, 1101)[0]
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    np.testing.assert_array_equal(frame, vertices[1100])
    assert isinstance(found.data.vertices, np.memmap)
    assert peak < 0.75 * vertices.nbytes


def test_a_frame_that_is_not_finite_is_named(tmp_path):
    bad = VERTICES.copy()
    bad[7, 2, 1] = np.nan
    (tmp_path / "m.pc2").write_bytes(samples.pc2_bytes(bad))
    (tmp_path / "m.npz").write_bytes(samples.npz_bytes(vertices=bad, fps=30))
    for name in ("m.pc2", "m.npz"):
        assert "frame 8" in refused(read_motion, tmp_path / name)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"fps": 30}, "vertices: is missing"),
        ({"vertices": VERTICES[0], "fps": 30}, "has shape (9, 3)"),
        ({"vertices": VERTICES, "fps": 0}, "frame rate of 0"),
        ({"vertices": VERTICES, "fps": np.nan}, "frame rate of nan"),
        ({"vertices": np.array([{}], dtype=object), "fps": 30}, "pickled"),
        ({"vertices": VERTICES[:, :, :2], "fps": 30}, "has shape (12, 9, 2)"),
    ],
)
def test_bad_archives_say_which_array(tmp_path, arrays, words):
    (tmp_path / "m.npz").write_bytes(samples.npz_bytes(**arrays))
    assert words in refused(read_motion, tmp_path / "m.npz")


@pytest.mark.parametrize("kept", [11, 31, 200, -4])
def test_a_cache_that_is_cut_off_is_refused(tmp_path, kept):
    (tmp_path / "m.pc2").write_bytes(samples.pc2_bytes(VERTICES)[:kept])
    refused(read_motion, tmp_path / "m.pc2")


def test_pairs_are_read(tmp_path):
    (tmp_path / "p.json").write_text(samples.PAIRS)
    assert read_marker_pairs(tmp_path / "p.json") == (MarkerPair("nose", 3), MarkerPair("chin", (1.0, 2.0, 3.0)))


@pytest.mark.parametrize(
    ("pairs", "words"),
    [
        ([], "pairs"),
        ([{"source": "a"}], "pairs.0.target"),
        ([{"source": "a", "target": -1}], "pairs.0.target"),
        ([{"source": "a", "target": [1, 2]}], "pairs.0.target"),
        ([{"source": 3, "target": 1}], "pairs.0.source"),
        ([{"source": "a", "target": 1}, {"source": "a", "target": 2}], "pairs a twice"),
    ],
)
def test_bad_pairs_name_the_field(tmp_path, pairs, words):
    (tmp_path / "p.json").write_text(json.dumps({"pairs": pairs}))
    assert words in refused(read_marker_pairs, tmp_path / "p.json")
