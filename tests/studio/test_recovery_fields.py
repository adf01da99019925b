"""What is saved, copied for another thread, or written to the journal comes back in every field there is.

The test asks the classes for their fields. A field that is added to them and forgotten in the file, in the copy or in
the journal fails it; so does one that the project made here leaves at its default.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from engine.files.motion_file import DenseClip
from engine.landmarks import Landmark, LandmarkDefinition, LandmarkScheme, LandmarkSet, LandmarkState
from engine.mesh import TriangleMesh
from engine.motion import MarkerClip, WeightCurves
from engine.scan.fit import FaceFit
from engine.scan.limits import REGIONS, Bounds, Limits, RegionLimits
from engine.scan.mesh_view import MeshView
from engine.scan.range_image import RangeImage
from engine.shape_edits import Combine, Rename
from engine.shapes import ExpressionBasis, Rig
from studio.basis.options import BasisOptions, MotionOptions
from studio.project import store
from studio.project.basis_items import BasisSetup, MotionItem, RigContent, RigItem, motion_key
from studio.project.basis_state import BasisItems, BasisState
from studio.project.document import Project, ScanItem, SourceInfo
from studio.project.header import SharedHeader
from studio.project.keys import content_key
from studio.project.linked import LinkedFile
from studio.project.recovery import copy_of, journal_of, pieces_of, recover, write_journal
from studio.project.recovery_files import RecoveryFiles
from studio.scan.job import input_key, scheme_of, template_of
from studio.scan.options import FitOptions

EDITS: tuple[Any, ...] = (Rename("smile", "grin"), Combine((("grin", 0.5), ("brow", 1.0)), "both"))
"""Edits of the rig."""
RUNTIME = {"_callbacks", "_name", "_path", "_keep_fits", "_keep_bytes"}
"""What a project has but a file need not hold; everything else of it is compared."""


def another(value: Any) -> Any:
    """Return a legal value of an option that is not the given one."""
    if isinstance(value, bool):
        return not value
    return value + 2 if isinstance(value, int) else value * 1.1


def own_scheme() -> LandmarkScheme:
    """Return the closed scheme under another name, with the vertex of its first point named."""
    closed = scheme_of("closed")
    vertex = template_of().layout("open").fiducials[closed.landmarks[0].name]
    first = dataclasses.replace(closed.landmarks[0], hint="Between hair and brows", vertex=vertex)
    return dataclasses.replace(
        closed, name="mine", title="Mine", layout="open", landmarks=(first, *closed.landmarks[1:])
    )


def add_basis(project: Project) -> None:
    """Add a rig, markers, weights and dense motion, with nothing at its default."""
    grid = np.random.default_rng(1)
    mesh = TriangleMesh(grid.normal(size=(5, 3)), [[0, 1, 2], [2, 3, 4]], grid.random((4, 2)), [[0, 1, 2], [1, 2, 3]],
                        {"skin": [0], "eyes": [1]})  # fmt: skip
    basis = ExpressionBasis(mesh.vertices, ("smile", "brow"), grid.normal(size=(2, 5, 3)), grid.normal(size=(5, 3)))
    content = RigContent(Rig(mesh, basis), grid.integers(0, 255, (4, 6, 3)).astype(np.uint8))
    edits = EDITS
    item = RigItem("rig-1", "hand", project.basis.keep_rig(content), "rigs/a.glb", "cm", "cm as asked", "glb", edits)
    project.basis.rigs.insert(0, item)
    positions = grid.normal(size=(7, 3, 3))
    positions[2, 1] = np.nan
    options = MotionOptions(
        unit="cm", up="z", forward="-y", fps=60.0, head=("h1",), pairs={"a": 3, "b": (1.0, 2.0, 3.0)}, rest_frame=2,
        scale=True,
    )  # fmt: skip
    axes = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    takes = {
        "markers": MarkerClip(("a", "b", "h1"), positions, 60.0),
        "weights": WeightCurves(("smile",), grid.normal(size=(9, 1)), 30.0),
        "dense": DenseClip(grid.normal(size=(3, 5, 3)).astype(np.float32), 25.0, 10.0, axes),
    }
    for kind, data in takes.items():
        key = motion_key(data)
        project.basis.keep_motion(key, data)
        take = MotionItem(f"m-{kind}", kind, kind, key, "take.c3d", "cm", "as asked", len(data), 3, data.fps, options)
        project.basis.motions.insert(99, take)
    choices = BasisOptions(coverage=0.9, count=3, train=(1, 5), affine=True, bounds="free", ridge=0.5, memory_mb=256.0)
    project.basis.set_setup(BasisSetup("rig-1", "m-weights", "rig-1", choices, {"grin": 0.25}))


@pytest.fixture
def full(scan: RangeImage, face: FaceFit, fiducials: dict[str, tuple[float, float]]) -> Project:
    """Return a project in which nothing is at its default."""
    project = Project()
    whole = [field.name for field in dataclasses.fields(Limits) if field.name != "regions"]
    limits = {name: 1 if isinstance(getattr(Limits(), name), int) else getattr(Limits(), name) * 1.5 for name in whole}
    strict = RegionLimits(**{field.name: Bounds(0.01, 0.02) for field in dataclasses.fields(RegionLimits)})
    regions = dict.fromkeys(REGIONS, strict)
    project.set_limits(Limits(**limits, regions=regions))
    project.set_schemes({"mine": own_scheme()})
    view = MeshView((0.1, -0.2, 0.3), (1.0, 2.0, 3.0), 700.0, 33.0, scan.width, scan.height)
    source = SourceInfo("scans/base.ply", "cm", "cm as asked", scan.width, scan.height, 0.25, 3, view, True)
    options = FitOptions(**{name: another(value) for name, value in FitOptions().model_dump().items()})
    names = own_scheme().names
    points = LandmarkSet(
        {
            names[0]: Landmark(3.125, 1 / 3, LandmarkState.PLACED, True),
            names[1]: Landmark(30.5, 20.25, LandmarkState.PROPOSED),
            names[2]: Landmark(state=LandmarkState.SKIPPED),
            names[3]: Landmark(7.0, 8.0, LandmarkState.UNSET, True),
        }
    )
    item = ScanItem("scan-1", "too", content_key(scan), "tool", "oo", source, "mine", points, options)
    project.insert_scan(0, item, scan)
    second = RangeImage(scan.points + 0.25, None, None)
    project.insert_scan(1, ScanItem("scan-2", "base", content_key(second)), second)
    fitted = ScanItem("scan-3", "fitted", item.image_key, landmarks=LandmarkSet.placed(fiducials))
    project.insert_scan(2, fitted)
    project.put_fit("scan-3", input_key(fitted), face)
    add_basis(project)
    return project


def assert_same(a: Any, b: Any, where: str = "project") -> None:
    """Compare values field by field, whatever they are made of."""
    assert type(a) is type(b), where
    if isinstance(a, np.ndarray):
        assert a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes(), where
    elif isinstance(a, (BasisState, BasisItems)):
        for name in set(vars(a)) - {"_tell", "_edited"}:
            assert_same(vars(a)[name], vars(b)[name], f"{where}.{name}")
    elif dataclasses.is_dataclass(a):
        for field in dataclasses.fields(a):
            assert_same(getattr(a, field.name), getattr(b, field.name), f"{where}.{field.name}")
    elif isinstance(a, BaseModel):
        for name in type(a).model_fields:
            assert_same(getattr(a, name), getattr(b, name), f"{where}.{name}")
    elif isinstance(a, Mapping):
        assert list(a) == list(b) or set(a) == set(b), where
        for key in a:
            assert_same(a[key], b[key], f"{where}[{key}]")
    elif isinstance(a, (tuple, list)):
        assert len(a) == len(b), where
        for k, (one, two) in enumerate(zip(a, b, strict=True)):
            assert_same(one, two, f"{where}[{k}]")
    else:
        assert a == b or (a != a and b != b), f"{where}: {a!r} is not {b!r}"


def assert_same_project(a: Project, b: Project) -> None:
    for name in set(vars(a)) | set(vars(b)):
        if name not in RUNTIME:
            assert_same(vars(a)[name], vars(b)[name], f"project.{name}")


def by_file(project: Project, folder: Path) -> Project:
    return store.load(store.save(project, folder / "all.qface"))


def by_copy(project: Project, _folder: Path) -> Project:
    return copy_of(project)


def by_journal(project: Project, folder: Path) -> Project:
    files = RecoveryFiles.of(folder, "lost")
    files.folder.mkdir()
    write_journal(journal_of(project, 1.0, 1), files.journal)
    for _path, write in pieces_of(project, files):
        write()
    found = recover(files)
    assert found.lost == ()
    return found.project


def a_link() -> LinkedFile:
    return LinkedFile(Path("/takes/one.pc2"), 1, 2, 64 * "a")


@pytest.mark.parametrize("way", [by_file, by_copy, by_journal])
def test_every_field_comes_back(full: Project, tmp_path: Path, way: Callable[[Project, Path], Project]) -> None:
    again = way(full, tmp_path)
    assert again is not full
    assert_same_project(full, again)
    assert [again.state(item.id) for item in again.scans] == [full.state(item.id) for item in full.scans]


def test_the_project_of_this_test_leaves_no_field_at_its_default(full: Project) -> None:
    item = full.scans[0]
    for value, plain in (
        (item, ScanItem("", "", "")),
        (item.source, SourceInfo()),
        (item.landmarks.points[own_scheme().names[0]], Landmark()),
        (own_scheme().landmarks[0], LandmarkDefinition("", "", None, "", "")),
        (full.limits, Limits()),
        (full.basis.rigs["rig-1"], RigItem("", "", "")),
        (dataclasses.replace(full.basis.motions["m-weights"], link=a_link()), MotionItem("", "", "dense", "")),
        (full.basis.setup, BasisSetup()),
    ):
        for field in dataclasses.fields(value):
            assert getattr(value, field.name) != getattr(plain, field.name), f"{type(value).__name__}.{field.name}"
    for options in (item.options, full.basis.setup.options, full.basis.motions["m-weights"].options):
        for name in type(options).model_fields:
            assert getattr(options, name) != getattr(type(options)(), name), name
    shared, empty = SharedHeader.of(full), SharedHeader.of(Project())
    for name in SharedHeader.model_fields:
        assert getattr(shared, name) != getattr(empty, name), name


def test_a_field_that_is_forgotten_is_noticed(full: Project) -> None:
    """The control."""
    for change in (
        lambda project: project.set_limits(Limits()),
        lambda project: project.change_scan("scan-1", source=dataclasses.replace(full.scans[0].source, view=None)),
        lambda project: project.change_scan("scan-1", held=""),
        lambda project: project.basis.rigs.change("rig-1", edits=full.basis.rigs["rig-1"].edits[:1]),
        lambda project: project.basis.change_setup(amounts={"grin": 0.5}),
    ):
        other = copy_of(full)
        change(other)
        with pytest.raises(AssertionError):
            assert_same_project(full, other)
