"""Rigs to files: GLB with morph targets, a folder of OBJs, or a NumPy archive."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from engine.errors import InputError
from engine.files.glb_rig_out import write_glb_rig
from engine.files.npz_rig import write_npz_rig
from engine.files.obj_rig import write_obj_rig
from engine.motion import WeightCurves
from engine.scan.range_image import ColourImage
from engine.shapes import Rig


def write_rig(
    path: str | Path,
    rig: Rig,
    *,
    name: str = "face",
    texture: ColourImage | None = None,
    curves: WeightCurves | None = None,
    extras: Mapping[str, Any] | None = None,
) -> tuple[Path, ...]:
    """Write a rig in the format that the ending of ``path`` names.

    Parameters
    ----------
    path : str or Path
        ``.glb`` (metres, float32, names and mean kept), ``.npz`` (mm, without loss), or a folder: one OBJ a shape in
        mm with 5 decimals, beside ``neutral.obj``.
    rig : Rig
        In mm.
    name : str
        Name of node, mesh and object.
    texture : (H, W, 3) uint8, optional
        RGB picture for the mesh's chart; an ``.npz`` has none.
    curves : WeightCurves, optional
        Weights over time, matched to the shapes by name; only a GLB can hold them.
    extras : mapping, optional
        Added to the ``extras`` of a GLB's asset.

    Returns
    -------
    tuple of Path
        All files that were written, the one to open first.

    Raises
    ------
    InputError
        When an ending is not known, curves or texture do not fit the rig or the format, or a file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".glb":
        write_glb_rig(path, rig, name=name, texture=texture, curves=curves, extras=extras)
        return (path,)
    if curves is not None:
        raise InputError(str(path), "cannot hold curves", "choose .glb")
    if suffix == ".npz":
        write_npz_rig(path, rig)
        return (path,)
    if not suffix or path.is_dir():
        return write_obj_rig(path, rig, name=name, texture=texture)
    raise InputError(str(path), "has no known ending", "choose .glb, .npz or a folder for OBJ files")
