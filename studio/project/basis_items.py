"""What the basis stage adds to a project: rigs, performances, and the setup of the basis made of them. No Qt.

The values are small and frozen; meshes, shapes and motion stay beside them in `basis_state.BasisState`, by content key.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

from engine.errors import InputError
from studio.basis.options import BasisOptions, MotionOptions
from studio.project.keys import array_key
from studio.project.linked import LinkedFile

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.files.motion_file import DenseClip
    from engine.motion import MarkerClip, WeightCurves
    from engine.shape_edits import ShapeEdit
    from engine.shapes import Rig

    MotionData = MarkerClip | WeightCurves | DenseClip

MotionKind = Literal["markers", "weights", "dense"]
WHOLE = 1.0
"""The amount of a shape that is its quasi-eigen shape altogether; 0 is the hand-sculpted one."""
MOST_ITEMS, MOST_EDITS = 200, 2_000


@dataclass(frozen=True)
class RigContent:
    """A rig as it was read, mm, with its texture (H, W, 3) uint8 where there is one; kept by its content key."""

    rig: Rig
    texture: NDArray[np.uint8] | None = None

    @property
    def key(self) -> str:
        """SHA-256 of mesh, parts, names, shapes, mean and texture, in hex."""
        mesh, basis = self.rig.mesh, self.rig.basis
        arrays: dict[str, NDArray[Any] | None] = {
            "vertices": mesh.vertices,
            "faces": mesh.faces,
            "uv": mesh.uv,
            "uv_faces": mesh.uv_faces,
        }
        arrays |= {"displacements": basis.displacements, "mean": basis.mean, "texture": self.texture}
        arrays |= {f"part {name}": part for name, part in mesh.parts.items()}
        return _key("rig", basis.names, arrays)


@dataclass(frozen=True)
class RigItem:
    """A rig of a project; a change makes a new item.

    Attributes
    ----------
    id, name : str
        The name is its own among the rigs.
    content : str
        Key of its `RigContent` as it was read.
    source, unit, assumed, format : str
        The path it was read from, its unit, what the reader assumed, and the kind of file.
    edits : tuple of ShapeEdit
        What was done to its shapes since, in order.
    """

    id: str
    name: str
    content: str
    source: str = ""
    unit: str = "mm"
    assumed: str = ""
    format: str = ""
    edits: tuple[ShapeEdit, ...] = ()


@dataclass(frozen=True)
class MotionItem:
    """A performance of a project; a change makes a new item.

    Attributes
    ----------
    id, name : str
        The name is its own among the performances.
    kind : {"markers", "weights", "dense"}
        What was recorded.
    content : str
        Key of its data; for a linked one, the digest of the link and of how it is read.
    source, unit, assumed : str
        The path it was read from, its unit, and what the reader assumed.
    frames, count : int
        How many frames there are, and how many markers, curves or vertices.
    fps : float
        Frames a second.
    options : MotionOptions
        What the user said about unit, axes, rate, head markers and pairs.
    link : LinkedFile, optional
        The file that is read when the project is opened; None where the data are in the project.
    """

    id: str
    name: str
    kind: MotionKind
    content: str
    source: str = ""
    unit: str = "mm"
    assumed: str = ""
    frames: int = 0
    count: int = 0
    fps: float = 0.0
    options: MotionOptions = field(default_factory=lambda: MotionOptions())
    link: LinkedFile | None = None


@dataclass(frozen=True)
class BasisSetup:
    """Which rig is the hand-sculpted basis, which performance it is measured by, and how.

    Attributes
    ----------
    hand, motion, driver : str, optional
        Ids of the rig, the performance, and the rig that weight curves drive (None: the hand-sculpted one).
    options : BasisOptions
        Coverage, training range, bounds.
    amounts : mapping of str to float
        By shape how much of it is quasi-eigen, 0 to 1; shapes that are not named are so altogether.
    """

    hand: str | None = None
    motion: str | None = None
    driver: str | None = None
    options: BasisOptions = field(default_factory=lambda: BasisOptions())
    amounts: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kept = {name: float(value) for name, value in self.amounts.items() if value != WHOLE}
        for name, value in kept.items():
            check_amount(name, value)
        object.__setattr__(self, "amounts", MappingProxyType(kept))

    def amount(self, name: str) -> float:
        """Return how much of a shape is quasi-eigen, 0 to 1."""
        return self.amounts.get(name, WHOLE)


def check_amount(name: str, value: float) -> None:
    """Raise InputError unless ``value`` is between hand (0) and quasi-eigen (1)."""
    if not 0.0 <= value <= 1.0:
        raise InputError(f"amount of {name}", f"is {value:g}", "choose 0 (hand) to 1 (quasi-eigen)")


def motion_key(data: MotionData) -> str:
    """Return the content key of marker positions, weight curves, or dense positions that are held in memory."""
    from engine.motion import MarkerClip, WeightCurves

    if isinstance(data, MarkerClip):
        return _key(f"markers {float(data.fps).hex()}", data.labels, {"positions": data.positions})
    if isinstance(data, WeightCurves):
        return _key(f"weights {float(data.fps).hex()}", data.names, {"weights": data.weights})
    kind = f"dense {float(data.fps).hex()} {float(data.scale).hex()}"
    return _key(kind, (), {"vertices": data.vertices, "axes": data.axes})


def motion_bytes(data: MotionData) -> int:
    """Return how much room the data of a performance take, bytes."""
    from engine.motion import MarkerClip, WeightCurves

    if isinstance(data, MarkerClip):
        return int(data.positions.nbytes)
    return int(data.weights.nbytes if isinstance(data, WeightCurves) else data.vertices.nbytes)


def link_key(link: LinkedFile, options: MotionOptions) -> str:
    """Return the key that stands for a linked file as it is read with these options."""
    read = repr((options.unit, options.up, options.forward, options.fps))
    return hashlib.sha256(f"link {link.digest} {read}".encode()).hexdigest()


def _key(kind: str, names: tuple[str, ...], arrays: Mapping[str, NDArray[Any] | None]) -> str:
    digest = hashlib.sha256(repr((kind, names)).encode())
    for name, array in arrays.items():
        digest.update(f"|{name!r}:{'' if array is None else array_key(array)}".encode())
    return digest.hexdigest()
