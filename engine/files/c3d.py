"""Markers of optical systems: C3D files, read from checked bytes, and written as 16-bit counts."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np

from engine.errors import InputError, some
from engine.files.atomic import atomic_write
from engine.files.c3d_header import BLOCK, C3DHeader, floats, read_header
from engine.files.marker_table import marker_file
from engine.files.motion_file import MotionFile
from engine.files.source import read_bytes
from engine.mesh import BoolArray, FloatArray
from engine.motion import MarkerClip

_UNITS = {"mm": "mm", "millimeter": "mm", "millimetre": "mm", "cm": "cm", "m": "m", "meter": "m", "metre": "m"}


def read_c3d(
    path: str | Path,
    *,
    unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    fps: float | None = None,
) -> MotionFile:
    """Read the markers of a C3D file; analog channels are passed over.

    A marker is a gap where its residual is negative, where a coordinate is no number, or where it lies exactly at the
    origin, as some systems write what they lost. Integers and floats, Intel, DEC and MIPS order.

    Raises
    ------
    InputError
        On a file that announces more than it holds, a frame rate of 0, double labels, or markers that are never seen.

    References
    ----------
    Motion Lab Systems, The C3D File Format user guide (2021).
    """
    path = Path(path)
    data = read_bytes(path)
    header = read_header(data, str(path))
    positions, origin = _positions(data, header)
    labels, warnings = _labels(header)
    if origin:
        warnings = (*warnings, f"{origin} positions exactly at the origin count as gaps")
    named_unit = _UNITS.get(header.text("POINT", "UNITS").lower().rstrip("s"))
    screen = header.text("POINT", "Y_SCREEN").lower().removeprefix("+")
    return marker_file(
        path,
        "c3d",
        labels,
        positions,
        unit=unit,
        named_unit=named_unit,
        up=up if up is not None or screen not in ("y", "z") else screen,
        forward=forward,
        fps=fps,
        named_fps=header.rate,
        warnings=warnings,
    )


def _positions(data: bytes, header: C3DHeader) -> tuple[FloatArray, int]:
    """Return positions (L, K, 3) with NaN in gaps, and how many lay exactly at the origin."""
    raw = data[header.data : header.data + header.frames * header.frame_bytes]
    if header.scale < 0:
        table = floats(raw, header.processor)
    else:
        table = np.frombuffer(raw, ">i2" if header.processor == "mips" else "<i2")
    rows = table.reshape(header.frames, -1)[:, : 4 * header.points].reshape(header.frames, header.points, 4)
    with np.errstate(invalid="ignore", over="ignore"):
        positions = rows[..., :3].astype(np.float64) * (1.0 if header.scale < 0 else header.scale)
        lost: BoolArray = ~(rows[..., 3] >= 0) | ~(np.abs(positions) < 1e9).all(axis=2)
    origin = ~lost & (positions == 0).all(axis=2)
    positions[lost | origin] = np.nan
    return positions, int(origin.sum())


def _labels(header: C3DHeader) -> tuple[tuple[str, ...], tuple[str, ...]]:
    given = header.texts("POINT", "LABELS")[: header.points]
    missing = [k for k in range(header.points) if k >= len(given) or not given[k]]
    labels = [given[k] if k < len(given) and given[k] else f"point {k + 1}" for k in range(header.points)]
    labels = ["".join(c if c.isprintable() else "?" for c in label) for label in labels]
    warnings: list[str] = []
    if missing:
        warnings.append(f"{len(missing)} markers have no label: {some([labels[k] for k in missing], 3)}")
    subjects = {found[1] if (found := re.match(r"([^:]+):.", label)) else "" for label in labels}
    if len(subjects) == 1 and "" not in subjects:
        labels = [label.partition(":")[2].strip() for label in labels]
    return tuple(labels), tuple(warnings)


def write_c3d(path: str | Path, clip: MarkerClip, *, scale: float | None = None, decimals: bool = False) -> None:
    """Write markers in mm as a C3D file, Intel order; NaN is written as a gap (residual -1).

    Parameters
    ----------
    path : str or Path
        The file to make.
    clip : MarkerClip
        Up to 65,535 frames of up to 255 markers.
    scale : float, optional
        Millimetres of one 16-bit count; the finest that reaches every position where left out.
    decimals : bool
        Whether to store 32-bit floats instead of counts.

    Raises
    ------
    InputError
        When there are too many markers or frames, or ``scale`` does not reach a position.
    """
    frames, count = clip.positions.shape[:2]
    if not 0 < count <= 255 or not 0 < frames <= 65535:
        problem = f"has {count} markers in {frames} frames"
        raise InputError("clip", problem, "a C3D file written here holds 255 markers and 65535 frames")
    largest = float(np.nanmax(np.abs(clip.positions), initial=1.0))
    counts = scale if scale is not None else largest / 32767
    if not counts > 0 or (not decimals and round(largest / counts) > 32767):
        raise InputError("scale", f"{counts:g} mm a count does not reach {largest:.1f} mm", "use a larger one")
    stored = -counts if decimals else counts
    parameters = _parameter_section(clip, stored)
    first_data = 2 + len(parameters) // BLOCK
    head = bytearray(BLOCK)
    struct.pack_into("<BB5H", head, 0, 2, 0x50, count, 0, 1, frames, 0)
    struct.pack_into("<fHHf", head, 12, stored, first_data, 0, clip.fps)
    parameters = parameters.replace(_DATA_START, struct.pack("<H", first_data))
    table = np.zeros((frames, count, 4), "<f4" if decimals else "<i2")
    gap = ~clip.seen
    filled = np.where(gap[..., None], 0.0, clip.positions)
    table[..., :3] = filled if decimals else np.rint(filled / counts)
    table[..., 3][gap] = -1
    body = table.tobytes()
    with atomic_write(path) as handle:
        handle.write(bytes(head) + parameters + body + bytes(-len(body) % BLOCK))


_DATA_START = b"\x01\xfe"


def _parameter_section(clip: MarkerClip, scale: float) -> bytes:
    labels = [label.encode("latin-1", "replace")[:127] for label in clip.labels]
    width = max(len(label) for label in labels)
    words = b"".join(label.ljust(width) for label in labels)
    frames, count = clip.positions.shape[:2]
    body = _record(b"POINT", -1, b"")
    for name, kind, shape, data in (
        (b"USED", 2, (), struct.pack("<H", count)),
        (b"SCALE", 4, (), struct.pack("<f", scale)),
        (b"RATE", 4, (), struct.pack("<f", clip.fps)),
        (b"DATA_START", 2, (), _DATA_START),
        (b"FRAMES", 2, (), struct.pack("<H", frames)),
        (b"UNITS", -1, (2,), b"mm"),
        (b"X_SCREEN", -1, (2,), b"+X"),
        (b"Y_SCREEN", -1, (2,), b"+Y"),
        (b"LABELS", -1, (width, count), words),
        (b"DESCRIPTIONS", -1, (1, count), b" " * count),
    ):
        body += _record(name, 1, struct.pack("<bB", kind, len(shape)) + bytes(shape) + data)
    # Readers look for the analog group even where there is none of it.
    body += _record(b"ANALOG", -2, b"")
    for name, kind, data in (
        (b"USED", 2, struct.pack("<H", 0)),
        (b"RATE", 4, struct.pack("<f", clip.fps)),
        (b"GEN_SCALE", 4, struct.pack("<f", 1.0)),
    ):
        body += _record(name, 2, struct.pack("<bB", kind, 0) + data)
    blocks = -(-(len(body) + 6) // BLOCK)
    return (bytes([1, 0x50, blocks, 84]) + body).ljust(blocks * BLOCK, b"\0")


def _record(name: bytes, group: int, data: bytes) -> bytes:
    step = 2 + len(data) + 1
    return struct.pack("<bb", len(name), group) + name + struct.pack("<h", step) + data + b"\0"
