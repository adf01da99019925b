"""``quasiface scan view``: what a virtual camera sees of a mesh, written as a scan. No Qt."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from engine.errors import InputError
from studio.output import Json, print_result, remark
from studio.scan.view_options import ViewOptions

if TYPE_CHECKING:
    from engine.scan.mesh_view import MeshView

_VIEW = ViewOptions()


def view(
    mesh: Path,
    /,
    *,
    out: Path,
    unit: str | None = None,
    placing: Annotated[ViewOptions, Parameter(name="*")] = _VIEW,
    as_json: Json = False,
) -> int:
    """Look at a mesh with a virtual camera and write a depth and a colour image.

    Parameters
    ----------
    mesh : Path
        A .obj, .glb, or a .ply with faces.
    out : Path
        The scan: .json, with its pictures beside it.
    unit : str
        What the file's numbers mean: mm, cm, m, or the millimetres of one, as "85.3 mm".
    """
    import numpy as np

    from engine.files.depth_json import write_depth_scan
    from studio.scan.job import check_overwrites
    from studio.scan.view_options import read_placed

    if out.suffix.lower() != ".json":
        raise InputError(str(out), "is not the name of a .json", "end it with .json")
    file = read_placed(mesh, unit, placing)
    if file.view is None:
        raise InputError(str(mesh), "is a range image already", "give an .obj, .glb, or a .ply with faces")
    pictures = [out.with_name(f"{out.stem}_depth.png")]
    if file.scan.colour is not None:
        pictures.append(out.with_name(f"{out.stem}_colour.png"))
    check_overwrites((out, *pictures), file.source_files)
    farthest = -float(np.nanmin(file.scan.points[..., 2]))
    # 16 bits in as fine steps as the furthest point allows.
    write_depth_scan(out, file.scan, max(0.02, math.ceil(farthest / 65535 * 1e4) / 1e4))
    for warning in file.warnings:
        remark(f"{mesh}: {warning}")
    values: dict[str, Any] = {
        "width": file.scan.width,
        "height": file.scan.height,
        "missing_fraction": file.scan.missing_fraction,
        "unit": file.unit,
        "assumed": file.assumed,
        "view": view_figures(file.view),
        "files": [out, *pictures],
    }
    print_result(values, as_json)
    return 0


def view_figures(view: MeshView) -> dict[str, Any]:
    """Return a view under the names that scripts rely on: angles in degrees, lengths in mm."""
    return ViewOptions.of(view).model_dump() | {"rotation": list(view.rotation)}
