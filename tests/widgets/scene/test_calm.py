"""The calmed heatmap: noise goes, what is wide stays, unknown stays unknown, and the reach is what it says."""

from __future__ import annotations

import numpy as np
import pytest

from tests.widgets.scene import synthetic
from widgets.scene.calm import calmed


def sheet(pitch: float, width: float = 60.0) -> tuple[np.ndarray, np.ndarray]:
    """A flat square of triangles, ``pitch`` mm apart."""
    n = round(width / pitch) + 1
    x, y = np.meshgrid(np.arange(n) * pitch, np.arange(n) * pitch)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)
    k = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([k, k + 1, k + n], 1), np.stack([k + 1, k + n + 1, k + n], 1)])
    return vertices, faces


@pytest.mark.parametrize("pitch", [0.6, 1.0, 1.7])
@pytest.mark.parametrize("reach", [2.0, 3.0, 5.0])
def test_it_reaches_as_far_as_it_says_however_fine_the_mesh(pitch: float, reach: float) -> None:
    vertices, faces = sheet(pitch)
    middle = int(np.linalg.norm(vertices - vertices.mean(axis=0), axis=1).argmin())
    spot = np.zeros(len(vertices))
    spot[middle] = 1.0
    result = calmed(spot, vertices, faces, reach)
    spread = (result * ((vertices - vertices[middle]) ** 2).sum(axis=1)).sum()
    assert result.sum() == pytest.approx(1.0, abs=0.02)
    assert np.sqrt(spread) == pytest.approx(reach / np.sqrt(2), rel=0.08), "as the points of a disc"


def test_noise_goes_and_a_wide_bump_stays() -> None:
    vertices, faces = sheet(1.0)
    place = np.linalg.norm(vertices - vertices.mean(axis=0), axis=1)
    bump = 0.4 * np.exp(-0.5 * (place / 8.0) ** 2)
    noise = np.random.default_rng(0).normal(0, 0.1, len(vertices))
    result = calmed(bump + noise, vertices, faces)
    assert (result - calmed(bump, vertices, faces)).std() < 0.25 * noise.std()
    assert np.abs(calmed(bump, vertices, faces) - bump).max() < 0.1 * bump.max()


def test_means_keep_what_is_even_and_stay_within_what_is_there() -> None:
    fit = synthetic.fit(levels=2)
    vertices, faces = fit.mesh.vertices, fit.mesh.faces
    assert calmed(np.full(len(vertices), 0.3), vertices, faces) == pytest.approx(np.full(len(vertices), 0.3))
    values = np.random.default_rng(1).uniform(0.1, 0.9, len(vertices))
    result = calmed(values, vertices, faces)
    assert result.min() >= values.min() and result.max() <= values.max()
    assert np.array_equal(calmed(values, vertices, faces, 0.0), values)


def test_unknown_values_stay_unknown_and_have_no_part() -> None:
    vertices, faces = sheet(1.0)
    values = np.where(vertices[:, 0] < 30, 0.2, np.nan)
    result = calmed(values, vertices, faces)
    assert np.array_equal(np.isnan(result), np.isnan(values))
    assert result[~np.isnan(result)] == pytest.approx(0.2)


def test_nothing_passes_between_sheets_that_only_lie_near_each_other() -> None:
    vertices, faces = sheet(1.0, 20.0)
    both = np.concatenate([vertices, vertices + np.array([0, 0, 0.5])])
    values = np.repeat([0.0, 1.0], len(vertices))
    result = calmed(values, both, np.concatenate([faces, faces + len(vertices)]))
    assert result == pytest.approx(values)
