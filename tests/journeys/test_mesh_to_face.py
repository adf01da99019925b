"""A textured mesh from photogrammetry goes the way of a range image: dropped, placed by hand, clicked, fitted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

import resources
from engine.files.images import read_image
from engine.files.obj import write_obj
from engine.landmarks import LandmarkState
from engine.mesh import TriangleMesh
from resources.sample.head import Heads
from studio.scan.job import as_command, scheme_of
from tests.journeys.driver import LEFT, NO_KEY, Hand, send_move
from widgets.scene.camera import project


@pytest.mark.timeout(300)
def test_from_a_textured_mesh_to_a_fitted_face(hand: Hand, tmp_path: Path) -> None:
    heads = Heads.load(resources.sample_path("truth.npz"))
    mesh = TriangleMesh(heads.vertices("base"), heads.faces[heads.parts["skin"]], heads.uv)
    path = tmp_path / "ada.obj"
    write_obj(path, mesh, texture=read_image(resources.sample_path("subject", "skin.jpg")))
    window, stage, placing = hand.window, hand.stage, hand.stage.files.placing
    assert "scan" in placing.reason()

    # Dropped: placed by itself, and the window says so.
    stage.drop([path])
    hand.rest()
    (item,) = window.session.project.scans
    assert item.source.view is not None and not item.source.view_asked
    assert "placed by its symmetry" in window.message.text.text() and "mm assumed" in window.message.text.text()
    assert stage.centre.inputs.source_panel.place.isVisible()

    # A fiducial placed before the camera moves goes along with it.
    truth = {name: mesh.vertices[vertex] for name, vertex in heads.fiducials_of("base").items()}
    at = item.source.view.project(truth["nose_tip"])[0]
    stage.context.select_fiducial("nose_tip")
    hand.click(*at)
    placed = hand.landmarks["nose_tip"]

    # The dialog: a ring is dragged, the numbers follow, the picture follows.
    hand.act("scan.place_camera")
    hand.qtbot.waitUntil(lambda: placing.dialog is not None, timeout=60_000)
    dialog = placing.dialog
    panel = dialog.panel
    hand.qtbot.waitUntil(lambda: panel.scene is not None, timeout=60_000)
    QTest.qWait(100)
    before, shown = panel.view, panel.colour_picture.pixmap().toImage()
    interactor = panel.viewer.plotter
    grip = panel.scene.radius * np.array([[np.sin(0.3), 0.0, np.cos(0.3)], [np.sin(0.55), 0.0, np.cos(0.55)]])
    pixels = project(panel.viewer.camera, grip, *panel.viewer.view_size(0))[:, :2]
    scale, height = panel.viewer.scale, interactor.height()
    start, end = (QPointF(x / scale, height - y / scale) for x, y in pixels)
    QTest.mousePress(interactor, LEFT, NO_KEY, start.toPoint())
    for share in np.linspace(0.1, 1.0, 10):
        send_move(interactor, start + (end - start) * float(share), LEFT)
    QTest.mouseRelease(interactor, LEFT, NO_KEY, end.toPoint())
    turned = panel.view.angles_deg[0] - before.angles_deg[0]
    assert 8 < turned < 21, turned
    assert panel.fields.turn.value() == pytest.approx(panel.view.angles_deg[0], abs=0.06)
    hand.qtbot.waitUntil(lambda: panel.colour_picture.pixmap().toImage() != shown, timeout=10_000)

    # Typed numbers, a step and back, a unit that is none.
    panel.fields.turn.setFocus()
    panel.fields.turn.selectAll()
    QTest.keyClicks(panel.fields.turn, "12")
    QTest.keyClick(panel.fields.turn, Qt.Key.Key_Tab)
    assert panel.view.angles_deg[0] == pytest.approx(12.0, abs=0.06)
    panel.step(1, 1)
    panel.step(1, -1)
    assert panel.view.angles_deg[0] == pytest.approx(12.0, abs=0.06)
    line = panel.fields.unit.lineEdit()
    line.setFocus()
    line.selectAll()
    QTest.keyClicks(line, "furlong")
    QTest.keyClick(line, Qt.Key.Key_Tab)
    assert "furlong" in dialog.trouble.text() and not dialog.use.isEnabled()
    line.setFocus()
    line.selectAll()
    QTest.keyClicks(line, "mm")
    QTest.keyClick(line, Qt.Key.Key_Tab)
    assert dialog.use.isEnabled()
    wanted = panel.view
    QTest.mouseClick(dialog.use, LEFT)
    hand.rest()

    # One step of the history; the point is where the nose is now.
    item = window.session.project.scans[0]
    assert item.source.view == wanted and item.source.view_asked
    moved = hand.landmarks["nose_tip"]
    assert moved.state == LandmarkState.PLACED
    now = wanted.project(truth["nose_tip"])[0]
    assert np.hypot(moved.x - now[0], moved.y - now[1]) < np.hypot(placed.x - at[0], placed.y - at[1]) + 1.0
    assert np.hypot(moved.x - placed.x, moved.y - placed.y) > 5
    window.session.stack.undo()
    assert hand.landmarks["nose_tip"] == placed and not window.session.project.scans[0].source.view_asked
    window.session.stack.redo()
    hand.rest()
    assert "--turn" in as_command(item, item.options) and "--look-at" in as_command(item, item.options)

    # The rest of the fiducials, and the face.
    names = scheme_of("closed").names
    for name in names:
        stage.context.select_fiducial(name)
        hand.click(*wanted.project(truth[name])[0])
    hand.rest()
    assert window.session.project.state(item.id).kind == "fresh"
    face = window.session.project.fit(item.id)
    fitted = wanted.into_mesh(face.mesh.vertices)
    from engine.geometry.distance import surface_distance

    away = surface_distance(fitted[~face.filled], mesh.vertices, mesh.faces)
    assert np.median(away) < 0.1 and np.percentile(away, 95) < 0.6
