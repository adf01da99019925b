"""Range images that are gone: found again where they were read from, or an empty one that fiducials stay on. No Qt."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.landmarks import LandmarkSet
from engine.scan.range_image import RangeImage
from studio.project.document import ScanItem, content_key

_LARGEST = 8_000


def from_source(item: ScanItem) -> RangeImage | None:
    """Return the range image of a scan from the file it was read from, if that still has exactly this content."""
    from engine.files.scan import read_scan

    source = item.source
    if not source.depth_file:
        return None
    try:
        image = read_scan(Path(source.depth_file), source.unit if source.unit_asked else None, source.view).scan
    except (InputError, OSError, ValueError):  # gone, or of a name that this machine does not take
        return None
    return image if content_key(image) == item.image_key else None


def placeholder(item: ScanItem) -> RangeImage:
    """Return a range image of the scan's size that is empty but for one pixel in the corner, which it must have."""
    width, height = _size(item.source.width, item.source.height, item.landmarks)
    points = np.full((height, width, 3), np.nan)
    points[0, 0] = (0.0, 0.0, -1.0)
    return RangeImage(points, None, None)


def _size(width: int, height: int, landmarks: LandmarkSet) -> tuple[int, int]:
    """Return a size in which all fiducials lie, also where the one that was noted is no size of a picture."""
    places = [(point.x, point.y) for point in landmarks.points.values() if point.is_set]
    needed = [max((int(place[axis] + 0.5) + 1 for place in places), default=2) for axis in (0, 1)]
    return tuple(min(max(noted, least, 2), _LARGEST) for noted, least in zip((width, height), needed, strict=True))  # type: ignore[return-value]
