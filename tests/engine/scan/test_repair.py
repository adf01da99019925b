from __future__ import annotations

import numpy as np
import pytest

from engine.errors import InputError
from engine.scan.range_image import Camera, RangeImage
from engine.scan.rays import Rays
from engine.scan.repair import RepairOptions, fill_gaps, find_spikes, remove_spikes, repair, smooth_depth

CAMERA = Camera(1200.0, 1190.0, 99.5, 79.5)
HEIGHT, WIDTH = 160, 200


def dome(noise: float = 0.0, seed: int = 0) -> np.ndarray:
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    depth = 650 - 60 * np.sqrt(1 - ((x - 100) / 160) ** 2 - ((y - 80) / 140) ** 2)
    return depth + np.random.default_rng(seed).normal(0, noise, depth.shape) if noise else depth


def scan_of(depth: np.ndarray, camera: Camera | None = CAMERA) -> RangeImage:
    return RangeImage(CAMERA.points(depth), camera=camera)


def test_planted_spikes_are_found_and_nothing_else() -> None:
    depth, rng = dome(0.15), np.random.default_rng(4)
    planted = rng.random(depth.shape) < 0.003
    depth[planted] += rng.choice([-1, 1], planted.sum()) * rng.uniform(4, 30, planted.sum())
    found = find_spikes(scan_of(depth))
    assert (found & planted).sum() >= 0.98 * planted.sum()
    assert (found & ~planted).sum() <= 1


def test_steps_slopes_and_thin_ridges_are_no_spikes() -> None:
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    step = np.where(x > 100, 650.0, 640.0) + 0.0 * y
    slope = 600 + 2.2 * x + 0.0 * y
    ridge = 650 - 12.0 * (abs(x - 100) <= 1) + 0.0 * y
    for depth in (step, slope, ridge):
        assert not find_spikes(scan_of(depth)).any()


def test_removed_spikes_are_missing_and_all_spikes_is_an_error() -> None:
    depth = dome()
    depth[40, 50] -= 9
    clean, mask = remove_spikes(scan_of(depth))
    assert mask.sum() == 1
    assert mask[40, 50]
    assert np.isnan(clean.points[40, 50]).all()
    assert clean.valid.sum() == HEIGHT * WIDTH - 1
    with pytest.raises(InputError, match="stands alone"):
        remove_spikes(scan_of(np.random.default_rng(0).uniform(1, 1e6, (20, 20))))


@pytest.mark.parametrize("camera", [CAMERA, None])
def test_small_gaps_get_the_surface_back_with_their_own_rays(camera: Camera | None) -> None:
    depth = dome()
    gap = np.zeros(depth.shape, dtype=bool)
    gap[60:67, 30:37] = gap[100:104, 80:140] = gap[20:28, 150:158] = True
    holed = np.where(gap, np.nan, depth)
    filled, mask = fill_gaps(scan_of(holed, camera), 12)
    np.testing.assert_array_equal(mask, gap)
    error = np.linalg.norm(filled.points - CAMERA.points(depth), axis=2)
    assert error[gap].max() < 0.15
    # Blurring x, y, z themselves bends the grid by an order of magnitude more.
    bent = CAMERA.points(np.nan_to_num(holed))
    for axis in range(3):
        row = bent[63, :, axis]
        row[30:37] = 0.5 * (row[29] + row[37])
    assert np.linalg.norm(bent[63, 30:37] - CAMERA.points(depth)[63, 30:37], axis=1).max() > 1.0
    np.testing.assert_array_equal(filled.points[~gap], CAMERA.points(depth)[~gap])


def test_wide_gaps_and_the_background_stay_missing() -> None:
    depth = dome()
    depth[40:90, 60:110] = np.nan
    depth[:, 170:] = np.nan
    filled, mask = fill_gaps(scan_of(depth), 12)
    assert not mask[50:80, 70:100].any()
    assert not mask[:, 171:].any()
    assert filled.missing_fraction > 0.2


def test_every_threshold_and_width_is_checked() -> None:
    with pytest.raises(InputError, match="matte threshold"):
        fill_gaps(scan_of(dome()), 5, threshold=1.5)
    for wrong in ({"spike_mm": -1.0}, {"largest_gap_px": 10_000}, {"smooth_px": 50.0}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            RepairOptions(**wrong)


def test_smoothing_lowers_noise_and_keeps_edges_and_holes() -> None:
    truth = dome()
    truth[:, 120:] += 6.0
    noisy = truth + np.random.default_rng(1).normal(0, 0.15, truth.shape)
    noisy[10:14, 10:14] = np.nan
    result = -smooth_depth(scan_of(noisy)).points[..., 2]
    assert np.isnan(result[10:14, 10:14]).all()
    error = np.abs(result - truth)[20:-20, 20:-20]
    assert np.sqrt(np.nanmean(error**2)) < 0.5 * 0.15
    assert error[:, 97:103].max() < 0.6, "the step between columns 119 and 120 is kept"
    flat = -smooth_depth(scan_of(dome())).points[..., 2]
    assert np.abs(flat - dome())[5:-5, 5:-5].max() < 0.02


def test_rays_of_a_pinhole_and_of_a_parallel_scanner() -> None:
    depth = dome(0.1)
    estimated, known = Rays.of(scan_of(depth, None)), Rays.of(scan_of(depth))
    where = np.random.default_rng(0).uniform(0, 150, (50, 2))
    np.testing.assert_allclose(
        estimated.points(where, np.full(50, 600.0)), known.points(where, np.full(50, 600.0)), atol=1e-6
    )
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    parallel = RangeImage(np.stack([0.5 * x - 40, 30 - 0.5 * y, -depth], axis=2))
    found = Rays.of(parallel).points(where, np.full(50, 580.0))
    np.testing.assert_allclose(found[:, :2], where * [0.5, -0.5] + [-40, 30], atol=1e-6)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_scan_in_a_turned_frame_keeps_its_points(axis: int) -> None:
    """Where pixel and depth do not tell x and y, they stay as measured and gaps take them from their neighbours."""
    angle = np.radians(20)
    turn = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
    true = CAMERA.points(dome()) @ turn.T
    noisy = CAMERA.points(dome(0.15)) @ turn.T
    noisy[60:66, 90:96] = np.nan
    done = repair(RangeImage(noisy))
    assert done.report.grid == ("grid" if axis == 2 else "irregular")
    error = np.linalg.norm(done.scan.points - true, axis=2)[6:-6, 6:-6]
    assert np.nanmedian(error) < 0.15
    assert np.nanmax(error) < 1.0
    assert done.report.filled_pixels == 36


def test_the_report_counts_what_was_done_and_the_input_stays() -> None:
    depth = dome(0.15)
    depth[50, 60] += 20
    depth[80:84, 90:94] = np.nan
    scan = scan_of(depth)
    before = scan.points.copy()
    done = repair(scan)
    np.testing.assert_array_equal(scan.points, before)
    assert done.report.spikes == done.spikes.sum() == 1
    assert done.report.filled_pixels == done.filled.sum() == 17
    assert done.report.missing_fraction == pytest.approx(16 / depth.size)
    assert done.report.unfilled_fraction == 0
    assert not (done.measured & done.filled).any()
    untouched = repair(scan, RepairOptions(remove_spikes=False, fill_gaps=False, smooth=False))
    np.testing.assert_array_equal(untouched.scan.points, scan.points)


def test_surfaces_are_told_apart_by_their_step() -> None:
    depth = dome()
    depth[:, 150:] += 80
    labels = repair(scan_of(depth)).surfaces
    assert labels[80, 40] != labels[80, 180]
    assert labels[80, 40] > 0
    assert labels[80, 149] == labels[80, 40]
    assert labels[80, 151] == labels[80, 180]
