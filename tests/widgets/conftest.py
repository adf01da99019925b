"""What the tests of the widgets share: scheme, template, landmarks in every state, a picture of 200 x 160."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication

import resources
from engine.files.scheme import read_scheme
from engine.files.template import read_template
from engine.landmarks import Landmark, LandmarkScheme, LandmarkSet, LandmarkState
from engine.scan.template import FaceTemplate
from widgets import theme

LOCKED, PROPOSED, SKIPPED, UNSET = "nose_bridge", "mouth_right", "jaw_left", "chin"


@pytest.fixture(scope="session")
def scheme() -> LandmarkScheme:
    return read_scheme(resources.scheme_path("closed"))


@pytest.fixture(scope="session")
def template() -> FaceTemplate:
    return read_template(resources.template_path())


@pytest.fixture(scope="session")
def positions(template: FaceTemplate) -> dict[str, tuple[float, float]]:
    layout = template.layouts["closed"]
    flat = layout.vertices
    low, high = flat.min(axis=0), flat.max(axis=0)
    scaled = 20.0 + (flat - low) / (high - low).max() * 120.0
    return {name: (float(scaled[k, 0]), float(scaled[k, 1])) for name, k in layout.fiducials.items()}


@pytest.fixture
def landmarks(positions: dict[str, tuple[float, float]]) -> LandmarkSet:
    """All placed, but one locked, one proposed, one skipped, one unset."""
    return LandmarkSet.placed(positions).with_points(
        {
            LOCKED: Landmark(*positions[LOCKED], LandmarkState.PLACED, locked=True),
            PROPOSED: Landmark(*positions[PROPOSED], LandmarkState.PROPOSED),
            SKIPPED: Landmark(*positions[SKIPPED], LandmarkState.SKIPPED),
            UNSET: Landmark(),
        }
    )


@pytest.fixture
def picture() -> np.ndarray:
    rng = np.random.default_rng(5)
    return rng.integers(0, 255, (160, 200, 3), dtype=np.uint8)


@pytest.fixture(autouse=True)
def dressed(qapp: QApplication) -> None:
    if theme.current() is not theme.DARK or not qapp.styleSheet():
        theme.apply(qapp, theme.DARK)
