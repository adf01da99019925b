"""A small picture that tells a project from others in lists: its scan with the fiducials. No Qt."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.landmarks import LandmarkSet, LandmarkState
from engine.scan.range_image import RangeImage
from studio.project.document import Project

WIDTH, HEIGHT = 192, 144
"""Pixels of a thumbnail."""
LARGEST_BYTES = 256 * 1024
_PNG = b"\x89PNG\r\n\x1a\n"
_GROUND = (0x1E, 0x1F, 0x22)
_SKIN_MARGIN = 0.06
_PLACED, _PROPOSED, _EDGE = (0xE8, 0x91, 0x2D), (0xFF, 0xFF, 0xFF), (0x14, 0x14, 0x16)


def picture_of(project: Project, scan_id: str | None = None) -> bytes | None:
    """Return a PNG (192 x 144) of one scan with its fiducials, the first one when ``scan_id`` is not there.

    Returns
    -------
    bytes or None
        None for a project without scans.
    """
    if not project.scans:
        return None
    item = project.scan(scan_id) if scan_id is not None and scan_id in project else project.scans[0]
    return draw(project.range_image(item.id), item.landmarks)


def draw(scan: RangeImage, landmarks: LandmarkSet) -> bytes:
    """Return a PNG of what the scan has measured, cut out and scaled, with placed points filled and proposed hollow."""
    import cv2

    rows, columns = _box(scan)
    picture = _shown(scan)[rows, columns]
    scale = min(WIDTH / picture.shape[1], HEIGHT / picture.shape[0])
    size = max(1, round(picture.shape[1] * scale)), max(1, round(picture.shape[0] * scale))
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
    canvas = np.full((HEIGHT, WIDTH, 3), _GROUND, np.uint8)
    left, top = (WIDTH - size[0]) // 2, (HEIGHT - size[1]) // 2
    canvas[top : top + size[1], left : left + size[0]] = small
    for point in landmarks.points.values():
        if not point.is_set:
            continue
        x = left + (point.x + 0.5 - columns.start) * scale - 0.5
        y = top + (point.y + 0.5 - rows.start) * scale - 0.5
        at = round(16 * x), round(16 * y)  # four bits behind the point
        placed = point.state == LandmarkState.PLACED
        cv2.circle(canvas, at, 52, _EDGE, -1 if placed else 2, cv2.LINE_AA, 4)
        cv2.circle(canvas, at, 38, _PLACED if placed else _PROPOSED, -1 if placed else 1, cv2.LINE_AA, 4)
    done, data = cv2.imencode(".png", canvas[..., ::-1])
    return data.tobytes() if done else b""


def thumbnail_of(path: Path) -> bytes | None:
    """Return the PNG in a project file, without reading anything else of it; None where there is none.

    Nothing is raised: a file that is absent, damaged, of another kind or of an older version has no picture.
    """
    try:
        if not Path(path).is_file():
            return None
        with closing(sqlite3.connect(f"{Path(path).resolve().as_uri()}?mode=ro&immutable=1", uri=True)) as connection:
            connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_BYTES)
            connection.execute("PRAGMA trusted_schema = OFF")
            kind = connection.execute("SELECT type FROM sqlite_schema WHERE name = 'pictures'").fetchone()
            if kind != ("table",):
                return None
            row = connection.execute(
                "SELECT png FROM pictures WHERE name = 'project' AND typeof(png) = 'blob' AND length(png) <= ?",
                (LARGEST_BYTES,),
            ).fetchone()
    except (sqlite3.Error, OSError, ValueError):
        return None
    return checked(row[0]) if row is not None else None


def checked(data: bytes) -> bytes | None:
    """Return ``data`` where it begins as a PNG of the size of a thumbnail, else None."""
    head = _PNG + (13).to_bytes(4, "big") + b"IHDR" + WIDTH.to_bytes(4, "big") + HEIGHT.to_bytes(4, "big")
    return data if len(data) <= LARGEST_BYTES and data.startswith(head) else None


def write_picture(connection: sqlite3.Connection, png: bytes) -> None:
    """Store the picture of a project in its open database."""
    connection.execute("INSERT OR REPLACE INTO pictures VALUES ('project', ?)", (png,))


def _shown(scan: RangeImage) -> NDArray[np.uint8]:
    """Return the colour picture, or the depth in grey, near ones light."""
    if scan.colour is not None:
        return np.ascontiguousarray(scan.colour)
    depth = -scan.points[..., 2]
    known = np.isfinite(depth)
    near, far = np.percentile(depth[known], (2, 98))
    share = np.clip((far - depth) / max(float(far - near), 1e-9), 0.0, 1.0)
    grey = np.where(known, 60.0 + 180.0 * np.nan_to_num(share), float(_GROUND[0]))
    return np.repeat(grey.astype(np.uint8)[..., None], 3, axis=-1)


def _box(scan: RangeImage) -> tuple[slice, slice]:
    """Return rows and columns of what was measured, with a margin."""
    known: NDArray[np.bool_] = np.isfinite(scan.points[..., 2])

    def span(found: NDArray[Any]) -> slice:
        places = np.flatnonzero(found)
        margin = round(_SKIN_MARGIN * (places[-1] - places[0] + 1)) + 1
        return slice(max(0, int(places[0]) - margin), min(len(found), int(places[-1]) + margin + 1))

    return span(np.any(known, axis=1)), span(np.any(known, axis=0))
