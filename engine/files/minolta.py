"""Range images of Minolta-style scanners as text: ``.abs``, also packed as ``.abs.gz``."""

from __future__ import annotations

import gzip
import zlib
from pathlib import Path
from typing import IO, cast

import numpy as np

from engine.errors import InputError
from engine.files.images import image_size, read_image
from engine.files.scan_file import MM_PER_UNIT, ScanFile, choose_unit, make_scan
from engine.files.scanner_frame import face_scanner
from engine.files.source import check_pixels, checked_file
from engine.files.text_numbers import read_numbers
from engine.scan.range_image import ColourImage

_PICTURES = (".ppm", ".png", ".jpg", ".jpeg")
_MAX_LINE = 256
_GZIP = b"\x1f\x8b"


def read_minolta(path: str | Path, unit: str | None = None) -> ScanFile:
    """Read a scan from ``.abs`` text, plain or packed with gzip.

    Three lines, ``<n> rows``, ``<m> columns`` and ``pixels (flag X Y Z):``, are followed by one line each of flags,
    X, Y and Z for all pixels, row by row. A pixel is missing where its flag is 0. A picture of the same name beside
    the file (.ppm, .png, .jpg) gives the colours when it has the same size.

    Raises
    ------
    InputError
        On another header, more or fewer numbers than announced, damaged packing, or no valid pixel.
    """
    path = checked_file(path)
    subject = str(path)
    with path.open("rb") as raw:
        is_packed = raw.read(2) == _GZIP
    try:
        with _opened(path, is_packed) as handle:
            height, width = _header(handle, subject)
            pixels = height * width
            # Deflate makes at most 1032 bytes of one.
            if 8 * pixels - 1 > path.stat().st_size * (1032 if is_packed else 1):
                raise InputError(
                    subject, f"is cut off: there is no room for {width} x {height} pixels", "copy it again"
                )
            numbers = read_numbers(handle, subject, 4 * pixels)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(subject, "is damaged or cut off: it cannot be unpacked", "copy it again") from error
    flags, axes = numbers[:pixels], numbers[pixels:].reshape(3, pixels)
    points = np.ascontiguousarray(axes.T)
    odd = int(((flags != 0) & (flags != 1)).sum())
    broken = (flags != 0) & ~np.isfinite(points).all(axis=1)
    points[(flags == 0) | broken] = np.nan
    del numbers, axes
    if np.isnan(points).all():
        raise InputError(subject, "has no valid pixel (every flag is 0)", "check that the scan succeeded")
    unit, assumed, warnings = choose_unit(unit, None, subject)
    points *= MM_PER_UNIT[unit]
    if odd:
        warnings += (f"{odd} flags are neither 0 nor 1: taken as measured",)
    if broken.any():
        warnings += (f"{int(broken.sum())} measured points are no numbers: taken as missing",)
    picture, colour, note = _picture_beside(path, width, height)
    facing = face_scanner(points.reshape(height, width, 3), colour)
    scan, more = make_scan(subject, facing.points, facing.colour, facing.camera, unit)
    sources = (path,) if picture is None else (path, picture)
    return ScanFile(
        scan, unit, "; ".join((assumed, *facing.said)), sources, "abs", warnings + note + facing.warnings + more
    )


def _opened(path: Path, is_packed: bool) -> IO[bytes]:
    return cast("IO[bytes]", gzip.open(path)) if is_packed else path.open("rb")


def _header(handle: IO[bytes], subject: str) -> tuple[int, int]:
    sizes = []
    for word in ("rows", "columns"):
        parts = handle.readline(_MAX_LINE).split()
        if len(parts) != 2 or parts[1] != word.encode() or not parts[0].isdigit() or len(parts[0]) > 18:
            shown = b" ".join(parts).decode("latin-1")[:60]
            raise InputError(subject, f"its header has {shown!r} where '<n> {word}' belongs", "export it again")
        sizes.append(int(parts[0]))
    line = handle.readline(_MAX_LINE)
    if line.split() != b"pixels (flag X Y Z):".split():
        problem = f"its header has {line.strip().decode('latin-1')[:60]!r} where 'pixels (flag X Y Z):' belongs"
        raise InputError(subject, problem, "export it again")
    check_pixels(subject, sizes[1], sizes[0])
    return sizes[0], sizes[1]


def _picture_beside(path: Path, width: int, height: int) -> tuple[Path | None, ColourImage | None, tuple[str, ...]]:
    stem = path.name[: -len(path.suffix)] if path.suffix.lower() != ".gz" else path.name[:-3]
    stem = stem[:-4] if stem.lower().endswith(".abs") else stem
    notes: tuple[str, ...] = ()
    for ending in _PICTURES:
        picture = path.with_name(stem + ending)
        if not picture.is_file():
            continue
        try:
            size = image_size(picture)
            if size == (width, height):
                return picture, read_image(picture), notes
            notes += (f"the picture {picture.name} beside it has {size[0]} x {size[1]} pixels: left out",)
        except InputError as error:
            notes += (f"the picture {picture.name} beside it {error.problem}: left out",)
    return None, None, notes
