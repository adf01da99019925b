"""Every edit can be undone and redone, in any order of edits, back to exactly what was there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

pytest.importorskip("PySide6")

from PySide6.QtGui import QUndoStack

from engine.errors import InputError
from engine.landmarks import UNSET, Landmark, LandmarkSet, LandmarkState
from engine.scan.range_image import RangeImage
from studio.project.document import Project, ScanItem, new_id
from studio.project.qt_project import QtProject
from studio.scan import commands
from studio.scan.commands import (
    AddScan,
    RemoveScan,
    RenameScan,
    SetLandmark,
    SetLandmarks,
    SetOptions,
    SetScheme,
    SetSource,
)
from studio.scan.job import input_key, scheme_of
from studio.scan.options import FitOptions

Make = Callable[..., tuple[Project, str]]
Positions = dict[str, tuple[float, float]]


def visible(project: Project) -> tuple[Any, ...]:
    """All that can be seen of a project."""
    return tuple(
        (item, project.state(item.id), project.fit(item.id), project.last_key(item.id)) for item in project.scans
    )


names = st.sampled_from(scheme_of("open").names)
places = st.builds(
    Landmark, st.floats(0, 159), st.floats(0, 199), st.sampled_from(["placed", "proposed"]), st.booleans()
)
points = st.one_of(places, st.just(UNSET), st.just(Landmark(state=LandmarkState.SKIPPED)))
option_sets = st.builds(FitOptions, levels=st.integers(0, 4), spike_mm=st.floats(0.5, 50), smooth=st.booleans())
edits = st.one_of(
    st.tuples(st.just("landmark"), names, points, st.booleans()),
    st.tuples(st.just("landmarks"), st.dictionaries(names, points, max_size=30)),
    st.tuples(st.just("rename"), st.sampled_from(["man", "she", "eel"]), st.text("abc", max_size=4)),
    st.tuples(st.just("scheme"), st.sampled_from(["closed", "open"])),
    st.tuples(st.just("options"), option_sets),
    st.tuples(st.just("add"), st.integers(0, 3)),
    st.tuples(st.just("remove")),
    st.tuples(st.just("result")),
    st.tuples(st.just("undo")),
    st.tuples(st.just("redo")),
)


def command_of(project: Project, scan_id: str, edit: tuple[Any, ...], face: Any, number: int):
    kind, *values = edit
    item = project.scan(scan_id)
    if kind == "landmark":
        name, point, nudge = values
        return SetLandmark(project, scan_id, name, item.landmarks[name], point, nudge=nudge)
    if kind == "landmarks":
        return SetLandmarks(project, scan_id, item.landmarks, item.landmarks.with_points(values[0]))
    if kind == "rename":
        return RenameScan(project, scan_id, project.unique_name(values[0], scan_id), word=values[1])
    if kind == "scheme":
        return SetScheme(project, scan_id, values[0])
    if kind == "options":
        return SetOptions(project, scan_id, values[0])
    if kind == "add":
        return AddScan(project, replace(item, id=f"new{number}", name=project.unique_name("new")), index=values[0])
    return RemoveScan(project, scan_id)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(edits, min_size=1, max_size=14), st.data())
def test_undo_is_the_inverse_of_every_sequence_of_edits(
    make_project: Make, fiducials: Positions, face, steps: list[tuple[Any, ...]], data: st.DataObject
) -> None:
    project, _ = make_project(fiducials)
    stack = QUndoStack()
    before = visible(project)
    for number, edit in enumerate(steps):
        if edit[0] == "undo":
            stack.undo()
            continue
        if edit[0] == "redo":
            stack.redo()
            continue
        if not project.scans:
            continue
        scan_id = data.draw(st.sampled_from([item.id for item in project.scans]))
        if edit[0] == "result":  # beside the stack: no undo takes it back, and no redo is lost by it
            project.put_fit(scan_id, input_key(project.scan(scan_id)), face)
            continue
        shown = visible(project)
        try:
            command = command_of(project, scan_id, edit, face, number)
        except InputError as error:
            assert "locked" in str(error)
            assert visible(project) == shown
            continue
        assert command.text()
        stack.push(command)
    after = visible(project)
    count = stack.index()
    stack.setIndex(0)
    # Fits are kept beside the stack, so going back can only find more of them, never other ones.
    assert [item for item, *_ in visible(project)] == [item for item, *_ in before]
    stack.setIndex(count)
    assert visible(project) == after


def test_nudges_of_one_point_within_a_second_are_one_step_and_drags_never(
    make_project: Make, fiducials: Positions, monkeypatch: pytest.MonkeyPatch
) -> None:
    project, scan_id = make_project(fiducials)
    stack = QUndoStack()
    clock = [10.0]
    monkeypatch.setattr(commands.time, "monotonic", lambda: clock[0])

    def move(name: str, nudge: bool, after: float) -> None:
        clock[0] += after
        old = project.scan(scan_id).landmarks[name]
        stack.push(SetLandmark(project, scan_id, name, old, replace(old, x=old.x + 0.1), nudge=nudge))

    start = project.scan(scan_id).landmarks
    for _ in range(15):
        move("chin", True, 0.3)
    assert stack.count() == 1
    move("chin", True, 1.5)
    assert stack.count() == 2
    move("nose_tip", True, 0.1)
    assert stack.count() == 3
    move("nose_tip", False, 0.1)
    move("nose_tip", False, 0.1)
    move("nose_tip", True, 0.1)
    assert stack.count() == 6
    for _ in range(6):
        stack.undo()
    assert project.scan(scan_id).landmarks == start


def test_values_of_one_option_within_a_second_are_one_step(
    make_project: Make, fiducials: Positions, monkeypatch: pytest.MonkeyPatch
) -> None:
    project, scan_id = make_project(fiducials)
    stack = QUndoStack()
    clock = [10.0]
    monkeypatch.setattr(commands.time, "monotonic", lambda: clock[0])

    def set_option(after: float, **values: object) -> None:
        clock[0] += after
        options = project.scan(scan_id).options
        stack.push(SetOptions(project, scan_id, options.model_copy(update=values)))

    start = project.scan(scan_id).options
    for number in range(6):
        set_option(0.2, spike_mm=3.0 + number)
    assert stack.count() == 1 and stack.undoText() == "Set spike height (mm) to 8 on base"
    set_option(1.5, spike_mm=9.0)
    assert stack.count() == 2
    set_option(0.1, largest_gap_px=20)
    set_option(0.1, smooth=False, fill_gaps=False)
    set_option(0.1, smooth=True, fill_gaps=True)
    assert stack.count() == 5
    stack.setIndex(1)
    assert project.scan(scan_id).options.spike_mm == 8.0
    stack.undo()
    assert project.scan(scan_id).options == start


def test_another_reading_of_a_file_takes_the_place_of_the_scan(
    make_project: Make, scan: RangeImage, fiducials: Positions, face
) -> None:
    project, scan_id = make_project(fiducials)
    item = project.scan(scan_id)
    project.put_fit(scan_id, input_key(item), face)
    larger = RangeImage(scan.points * 10.0, scan.colour, scan.camera)
    stack = QUndoStack()
    source = replace(item.source, unit="cm", assumed="cm, as asked")
    stack.push(SetSource(project, scan_id, source, larger))
    assert stack.undoText() == "Read base in cm"
    assert project.range_image(scan_id) is larger and project.scan(scan_id).landmarks == item.landmarks
    assert project.state(scan_id).reason == "scan replaced"
    stack.undo()
    assert project.range_image(scan_id) is scan and project.state(scan_id).kind == "fresh"
    small = RangeImage(scan.points[:50, :50], None, None)
    with pytest.raises(InputError, match="outside"):
        SetSource(project, scan_id, source, small)


def test_texts_say_what_is_done(make_project: Make, fiducials: Positions) -> None:
    project, scan_id = make_project(fiducials)
    chin = project.scan(scan_id).landmarks["chin"]

    def text(new: Landmark, **more: Any) -> str:
        return SetLandmark(project, scan_id, "chin", chin, new, **more).text()

    assert text(replace(chin, x=3.0)) == "Move chin on base"
    assert text(replace(chin, x=3.0), nudge=True) == "Nudge chin on base"
    assert text(UNSET) == "Unset chin on base"
    assert text(replace(chin, locked=True)) == "Lock chin on base"
    assert text(Landmark(state=LandmarkState.SKIPPED)) == "Skip chin on base"
    assert text(chin, text="Snap chin") == "Snap chin"
    project.change_scan(scan_id, landmarks=LandmarkSet({"chin": replace(chin, state=LandmarkState.PROPOSED)}))
    old = project.scan(scan_id).landmarks["chin"]
    assert SetLandmark(project, scan_id, "chin", old, chin).text() == "Confirm chin on base"
    assert SetLandmark(project, scan_id, "nose_tip", UNSET, chin).text() == "Place nose_tip on base"
    assert SetOptions(project, scan_id, FitOptions(levels=3)).text() == "Set levels to 3 on base"
    assert SetOptions(project, scan_id, FitOptions(smooth=False)).text() == "Set smooth to off on base"
    assert RenameScan(project, scan_id, "car").text() == "Rename base to car"


def test_what_is_wrong_is_refused_before_it_is_pushed(
    make_project: Make, scan: RangeImage, fiducials: Positions
) -> None:
    project, scan_id = make_project(fiducials)
    item = project.scan(scan_id)
    chin = item.landmarks["chin"]
    inside = Landmark(5.0, 5.0, LandmarkState.PLACED)
    shown = visible(project)
    refused: list[tuple[str, Callable[[], object]]] = [
        ("outside", lambda: SetLandmark(project, scan_id, "chin", chin, replace(chin, x=160.0))),
        ("outside", lambda: SetLandmark(project, scan_id, "chin", chin, replace(chin, y=-0.6))),
        ("finite", lambda: SetLandmark(project, scan_id, "chin", chin, replace(chin, y=float("nan")))),
        ("no scheme", lambda: SetLandmark(project, scan_id, "ear", UNSET, inside)),
        ("outside", lambda: SetLandmarks(project, scan_id, item.landmarks, item.landmarks.moved("chin", 1e9, 0))),
        ("not known", lambda: SetScheme(project, scan_id, "ajar")),
        ("levels", lambda: SetOptions(project, scan_id, FitOptions.model_construct(levels=77))),
        ("empty", lambda: RenameScan(project, scan_id, "  ")),
        ("cannot name a file", lambda: RenameScan(project, scan_id, "../etc")),
        ("not in the project", lambda: RemoveScan(project, "gone")),
        ("belongs to another", lambda: AddScan(project, replace(item, id=new_id()))),
        ("already", lambda: AddScan(project, item)),
        ("without its range image", lambda: AddScan(project, ScanItem(new_id(), "car", "0" * 64))),
        ("not the one it names", lambda: AddScan(project, ScanItem(new_id(), "car", "0" * 64), scan)),
    ]
    for words, make in refused:
        with pytest.raises(InputError, match=words):
            make()
    assert visible(project) == shown
    with pytest.raises(ValueError, match="has changed"):
        SetLandmark(project, scan_id, "chin", inside, inside)


def test_a_locked_point_moves_only_after_it_was_unlocked(make_project: Make, fiducials: Positions) -> None:
    project, scan_id = make_project(fiducials)
    stack = QUndoStack()
    chin = project.scan(scan_id).landmarks["chin"]
    locked = replace(chin, locked=True)
    stack.push(SetLandmark(project, scan_id, "chin", chin, locked))
    with pytest.raises(InputError, match="unlock"):
        SetLandmark(project, scan_id, "chin", locked, replace(locked, x=1.0))
    with pytest.raises(InputError, match="unlock"):
        landmarks = project.scan(scan_id).landmarks
        SetLandmarks(project, scan_id, landmarks, landmarks.moved("chin", 1.0, 1.0))
    stack.push(SetLandmark(project, scan_id, "chin", locked, chin))
    stack.push(SetLandmark(project, scan_id, "chin", chin, replace(chin, x=1.0)))
    assert project.scan(scan_id).landmarks["chin"].x == 1.0


def test_a_result_beside_the_stack_keeps_what_can_be_redone(make_project: Make, fiducials: Positions, face) -> None:
    project, scan_id = make_project(fiducials)
    stack = QUndoStack()
    old = project.scan(scan_id).landmarks["chin"]
    stack.push(SetLandmark(project, scan_id, "chin", old, replace(old, x=old.x + 1)))
    stack.undo()
    project.put_fit(scan_id, input_key(project.scan(scan_id)), face)
    assert stack.canRedo() and project.state(scan_id).kind == "fresh"
    stack.redo()
    assert project.state(scan_id).reason == "fiducials moved"


def test_changes_reach_qt_until_released(make_project: Make) -> None:
    project, scan_id = make_project()
    adapter = QtProject(project)
    heard: list[tuple[str, str]] = []
    adapter.changed.connect(lambda change: heard.append((change.kind, change.id)))
    project.change_scan(scan_id, name="car")
    adapter.release()
    project.change_scan(scan_id, name="man")
    assert heard == [("name", scan_id)]
