"""``quasiface basis ...`` as scripts see it: files in, files and figures out, against a float64 reference."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from engine.files.rig import read_rig
from engine.files.rig_out import write_rig
from engine.motion import MarkerClip
from studio import cli
from studio.basis.job import as_command
from studio.basis.motions import prepare
from studio.basis.options import BasisOptions, MotionOptions
from studio.basis.results import _motion_text, _options_text
from studio.project.basis_items import MotionItem

Array = NDArray[np.float64]
BOUNDS = {"0..1": (0.0, 1.0), "-1..2": (-1.0, 2.0), "free": (-np.inf, np.inf)}
ROWS, COLUMNS, FRAMES, UNITS, SHAPES = 9, 7, 40, 4, 6


def call(capfd: pytest.CaptureFixture[str], *arguments: str | Path) -> tuple[int, str, str]:
    """Run a command here, with all that any library writes to stdout and stderr."""
    code = cli.main([str(argument) for argument in arguments])
    return code, *capfd.readouterr()


def answer(capfd: pytest.CaptureFixture[str], *arguments: str | Path) -> dict[str, Any]:
    """Run a command that must succeed and return the one JSON object it prints."""
    code, out, err = call(capfd, *arguments, "--json")
    assert code == 0, err
    values: dict[str, Any] = json.loads(out)
    return values


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def face() -> dict[str, Array]:
    """A bent sheet of 63 vertices, mm, as large as a face; the units that move it, and shapes sculpted after them."""
    rng = np.random.default_rng(3)
    x, y = np.meshgrid(np.linspace(-70, 70, COLUMNS), np.linspace(-100, 100, ROWS))
    neutral = np.stack([x, y, 40 * np.cos(x / 60)], axis=2).reshape(-1, 3)
    at = np.arange(ROWS * COLUMNS).reshape(ROWS, COLUMNS)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    units = rng.normal(size=(UNITS, len(neutral), 3)) * 4
    weights = rng.uniform(0, 1, (FRAMES, UNITS))
    hand = rng.uniform(0, 1, (SHAPES, UNITS)) @ units.reshape(UNITS, -1)
    hand = hand.reshape(SHAPES, -1, 3) + rng.normal(size=(SHAPES, len(neutral), 3))
    moved = neutral + (weights @ units.reshape(UNITS, -1)).reshape(FRAMES, -1, 3)
    return {"neutral": neutral, "faces": faces, "units": units, "weights": weights, "hand": hand, "moved": moved}


@pytest.fixture
def files(face: dict[str, Array], tmp_path: Path) -> Path:
    rig = {"neutral": face["neutral"], "faces": face["faces"]}
    names = np.array([f"shape{k}" for k in range(SHAPES)])
    np.savez(tmp_path / "hand.npz", **rig, names=names, displacements=face["hand"])
    units = np.array([f"unit{k}" for k in range(UNITS)])
    np.savez(tmp_path / "units.npz", **rig, names=units, displacements=face["units"])
    np.savez(tmp_path / "clip.npz", vertices=face["moved"], fps=np.array(60.0))
    rows = [",".join(["frame", "time_s", *units])]
    rows += [",".join([str(k), f"{k / 60:.9f}", *map(repr, row.tolist())]) for k, row in enumerate(face["weights"])]
    (tmp_path / "curves.csv").write_text("\n".join(rows) + "\n")
    return tmp_path


def reference(shapes: Array, mean: Array, moved: Array, bounds: tuple[float, float]) -> Array:
    """Return the weights (L, n) of bounded least squares, frame by frame."""
    matrix, targets = shapes.reshape(len(shapes), -1).T, (moved - mean).reshape(len(moved), -1)
    if np.isinf(bounds[0]):
        return np.linalg.lstsq(matrix, targets.T, rcond=None)[0].T
    return np.array([lsq_linear(matrix, target, bounds, method="bvls", tol=1e-14).x for target in targets])


def alphas(neutral: Array, moved: Array, built: Array) -> tuple[float, float]:
    """Return alpha as the mean over frames and pooled, % (Kim & Ko 2007, eq. 6; origin: the neutral's centroid)."""
    error = np.linalg.norm((built - moved).reshape(len(moved), -1), axis=1)
    size = np.linalg.norm((moved + neutral - neutral.mean(axis=0)).reshape(len(moved), -1), axis=1)
    return float(100 * np.mean(error / size)), float(100 * np.linalg.norm(error) / np.linalg.norm(size))


def quasi_eigen(face: dict[str, Array], count: int) -> tuple[Array, Array, Array]:
    """Return mean, axes and the projected shapes, each by the plainest means."""
    moves = (face["moved"] - face["neutral"]).reshape(FRAMES, -1)
    mean = moves.mean(axis=0)
    axes = np.linalg.svd(moves - mean, full_matrices=False)[2][:count]
    axes *= np.sign([axis[np.argmax(np.abs(axis))] for axis in axes])[:, None]
    made = mean + ((face["hand"].reshape(SHAPES, -1) - mean) @ axes.T) @ axes
    return mean.reshape(-1, 3), axes, made.reshape(SHAPES, -1, 3)


def test_project_prints_the_figures_of_a_plain_float64_computation(
    face: dict[str, Array], files: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    found = answer(capfd, "basis", "project", "--hand", files / "hand.npz", "--motion", files / "clip.npz",
                   "--count", "3", "--out", files / "qe.npz")  # fmt: skip
    mean, axes, made = quasi_eigen(face, 3)
    moved = face["moved"] - face["neutral"]
    variance = np.linalg.svd((moved - mean).reshape(FRAMES, -1), compute_uv=False) ** 2
    assert found["axes"] == 3 and found["coverage"] == pytest.approx(variance[:3].sum() / variance.sum(), abs=1e-9)
    with np.load(files / "qe.npz") as stored:
        np.testing.assert_allclose(stored["displacements"], made, atol=1e-9)
        np.testing.assert_allclose(stored["neutral"], face["neutral"], atol=1e-12)
        assert [str(name) for name in stored["names"]] == [f"shape{k}" for k in range(SHAPES)]
    for row, hand, quasi in zip(found["shapes"], face["hand"], made, strict=True):
        assert row["cosine"] == pytest.approx(np.vdot(hand, quasi) / np.linalg.norm(hand) / np.linalg.norm(quasi))
        assert row["residual_fraction"] == pytest.approx(np.linalg.norm(hand - quasi) / np.linalg.norm(hand))
        assert row["residual_mm"] == pytest.approx(np.sqrt(np.mean(np.sum((hand - quasi) ** 2, axis=1))))
    still = np.zeros_like(mean)
    deviations = np.sqrt(variance[:3] / FRAMES)
    bases = {
        "hand": (face["hand"], still),
        "quasi_eigen": (made, still),
        "pca": ((axes * deviations[:, None]).reshape(3, -1, 3), mean),
    }
    for basis, (shapes, about) in bases.items():
        for key, bounds in BOUNDS.items():
            weights = reference(shapes, about, moved, bounds)
            built = about + (weights @ shapes.reshape(len(shapes), -1)).reshape(moved.shape)
            wanted = alphas(face["neutral"], moved, built)
            alpha = found["alpha"][basis][key]
            assert (alpha["mean"], alpha["pooled"]) == pytest.approx(wanted, rel=1e-6), (basis, key)
            rms = np.sqrt(np.mean(np.sum((built - moved) ** 2, axis=2)))
            assert found["rms_mm"][basis][key] == pytest.approx(rms, rel=1e-6)
    pooled = 100 * np.sqrt(
        (1 - found["coverage"]) * variance.sum() / np.sum((face["moved"] - face["neutral"].mean(0)) ** 2)
    )
    assert found["alpha"]["pca"]["free"]["pooled"] == pytest.approx(pooled, rel=1e-6)
    assert found["measured_on"] == "all vertices" and found["frames"] == FRAMES and found["seconds"] > 0


def test_an_affine_basis_of_full_rank_reproduces_as_well_as_the_axes(
    files: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    base = ("basis", "project", "--hand", files / "hand.npz", "--motion", files / "clip.npz", "--count", "3")
    affine = answer(capfd, *base, "--affine", "--out", files / "affine.npz")
    assert affine["rank"] == 3
    own, best = (affine["alpha"][basis]["free"]["pooled"] for basis in ("quasi_eigen", "pca"))
    assert own == pytest.approx(best, rel=1e-6) and best > 0.01
    with np.load(files / "affine.npz") as stored:
        assert stored["mean"].shape == stored["neutral"].shape and np.abs(stored["mean"]).max() > 1


def test_curves_drive_a_rig_and_give_what_its_mesh_gives(files: Path, capfd: pytest.CaptureFixture[str]) -> None:
    base = (
        "basis",
        "project",
        "--hand",
        files / "hand.npz",
        "--coverage",
        "0.9",
        "--train",
        "1:30",
        "--out",
        files / "o.npz",
    )
    mesh = answer(capfd, *base, "--motion", files / "clip.npz")
    driven = answer(capfd, *base, "--motion", files / "curves.csv", "--rig", files / "units.npz")
    assert mesh["trained_on"] == driven["trained_on"] == [1, 30] and mesh["axes"] == driven["axes"]
    for basis in mesh["alpha"]:
        for key in BOUNDS:
            assert mesh["alpha"][basis][key] == pytest.approx(driven["alpha"][basis][key], rel=1e-5, abs=1e-9)


def test_solve_gives_back_the_weights_that_moved_the_rig(
    face: dict[str, Array], files: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    found = answer(capfd, "basis", "solve", "--basis", files / "units.npz", "--motion", files / "clip.npz",
                   "--bounds", "0", "1", "--out", files / "w.csv")  # fmt: skip
    lines = (files / "w.csv").read_text().splitlines()
    assert lines[0].split(",") == ["frame", "time_s", *(f"unit{k}" for k in range(UNITS))]
    solved = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    np.testing.assert_allclose(solved[:, 2:], face["weights"], atol=1e-6)
    np.testing.assert_allclose(solved[:, 1], np.arange(FRAMES) / 60, atol=1e-6)
    assert found["alpha"]["pooled"] < 1e-6 and found["bounds"] == [0.0, 1.0]
    tight = answer(capfd, "basis", "solve", "--basis", files / "units.npz", "--motion", files / "clip.npz",
                   "--bounds", "0", "0.5", "--out", files / "w.csv")  # fmt: skip
    assert tight["weights_max"] <= 0.5 and tight["alpha"]["pooled"] > 0.1


def test_pca_writes_orthonormal_axes_about_the_mean(
    face: dict[str, Array], files: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    found = answer(capfd, "basis", "pca", "--motion", files / "clip.npz", "--rig", files / "hand.npz",
                   "--coverage", "1.0", "--out", files / "axes.npz")  # fmt: skip
    with np.load(files / "axes.npz") as stored:
        axes = stored["displacements"].reshape(found["axes"], -1)
        moves = (face["moved"] - face["neutral"] - stored["mean"]).reshape(FRAMES, -1)
    np.testing.assert_allclose(axes @ axes.T, np.eye(len(axes)), atol=1e-9)
    np.testing.assert_allclose(moves @ axes.T @ axes, moves, atol=1e-8)
    np.testing.assert_allclose(np.mean((moves @ axes.T) ** 2, axis=0), found["eigenvalues_mm2"], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ("project --hand hand.npz --motion other.npz --out q.npz", ("63", "12")),
        ("project --hand hand.npz --motion curves.csv --out q.npz", ("curves",)),
        ("project --hand hand.npz --motion clip.npz --train 30:90 --out q.npz", ("40",)),
        ("project --hand hand.npz --motion clip.npz --train 9 --out q.npz", ("--train",)),
        ("project --hand hand.npz --motion clip.npz --count 60 --out q.npz", ("axes",)),
        ("project --hand hand.npz --motion clip.npz --coverage 1.5 --out q.npz", ("--coverage",)),
        ("project --hand hand.npz --motion clip.npz --out hand.npz", ("hand.npz", "input")),
        ("project --hand hand.npz --motion clip.npz --out q.stl", ("q.stl",)),
        ("project --hand hand.npz --motion clip.npz --train 1:1 --out q.npz", ("two frames",)),
        ("project --hand hand.npz --motion clip.npz --unit furlong --out q.npz", ("--unit", "furlong")),
        ("project --hand missing.npz --motion clip.npz --out q.npz --report r.txt", ("r.txt", ".pdf")),
        ("project --hand missing.npz --motion clip.npz --out no/q.npz", ("no/q.npz", "folder")),
        ("project --hand sculpted --motion clip.npz --out sculpted", ("sculpted", "input")),
        ("project --hand sculpted/neutral.obj --motion clip.npz --out sculpted", ("sculpted", "input")),
        ("pca --motion clip.npz --rig sculpted --out .", (".", "input")),
        ("pca --motion clip.npz --rig hand.npz --out others", ("others", "no basis of ours")),
        ("solve --basis missing.npz --motion clip.npz --out w.txt", ("w.txt", ".csv")),
        ("project --hand hand.npz --motion far.npz --out q.npz", ("far.npz", "--unit")),
        ("project --hand hand.npz --motion curves.csv --rig large.npz --out q.npz", ("--rig", "one unit")),
        ("solve --basis hand.npz --motion clip.npz --bounds 1 0 --out w.csv", ("--bounds",)),
        ("solve --basis hand.npz --motion clip.npz --bounds 0 1 --free --out w.csv", ("--free",)),
        ("pca --motion clip.npz --out q.npz", ("--rig",)),
        ("project --hand clip.npz --motion clip.npz --out q.npz", ("clip.npz",)),
        ("project --hand missing.glb --motion clip.npz --out q.npz", ("missing.glb", "no such file")),
    ],
)
def test_wrong_input_is_told_in_one_line_and_nothing_is_written(
    files: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: str,
    told: tuple[str, ...],
    face: dict[str, Array],
) -> None:
    sculpted = read_rig(files / "hand.npz").rig
    write_rig(files / "sculpted", sculpted)
    (files / "sculpted" / "shapes.json").unlink()
    (files / "others").mkdir()
    (files / "others" / "a.obj").write_text("v 0 0 0")
    np.savez(files / "far.npz", vertices=face["moved"] + [0, 900, 0], fps=np.array(30.0))
    with np.load(files / "units.npz") as units:
        np.savez(files / "large.npz", **{**units, "neutral": 1.4 * units["neutral"]})
    np.savez(files / "other.npz", vertices=np.random.default_rng(1).normal(size=(5, 12, 3)) * 50, fps=np.array(30.0))
    monkeypatch.chdir(files)
    before = contents(files)
    code, out, err = call(capfd, "basis", *arguments.split(), "--json")
    assert code == 2 and out == "" and len(err.splitlines()) == 1, err
    for word in told:
        assert word in err, err
    assert contents(files) == before


def test_a_folder_of_an_earlier_run_is_written_again(files: Path, capfd: pytest.CaptureFixture[str]) -> None:
    base = ("basis", "pca", "--motion", files / "clip.npz", "--rig", files / "hand.npz", "--out", files / "axes")
    assert answer(capfd, *base, "--count", "3")["files"] == answer(capfd, *base, "--count", "3")["files"]


def markers(path: Path, face: dict[str, Array], size: float = 1.0, hidden: int = 0) -> Path:
    """Write every third vertex as a marker, the first ``hidden`` frames without any, and beside it where they lie."""
    positions = np.array(face["moved"][:, ::3]) * size
    positions[:hidden] = np.nan
    labels = [f"m{k}" for k in range(positions.shape[1])]
    rows = [",".join(["frame", "time_s", *(f"{label}_{axis}" for label in labels for axis in "xyz")])]
    for k, frame in enumerate(positions.reshape(len(positions), -1).tolist()):
        rows.append(",".join([str(k), repr(k / 60), *("" if np.isnan(x) else repr(x) for x in frame)]))
    path.write_text("\n".join(rows) + "\n")
    pairs = [{"source": label, "target": 3 * k} for k, label in enumerate(labels)]
    path.with_name("pairs.json").write_text(json.dumps({"pairs": pairs}))
    return path


def test_scale_brings_a_larger_performer_to_the_size_of_the_face(
    face: dict[str, Array], files: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    base = ("basis", "pca", "--rig", files / "hand.npz", "--pairs", files / "pairs.json", "--out", files / "a.npz")
    base = (*base, "--motion")
    own = answer(capfd, *base, markers(files / "own.csv", face), "--scale")
    large = markers(files / "large.csv", face, 1.1)
    fitted, left = answer(capfd, *base, large, "--scale"), answer(capfd, *base, large)
    assert fitted["total_variance_mm2"] == pytest.approx(own["total_variance_mm2"], rel=1e-9)
    assert left["total_variance_mm2"] > 1.1 * own["total_variance_mm2"]


def test_the_size_counts_among_the_inputs_and_the_memory_does_not() -> None:
    item = MotionItem("m", "take", "markers", "key")
    assert _motion_text(item) != _motion_text(replace(item, options=MotionOptions(scale=True)))
    assert _options_text(BasisOptions(memory_mb=64)) == _options_text(BasisOptions())


def test_markers_on_the_head_are_not_bound_where_its_motion_stays(face: dict[str, Array], files: Path) -> None:
    rig = read_rig(files / "hand.npz").rig
    above = np.array([[-60.0, 150, -60], [60, 150, -60], [0, 180, -90], [0, 160, 20]])
    head = np.broadcast_to(above, (FRAMES, 4, 3))
    labels = (*(f"m{k}" for k in range(21)), "head_a", "head_b", "head_c", "head_d")
    shift = np.linspace(0, 40, FRAMES)[:, None, None]
    clip = MarkerClip(labels, np.concatenate([face["moved"][:, ::3], head], axis=1) + shift, 60.0)
    pairs: dict[str, int | tuple[float, float, float]] = {f"m{k}": 3 * k for k in range(21)}
    prepared = prepare(clip, rig, MotionOptions(head=(), pairs=pairs))
    assert prepared.bound is not None and prepared.bound.binding.labels == labels[:21]
    assert any("4 head markers left out" in note for note in prepared.notes)
    assert any("whole face moves" in note for note in prepared.notes)


def test_a_performer_in_no_known_unit_is_refused_unless_the_size_is_fitted(
    face: dict[str, Array], files: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    odd = markers(files / "odd.csv", face, 1 / 40)
    base = ("basis", "pca", "--rig", files / "hand.npz", "--motion", odd, "--out", files / "a.npz")
    base = (*base, "--pairs", files / "pairs.json")
    code, _, err = call(capfd, *base)
    assert code == 2 and "--unit" in err and "--scale" in err and not (files / "a.npz").exists()
    stated = answer(capfd, *base, "--unit", "40 mm")
    fitted = answer(capfd, *base, "--scale")
    assert (stated["unit"], stated["rig_unit"]) == ("40 mm", "mm") and "as asked" in stated["assumed"]
    assert fitted["total_variance_mm2"] == pytest.approx(stated["total_variance_mm2"], rel=0.1)


def test_frames_that_show_no_marker_are_counted_and_keep_their_numbers(
    face: dict[str, Array], files: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    clip = markers(files / "late.csv", face, hidden=10)
    solved = answer(capfd, "basis", "solve", "--basis", files / "units.npz", "--motion", clip, "--out", files / "w.csv")
    rows = [line.split(",") for line in (files / "w.csv").read_text().splitlines()[1:]]
    assert solved["left_out_frames"] == 10 and solved["frames"] == FRAMES - 10
    assert [int(row[0]) for row in rows] == list(range(11, FRAMES + 1)) and float(rows[0][1]) == pytest.approx(10 / 60)
    base = ("basis", "pca", "--rig", files / "hand.npz", "--motion", clip, "--count", "2", "--out", files / "a.npz")
    assert answer(capfd, *base, "--train", "5:20")["trained_on"] == [11, 20]
    assert answer(capfd, *base)["trained_on"] == [11, FRAMES]
    assert call(capfd, *base, "--train", "1:11")[0] == call(capfd, *base, "--train", "20:60")[0] == 2


def test_a_mesh_clip_of_another_neutral_face_moves_as_on_its_own(
    face: dict[str, Array], files: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    other = face["neutral"] + 3 * np.sin(face["neutral"] / 30)
    with np.load(files / "units.npz") as units:
        np.savez(files / "driver.npz", **{**units, "neutral": other})
    np.savez(files / "apart.npz", vertices=face["moved"] - face["neutral"] + other, fps=np.array(60.0))
    base = ("basis", "project", "--hand", files / "hand.npz", "--count", "3", "--out", files / "o.npz", "--motion")
    own = answer(capfd, *base, files / "clip.npz")
    driven = answer(capfd, *base, files / "apart.npz", "--rig", files / "driver.npz")
    for basis in own["alpha"]:
        for key in BOUNDS:
            assert driven["alpha"][basis][key] == pytest.approx(own["alpha"][basis][key], rel=1e-6)
    assert any("nearest to the neutral" in note for note in answer(capfd, *base, files / "apart.npz")["notes"])


def test_the_copied_command_reads_and_computes_the_same() -> None:
    options = BasisOptions(coverage=0.9912345678901234, train=(4, 30), affine=True, ridge=1 / 3, memory_mb=64)
    reading = MotionOptions(unit="85.3 mm", up="z", forward="-y", fps=119.88, rest_frame=2, scale=True, head=("a", "b"))
    line = as_command("my hand.npz", "clip.csv", options, reading, "q.glb", "rig.npz", None)
    called, bound, _ = cli.app.parse_args(shlex.split(line)[1:], exit_on_error=False, print_error=False)
    assert called.__name__ == "project" and bound.arguments["hand"] == Path("my hand.npz")
    assert bound.arguments["axes"].options(affine=bound.arguments["affine"], ridge=bound.arguments["ridge"]) == options
    assert bound.arguments["reading"].options() == reading


def test_a_stopped_command_says_that_nothing_was_written(
    files: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("studio.basis.job.find_axes", stop)
    base = ("basis", "pca", "--motion", files / "clip.npz", "--rig", files / "hand.npz", "--out", files / "a.npz")
    assert call(capfd, *base) == (130, "", "cancelled; nothing was written\n")
