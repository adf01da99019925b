"""Fiducials of one picture as JSON: ``{"image_size": [w, h], "points": {"name": [x, y], ...}}``."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, NamedTuple

from pydantic import BaseModel, ConfigDict, Field

from engine.errors import InputError, some
from engine.files.atomic import atomic_write
from engine.files.json_text import checked, load_json
from engine.landmarks import inside

Positions = dict[str, tuple[float, float]]


class Fiducials(NamedTuple):
    """Positions in pixels (centres at integers, origin top left) by name, and the image's (width, height)."""

    positions: Positions
    image_size: tuple[int, int]


_Size = Annotated[int, Field(ge=1, le=1_000_000)]
_Pair = Annotated[list[float], Field(min_length=2, max_length=2)]


class _FiducialFields(BaseModel):
    model_config = ConfigDict(strict=True, extra="ignore", allow_inf_nan=False)

    image_size: Annotated[list[_Size], Field(min_length=2, max_length=2)]
    points: Annotated[dict[str, _Pair], Field(max_length=10_000)]


def read_fiducials(path: str | Path) -> Fiducials:
    """Read fiducials; whether they fit a scheme and a picture is ``check_fiducials``'s question.

    Raises
    ------
    InputError
        On a missing or damaged file, a name that occurs twice, and numbers that are missing or not finite.
    """
    fields = checked(_FiducialFields, load_json(path), path)
    for name in fields.points:
        if not name or not name.isprintable():
            raise InputError(f"{path}, points", f"the name {name[:60]!r} cannot be used", "rename the point")
    width, height = fields.image_size
    return Fiducials({name: (x, y) for name, (x, y) in fields.points.items()}, (width, height))


def write_fiducials(
    path: str | Path, positions: Mapping[str, tuple[float, float]], image_size: tuple[int, int]
) -> None:
    """Write fiducials atomically, in the order given and without loss.

    Parameters
    ----------
    path : str or Path
        The JSON file.
    positions : mapping of str to (float, float)
        Pixels, centres at integers, origin top left.
    image_size : (int, int)
        Width and height of the picture they were placed on.

    Raises
    ------
    InputError
        When a position is not finite, or the file cannot be written.
    """
    points = {}
    for name, (x, y) in positions.items():
        if not (math.isfinite(x) and math.isfinite(y)):
            raise InputError(f"fiducial {name}", f"stands at {x}, {y}", "place it first")
        points[str(name)] = [float(x), float(y)]
    lines = ",\n".join(f"  {json.dumps(name)}: {json.dumps(point)}" for name, point in points.items())
    size = json.dumps([int(image_size[0]), int(image_size[1])])
    with atomic_write(path) as handle:
        handle.write(f'{{\n "image_size": {size},\n "points": {{\n{lines}\n }}\n}}\n'.encode())


def check_fiducials(
    fiducials: Fiducials, scheme_names: Iterable[str], image_size: tuple[int, int], subject: str = "fiducials"
) -> None:
    """Check that fiducials are those of a scheme and lie on the picture they are used with.

    Parameters
    ----------
    fiducials : Fiducials
        As read.
    scheme_names : iterable of str
        All names of the scheme.
    image_size : (int, int)
        Width and height of the scan's picture.
    subject : str
        The file's name, for the message.

    Raises
    ------
    InputError
        Naming the points that are missing, unknown or outside, or the two image sizes that differ.
    """
    names = list(scheme_names)
    missing = [name for name in names if name not in fiducials.positions]
    if missing:
        raise InputError(subject, f"{_some(missing)} missing", "place them, skip them, or choose the other scheme")
    unknown = [name for name in fiducials.positions if name not in names]
    if unknown:
        raise InputError(subject, f"{_some(unknown)} not in the scheme", "remove them, or choose the other scheme")
    if tuple(fiducials.image_size) != tuple(image_size):
        placed, used = (" x ".join(map(str, size)) for size in (fiducials.image_size, image_size))
        raise InputError(subject, f"image_size is {placed}, the scan's picture {used}", "give the file of this scan")
    width, height = image_size
    outside = [name for name, (x, y) in fiducials.positions.items() if not inside(x, y, width, height)]
    if outside:
        raise InputError(subject, f"{_some(outside)} outside the picture of {width} x {height}", "move them into it")


def _some(names: list[str]) -> str:
    return f"{some(name[:40] for name in names)} {'is' if len(names) == 1 else 'are'}"
