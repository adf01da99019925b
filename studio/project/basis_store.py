"""Rigs and performances to and from the project file: small values in its header, arrays by content key. No Qt."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from studio.project import basis_header as b
from studio.project.arrays import read_array
from studio.project.basis_items import RigContent, motion_key
from studio.project.basis_state import BasisState

if TYPE_CHECKING:
    from studio.project.basis_items import MotionData

Keep = Callable[[NDArray[Any]], str]
"""Stores an array and returns its key."""


def contents_of(state: BasisState, keep: Keep) -> b.ContentsHeader | None:
    """Return what the items of a project stand for, its arrays given to ``keep``; None where there is nothing."""
    rigs: dict[str, b.RigDataHeader] = {}
    for item in state.rigs:
        content = state.rig_content(item.content)
        if content is not None:
            rigs[item.content] = _rig_header(content, keep)
    motions: dict[str, b.MotionDataHeader] = {}
    for motion in state.motions:
        data = state.motion_data(motion.content)
        if data is not None and motion.link is None:
            motions[motion.content] = _motion_header(data, keep)
    return b.ContentsHeader(rigs=rigs, motions=motions) if rigs or motions else None


def read_contents(
    state: BasisState, header: b.ContentsHeader | None, connection: sqlite3.Connection, subject: str
) -> None:
    """Read what the items of a project stand for; what was stored of it must be whole.

    An item that was saved while its content was lost, as after a crash, has no entry: it stays one that lacks it.

    Raises
    ------
    InputError
        Naming the item.
    """
    for text, stored, read in readings(state, header, connection, subject):
        if not stored:
            continue
        try:
            read()
        except InputError as error:
            raise InputError(text, f"{error.subject} {error.problem}".strip(), error.remedy) from None


def readings(
    state: BasisState, header: b.ContentsHeader | None, connection: sqlite3.Connection, subject: str
) -> list[tuple[str, bool, Callable[[], None]]]:
    """Return, for every item whose content belongs in the file, its words, whether it is there, and what reads it."""
    known = header or b.ContentsHeader()
    found: list[tuple[str, bool, Callable[[], None]]] = []
    for rig in state.rigs:
        entry = known.rigs.get(rig.content)
        text = f"{subject}, rig {rig.name[:40]!r}"
        found.append((text, entry is not None, _rig_reading(state, rig.content, entry, connection)))
    for item in state.motions:
        if item.link is None:
            data = known.motions.get(item.content)
            text = f"{subject}, performance {item.name[:40]!r}"
            found.append((text, data is not None, _motion_reading(state, item.content, data, connection)))
    return found


def _rig_reading(
    state: BasisState, key: str, entry: b.RigDataHeader | None, connection: sqlite3.Connection
) -> Callable[[], None]:
    def read() -> None:
        if entry is None:
            raise _absent()
        content = read_rig_data(entry, connection)
        if content.key != key:
            raise InputError("shapes", "are not those that were stored", "open an older copy of the project")
        state.keep_rig(content, key)

    return read


def _motion_reading(
    state: BasisState, key: str, entry: b.MotionDataHeader | None, connection: sqlite3.Connection
) -> Callable[[], None]:
    def read() -> None:
        if entry is None:
            raise _absent()
        data = read_motion_data(entry, connection)
        if motion_key(data) != key:
            raise InputError("motion", "is not the one that was stored", "open an older copy of the project")
        state.keep_motion(key, data)

    return read


def _absent() -> InputError:
    return InputError("content", "is not in it", "open an older copy of the project")


def read_rig_data(entry: b.RigDataHeader, connection: sqlite3.Connection) -> RigContent:
    """Return the rig of a header.

    Raises
    ------
    InputError
        When an array is absent, damaged or of another form, or they make no rig.
    """
    from engine.mesh import TriangleMesh
    from engine.shapes import ExpressionBasis, Rig

    def array(key: str | None, dtype: str, *shape: int | None) -> NDArray[Any] | None:
        return None if key is None else _array(connection, key, dtype, shape)

    vertices = _array(connection, entry.vertices, "<f8", (None, 3))
    count = len(vertices)
    parts = {name: _array(connection, key, "<i8", (None,)) for name, key in entry.parts.items()}
    faces = _array(connection, entry.faces, "<i8", (None, 3))
    mesh = TriangleMesh(
        vertices, faces, array(entry.uv, "<f8", None, 2), array(entry.uv_faces, "<i8", len(faces), 3), parts
    )
    shapes = _array(connection, entry.displacements, "<f8", (len(entry.names), count, 3))
    basis = ExpressionBasis(vertices, tuple(entry.names), shapes, array(entry.mean, "<f8", count, 3))
    return RigContent(Rig(mesh, basis), array(entry.texture, "|u1", None, None, 3))


def read_motion_data(entry: b.MotionDataHeader, connection: sqlite3.Connection) -> MotionData:
    """Return the performance of a header.

    Raises
    ------
    InputError
        When an array is absent, damaged or of another form, or they make no performance.
    """
    from engine.files.motion_file import DenseClip
    from engine.motion import MarkerClip, WeightCurves

    names = tuple(entry.names)
    if entry.kind == "markers":
        return MarkerClip(names, _array(connection, entry.values, "<f8", (None, len(names), 3)), entry.fps)
    if entry.kind == "weights":
        return WeightCurves(names, _array(connection, entry.values, "<f8", (None, len(names))), entry.fps)
    axes = None if entry.axes is None else _array(connection, entry.axes, "<f8", (3, 3))
    return DenseClip(_array(connection, entry.values, "<f8 <f4", (None, None, 3)), entry.fps, entry.scale, axes)


def _rig_header(content: RigContent, keep: Keep) -> b.RigDataHeader:
    mesh, basis = content.rig.mesh, content.rig.basis
    return b.RigDataHeader(
        vertices=keep(mesh.vertices),
        faces=keep(mesh.faces),
        uv=None if mesh.uv is None else keep(mesh.uv),
        uv_faces=None if mesh.uv_faces is None else keep(mesh.uv_faces),
        parts={name: keep(part) for name, part in mesh.parts.items()},
        names=list(basis.names),
        displacements=keep(basis.displacements),
        mean=None if basis.mean is None else keep(basis.mean),
        texture=None if content.texture is None else keep(content.texture),
    )


def _motion_header(data: MotionData, keep: Keep) -> b.MotionDataHeader:
    from engine.motion import MarkerClip, WeightCurves

    if isinstance(data, MarkerClip):
        return b.MotionDataHeader(kind="markers", names=list(data.labels), fps=data.fps, values=keep(data.positions))
    if isinstance(data, WeightCurves):
        return b.MotionDataHeader(kind="weights", names=list(data.names), fps=data.fps, values=keep(data.weights))
    axes = None if data.axes is None else keep(np.asarray(data.axes, dtype=np.float64))
    return b.MotionDataHeader(kind="dense", fps=data.fps, values=keep(data.vertices), scale=data.scale, axes=axes)


def _array(connection: sqlite3.Connection, key: str, dtypes: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
    array = read_array(connection, key, "content")
    fits = array.ndim == len(shape) and all(n is None or n == m for n, m in zip(shape, array.shape, strict=False))
    if array.dtype.str not in dtypes.split() or not fits:
        raise InputError("content", f"array {key[:12]} is {array.dtype} {array.shape}", "open an older copy")
    return array
