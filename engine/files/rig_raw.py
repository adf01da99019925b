"""What the readers of rigs have in common: the rig as a file has it, in the file's own unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from engine.errors import InputError
from engine.mesh import FloatArray, IntArray
from engine.scan.range_image import ColourImage

MAX_VALUES = 50_000_000
"""Most numbers of all shapes together: 300 of 55,000 vertices take 400 MB."""

MAX_SHAPES = 5000
"""Most shapes of one rig."""


@dataclass(frozen=True)
class RawRig:
    """A neutral face and its shapes as they stand in a file.

    ``uv`` has its origin at the top left; ``unit`` is the file's own word, ``notes`` what was assumed or left out,
    ``files`` what was read beside the file that the user named.
    """

    vertices: FloatArray
    faces: IntArray
    names: Sequence[str]
    displacements: FloatArray
    mean: FloatArray | None = None
    uv: FloatArray | None = None
    uv_faces: IntArray | None = None
    parts: Mapping[str, IntArray] = field(default_factory=dict)
    texture: ColourImage | None = None
    unit: str | None = None
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()


def check_size(subject: str, shapes: int, vertices: int) -> None:
    """Raise InputError for a rig without shapes, or with more numbers than are read; before they are unpacked."""
    if not shapes:
        raise InputError(subject, "has no shapes", "export it with its morph targets (blend shapes)")
    if shapes > MAX_SHAPES:
        raise InputError(subject, f"has {shapes} shapes, more than {MAX_SHAPES}", "remove those that are not needed")
    if 3 * shapes * vertices > MAX_VALUES:
        problem = f"has {shapes} shapes of {vertices} vertices, more than {MAX_VALUES // 1_000_000} million numbers"
        raise InputError(subject, problem, "export the face alone, or fewer shapes")
