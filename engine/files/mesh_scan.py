"""A mesh file as a scan: read, placed before a virtual camera, seen."""

from __future__ import annotations

from pathlib import Path

from engine.errors import InputError
from engine.files.mesh_file import MESH_SUFFIXES, MeshFile, read_mesh
from engine.files.ply_mesh import is_ply_mesh
from engine.files.scan_file import ScanFile
from engine.progress import Progress, part, silent
from engine.scan.mesh_view import MeshView, Placement, propose_view, view_mesh
from engine.scan.orient import SURE


def is_mesh(path: Path) -> bool:
    """Whether a file is a mesh: OBJ always, GLB by its first bytes, PLY where it has faces and no grid.

    Raises
    ------
    InputError
        For a PLY whose header cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix == ".glb":
        with path.open("rb") as handle:
            return handle.read(4) == b"glTF"
    return suffix in MESH_SUFFIXES and (suffix != ".ply" or is_ply_mesh(path))


def read_mesh_scan(
    path: Path, unit: str | None = None, view: MeshView | None = None, progress: Progress = silent
) -> ScanFile:
    """Read a mesh and return what a camera sees of it.

    Parameters
    ----------
    path : Path
        OBJ, PLY or GLB.
    unit : str, optional
        As for ``read_mesh``.
    view : MeshView, optional
        Where the camera stands; placed automatically where it is left out, which ``warnings`` says.

    Raises
    ------
    InputError
        As ``read_mesh`` and ``view_mesh``.
    """
    progress(0.0, f"reading {path.name}")
    file = read_mesh(path, unit)
    try:
        return scan_of(file, view, part(progress, 0.3, 1.0))
    except InputError as error:
        raise InputError(f"{path}, {error.subject}", error.problem, error.remedy) from error


def scan_of(file: MeshFile, view: MeshView | None, progress: Progress = silent) -> ScanFile:
    """Return what a camera sees of a mesh that has been read; without a view it is placed automatically."""
    said = file.warnings
    if view is None:
        progress(0.0, "looking for the face")
        placed = propose_view(file.mesh)
        view = placed.view
        said = (*said, in_words(placed))
    scan = view_mesh(file, view, part(progress, 0.4, 1.0))
    return ScanFile(scan, file.unit, file.assumed, file.source_files, file.format, said, view)


def in_words(placed: Placement) -> str:
    """Return how a view was found, and how surely."""
    sure = "surely" if placed.confidence >= 0.8 else "rather surely" if placed.confidence >= SURE else "not sure"
    return f"{placed.reason} ({sure}, confidence {placed.confidence:.2f})"
