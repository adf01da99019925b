"""Markers of optical systems: C3D files, read from checked bytes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.errors import some
from engine.files.c3d_header import C3DHeader, floats, read_header
from engine.files.marker_table import marker_file
from engine.files.motion_file import MotionFile
from engine.files.motion_text import length_unit
from engine.files.source import read_bytes
from engine.mesh import BoolArray, FloatArray


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
    named_unit = length_unit(header.text("POINT", "UNITS"))
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
    return tuple(labels), tuple(warnings)
