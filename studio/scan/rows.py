"""How scans are listed: thumbnail, state in two or three words, how many fiducials. No Qt widgets are touched."""

from __future__ import annotations

import numpy as np

from engine.landmarks import LandmarkState
from engine.scan.range_image import ColourImage, RangeImage
from studio.project.document import Project, ScanItem
from studio.scan.job import item_scheme, missing_fiducials
from widgets.canvases.pictures import depth_picture, depth_window
from widgets.scan.scan_list import ScanRow

THUMBNAIL_WIDTH = 160


class Thumbnails:
    """Small pictures of range images by content key, made once."""

    def __init__(self) -> None:
        self._pictures: dict[str, ColourImage] = {}

    def get(self, image_key: str, scan: RangeImage) -> ColourImage:
        """Return the middle of what was measured, about 160 pixels wide and 4 : 3."""
        if image_key not in self._pictures:
            self._pictures[image_key] = _thumbnail(scan)
        return self._pictures[image_key]


def _thumbnail(scan: RangeImage) -> ColourImage:
    picture = scan.colour
    if picture is None:
        depth = -scan.points[..., 2]
        picture = depth_picture(depth, *depth_window(depth))
    rows, columns = np.flatnonzero(scan.valid.any(axis=1)), np.flatnonzero(scan.valid.any(axis=0))
    middle_x, middle_y = (columns[0] + columns[-1]) / 2, (rows[0] + rows[-1]) / 2
    half = max(8.0, 0.5 * min(columns[-1] - columns[0], (rows[-1] - rows[0]) * 4 / 3))
    left, right = int(max(middle_x - half, 0)), int(min(middle_x + half, scan.width))
    top, bottom = int(max(middle_y - 0.75 * half, 0)), int(min(middle_y + 0.75 * half, scan.height))
    step = max(1, (right - left) // THUMBNAIL_WIDTH)
    return np.ascontiguousarray(picture[top:bottom:step, left:right:step])


def scan_row(project: Project, item: ScanItem, thumbnails: Thumbnails, verdict: str = "") -> ScanRow:
    """Return what the list says about a scan; ``verdict`` names what is beyond its limits."""
    scheme = item_scheme(item)
    state = project.state(item.id)
    unset, proposed = missing_fiducials(item.landmarks, scheme)
    if state.kind == "fresh":
        note = verdict or "fit fresh"
    elif state.kind == "stale":
        note = state.reason
    elif unset:
        note = f"{len(unset)} to place"
    elif proposed:
        note = f"{len(proposed)} proposed"
    else:
        note = state.reason
    kind = "stale" if state.kind == "missing" and proposed and not unset else state.kind
    decided = item.landmarks.names(LandmarkState.PLACED, order=scheme.names)
    return ScanRow(
        item.id,
        item.name,
        note,
        item.held,
        len(decided),
        len(scheme),
        kind,
        thumbnails.get(item.image_key, project.range_image(item.id)),
    )
