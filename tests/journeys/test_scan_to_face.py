"""A range image becomes a face in the real window: opened, clicked, fitted, undone, saved, reopened, exported."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pygltflib
import pytest
from PySide6.QtCore import Qt

import resources
from engine.files.scan import read_scan
from engine.landmarks import LandmarkState
from engine.scan.fit import fit_template
from studio.scan.job import repair_options, scheme_of, template_of
from tests.journeys.conftest import close
from tests.journeys.driver import Hand, bare_scan, truth


@pytest.mark.timeout(240)
def test_from_range_image_to_exported_face(hand: Hand, hands: Callable[[], Hand], tmp_path: Path) -> None:
    window, stage = hand.window, hand.stage
    places, names = truth("base"), scheme_of("closed").names

    # Opened by the action a user takes.
    hand.choose("scan.add", bare_scan("base"))
    assert [item.name for item in window.session.project.scans] == ["base"]
    assert stage.context.fiducial == names[0]
    before = hand.skin_share()

    # Twenty clicks: each places its fiducial, goes on, and the template warps along.
    warps = [hand.template()]
    for number, name in enumerate(names):
        assert stage.context.fiducial == name
        hand.click(*places[name])
        point = hand.landmarks[name]
        assert point.state == LandmarkState.PLACED
        assert np.hypot(point.x - places[name][0], point.y - places[name][1]) <= 0.75 / hand.canvas.zoom + 1e-9
        assert window.session.stack.count() == number + 2
        warps.append(hand.template())
        if number >= 2:
            assert len(warps[-1]) == 441
            assert len(warps[-2]) == 0 or np.abs(warps[-1] - warps[-2]).max() > 0
        hand.rest()
        if number >= 4:
            assert all(hand.landmarks[other].is_set for other in names)
    for name in names:
        vertex = hand.template()[template_of().layout("closed").fiducials[name]]
        np.testing.assert_allclose(vertex, (hand.landmarks[name].x, hand.landmarks[name].y), atol=1e-6)

    # The fit has come by itself, textured.
    scan_id = stage.context.scan_id
    project = window.session.project
    assert project.state(scan_id).kind == "fresh"
    face = project.fit(scan_id)
    assert face.levels == 2 and len(face.mesh.vertices) == 6588
    assert hand.skin_share() > before + 0.15
    assert stage.shown.median_mm < 0.07

    # It is the very face that the engine makes of these points.
    placed = {name: (hand.landmarks[name].x, hand.landmarks[name].y) for name in names}
    scan = read_scan(resources.sample_path("subject", "base.json")).scan
    repair = repair_options(project.scans[0].options)
    again = fit_template(scan, placed, template_of(), "closed", levels=2, repair=repair)
    np.testing.assert_array_equal(again.mesh.vertices, face.mesh.vertices)

    # Three clicks are undone and redone.
    done = hand.landmarks
    for left in (19, 18, 17):
        hand.key(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
        hand.rest()
        assert len(hand.landmarks.names(LandmarkState.PLACED, order=names)) == left
        assert project.state(scan_id).kind == "missing"
    np.testing.assert_allclose(hand.template(), warps[17], atol=1e-9)
    for _ in range(3):
        hand.key(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    hand.rest()
    assert hand.landmarks == done
    np.testing.assert_allclose(hand.template(), warps[20], atol=1e-9)
    assert project.state(scan_id).kind == "fresh" and project.fit(scan_id) is face

    # Saved, closed, reopened in a fresh window.
    path = tmp_path / "anna.qface"
    assert window.isWindowModified()
    hand.choose("file.save_as", path)
    assert path.is_file() and not window.isWindowModified() and window.session.name == "anna.qface"
    close(hand)
    second = hands()
    second.choose("file.open", path)
    reopened = second.window.session.project
    assert reopened.scans == project.scans
    assert reopened.state(scan_id).kind == "fresh"
    np.testing.assert_array_equal(reopened.fit(scan_id).mesh.vertices, face.mesh.vertices)
    np.testing.assert_array_equal(reopened.range_image(scan_id).points, scan.points)
    np.testing.assert_allclose(second.template(), warps[20], atol=1e-9)
    assert second.skin_share() > before + 0.15

    # Exported as GLB and OBJ that others read.
    second.export(tmp_path / "face.glb")
    second.export(tmp_path / "face.obj")
    check_glb(tmp_path / "face.glb", face)
    check_obj(tmp_path / "face.obj", face)


def check_glb(path: Path, face: object) -> None:
    document = pygltflib.GLTF2().load(str(path))
    primitive = document.meshes[0].primitives[0]
    accessor = document.accessors[primitive.attributes.POSITION]
    view = document.bufferViews[accessor.bufferView]
    start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
    values = np.frombuffer(document.binary_blob(), "<f4", 3 * accessor.count, start).reshape(-1, 3)
    source = getattr(primitive.attributes, "_SOURCE", None)
    assert source is not None and document.images
    assert accessor.count >= 6588
    low, high = face.mesh.vertices.min(axis=0), face.mesh.vertices.max(axis=0)  # type: ignore[attr-defined]
    np.testing.assert_allclose(values.min(axis=0), low / 1000, atol=1e-5)
    np.testing.assert_allclose(values.max(axis=0), high / 1000, atol=1e-5)


def check_obj(path: Path, face: object) -> None:
    lines = path.read_text().splitlines()
    vertices = np.array([[float(v) for v in line.split()[1:4]] for line in lines if line.startswith("v ")])
    np.testing.assert_allclose(vertices, face.mesh.vertices, atol=1e-4)  # type: ignore[attr-defined]
    assert sum(line.startswith("f ") for line in lines) == len(face.mesh.faces)  # type: ignore[attr-defined]
    assert path.with_suffix(".mtl").is_file() and path.with_name(f"{path.stem}_texture.png").is_file()
