"""A small scan that a face can be fitted to: a smooth dome before a pinhole, with fiducials of the right layout."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.files.depth_json import write_depth_scan
from engine.files.landmarks_json import write_fiducials
from engine.files.npz import write_npz
from engine.files.ply import write_ply
from engine.landmarks import LandmarkSet
from engine.scan.fit import FaceFit
from engine.scan.range_image import Camera, RangeImage
from studio.project import store
from studio.project.document import Project, ScanItem, SourceInfo, new_id
from studio.scan.job import FitInputs, input_key, run, template_of
from studio.scan.options import FitOptions

Make = Callable[..., tuple[Project, str]]
Positions = dict[str, tuple[float, float]]

WIDTH, HEIGHT = 160, 200


def dome(seed: int = 0) -> RangeImage:
    """A dome of 100 mm radius, 650 mm away, with noise, a gap and one spike."""
    camera = Camera(700.0, 700.0, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
    rows, columns = np.indices((HEIGHT, WIDTH))
    x, y = (columns - camera.cx) / WIDTH, (rows - camera.cy) / HEIGHT
    depth = 650.0 + 160.0 * (x**2 + y**2) + np.random.default_rng(seed).normal(0.0, 0.1, (HEIGHT, WIDTH))
    depth[60:64, 70:73] = np.nan
    depth[120, 80] -= 20.0
    shade = np.clip(255 - 200 * np.hypot(x, y), 0, 255)
    colour = np.stack([shade, 0.8 * shade, 0.7 * shade], axis=-1).astype(np.uint8)
    return RangeImage(camera.points(depth), colour, camera)


def face_fiducials(scheme: str = "closed") -> dict[str, tuple[float, float]]:
    """Return the template's own fiducials, laid into the middle of the picture, pixels."""
    layout = template_of().layout(scheme)
    low, high = layout.vertices.min(axis=0), layout.vertices.max(axis=0)
    scale = 0.75 * min(WIDTH / (high - low)[0], HEIGHT / (high - low)[1])
    middle = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
    return {
        name: tuple((layout.vertices[vertex] - (low + high) / 2) * scale + middle)
        for name, vertex in layout.fiducials.items()
    }


@pytest.fixture(scope="session")
def scan() -> RangeImage:
    return dome()


@pytest.fixture(scope="session")
def fiducials() -> dict[str, tuple[float, float]]:
    return face_fiducials()


@pytest.fixture(scope="session")
def make_project(scan: RangeImage) -> Callable[..., tuple[Project, str]]:
    """Return what makes a project with one scan, and its id."""

    def make(positions: dict[str, tuple[float, float]] | None = None, name: str = "base") -> tuple[Project, str]:
        project = Project()
        key = project.add_image(scan)
        source = SourceInfo("base.json", "mm", "", scan.width, scan.height, scan.missing_fraction, 1)
        item = ScanItem(new_id(), name, key, source=source, landmarks=LandmarkSet.placed(positions or {}))
        project.insert_scan(0, item)
        return project, item.id

    return make


@pytest.fixture(scope="session")
def face(scan: RangeImage, fiducials: Positions) -> FaceFit:
    """The dome's face, subdivided once."""
    return run(FitInputs(scan, fiducials), FitOptions(levels=1))


@pytest.fixture
def saved(make_project: Make, fiducials: Positions, face: FaceFit, tmp_path: Path) -> Path:
    """A project file with one scan and its fresh fit."""
    project, scan_id = make_project(fiducials)
    project.put_fit(scan_id, input_key(project.scan(scan_id)), face)
    return store.save(project, tmp_path / "faces.qface")


@pytest.fixture
def folder(tmp_path: Path, scan: RangeImage, fiducials: Positions, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with one scan in every form and its fiducials, which is also the working folder."""
    write_depth_scan(tmp_path / "base.json", scan, 0.02)
    write_npz(tmp_path / "base.npz", scan)
    write_ply(tmp_path / "base.ply", scan)
    write_fiducials(tmp_path / "f.json", fiducials, (scan.width, scan.height))
    monkeypatch.chdir(tmp_path)
    return tmp_path
