"""Landmarks from and to a file of any format: our JSON, ``.pts``, ``.ljson``, and tables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.json_text import load_json
from engine.files.landmark_file import DEFAULT_ORIGIN, LandmarkFile, checked_origin
from engine.files.landmarks_csv import read_landmark_csv, write_landmark_csv
from engine.files.landmarks_json import read_fiducials, write_fiducials
from engine.files.ljson import read_ljson, write_ljson
from engine.files.pts import read_pts, write_pts
from engine.files.source import checked_file
from engine.mesh import FloatArray

__all__ = ["ENDINGS", "LandmarkFile", "format_of", "read_landmarks", "write_landmarks"]

ENDINGS = {".json": "json", ".pts": "pts", ".ljson": "ljson", ".csv": "csv", ".tsv": "csv", ".txt": "csv"}
"""The format that a file's ending stands for."""


def format_of(path: str | Path) -> str:
    """Return ``json``, ``pts``, ``ljson`` or ``csv`` from a file's ending; InputError for any other ending."""
    kind = ENDINGS.get(Path(path).suffix.lower())
    if kind is None:
        raise InputError(str(path), "has no ending that tells the format", "end it in .json, .pts, .ljson or .csv")
    return kind


def read_landmarks(path: str | Path, group: str | None = None, origin: float | None = None) -> LandmarkFile:
    """Read the landmarks of one picture or mesh.

    Parameters
    ----------
    path : str or Path
        ``.json`` (ours), ``.pts``, ``.ljson``, or a table ``.csv``, ``.tsv``, ``.txt``.
    group : str, optional
        Which of several groups or rows; the first where left out, and the file's remarks say so.
    origin : {0, 0.5, 1}, optional
        What the file calls the centre of the top left pixel. Left out: 1 for ``.pts``, 0 for the others.

    Returns
    -------
    LandmarkFile
        2-D points in pixels with centres at integers and the origin at the top left; 3-D points as they stand there.

    Raises
    ------
    InputError
        When the file cannot be read, for whatever reason.
    """
    path = checked_file(path)
    kind = format_of(path)
    if kind == "pts":
        return read_pts(path, group, origin)
    if kind == "ljson":
        return read_ljson(path, group, origin)
    if kind == "csv":
        return read_landmark_csv(path, group, origin)
    if _is_ljson(path):
        return read_ljson(path, group, origin)
    if group:
        raise InputError(str(path), f"has no group {group[:60]!r}", "it holds one picture only")
    first = checked_origin(origin, "json")
    fiducials = read_fiducials(path)
    points = np.array([list(place) for place in fiducials.positions.values()]).reshape(-1, 2) - first
    return LandmarkFile(points, tuple(fiducials.positions), image_size=fiducials.image_size, origin=first)


def _is_ljson(path: Path) -> bool:
    """Whether a ``.json`` is an ``.ljson`` under another name."""
    value = load_json(path)
    return "version" in value and not value.keys().isdisjoint(("groups", "landmarks"))


def write_landmarks(
    path: str | Path,
    points: FloatArray,
    labels: Sequence[str],
    image_size: tuple[int, int] | None = None,
    origin: float | None = None,
) -> None:
    """Write landmarks atomically; the ending chooses the format.

    Parameters
    ----------
    path : str or Path
        ``.json``, ``.pts``, ``.ljson`` or ``.csv``.
    points : (n, 2) or (n, 3) float
        Pixels (centres at integers, origin top left) or positions; NaN where a point has no place.
    labels : sequence of str
        What each point is called; ``.pts`` keeps their order only.
    image_size : (int, int), optional
        Width and height of the picture; ``.json`` needs it, the others have no room for it.
    origin : {0, 0.5, 1}, optional
        What the file calls the centre of the top left pixel. Left out: 1 for ``.pts``, 0 for the others.

    Raises
    ------
    InputError
        On holes in a ``.pts``, 3-D points or no image size for a ``.json``, and where the file cannot be written.
    """
    path = Path(path)
    kind = format_of(path)
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) != len(labels):
        raise InputError("landmarks", f"have shape {points.shape} for {len(labels)} labels", "give one place a label")
    if not len(points):
        raise InputError(str(path), "there is no point to write", "place some first")
    if kind == "pts":
        write_pts(path, points, origin)
    elif kind == "ljson":
        write_ljson(path, points, labels, origin)
    elif kind == "csv" and path.suffix.lower() == ".csv":
        write_landmark_csv(path, points, labels, origin)
    elif kind == "csv":
        raise InputError(str(path), "tables are written as .csv", "end it in .csv")
    else:
        if points.shape[1] != 2 or image_size is None:
            problem = "holds pixels of a picture with its size only"
            raise InputError(str(path), problem, "write .ljson or .csv, or name the picture's size")
        if checked_origin(origin, "json") != DEFAULT_ORIGIN["json"]:
            raise InputError(str(path), "always counts pixels from 0", "leave the origin out")
        positions = {
            name: (float(x), float(y))
            for name, (x, y) in zip(labels, points.tolist(), strict=True)
            if np.isfinite(x) and np.isfinite(y)
        }
        write_fiducials(path, positions, image_size)
