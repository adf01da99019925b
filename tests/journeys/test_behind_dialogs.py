"""What goes on behind a dialog, or beside a task, changes nothing of what it is for."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit

import resources
from engine.errors import InputError
from engine.files.landmarks import write_landmarks
from engine.files.mesh_file import MeshFile
from engine.mesh import TriangleMesh
from engine.scan.mesh_view import MeshView, view_mesh
from resources.sample.head import Heads
from studio.app import make_window
from studio.main_window import MainWindow
from studio.project.document import ScanItem, SourceInfo, new_id
from studio.scan import placing, scheme_dialog
from studio.scan.commands import AddScan, RemoveScan
from studio.scan.fiducial_import import FiducialImportDialog
from studio.scan.limits_dialog import LimitsDialog, default_path
from studio.scan.scheme_dialog import SchemeDialog
from studio.scan.view_job import Seen
from studio.settings import Settings
from tests.journeys.driver import LEFT
from widgets.scan.scheme_editor import SchemeResult


@pytest.fixture
def bare_window(qtbot: Any) -> Iterator[MainWindow]:
    """A window; nothing here needs its 3-D."""
    window = make_window(Settings())
    window._after_first_paint = lambda: None
    window.resize(1280, 800)
    window.show()
    qtbot.waitExposed(window)
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow, timeout=10_000)
    yield window
    window.session.stack.setClean()
    window.close()
    window.deleteLater()


@pytest.fixture
def main_window(bare_window: MainWindow, qtbot: Any) -> MainWindow:
    """A window with the sample."""
    bare_window.actions_["scan.sample"].trigger()
    rest(bare_window, qtbot)
    return bare_window


def rest(window: MainWindow, qtbot: Any) -> None:
    for _ in range(2):
        qtbot.waitUntil(lambda: not window.session.tasks.busy, timeout=60_000)
        QTest.qWait(30)


def shown(window: MainWindow, kind: type, qtbot: Any) -> Any:
    (dialog,) = [d for d in window.findChildren(kind) if d.isVisible()]
    return dialog


def test_fiducials_are_imported_to_the_scan_that_the_dialog_shows(
    main_window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    stage, project = main_window.stage, main_window.session.project
    first, _, other = project.scans[:3]
    names = tuple(first.landmarks.points)[:6]
    points = np.array([[100.0 + 3 * k, 200.0] for k in range(6)])
    write_landmarks(tmp_path / "points.csv", points, names)

    def opened() -> FiducialImportDialog:
        stage.context.select_scan(first.id)
        stage.files.fiducials.place(tmp_path / "points.csv")
        stage.context.select_scan(other.id)  # as a reading that ends behind the dialog does
        return shown(main_window, FiducialImportDialog, qtbot)

    opened()._accept("placed")
    assert project.scan(other.id) == other and stage.context.scan_id == first.id
    assert [(project.scan(first.id).landmarks[n].x, project.scan(first.id).landmarks[n].y) for n in names] == [
        tuple(p) for p in points.tolist()
    ]
    main_window.session.stack.undo()
    dialog = opened()
    project.change_scan(first.id, image_key=other.image_key)
    dialog._accept("placed")
    assert "has changed meanwhile" in main_window.message.text.text()
    project.change_scan(first.id, image_key=first.image_key)
    dialog = opened()
    main_window.session.stack.push(RemoveScan(project, first.id))
    dialog._accept("proposed")
    assert "not in the project any more" in main_window.message.text.text()
    assert project.scan(other.id) == other


def test_a_scheme_is_used_on_the_scan_that_the_dialog_is_for_or_nothing_changes(
    main_window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage, session = main_window.stage, main_window.session
    first, other = session.project.scans[0], session.project.scans[2]
    scheme = replace(stage.context.scheme, name="mine")
    result = SchemeResult(scheme, None, {}, True, True, False)
    count = session.stack.count()

    def opened() -> SchemeDialog:
        stage.context.select_scan(first.id)
        main_window.actions_["scan.scheme"].trigger()
        stage.context.select_scan(other.id)
        return shown(main_window, SchemeDialog, qtbot)

    def broken(*_values: object) -> None:
        raise InputError("template", "has no such vertex")

    with monkeypatch.context() as patch:
        patch.setattr(scheme_dialog, "template_for", broken)
        dialog = opened()
        dialog._finish(result)
        assert "no such vertex" in dialog.editor.message.text()
        assert session.stack.count() == count and not session.project.schemes, "refused before anything is done"
    dialog._finish(result)
    assert [item.scheme for item in session.project.scans].count("mine") == 1
    assert session.project.scan(first.id).scheme == "mine" and session.stack.undoText() == "Use scheme mine"
    for _ in range(3):
        opened().close()
        QTest.qWait(30)
    assert not main_window.findChildren(SchemeDialog), "the window's own cross lets go of it like Esc"


def test_fiducials_moved_while_the_mesh_is_looked_at_stay_moved(
    bare_window: MainWindow, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    heads = Heads.load(resources.sample_path("truth.npz"))
    mesh = TriangleMesh(heads.vertices("base"), heads.faces[heads.parts["skin"]])
    file = MeshFile(mesh, None, None, "mm", "", (Path("ada.obj"),))
    start = MeshView(look_at_mm=(0.0, -4.0, 91.0), distance_mm=749.0, width=320, height=240)
    image = view_mesh(file, start)
    truth = {name: mesh.vertices[vertex] for name, vertex in heads.fiducials_of("base").items()}
    stage, project = bare_window.stage, bare_window.session.project
    source = SourceInfo("ada.obj", "mm", "", 320, 240, view=start)
    item = ScanItem(new_id(), "ada", project.add_image(image), source=source)
    bare_window.session.stack.push(AddScan(project, item, image))
    stage.context.select_scan(item.id)
    stage.editor.place("nose_tip", *start.project(truth["nose_tip"])[0])
    stage.editor.place("chin", *(start.project(truth["chin"])[0] + [20.0, -15.0]))
    go, see = threading.Event(), placing.see

    def slow(*values: Any) -> Any:
        go.wait(20)
        return see(*values)

    monkeypatch.setattr(placing, "see", slow)
    item = project.scan(item.id)
    view = replace(start, distance_mm=1.25 * start.distance_mm)
    to_place: Any = SimpleNamespace(file=file)
    stage.files.placing._use(item, to_place, view, item.source.unit)
    QTest.qWait(50)
    stage.editor.move("chin", *start.project(truth["chin"])[0])
    moved = project.scan(item.id).landmarks
    go.set()
    rest(bare_window, qtbot)
    now = project.scan(item.id)
    assert now.source.view == view
    for name in ("nose_tip", "chin"):
        there, right = now.landmarks[name], view.project(truth[name])[0]
        assert np.hypot(there.x - right[0], there.y - right[1]) < 0.5, name
    bare_window.session.stack.undo()
    assert project.scan(item.id).landmarks == moved

    go.clear()
    item, image = project.scan(item.id), project.range_image(item.id)
    see = lambda *_values: Seen(replace(item.source, view=view), image, item.landmarks, "")  # noqa: E731
    stage.files.placing._use(item, to_place, view, item.source.unit)
    QTest.qWait(50)
    project.change_scan(item.id, source=replace(item.source, missing_fraction=0.5))
    go.set()
    rest(bare_window, qtbot)
    assert "place its camera again" in bare_window.message.text.text()
    assert project.scan(item.id).source.view == item.source.view


def test_a_batch_goes_on_without_its_dialog_and_writes_its_report(
    main_window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    quality, session = main_window.stage.quality, main_window.session
    written: list[Path] = []
    quality.start_report = written.append
    main_window.actions_["scan.batch"].trigger()
    panel = quality._batch.panel
    for typed in ("~nobody_of_this_name/x", "/tmp/" + "y" * 300):
        panel.folder.field.setText(typed)
        panel.report.field.setText(typed)
        QTest.qWait(10)
    assert "cannot be written (File name too long)" in panel.note.text() and not panel.start_button.isEnabled()
    panel.report.field.setText(str(tmp_path / "report"))
    panel.folder.field.setText(str(tmp_path / "faces"))
    panel.pattern.setText("all")
    panel.level.setCurrentIndex(panel.level.findData(1))
    count = session.stack.count()
    quality._batch.start()
    assert session.stack.count() == count and "two scans" in panel.note.text(), "refused before a level is set"
    panel.pattern.setText("{name}")
    ready = panel.chosen()
    QTest.mouseClick(panel.start_button, LEFT)
    qtbot.waitUntil(lambda: quality._run.fraction > 0.05, timeout=20_000)
    QTest.keyClick(quality._batch, Qt.Key.Key_Escape)
    QTest.qWait(50)
    main_window.actions_["scan.batch"].trigger()
    assert quality._batch.panel is not panel and quality._batch.panel.cancel_button.isVisible(), "it is found again"
    quality._batch.close()
    qtbot.waitUntil(lambda: not quality._run.running, timeout=60_000)
    rest(main_window, qtbot)
    assert not [result.error for result in quality._run._results.values() if result.error]
    assert len(list((tmp_path / "faces").glob("*.glb"))) == len(ready) > 0
    assert written == [tmp_path / "report.pdf"]
    assert f"{len(ready)} fitted" in main_window.message.text.text()
    main_window.actions_["scan.batch"].trigger()
    texts = [quality._batch.panel.table.item(k, 1).text() for k in range(len(ready))]
    assert all("wrote" in text for text in texts), "what became of them is still told"
    QTest.mouseClick(quality._batch.panel.start_button, LEFT)
    session.new()
    rest(main_window, qtbot)
    assert not quality._run.running and quality._run.fraction == 0.0 and len(written) == 1


def test_keys_in_the_list_of_scans_are_for_scans_and_f6_outlives_the_editor_of_a_name(
    main_window: MainWindow, qtbot: Any
) -> None:
    stage, session = main_window.stage, main_window.session
    view = stage.centre.inputs.scan_list._view
    before, scan_id = session.project.scans, stage.context.scan_id
    stage.context.select_fiducial(next(iter(stage.context.landmarks.points)))
    view.setFocus()
    main_window.actions_.refresh()
    QTest.keyClick(view, Qt.Key.Key_Delete)
    assert session.stack.undoText() == f"Remove {before[0].name}" and scan_id not in session.project
    session.stack.undo()
    assert session.project.scans == before
    stage.centre.canvas_panel.canvas.setFocus()
    stage.context.select_fiducial(next(iter(stage.context.landmarks.points)))
    main_window.actions_.refresh()
    QTest.keyClick(stage.centre.canvas_panel.canvas, Qt.Key.Key_Delete)
    assert session.stack.undoText().startswith("Unset"), "elsewhere it means a fiducial"

    main_window.actions_["scan.rename"].trigger()
    editor = QApplication.focusWidget()
    assert isinstance(editor, QLineEdit) and view.isAncestorOf(editor)
    zones = len(main_window.habits.zones.zones())
    QTest.keyClick(editor, Qt.Key.Key_F6)
    QTest.qWait(50)
    seen = []
    for _ in range(zones):
        seen.append(QApplication.focusWidget())
        QTest.keyClick(seen[-1], Qt.Key.Key_F6)
        QTest.qWait(20)
    assert view in seen, "the keys come back to the list"


def test_my_own_limits_are_kept_or_it_is_told_why_not(
    bare_window: MainWindow, own_home: Path, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    main_window = bare_window
    main_window.actions_["scan.limits"].trigger()
    dialog = shown(main_window, LimitsDialog, qtbot)
    refused: Callable[..., None] = lambda *_a, **_k: (_ for _ in ()).throw(PermissionError(13, "Permission denied"))  # noqa: E731
    with monkeypatch.context() as patch:
        patch.setattr(Path, "mkdir", refused)
        dialog.panel.default_button.click()
    assert "cannot be made (Permission denied)" in dialog.panel.trouble.text()
    dialog.panel.default_button.click()
    assert default_path().is_file()
    dialog.close()
