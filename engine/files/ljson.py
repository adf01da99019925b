"""Landmarks as ``.ljson``, the labelled JSON of menpo, versions 1, 2 and 3.

Points of a picture stand there as (row, column), points of a mesh as (x, y, z); null is a point without a place.
Version 1 lists its points label by label, version 2 one list of points with masks, version 3 several such groups.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.json_text import checked, load_json
from engine.files.landmark_file import (
    FARTHEST,
    MAX_POINTS,
    LandmarkFile,
    checked_name,
    checked_origin,
    chosen_group,
)
from engine.mesh import FloatArray

_EVERYTHING = "all"
_STRICT = ConfigDict(strict=True, extra="ignore", allow_inf_nan=False)
_Number = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
_Point = Annotated[list[_Number | None], Field(min_length=2, max_length=3)] | None
_Index = Annotated[int, Field(ge=0, lt=MAX_POINTS)]


class _Label(BaseModel):
    model_config = _STRICT
    label: str
    mask: Annotated[list[_Index], Field(max_length=MAX_POINTS)]


class _Points(BaseModel):
    model_config = _STRICT
    points: Annotated[list[_Point], Field(max_length=MAX_POINTS)]


class _Group(BaseModel):
    model_config = _STRICT
    landmarks: _Points
    labels: Annotated[list[_Label], Field(max_length=MAX_POINTS)] = []


class _Three(BaseModel):
    model_config = _STRICT
    groups: Annotated[dict[str, _Group], Field(min_length=1, max_length=1000)]


class _OldPoint(BaseModel):
    model_config = _STRICT
    point: _Point


class _OldLabel(BaseModel):
    model_config = _STRICT
    label: str
    landmarks: Annotated[list[_OldPoint], Field(max_length=MAX_POINTS)]


class _One(BaseModel):
    model_config = _STRICT
    groups: Annotated[list[_OldLabel], Field(min_length=1, max_length=MAX_POINTS)]


def read_ljson(path: str | Path, group: str | None = None, origin: float | None = None) -> LandmarkFile:
    """Read an ``.ljson`` file.

    Parameters
    ----------
    path : str or Path
        The file.
    group : str, optional
        Which group of several; the first where left out, and the file's remarks say so.
    origin : {0, 0.5, 1}, optional
        What the file calls the centre of the top left pixel; 0 where left out.

    Raises
    ------
    InputError
        On a damaged file, a mask that leads outside the points, and a group that is not there.
    """
    first = checked_origin(origin, "ljson")
    value = load_json(path)
    version = value.get("version")
    name = ""
    groups: tuple[str, ...] = ("",)
    said: tuple[str, ...] = ()
    if version == 1 and not isinstance(version, bool):
        if group:
            raise InputError(str(path), f"has no group {group[:60]!r}", "version 1 has one group only")
        points, labels = _first_version(checked(_One, value, path), path)
    elif version == 2:
        if group:
            raise InputError(str(path), f"has no group {group[:60]!r}", "version 2 has one group only")
        points, labels = _with_masks(checked(_Group, value, path), path)
    elif version == 3:
        fields = checked(_Three, value, path)
        groups = tuple(checked_name(key, f"{path}, groups") for key in fields.groups)
        if len(set(groups)) != len(groups):
            raise InputError(f"{path}, groups", "two groups have one name", "rename one of them")
        name, said = chosen_group(str(path), groups, group)
        chosen = dict(zip(groups, fields.groups.values(), strict=True))[name]
        points, labels = _with_masks(chosen, f"{path}, groups.{name}")
    else:
        raise InputError(f"{path}, version", f"is {str(version)[:20]}, not 1, 2 or 3", "export it again")
    table, remarks = _table(points, path)
    if table.shape[1] == 2:
        table = table[:, ::-1] - first
        remarks = (*remarks, f"pairs taken as row and column, pixels counted from {first:g}")
    is_flat = table.shape[1] == 2
    return LandmarkFile(
        table, labels, name, groups, origin=first if is_flat else 0.0, format="ljson", remarks=(*said, *remarks)
    )


def _first_version(fields: _One, path: str | Path) -> tuple[list[Any], tuple[str, ...]]:
    points: list[Any] = []
    masks: list[tuple[str, list[int]]] = []
    for entry in fields.groups:
        masks.append((entry.label, list(range(len(points), len(points) + len(entry.landmarks)))))
        points += [old.point for old in entry.landmarks]
        if len(points) > MAX_POINTS:
            raise InputError(f"{path}, groups", f"hold more than {MAX_POINTS} points", "export it again")
    return points, _names(len(points), masks, f"{path}, groups")


def _with_masks(fields: _Group, subject: str | Path) -> tuple[list[Any], tuple[str, ...]]:
    points = fields.landmarks.points
    masks = [(entry.label, entry.mask) for entry in fields.labels]
    if sum(len(mask) for _, mask in masks) > 20 * MAX_POINTS:
        raise InputError(f"{subject}, labels", "name far more points than there are", "export it again")
    for label, mask in masks:
        if mask and max(mask) >= len(points):
            problem = f"the mask of {label[:40]!r} names point {max(mask)} of {len(points)}"
            raise InputError(f"{subject}, labels", problem, "export it again")
    return list(points), _names(len(points), masks, f"{subject}, labels")


def _names(count: int, masks: Sequence[tuple[str, list[int]]], subject: str) -> tuple[str, ...]:
    """Return a name for each point: its smallest label, with its place there where the label has several points.

    ``all`` over all points names none of them: the index is all there is to go by.
    """
    names: dict[int, str] = {}
    for label, mask in sorted(masks, key=lambda entry: len(entry[1])):
        label = checked_name(label, subject)
        if len(mask) == count and label.lower() == _EVERYTHING:
            continue
        for place, index in enumerate(mask):
            names.setdefault(index, label if len(mask) == 1 else f"{label}.{place}")
    return tuple(names.get(index, str(index)) for index in range(count))


def _table(points: list[Any], path: str | Path) -> tuple[FloatArray, tuple[str, ...]]:
    """Return (n, 2 | 3) coordinates, NaN where a point or one of its coordinates is null."""
    widths = {len(point) for point in points if point is not None}
    if not points or not widths:
        raise InputError(str(path), "has no points", "export it again")
    if len(widths) > 1:
        raise InputError(f"{path}, points", "some have two coordinates, some three", "export it again")
    width = widths.pop()
    table = np.full((len(points), width), np.nan)
    for k, point in enumerate(points):
        if point is not None and None not in point:
            table[k] = point
    missing = int(np.isnan(table).any(axis=1).sum())
    return table, (f"{missing} of {len(points)} points are null",) if missing else ()


def write_ljson(
    path: str | Path, points: FloatArray, labels: Sequence[str], origin: float | None = None, group: str = "LJSON"
) -> None:
    """Write points as ``.ljson``, version 3, so that reading gives the same points and names.

    Parameters
    ----------
    path : str or Path
        The file.
    points : (n, 2) or (n, 3) float
        Pixels x, y, or x, y, z; NaN becomes null.
    labels : sequence of str
        What each point is called; ``leye.0``, ``leye.1`` ... become one label ``leye``, bare indices none.
    origin : {0, 0.5, 1}, optional
        What the file calls the centre of the top left pixel; 0 where left out.
    group : str
        The name of the one group.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    points = np.asarray(points, dtype=np.float64)
    if points.shape[1] == 2:
        points = points[:, ::-1] + checked_origin(origin, "ljson")
    rows = [[float(v) for v in row] if np.isfinite(row).all() else [None] * points.shape[1] for row in points]
    value = {
        "version": 3,
        "groups": {group: {"labels": _masks(labels), "landmarks": {"connectivity": [], "points": rows}}},
    }
    with atomic_write(path) as handle:
        handle.write((json.dumps(value, indent=1, ensure_ascii=False) + "\n").encode())


def _masks(labels: Sequence[str]) -> list[dict[str, Any]]:
    """Return the labels with masks from which `_names` gives ``labels`` again, and one that covers all points."""
    masks: dict[str, list[int]] = {}
    for index, label in enumerate(labels):
        if label == str(index):
            continue
        stem, dot, place = label.rpartition(".")
        known = masks.get(stem, [])
        follows = dot and stem and place == str(len(known)) and stem not in labels
        masks.setdefault(stem if follows else label, []).append(index)
    single = {stem: mask for stem, mask in masks.items() if len(mask) == 1 and stem not in labels}
    for stem, mask in single.items():  # one point of a label of its own keeps its whole name
        del masks[stem]
        masks[labels[mask[0]]] = mask
    named = [{"label": label, "mask": mask} for label, mask in masks.items()]
    return [*named, {"label": _EVERYTHING, "mask": list(range(len(labels)))}]
