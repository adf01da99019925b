"""The fit against the virtual scanner's truth, and two lazier methods that must miss the same figures."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import resources
from engine.files.template import read_template
from engine.geometry.distance import surface_distance
from engine.geometry.sampling import sample_bilinear
from engine.mesh import BoolArray, FloatArray
from engine.scan.fit import FaceFit, fit_template
from engine.scan.range_image import RangeImage
from engine.scan.repair import RepairOptions, repair
from tests.engine.scan.truth import SCANS, STRANGER, bundled_scan, scheme_of, true_scan

TEMPLATE = read_template(resources.template_path())
VISIBLE = {"median": 0.07, "p99": 0.30, "max": 1.50}
FILLED_P95 = BACK_P95 = 1.0
ANATOMY_MEDIAN = 2.5


def scan(name: str) -> RangeImage:
    return bundled_scan(name)[0]


def fiducials(name: str) -> dict[str, tuple[float, float]]:
    return bundled_scan(name)[1]


@cache
def fit(name: str) -> FaceFit:
    return fit_template(scan(name), fiducials(name), TEMPLATE, scheme_of(name), levels=2)


def to_truth(name: str, points: FloatArray) -> FloatArray:
    """Distance of points to the true surface; faces far from all of them are left out for speed."""
    mesh = true_scan(name).mesh
    low, high = points.min(axis=0) - 30, points.max(axis=0) + 30
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    near = ((middles > low) & (middles < high)).all(axis=1)
    return surface_distance(points, mesh.vertices, mesh.faces[near])


def visible_figures(distance: FloatArray) -> dict[str, float]:
    return {"median": np.median(distance), "p99": np.percentile(distance, 99), "max": distance.max()}


def missed(figures: dict[str, float]) -> set[str]:
    return {name for name, value in figures.items() if value > VISIBLE[name]}


@pytest.mark.parametrize("name", SCANS)
def test_the_fit_is_the_true_face(name: str) -> None:
    face = fit(name)
    layout = TEMPLATE.layout(face.scheme)
    for label, place in fiducials(name).items():
        np.testing.assert_allclose(face.pixels[layout.fiducials[label]], place, atol=1e-6)
    assert not len(face.folded_faces)
    distance = to_truth(name, face.mesh.vertices)
    assert missed(visible_figures(distance[~face.filled])) == set()
    assert face.filled.mean() < 0.05
    assert np.percentile(distance[face.filled], 95) <= FILLED_P95


@pytest.mark.parametrize("name", SCANS)
def test_no_part_of_the_true_face_is_left_out(name: str) -> None:
    face, skin = fit(name), true_scan(name).face_skin_points()
    sample = skin[np.random.default_rng(0).choice(len(skin), 3000, replace=False)]
    assert np.percentile(surface_distance(sample, face.mesh.vertices, face.mesh.faces), 95) <= BACK_P95


def anatomy_errors(place: Callable[[str], FloatArray]) -> list[float]:
    """Choose the vertex nearest to each point on the subject; say how far the same vertex is on the stranger."""
    subject, stranger = true_scan("base"), true_scan(STRANGER)
    on_subject, on_stranger = place("base"), place(STRANGER)
    return [
        float(np.linalg.norm(on_stranger[_nearest(on_subject, subject.position(point))] - stranger.position(point)))
        for point in subject.anatomy
    ]


def _nearest(vertices: FloatArray, point: FloatArray) -> int:
    return int(np.linalg.norm(vertices - point, axis=1).argmin())


def test_the_same_vertex_is_the_same_place_on_another_head() -> None:
    assert len(true_scan("base").anatomy) == 10
    assert not set(true_scan("base").anatomy) & set(TEMPLATE.layout("open").fiducials)
    assert np.median(anatomy_errors(lambda name: fit(name).mesh.vertices)) <= ANATOMY_MEDIAN


def test_without_spike_removal_the_figures_are_missed() -> None:
    lazy = fit_template(scan("base"), fiducials("base"), TEMPLATE, repair=RepairOptions(remove_spikes=False))
    figures = visible_figures(to_truth("base", lazy.mesh.vertices)[~lazy.filled])
    assert "max" in missed(figures)
    assert figures["max"] > 3 * VISIBLE["max"]


def grid_face(name: str) -> tuple[FloatArray, BoolArray]:
    """A face without the template: an even grid of pixels between the outermost fiducials, as many as vertices."""
    places = np.array(list(fiducials(name).values()))
    low, high = places.min(axis=0), places.max(axis=0)
    side = int(np.sqrt(len(fit(name).mesh.vertices)))
    x, y = np.meshgrid(*(np.linspace(low[k], high[k], side) for k in range(2)))
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    repaired = repair(scan(name))
    points, _ = sample_bilinear(repaired.scan.points, pixels)
    _, measured = sample_bilinear(repaired.raw, pixels, repaired.measured)
    return points, measured < 0.5


def test_without_the_template_the_figures_are_missed() -> None:
    errors = anatomy_errors(lambda name: np.nan_to_num(grid_face(name)[0], nan=1e4))
    assert np.median(errors) > ANATOMY_MEDIAN
    # Nothing tells the grid that the opening of a mouth is not a face, nor the neck.
    points, _ = grid_face("car")
    skin = true_scan("car").face_skin_mesh()
    there = points[~np.isnan(points[:, 0])]
    assert surface_distance(there, skin.vertices, skin.faces).max() > VISIBLE["max"]
    assert np.isnan(points).any()
