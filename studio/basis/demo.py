"""The basis stage of the demo: the sample's rigs and performance become bases, a report and plates. No Qt."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engine.files.rig_out import write_rig
from engine.files.weights_csv import write_weights
from engine.motion import WeightCurves
from engine.progress import Progress, part
from studio.basis.job import BasisInputs, checks, figures
from studio.basis.loading import load_rig
from studio.basis.results import Analysis, Ingredients, analyse
from studio.basis.sample import CLIP, HAND, OTHER, load_sample, sample_path
from studio.project.document import Project
from studio.report.basis_entry import BasisEntry, entry_of

BOUNDS = "-1..2"


@dataclass(frozen=True)
class BasisDemo:
    """What was made.

    ``files`` are the bases, weights and the report, ``plates`` the figures of the paper; ``rows`` hold by basis the
    printed figures, ``checks`` what the animator's basis is judged by.
    """

    files: tuple[Path, ...]
    plates: tuple[Path, ...]
    rows: tuple[dict[str, Any], ...]
    checks: tuple[dict[str, Any], ...]


def add_sample(project: Project, progress: Progress) -> None:
    """Put the sample's hand-sculpted rig and its performance into a project.

    Raises
    ------
    InputError
        When the sample is not installed whole.
    """
    rig, motion = load_sample(progress)
    project.basis.keep_rig(rig.content, rig.item.content)
    project.basis.keep_motion(motion.item.content, motion.data)
    project.basis.rigs.insert(0, rig.item)
    project.basis.motions.insert(0, motion.item)
    project.basis.change_setup(hand=rig.item.id, motion=motion.item.id)


def run(out: Path, plates: Path, project: Project, progress: Progress) -> BasisDemo:
    """Make the bases of both sample rigs, and write what belongs to them.

    Parameters
    ----------
    out, plates : Path
        Folders for bases and report, and for the plates; both are there.
    project : Project
        Gets the sample's rig and performance.

    Raises
    ------
    InputError
        When a file cannot be written.
    """
    from studio.report.basis_job import write_pages

    progress(0.0, "reading the performance")
    add_sample(project, part(progress, 0.0, 0.05))
    own = _analysed(project, part(progress, 0.05, 0.25))
    entry = _entry(own, {"hand": sample_path(HAND), "motion": sample_path(CLIP)}, "The animator's basis")
    written = list(_written(own, out, "animator", part(progress, 0.25, 0.3)))
    written += write_pages(part(progress, 0.3, 0.65), entry, out / "basis.pdf")
    drawn = _plates(plates, own, entry, part(progress, 0.65, 0.85))
    other = _other(project, part(progress, 0.85, 0.97))
    written += _written(other, out, "another_artist", part(progress, 0.97, 1.0))
    rows = (_row("the animator's 24", own), _row("another artist's 34", other))
    judged = tuple({**vars(check), "passes": check.passes} for check in checks(own.result, BOUNDS))
    progress(1.0, "done")
    return BasisDemo(tuple(written), drawn, rows, judged)


def _analysed(project: Project, progress: Progress) -> Analysis:
    ingredients = Ingredients.of(project.basis)
    assert ingredients is not None
    return analyse(ingredients, None, progress)


def _other(project: Project, progress: Progress) -> Analysis:
    """Return the basis of the other artist's rig; the project is left with the animator's."""
    loaded, setup = load_rig(sample_path(OTHER)), project.basis.setup
    project.basis.keep_rig(loaded.content, loaded.item.content)
    project.basis.rigs.insert(1, loaded.item)
    project.basis.change_setup(hand=loaded.item.id)
    try:
        return _analysed(project, progress)
    finally:
        project.basis.set_setup(setup)


def _entry(analysis: Analysis, files: dict[str, Path], title: str) -> BasisEntry:
    inputs = BasisInputs(analysis.hand, analysis.prepared.motion)
    return entry_of(inputs, analysis.options, analysis.result, files=files, title=title)


def _written(analysis: Analysis, out: Path, name: str, progress: Progress) -> tuple[Path, ...]:
    """Write both forms of a basis and the weights that reproduce the performance."""
    progress(0.0, f"writing {name}")
    quasi, motion = analysis.result.quasi.basis, analysis.prepared.motion
    curves = WeightCurves(quasi.names, analysis.result.comparison.weights["quasi_eigen"][BOUNDS], motion.fps)
    hand = write_rig(out / f"{name}_hand.glb", analysis.hand, name=name)
    made = write_rig(out / f"{name}_quasi_eigen.glb", analysis.hand.with_basis(quasi), name=name, curves=curves)
    weights = out / f"{name}_weights.csv"
    write_weights(weights, curves)
    return (*hand, *made, weights)


def _plates(folder: Path, analysis: Analysis, entry: BasisEntry, progress: Progress) -> tuple[Path, ...]:
    from studio.report.basis_plates import write_basis_plates

    return tuple(write_basis_plates(folder, analysis, entry, progress=progress))


def _row(title: str, analysis: Analysis) -> dict[str, Any]:
    found = figures(analysis.result)
    alpha = {
        f"{basis} {key}": found["alpha"][basis][key]["mean"]
        for basis, key in (("hand", BOUNDS), ("quasi_eigen", BOUNDS), ("quasi_eigen", "free"), ("pca", "free"))
    }
    return {
        "basis": title,
        "axes": found["axes"],
        **alpha,
        "weights_p99": found["weights_p99"]["quasi_eigen"][BOUNDS],
        "median_cosine": found["median_cosine"],
        "warnings": found["warnings"],
    }
