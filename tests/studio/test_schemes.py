"""A project's own schemes: put, renamed, removed, undone, stored, and part of what a fit depends on."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtGui import QUndoStack

from engine.errors import InputError
from engine.files.scheme import SchemeEntry, read_scheme, write_scheme
from engine.landmarks import Landmark, LandmarkDefinition, LandmarkScheme, LandmarkState, Side
from engine.scan.fit import FaceFit
from studio.project import store
from studio.project.document import Change, ItemState, Project
from studio.project.header import SharedHeader
from studio.project.recovery import Journal
from studio.scan.commands import AddScan, RemoveScan, SetLandmark, SetScheme
from studio.scan.job import as_command, changes, input_key, inputs_of, run
from studio.scan.options import FitOptions
from studio.scan.scheme_commands import PutScheme, RemoveScheme
from tests.engine.schemes import TEMPLATE, changed, quick, shipped, thorough
from tests.studio.conftest import Make, Positions, face_fiducials
from tests.studio.test_command_line_refusals import refused
from tests.studio.test_project_store_hostile import change_header


def own(name: str = "own") -> LandmarkScheme:
    """The closed scheme with a point of its own on the left ear and no chin."""
    ear = LandmarkDefinition("ear", "ears", Side.LEFT, "", "The ear.", 5)
    marks = (*(mark for mark in shipped("closed") if mark.name != "chin"), ear)
    return LandmarkScheme(name, "without chin", marks)


@pytest.fixture
def placed(make_project: Make, fiducials: Positions) -> tuple[Project, QUndoStack, str]:
    """A project in which one scan uses a scheme of its own, all points placed."""
    project, scan_id = make_project({**fiducials})
    stack = QUndoStack()
    stack.push(PutScheme(project, own()))
    stack.push(SetScheme(project, scan_id, "own"))
    spot = Landmark(30.0, 100.0, LandmarkState.PLACED)
    stack.push(SetLandmark(project, scan_id, "ear", project.scan(scan_id).landmarks["ear"], spot))
    return project, stack, scan_id


def seen(project: Project) -> tuple[object, ...]:
    """Return all that edits can change."""
    return project.scans, dict(project.schemes)


def walk(project: Project, stack: QUndoStack) -> None:
    """Go all the way back and forth twice; every step must be as it was."""
    stack.setIndex(stack.count())
    states = [seen(project)]
    for _ in range(2):
        while stack.canUndo():
            stack.undo()
            states.append(seen(project))
        back = [seen(project)]
        while stack.canRedo():
            stack.redo()
            back.append(seen(project))
        assert back == states[::-1]
        states = [seen(project)]


def test_a_custom_scheme_is_fitted_and_its_fit_goes_stale_with_it(placed: Any) -> None:
    project, stack, scan_id = placed
    item, scan = project.scan(scan_id), project.range_image(scan_id)
    assert project.state(scan_id) == ItemState("missing", "no fit yet")
    inputs = inputs_of(item, scan)
    assert set(inputs.fiducials) == set(own().names)
    project.put_fit(scan_id, input_key(item), run(inputs, FitOptions(levels=0)))
    assert project.state(scan_id).kind == "fresh" and project.fit(scan_id).scheme == "own"

    moved = replace(own(), landmarks=changed(own(), "ear", vertex=6))
    stack.push(PutScheme(project, moved, "own"))
    assert project.state(scan_id) == ItemState("stale", "scheme changed")
    stack.undo()
    assert project.state(scan_id).kind == "fresh"
    stack.push(PutScheme(project, replace(own(), layout="open"), "own"))
    assert project.state(scan_id) == ItemState("stale", "scheme changed")
    stack.undo()
    words = replace(own(), title="x", landmarks=changed(own(), "ear", hint="Elsewhere.", group="g")[::-1])
    stack.push(PutScheme(project, words, "own"))
    assert project.state(scan_id).kind == "fresh", "texts and order change no face"
    stack.push(PutScheme(project, replace(own(), name="mine"), "own"))
    assert project.state(scan_id).kind == "fresh", "nor does what the scheme is called"
    walk(project, stack)


def test_a_scheme_of_the_same_points_is_told_from_the_shipped_one(make_project: Make, fiducials: Positions) -> None:
    project, scan_id = make_project(fiducials)
    before = input_key(project.scan(scan_id))
    PutScheme(project, replace(shipped("closed"), name="own")).redo()
    SetScheme(project, scan_id, "own").redo()
    assert changes(before, input_key(project.scan(scan_id))) == ("scheme changed",)


def test_renaming_a_fiducial_carries_its_points_along_in_one_step(placed: Any, fiducials: Positions) -> None:
    project, stack, scan_id = placed
    other = replace(project.scan(scan_id), id="other", name="other")
    stack.push(AddScan(project, other))
    aside = replace(other, id="aside", name="aside", scheme="closed", custom=None)
    stack.push(AddScan(project, aside))
    ear, tip = other.landmarks["ear"], other.landmarks["nose_tip"]
    marks = changed(
        replace(own(), landmarks=changed(own(), "ear", name="ear_left")), "nose_tip", name="tip", mirror="tip"
    )
    count = stack.count()
    stack.push(PutScheme(project, replace(own(), landmarks=marks), "own", {"ear": "ear_left", "nose_tip": "tip"}))
    assert stack.count() == count + 1
    for user in (scan_id, "other"):
        landmarks = project.scan(user).landmarks
        assert landmarks["ear_left"] == ear and landmarks["tip"] == tip
        assert "ear" not in landmarks.points and "nose_tip" not in landmarks.points
    landmarks = project.scan("aside").landmarks
    assert landmarks["nose_tip"] == tip, "a scan of another scheme keeps that scheme's point"
    assert landmarks["ear_left"] == ear and "ear" not in landmarks.points, "and follows with what only this one has"
    walk(project, stack)


def test_names_that_are_exchanged_exchange_their_points(placed: Any) -> None:
    project, stack, scan_id = placed
    before = project.scan(scan_id).landmarks
    swap = {"lip_upper": "lip_lower", "lip_lower": "lip_upper"}
    marks = tuple(replace(m, name=swap.get(m.name, m.name), mirror=swap.get(m.mirror, m.mirror)) for m in own())
    stack.push(PutScheme(project, replace(own(), landmarks=marks), "own", swap))
    after = project.scan(scan_id).landmarks
    assert (after["lip_upper"], after["lip_lower"]) == (before["lip_lower"], before["lip_upper"])
    walk(project, stack)


def test_points_that_no_scheme_knows_any_more_are_taken_off_and_come_back(placed: Any, tmp_path: Path) -> None:
    project, stack, scan_id = placed
    marks = tuple(mark for mark in own() if mark.name not in ("ear", "nose_tip"))
    stack.push(PutScheme(project, replace(own(), landmarks=marks), "own"))
    assert "ear" not in project.scan(scan_id).landmarks.points
    assert project.scan(scan_id).landmarks["nose_tip"].is_set, "the closed scheme knows it"
    stack.undo()
    assert project.scan(scan_id).landmarks["ear"].is_set
    stack.push(SetScheme(project, scan_id, "closed"))
    stack.push(RemoveScheme(project, "own"))
    assert "ear" not in project.scan(scan_id).landmarks.points and not project.schemes
    assert seen(store.load(store.save(project, tmp_path / "faces.qface"))) == seen(project)
    stack.undo()
    assert project.scan(scan_id).landmarks["ear"].is_set
    stack.redo()
    walk(project, stack)


def test_what_cannot_be_done_changes_nothing(placed: Any) -> None:
    project, _stack, scan_id = placed
    before = seen(project)
    heard: list[Change] = []
    project.subscribe(heard.append)
    outside = replace(own("other"), landmarks=changed(own(), "ear", vertex=9999))
    for deed, words in (
        (lambda: RemoveScheme(project, "own"), "own: is used by base"),
        (lambda: RemoveScheme(project, "closed"), "comes with the program"),
        (lambda: RemoveScheme(project, "none"), "is not in the project"),
        (lambda: PutScheme(project, own()), "is in the project already"),
        (lambda: PutScheme(project, own("closed")), "has the name of one that comes with the program"),
        (lambda: PutScheme(project, own("new"), "none"), "none: is not in the project"),
        (lambda: PutScheme(project, outside), "ear, vertex: vertex 9999 is not one of"),
        (lambda: PutScheme(project, own(), "own", {"ear": "nowhere"}), "no fiducial to rename ear to nowhere"),
        (lambda: SetScheme(project, scan_id, "none"), "'none': is not known"),
        (lambda: AddScan(project, replace(project.scan(scan_id), id="x", name="x", scheme="no", custom=None)), "'no'"),
    ):
        with pytest.raises(InputError, match=words):
            deed()
    assert seen(project) == before and heard == []


def test_a_removed_scan_comes_back_with_the_scheme_as_it_is(placed: Any) -> None:
    project, stack, scan_id = placed
    stack.push(RemoveScan(project, scan_id))
    stack.undo()
    assert project.scan(scan_id).custom == project.schemes["own"]
    walk(project, stack)


def test_schemes_are_stored_and_journalled(placed: Any, tmp_path: Path) -> None:
    project, stack, scan_id = placed
    stack.push(PutScheme(project, thorough()))
    again = store.load(store.save(project, tmp_path / "faces.qface"))
    assert seen(again) == seen(project) and list(again.schemes) == ["own", "thorough"]
    assert input_key(again.scan(scan_id)) == input_key(project.scan(scan_id))
    copy = Project()
    text = SharedHeader.of(project).model_dump_json()
    SharedHeader.model_validate_json(text).give(copy)
    assert dict(copy.schemes) == dict(project.schemes)
    assert set(SharedHeader.model_fields) <= set(Journal.model_fields)


def _spoil(entry: dict[str, Any]) -> dict[str, Any]:
    return {**json.loads(SchemeEntry.of(own()).model_dump_json()), **entry}


HEADERS: dict[str, tuple[list[dict[str, Any]], str]] = {
    "name of a shipped one": ([_spoil({"name": "closed"})], "schemes.*comes with the program"),
    "two of a name": ([_spoil({}), _spoil({})], "schemes.*belongs to two schemes"),
    "path as name": ([_spoil({"name": "../own"})], r"schemes.*other signs"),
    "no fiducials": ([_spoil({"landmark": []})], "schemes.*too few"),
    "bad layout": ([_spoil({"layout": "ajar"})], r"schemes\.0\.layout"),
    "none at all": ([], "ear: is in no scheme"),
}


@pytest.mark.parametrize("kind", HEADERS)
def test_a_bad_scheme_in_a_project_is_named(placed: Any, tmp_path: Path, kind: str) -> None:
    path = store.save(placed[0], tmp_path / "faces.qface")
    entries, words = HEADERS[kind]
    change_header(path, lambda header: header.update(schemes=entries))
    with pytest.raises(InputError, match=words) as caught:
        store.load(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_the_copied_command_names_the_file_of_the_scheme(placed: Any) -> None:
    project, _stack, scan_id = placed
    item = project.scan(scan_id)
    assert "--scheme own.toml" in as_command(item, item.options)


def test_the_command_line_fits_with_a_scheme_of_a_file(folder: Path, capsys: Any) -> None:
    from studio.cli import main

    write_scheme(folder / "quick.toml", quick())
    places = {name: place for name, place in face_fiducials().items() if name in quick()}
    size = json.loads((folder / "f.json").read_text())["image_size"]
    (folder / "q.json").write_text(json.dumps({"image_size": size, "points": places}))
    words = "scan fit base.json --fiducials q.json --out face.glb --levels 0 --json --scheme"
    assert main([*words.split(), "quick.toml"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["scheme"] == "quick" and figures["fiducial_residual_px"] < 1e-6
    assert main(["scheme", "check", "quick.toml", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["fiducials"] == 12 and told["vertices"]["chin"] == TEMPLATE.layout("closed").fiducials["chin"]
    assert told["remarks"] == []


def test_schemes_that_cannot_be_used_are_refused_on_the_command_line(folder: Path, capfd: Any) -> None:
    wrong = replace(quick(), landmarks=changed(quick(), "chin", vertex=440))
    write_scheme(folder / "quick.toml", wrong)
    assert read_scheme(folder / "quick.toml") == wrong
    fit = "scan fit base.json --fiducials f.json --out face.glb --scheme"
    refused(capfd, ["scheme", "check", "quick.toml"], "quick.toml, scheme quick, chin, side")
    refused(capfd, [*fit.split(), "quick.toml"], "scheme quick, chin, side")
    refused(capfd, [*fit.split(), "none.toml"], "none.toml")
    refused(capfd, [*fit.split(), "ajar"], "--scheme 'ajar'")
    write_scheme(folder / "face.toml", quick())
    words = fit.replace("face.glb", "face.obj").split()
    refused(capfd, [*words, "face.toml"], "f.json")


def test_a_fit_is_the_same_however_its_scheme_is_called(placed: Any, face: FaceFit) -> None:
    project, _stack, scan_id = placed
    item, scan = project.scan(scan_id), project.range_image(scan_id)
    places = {name: place for name, place in inputs_of(item, scan).fiducials.items() if name != "ear"}
    whole = {**places, "chin": face_fiducials()["chin"]}
    same = replace(shipped("closed"), name="same")
    first = run(replace(inputs_of(item, scan), scheme=same, fiducials=whole), FitOptions(levels=1))
    assert abs(first.mesh.vertices - face.mesh.vertices).max() < 1e-9
