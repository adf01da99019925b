"""A scan from a file of any format that the studio reads."""

from __future__ import annotations

from pathlib import Path

from engine.errors import InputError
from engine.files.depth_json import read_depth_json
from engine.files.mesh_file import MESH_SUFFIXES
from engine.files.mesh_scan import is_mesh, read_mesh_scan
from engine.files.mesh_unit import mm_per_unit
from engine.files.minolta import read_minolta
from engine.files.npz import read_npz
from engine.files.pcd import read_pcd
from engine.files.ply import read_ply
from engine.files.scan_file import MM_PER_UNIT, ScanFile
from engine.files.source import checked_file
from engine.files.xyz import looks_like_points, read_xyz
from engine.scan.mesh_view import MeshView

_READERS = {
    ".json": read_depth_json,
    ".ply": read_ply,
    ".npz": read_npz,
    ".pcd": read_pcd,
    ".abs": read_minolta,
    ".abs.gz": read_minolta,
    ".xyz": read_xyz,
    ".asc": read_xyz,
}
_BEGINNINGS = {
    b"ply": ".ply",
    b"PK\x03": ".npz",
    b"{": ".json",
    b"# .PCD": ".pcd",
    b"VERSION": ".pcd",
    b"\x1f\x8b": ".abs.gz",
}


def has_scan_ending(path: str | Path) -> bool:
    """Return whether a file is named like a scan; ``read_scan`` knows others by their first bytes."""
    return Path(path).name.lower().endswith((*_READERS, *MESH_SUFFIXES))


def read_scan(path: str | Path, unit: str | None = None, view: MeshView | None = None) -> ScanFile:
    """Read a scan: an organised ``.ply`` or ``.pcd``, ``.npz``, ``.abs``, point text, or images with a ``.json``.

    An ``.obj``, a ``.glb`` and a ``.ply`` with faces and no grid are meshes: a virtual camera looks at them.

    Parameters
    ----------
    path : str or Path
        The file. The format follows its ending, or its first bytes where the ending says nothing.
    unit : {"mm", "cm", "m"}, optional
        What the file's numbers mean (a ``.json`` says it itself). Left out, the file's own word counts, or else mm;
        ``ScanFile.assumed`` says which. For a mesh also the millimetres of one of its units, ``"85.3 mm"``.
    view : MeshView, optional
        Where the camera stands before a mesh; placed automatically where it is left out.

    Returns
    -------
    ScanFile
        Points in mm, and what was assumed about the file.

    Raises
    ------
    InputError
        When the file cannot be read as a scan, for whatever reason.
    """
    path = checked_file(path)
    if is_mesh(path):
        if unit is not None:
            mm_per_unit(unit)
        return read_mesh_scan(path, unit, view)
    if view is not None:
        raise InputError(str(path), "is a range image: it has been seen by its own camera", "leave the view out")
    if unit is not None and unit not in MM_PER_UNIT:
        raise InputError("unit", f"{str(unit)[:40]!r} is not known", "choose mm, cm or m")
    suffix = _kind(path)
    if suffix not in _READERS:
        raise InputError(
            str(path), "is not a scan that can be read", f"give a {', '.join((*_READERS, '.obj', '.glb'))} file"
        )
    try:
        return _READERS[suffix](path, unit)
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "check the file and the disk") from error


def _kind(path: Path) -> str:
    """Return the ending whose reader fits: the file's own, or what its first bytes say, or nothing."""
    for ending in _READERS:
        if path.name.lower().endswith(ending):
            return ending
    with path.open("rb") as handle:
        start = handle.read(4096)
    bare = start.lstrip(b"\xef\xbb\xbf \t\r\n")
    if known := next((known for magic, known in _BEGINNINGS.items() if bare.startswith(magic)), ""):
        return known
    if b"pixels (flag" in start[:300]:
        return ".abs"
    return ".xyz" if looks_like_points(start) else ""
