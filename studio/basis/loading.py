"""Files become rigs and performances of a project: read, keyed, and linked where they are large. No Qt."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from engine.errors import InputError
from engine.progress import Progress, silent
from studio.basis.options import MotionOptions
from studio.project.basis_items import (
    MotionItem,
    RigContent,
    RigItem,
    link_key,
    motion_bytes,
    motion_key,
)
from studio.project.keys import new_id
from studio.project.linked import LARGEST_EMBEDDED, LinkedFile

if TYPE_CHECKING:
    from engine.files.motion_file import MotionFile
    from studio.project.basis_items import MotionData

NAME_LIMIT = 60


@dataclass(frozen=True)
class LoadedRig:
    """A rig that was read, not yet in the project."""

    item: RigItem
    content: RigContent
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class LoadedMotion:
    """A performance that was read, not yet in the project."""

    item: MotionItem
    data: MotionData
    remarks: tuple[str, ...]


def load_rig(path: Path, progress: Progress = silent, unit: str | None = None) -> LoadedRig:
    """Read a rig and say what was assumed.

    Raises
    ------
    InputError
        When it cannot be read as a rig.
    """
    from engine.files.rig import read_rig

    path = Path(path)
    progress(0.05, f"reading {path.name}")
    file = read_rig(path, unit)
    progress(0.9, "checking its content")
    content = RigContent(file.rig, file.texture)
    item = RigItem(new_id("rig"), plain_name(path), content.key, str(path), file.unit, file.assumed, file.format)
    return LoadedRig(item, content, file.warnings)


def load_motion(path: Path, options: MotionOptions | None = None, progress: Progress = silent) -> LoadedMotion:
    """Read a performance and say what was assumed; more than 64 MB of it stays in its file.

    Raises
    ------
    InputError
        When it cannot be read as a performance.
    """
    path, options = Path(path), options or MotionOptions()
    progress(0.05, f"reading {path.name}")
    file = motion_of(path, options)
    progress(0.9, "checking its content")
    link = LinkedFile.of(path) if motion_bytes(file.data) > LARGEST_EMBEDDED else None
    data = file.data if link is not None else _own(file.data)
    key = motion_key(data) if link is None else link_key(link, options)
    item = MotionItem(
        new_id("motion"),
        plain_name(path),
        file.kind,
        key,
        str(path),
        file.unit,
        file.assumed,
        len(file.data),
        count_of(file.data),
        file.fps,
        options,
        link,
    )
    return LoadedMotion(item, data, file.warnings)


def _own(data: MotionData) -> MotionData:
    """Return data that do not change with the file they were read from."""
    from engine.files.motion_file import DenseClip

    if not isinstance(data, DenseClip):
        return data
    vertices = np.array(data.vertices)
    vertices.flags.writeable = False
    return replace(data, vertices=vertices)


def motion_of(path: Path, options: MotionOptions) -> MotionFile:
    """Return the performance of a file as the options say it is to be read.

    Raises
    ------
    InputError
        When it cannot be read as a performance.
    """
    from engine.files.motion import read_motion
    from engine.files.motion_file import DenseClip

    file = read_motion(path, unit=options.unit, up=options.up, forward=options.forward, fps=options.fps)
    data = file.data
    if isinstance(data, DenseClip) and data.vertices.dtype.str not in ("<f4", "<f8"):
        vertices = np.asarray(data.vertices, dtype="<f8" if data.vertices.dtype.itemsize > 4 else "<f4")
        return replace(file, data=replace(data, vertices=vertices))
    return file


def read_linked(item: MotionItem, progress: Progress = silent) -> MotionData:
    """Return the data of a linked performance from its file.

    Raises
    ------
    InputError
        When the file is not there, or is another than the one that was linked.
    """
    link = item.link
    if link is None:
        raise InputError(f"performance {item.name}", "is not linked", "choose its file")
    found = link.state()
    if found != "there":
        problem = "is not where it was" if found == "missing" else "has changed since it was linked"
        raise InputError(str(link.path), problem, "choose the file again")
    progress(0.05, f"reading {link.path.name}")
    return motion_of(link.path, item.options).data


def count_of(data: MotionData) -> int:
    """Return how many markers, curves or vertices there are."""
    from engine.motion import MarkerClip, WeightCurves

    if isinstance(data, MarkerClip):
        return len(data.labels)
    return len(data.names) if isinstance(data, WeightCurves) else data.count


def plain_name(path: Path) -> str:
    """Return a name for what a file or folder holds."""
    stem = path.name.split(".")[0] or path.stem
    plain = "".join("_" if c in '/\\:*?"<>|' or not c.isprintable() else c for c in stem)[:NAME_LIMIT]
    return plain.strip(". ") or "item"
