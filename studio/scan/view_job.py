"""A mesh seen from elsewhere: the new range image, and its fiducials carried there through space. No Qt."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from engine.errors import InputError
from engine.landmarks import UNSET, LandmarkSet
from engine.progress import Progress, part
from engine.scan.range_image import RangeImage
from studio.project.document import ScanItem, SourceInfo

if TYPE_CHECKING:
    from engine.files.mesh_file import MeshFile
    from engine.scan.mesh_preview import LightMesh
    from engine.scan.mesh_view import MeshView, Placement


@dataclass(frozen=True)
class MeshToPlace:
    """A scan's mesh, read again: itself, light enough to follow the hand, and where it would be placed by itself."""

    file: MeshFile
    light: LightMesh
    automatic: Placement


@dataclass(frozen=True)
class Seen:
    """A scan from elsewhere; ``lost`` says in words which fiducials it does not show.

    ``scale`` is how many of its millimetres were one before, where the unit of the mesh has changed too.
    """

    source: SourceInfo
    scan: RangeImage
    landmarks: LandmarkSet
    lost: str
    scale: float = 1.0


def read_to_place(item: ScanItem, progress: Progress) -> MeshToPlace:
    """Read the mesh of a scan again.

    Raises
    ------
    InputError
        When its file is gone or is no mesh.
    """
    from engine.files.mesh_file import read_mesh
    from engine.scan.mesh_preview import light_copy
    from engine.scan.mesh_view import propose_view

    source = item.source
    if source.view is None:
        raise InputError(f"scan {item.name}", "is a range image: it has been seen by its own camera")
    path = Path(source.depth_file)
    progress(0.0, f"reading {path.name}")
    file = read_mesh(path, source.unit)
    progress(0.5, "looking for the face")
    automatic = propose_view(file.mesh, source.view.width, source.view.height)
    progress(0.9, "making it light")
    return MeshToPlace(file, light_copy(file), automatic)


def see(item: ScanItem, image: RangeImage, file: MeshFile, view: MeshView, unit: str, progress: Progress) -> Seen:
    """Look at a mesh and carry the fiducials of ``item`` from its picture ``image`` to the new one.

    Parameters
    ----------
    unit : str
        What one unit of the file is; where it is another than ``file.unit``, the mesh is scaled.

    Raises
    ------
    InputError
        When the view shows nothing of the mesh.
    """
    from engine.files.mesh_unit import mm_per_unit
    from engine.scan.mesh_view import view_mesh
    from engine.scan.repair import find_spikes

    source = item.source
    assert source.view is not None
    factor = mm_per_unit(unit) / file.mm_per_unit
    if factor != 1.0:
        file = replace(file, mesh=file.mesh.with_vertices(file.mesh.vertices * factor), unit=unit)
    scan = view_mesh(file, view, part(progress, 0.0, 0.7))
    progress(0.7, "carrying the fiducials")
    landmarks, lost = carried(item.landmarks, (image, source.view), (scan, view), factor)
    progress(0.8, "looking for spikes")
    spikes = int(find_spikes(scan, item.options.spike_mm).sum())
    assumed = source.assumed if factor == 1.0 else f"{unit}, as asked"
    seen = SourceInfo(
        source.depth_file, unit, assumed, scan.width, scan.height, scan.missing_fraction, spikes, view, view_asked=True
    )
    return Seen(seen, scan, landmarks, lost, factor)


def carried(
    landmarks: LandmarkSet, old: tuple[RangeImage, MeshView], new: tuple[RangeImage, MeshView], scale: float = 1.0
) -> tuple[LandmarkSet, str]:
    """Return fiducials where another view shows them, and in words those that it does not show, which become unset."""
    from engine.scan.reproject import reproject

    names = [name for name, point in landmarks.points.items() if point.is_set]
    if not names:
        return landmarks, ""
    found = reproject(np.array([(landmarks[name].x, landmarks[name].y) for name in names]), old, new, scale)
    points = {}
    for name, (x, y) in zip(names, found.pixels.tolist(), strict=True):
        points[name] = replace(landmarks[name], x=x, y=y) if np.isfinite([x, y]).all() else UNSET
    reasons = (
        ("outside the picture", found.outside),
        ("hidden", found.hidden),
        ("on missing pixels", found.unmeasured),
    )
    parts = [
        f"{int(mask.sum())} {why}: {', '.join(name for name, is_so in zip(names, mask, strict=True) if is_so)}"
        for why, mask in reasons
        if mask.any()
    ]
    lost = sum(int(mask.sum()) for _, mask in reasons)
    said = f"{lost} fiducial{'' if lost == 1 else 's'} unset ({'; '.join(parts)})" if lost else ""
    return landmarks.with_points(points), said
