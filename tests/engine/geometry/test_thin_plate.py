from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import RBFInterpolator

from engine.errors import InputError
from engine.geometry.thin_plate import ThinPlateSpline, warp_operator


def points(seed: int, count: int, dimension: int, scale: float = 1.0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (count, dimension)) * scale


@pytest.mark.parametrize(("dimension", "kernel"), [(2, "thin_plate_spline"), (3, "linear")])
def test_agrees_with_a_reference_library(dimension: int, kernel: str) -> None:
    source, target = points(0, 25, dimension, 300), points(1, 25, dimension, 300)
    where = points(2, 200, dimension, 350)
    ours = ThinPlateSpline(source, target)(where)
    reference = RBFInterpolator(source, target, kernel=kernel, degree=1)(where)
    np.testing.assert_allclose(ours, reference, atol=1e-6)


@given(st.integers(0, 10_000), st.integers(4, 40), st.sampled_from([2, 3]), st.floats(1e-3, 1e4))
@settings(max_examples=60, deadline=None)
def test_interpolates_to_rounding_at_any_scale(seed: int, count: int, dimension: int, scale: float) -> None:
    source = points(seed, count + dimension, dimension, scale) + 7 * scale
    target = points(seed + 1, count + dimension, dimension, 500)
    np.testing.assert_allclose(ThinPlateSpline(source, target)(source), target, atol=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_affine_maps_are_reproduced_and_their_jacobian_is_their_matrix(dimension: int) -> None:
    matrix, shift = points(3, dimension, dimension), points(4, 1, dimension, 50)
    source, where = points(5, 12, dimension, 100), points(6, 50, dimension, 300)
    spline = ThinPlateSpline(source, source @ matrix.T + shift)
    np.testing.assert_allclose(spline(where), where @ matrix.T + shift, atol=1e-9)
    np.testing.assert_allclose(spline.jacobian(where), np.broadcast_to(matrix, (50, dimension, dimension)), atol=1e-11)


@pytest.mark.parametrize("dimension", [2, 3])
def test_jacobian_is_the_derivative(dimension: int) -> None:
    spline = ThinPlateSpline(points(7, 20, dimension, 100), points(8, 20, dimension, 100))
    where, step = points(9, 30, dimension, 100), 1e-4
    numeric = np.stack(
        [(spline(where + step * axis) - spline(where - step * axis)) / (2 * step) for axis in np.eye(dimension)], axis=2
    )
    np.testing.assert_allclose(spline.jacobian(where), numeric, atol=1e-6)


def test_bends_less_than_any_other_interpolant_tried() -> None:
    """The side conditions make the bending energy minimal: a perturbed interpolant bends more."""
    source, target = points(10, 15, 2), points(11, 15, 2)
    grid = np.stack(np.meshgrid(*[np.linspace(-3, 3, 121)] * 2, indexing="ij"), axis=-1)
    bump = np.prod([((grid - node) ** 2).sum(axis=-1) for node in source], axis=0)
    bump *= np.exp(-2 * (grid**2).sum(axis=-1))
    bump /= bump.max()

    def energy(field: np.ndarray) -> float:
        gx, gy = np.gradient(field)
        return float(sum((second**2).sum() for first in (gx, gy) for second in np.gradient(first)))

    smooth = ThinPlateSpline(source, target)(grid.reshape(-1, 2))[:, 0].reshape(grid.shape[:2])
    assert energy(smooth) < min(energy(smooth + factor * bump) for factor in (-3.0, -0.5, 0.5, 3.0))


def test_operator_is_the_spline() -> None:
    source, target, where = points(12, 20, 2, 100), points(13, 20, 2, 640), points(14, 441, 2, 100)
    np.testing.assert_allclose(warp_operator(source, where) @ target, ThinPlateSpline(source, target)(where), atol=1e-8)


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ([[0, 0], [1, 0]], "has 2 points"),
        ([[0, 0], [1, 0], [1, 1], [0, 0]], "0 and 3 are at one place"),
        ([[0, 0], [1, 1], [2, 2], [5, 5]], "on one line"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [3, 2, 0]], "in one plane"),
        ([[0, 0], [1, 0], [float("nan"), 1]], "not finite"),
        ([[0.0], [1.0], [2.0]], "has shape"),
    ],
)
def test_says_what_is_wrong(source: list[list[float]], words: str) -> None:
    with pytest.raises(InputError, match=words):
        ThinPlateSpline(source, source)
