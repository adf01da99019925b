"""Files as other programs write them, made point by point from a scan whose every number is known."""

from __future__ import annotations

import gzip
import struct
from collections.abc import Sequence

import numpy as np

from engine.scan.range_image import RangeImage

OPTICAL = np.array([1.0, -1.0, -1.0])
"""Our axes in a sensor's frame: +Y down, +Z away from it."""


def lzf_pack(data: bytes, longest: int = 264) -> bytes:
    """Pack with LZF the slow way: the last place of every three bytes is remembered."""
    out, literals, seen = bytearray(), bytearray(), {}
    place = 0

    def flush() -> None:
        for start in range(0, len(literals), 32):
            piece = literals[start : start + 32]
            out.append(len(piece) - 1)
            out.extend(piece)
        literals.clear()

    while place < len(data):
        key = data[place : place + 3]
        before = seen.get(key, -1) if len(key) == 3 else -1
        seen[key] = place
        if before >= 0 and place - before <= 8192:
            size = 3
            while size < longest and place + size < len(data) and data[before + size] == data[place + size]:
                size += 1
            flush()
            back = place - before - 1
            if size < 9:
                out.append((size - 2) << 5 | back >> 8)
            else:
                out.extend((7 << 5 | back >> 8, size - 9))
            out.append(back & 255)
            place += size
        else:
            literals.append(data[place])
            place += 1
    flush()
    return bytes(out)


def pcd_bytes(
    scan: RangeImage,
    data: str = "binary",
    factor: float = 1e-3,
    colour: str = "rgb F4",
    kind: str = "F4",
    axes: Sequence[float] = OPTICAL,
    before: Sequence[tuple[str, str, int]] = (),
    viewpoint: str = "0 0 0 1 0 0 0",
    holes: bool = True,
    version: str = "0.7",
) -> bytes:
    """A PCD file. ``colour`` is ``''``, ``rgb F4``, ``rgba U4``, ``rgb U1`` or ``rgb F4 channels``.

    ``before`` are other fields (name, type, count) that stand before x; without ``holes`` the valid points are
    written as one row.
    """
    points = (scan.points * axes * factor).reshape(-1, 3)
    shades = None if scan.colour is None else scan.colour.reshape(-1, 3).astype(np.uint32)
    fields = [*before, *((axis, kind, 1) for axis in "xyz")]
    columns = [np.full((len(points), count), 7, _dtype(type_)) for _, type_, count in before]
    columns += [points[:, [axis]].astype(_dtype(kind)) for axis in range(3)]
    if colour and shades is not None:
        packed = shades[:, 0] << 16 | shades[:, 1] << 8 | shades[:, 2]
        if colour == "rgb F4":
            fields.append(("rgb", "F4", 1))
            columns.append(packed.astype("<u4").view("<f4")[:, None])
        elif colour == "rgba U4":
            fields.append(("rgba", "U4", 1))
            columns.append((packed | 255 << 24).astype("<u4")[:, None])
        elif colour == "rgb U1":
            fields += [(name, "U1", 1) for name in "rgb"]
            columns += [shades[:, [axis]].astype("u1") for axis in range(3)]
        else:
            fields += [(name, "F4", 1) for name in "rgb"]
            columns += [(shades[:, [axis]] / 255.0).astype("<f4") for axis in range(3)]
    width, height = scan.width, scan.height
    if not holes:
        kept = np.isfinite(points).all(axis=1)
        columns, width, height = [column[kept] for column in columns], int(kept.sum()), 1
    lines = ["# .PCD v0.7 - Point Cloud Data file format", f"VERSION {version}"]
    lines += [
        "FIELDS " + " ".join(name for name, _, _ in fields),
        "SIZE " + " ".join(type_[1] for _, type_, _ in fields),
    ]
    lines += ["TYPE " + " ".join(type_[0] for _, type_, _ in fields), "COUNT " + " ".join(str(n) for _, _, n in fields)]
    lines += [
        f"WIDTH {width}",
        f"HEIGHT {height}",
        f"VIEWPOINT {viewpoint}",
        f"POINTS {width * height}",
        f"DATA {data}",
    ]
    return ("\n".join(lines) + "\n").encode() + _pcd_body(data, columns)


def _dtype(kind: str) -> str:
    return "<" + kind[0].lower() + kind[1]


def _pcd_body(data: str, columns: list[np.ndarray]) -> bytes:
    if data == "binary_compressed":
        body = b"".join(column.tobytes() for column in columns)
        packed = lzf_pack(body)
        return struct.pack("<II", len(packed), len(body)) + packed
    rows = range(len(columns[0]))
    if data == "binary":
        return b"".join(column[row].tobytes() for row in rows for column in columns)
    return "".join(" ".join(str(value) for column in columns for value in column[row]) + "\n" for row in rows).encode()


def abs_bytes(scan: RangeImage, digits: int = 6, packed: bool = False, factor: float = 1.0) -> bytes:
    """An ``.abs`` file: flags, X, Y, Z of all pixels, -999999 where there is none."""
    flags = scan.valid.ravel()
    points = np.where(flags[:, None], scan.points.reshape(-1, 3) * factor, -999999.0)
    lines = [f"{scan.height} rows", f"{scan.width} columns", "pixels (flag X Y Z):"]
    lines.append(" ".join(str(int(flag)) for flag in flags))
    lines += [" ".join(f"{value:.{digits}f}" for value in points[:, axis]) for axis in range(3)]
    data = ("\n".join(lines) + "\n").encode()
    return gzip.compress(data, 1) if packed else data


def xyz_bytes(
    scan: RangeImage,
    digits: int = 3,
    separator: str = " ",
    colour: str = "bytes",
    axes: Sequence[float] = (1.0, 1.0, 1.0),
    factor: float = 1.0,
    order: str = "rows",
    heading: str = "",
) -> bytes:
    """Point text with the holes left out; ``order``: ``rows``, ``columns`` or ``shuffled``."""
    points, shades = scan.points * axes * factor, scan.colour
    if order == "columns":
        points = points.transpose(1, 0, 2)
        shades = None if shades is None else shades.transpose(1, 0, 2)
    valid = np.isfinite(points).all(axis=2)
    kept = points[valid]
    tints = None if shades is None or not colour else shades[valid]
    rank = np.random.default_rng(3).permutation(len(kept)) if order == "shuffled" else range(len(kept))
    lines = []
    for row in rank:
        words = [f"{value:.{digits}f}" for value in kept[row]]
        if tints is not None:
            words += [str(int(v)) if colour == "bytes" else f"{v / 255:.4f}" for v in tints[row]]
        lines.append(separator.join(words))
    return (heading + "\n".join(lines) + "\n").encode()
