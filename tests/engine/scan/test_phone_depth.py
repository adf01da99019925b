"""A phone's coarse 8-bit disparity: the fit has no hole, and its report does not flatter the scan."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

import resources
from engine.files.depth_json import write_depth_scan
from engine.files.scan import read_scan
from engine.files.template import read_template
from engine.scan.fit import FaceFit, fit_template
from engine.scan.quality import Verdict, measure, verdicts
from engine.scan.range_image import RangeImage
from tests.engine.scan.truth import bundled_scan

TEMPLATE = read_template(resources.template_path())
REAL = Path(__file__).parents[4] / "shared/data/scans/truedepth_frontal/scan.json"
# Clicked by eye on the picture, in its 480 x 640 pixels.
CLICKED = {
    "forehead": (234.5, 188.2), "brow_left_outer": (327.6, 257.2), "brow_left_inner": (248.7, 234.5),
    "brow_right_inner": (211.7, 234.5), "brow_right_outer": (147.7, 243.0), "eye_left_outer": (308.4, 277.1),
    "eye_left_inner": (260.8, 272.9), "eye_right_inner": (206.0, 269.3), "eye_right_outer": (155.5, 275.0),
    "nose_bridge": (232.3, 266.5), "nose_tip": (230.9, 312.7), "nose_left": (261.5, 328.3),
    "nose_right": (201.0, 326.9), "mouth_left": (271.4, 378.8), "mouth_right": (177.6, 379.5),
    "lip_upper": (225.2, 366.0), "lip_lower": (225.2, 387.4), "chin": (223.8, 454.9), "jaw_left": (344.7, 369.6),
    "jaw_right": (127.8, 383.8),
}  # fmt: skip


def honest(fit: FaceFit) -> None:
    assert np.isfinite(fit.mesh.vertices).all()
    assert np.isfinite(fit.normals).all()
    assert not len(fit.folded_faces)
    judged = {check.name: check for check in verdicts(measure(fit))}
    assert judged["scan noise"].verdict in (Verdict.WARN, Verdict.FAIL)
    assert judged["scan noise"].value > 0.25


def test_eight_bits_of_disparity_fit_and_are_called_noisy(tmp_path: Path) -> None:
    """The bundled face as a phone at 330 mm would store it: one step is about a millimetre."""
    scan, places = bundled_scan("base")
    near = RangeImage(scan.points / 2, scan.colour, scan.camera)
    path = tmp_path / "near.json"
    write_depth_scan(path, near)
    depth = -near.points[..., 2]
    low, high = 0.49, 3.4
    stored = np.where(np.isnan(depth), 0, np.rint((1000 / depth - low) / (high - low) * 255))
    cv2.imwrite(str(tmp_path / "disparity.png"), np.clip(np.nan_to_num(stored), 0, 255).astype(np.uint8))
    camera = near.camera
    assert camera is not None
    path.write_text(
        f'{{"disparity": "disparity.png", "disparity_min": {low}, "disparity_max": {high}, '
        f'"fx": {camera.fx}, "fy": {camera.fy}, "cx": {camera.cx}, "cy": {camera.cy}}}'
    )
    fit = fit_template(read_scan(path).scan, places, TEMPLATE)
    honest(fit)
    close = fit_template(near, places, TEMPLATE)
    assert np.median(np.linalg.norm(fit.mesh.vertices - close.mesh.vertices, axis=1)) < 0.6


@pytest.mark.skipif(not REAL.exists(), reason="the folder with real scans is not beside the project")
def test_a_real_phone_scan_fits_and_is_called_noisy() -> None:
    fit = fit_template(read_scan(REAL).scan, CLICKED, TEMPLATE)
    honest(fit)
    size = np.ptp(fit.mesh.vertices, axis=0)
    assert 120 < size[0] < 200, "a face is some 15 cm wide; the wall behind it is not part of it"
    assert size[2] < 200
