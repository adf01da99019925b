"""The same face comes out of a bundled scan in every format."""

from __future__ import annotations

import numpy as np
import pytest

import resources
from engine.files.landmarks_json import read_fiducials
from engine.files.scan import read_scan
from engine.files.template import read_template
from engine.scan.fit import fit_template
from engine.scan.range_image import Camera, RangeImage
from tests.engine.files.foreign import OPTICAL, abs_bytes, pcd_bytes, xyz_bytes
from tests.engine.files.planted import write

WRITERS = {
    "ascii.pcd": lambda scan: pcd_bytes(scan, "ascii", kind="F8"),
    "binary.pcd": lambda scan: pcd_bytes(scan, "binary"),
    "packed.pcd": lambda scan: pcd_bytes(scan, "binary_compressed"),
    "plain.abs": lambda scan: abs_bytes(scan, 4),
    "packed.abs.gz": lambda scan: abs_bytes(scan, 4, packed=True),
    "points.xyz": lambda scan: xyz_bytes(scan, 4),
    "optical.txt": lambda scan: xyz_bytes(scan, 4, ",", axes=OPTICAL),
}
ROUNDING_MM = 1e-4
"""Four digits in millimetres, or 4-byte floats of metres."""


@pytest.fixture(scope="module")
def sample():
    """A bundled scan at half its resolution, its fiducials, and the face that it gives."""
    path = resources.sample_path("subject", "base.json")
    whole = read_scan(path).scan
    camera = Camera(*(value / 2 for value in (whole.camera.fx, whole.camera.fy, whole.camera.cx, whole.camera.cy)))
    scan = RangeImage(whole.points[::2, ::2], whole.colour[::2, ::2], camera)
    placed = read_fiducials(path.with_name("base_fiducials.json")).positions
    fiducials = {name: (x / 2, y / 2) for name, (x, y) in placed.items()}
    return scan, fiducials, fitted(scan, fiducials)


def fitted(scan, fiducials):
    """The face's vertices, in mm."""
    return fit_template(scan, fiducials, read_template(resources.template_path()), levels=1).mesh.vertices


@pytest.mark.parametrize("name", WRITERS)
def test_the_same_face_from_every_format(tmp_path, sample, name):
    scan, fiducials, expected = sample
    found = read_scan(write(tmp_path / name, WRITERS[name](scan)))
    shift = np.zeros(2)
    if found.scan.points.shape != scan.points.shape:  # holes at the border are no pixels of a list of points
        shift = np.argwhere(scan.valid).min(axis=0)[::-1].astype(float)
        assert found.scan.camera.cx == pytest.approx(scan.camera.cx - shift[0], abs=1e-3)
    placed = {name: tuple(np.subtract(place, shift)) for name, place in fiducials.items()}
    distance = np.linalg.norm(fitted(found.scan, placed) - expected, axis=1)
    assert np.median(distance) < ROUNDING_MM
    assert distance.max() < 50 * ROUNDING_MM
    assert found.warnings == ()
