"""What files and folders hold that were dropped on the basis stage: rigs, performances, pairs of markers. No Qt."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

MOTION_SUFFIXES = frozenset({".c3d", ".trc", ".csv", ".tsv", ".txt", ".pc2"})


@dataclass(frozen=True)
class DroppedFiles:
    """Paths by what they hold; ``left_out`` says in words what was not recognised."""

    rigs: tuple[Path, ...] = ()
    motions: tuple[Path, ...] = ()
    pairs: tuple[Path, ...] = ()
    left_out: tuple[str, ...] = ()


def sort_dropped(paths: Iterable[Path]) -> DroppedFiles:
    """Return what was dropped, judged by names and tables of contents alone."""
    rigs: list[Path] = []
    motions: list[Path] = []
    pairs: list[Path] = []
    others: list[str] = []
    for path in paths:
        kind = kind_of_file(path)
        target = {"rig": rigs, "motion": motions, "pairs": pairs}.get(kind)
        if target is None:
            others.append(f"{path.name}: is neither a rig nor a performance")
        elif path not in target:
            target.append(path)
    return DroppedFiles(tuple(rigs), tuple(motions), tuple(pairs), tuple(others))


def kind_of_file(path: Path) -> str:
    """Return ``rig``, ``motion``, ``pairs``, or an empty text."""
    suffix = path.suffix.lower()
    if path.is_dir():
        return "rig" if any(child.suffix.lower() == ".obj" for child in path.iterdir()) else ""
    if suffix in (".glb", ".obj"):
        return "rig"
    if suffix in MOTION_SUFFIXES:
        return "motion"
    if suffix == ".json":
        return "pairs"
    return _kind_of_archive(path) if suffix == ".npz" else ""


def _kind_of_archive(path: Path) -> str:
    try:
        with zipfile.ZipFile(path) as archive:
            names = {name.removesuffix(".npy") for name in archive.namelist()[:1000]}
    except (OSError, zipfile.BadZipFile):
        return "rig"  # the reader says what is wrong with it
    rig = names & {"displacements", "expressions", "names", "expression_names"}
    return "motion" if not rig and names & {"vertices", "positions", "markers", "weights"} else "rig"
