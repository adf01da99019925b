"""What a project derives: states with their reasons, results by content, and who is told what."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from engine.errors import InputError
from engine.landmarks import Landmark, LandmarkSet, LandmarkState
from engine.scan.range_image import RangeImage
from studio.project import document
from studio.project.document import Change, ItemState, Project, ScanItem, content_key, new_id
from studio.scan.job import changes, input_key, inputs_of, repair_options, scheme_of
from studio.scan.options import FitOptions

Make = Callable[..., tuple[Project, str]]
Positions = dict[str, tuple[float, float]]


def set_points(project: Project, scan_id: str, **states: LandmarkState) -> None:
    landmarks = project.scan(scan_id).landmarks
    points = {name: replace(landmarks[name], state=state) for name, state in states.items()}
    project.change_scan(scan_id, landmarks=landmarks.with_points(points))


def test_what_is_missing_is_named(make_project: Make, fiducials: Positions) -> None:
    project, scan_id = make_project()
    assert project.state(scan_id) == ItemState("missing", "no fiducials")
    project.change_scan(scan_id, landmarks=LandmarkSet.placed({n: fiducials[n] for n in list(fiducials)[:17]}))
    assert project.state(scan_id) == ItemState("missing", "3 fiducials to place")
    project.change_scan(scan_id, landmarks=LandmarkSet.placed(fiducials))
    assert project.state(scan_id) == ItemState("missing", "no fit yet")
    set_points(project, scan_id, chin=LandmarkState.PROPOSED)
    assert project.state(scan_id) == ItemState("missing", "1 fiducial to confirm")
    set_points(project, scan_id, chin=LandmarkState.SKIPPED)
    assert project.state(scan_id) == ItemState("missing", "no fit yet")
    landmarks = project.scan(scan_id).landmarks.with_points(
        {"chin": Landmark(), "nose_tip": replace(project.scan(scan_id).landmarks["nose_tip"], state="proposed")}
    )
    project.change_scan(scan_id, landmarks=landmarks)
    assert project.state(scan_id) == ItemState("missing", "1 fiducial to place, 1 to confirm")
    names = list(fiducials)
    skipped = LandmarkSet({n: Landmark(state=LandmarkState.SKIPPED) for n in names[3:]})
    three = LandmarkSet.placed({n: fiducials[n] for n in names[:3]}).points
    project.change_scan(scan_id, landmarks=skipped.with_points(three))
    assert project.state(scan_id) == ItemState("missing", "1 more to place (too many are skipped)")


def test_a_result_is_fresh_for_its_inputs_and_stale_with_the_reason_for_others(
    make_project: Make, fiducials: Positions, face
) -> None:
    project, scan_id = make_project(fiducials)
    first = project.scan(scan_id)
    project.put_fit(scan_id, input_key(first), face)
    assert project.state(scan_id) == ItemState("fresh")

    moved = first.landmarks.moved("chin", 80.0, 180.0)
    project.change_scan(scan_id, landmarks=moved)
    assert project.state(scan_id) == ItemState("stale", "fiducials moved")
    assert project.fit(scan_id) is face
    project.change_scan(scan_id, options=FitOptions(levels=3))
    assert project.state(scan_id) == ItemState("stale", "fiducials moved, options changed")
    project.replace_scan(first)
    assert project.state(scan_id) == ItemState("fresh")

    # The old result stays the one of the old inputs after a new one has come.
    project.change_scan(scan_id, landmarks=moved)
    other = replace(face, levels=0)
    project.put_fit(scan_id, input_key(project.scan(scan_id)), other)
    assert project.state(scan_id).kind == "fresh" and project.fit(scan_id) is other
    project.replace_scan(first)
    assert project.state(scan_id).kind == "fresh" and project.fit(scan_id) is face


def test_scheme_change_is_named_once_and_locks_and_foreign_points_do_not_matter(
    make_project: Make, fiducials: Positions, face
) -> None:
    project, scan_id = make_project(fiducials)
    item = project.scan(scan_id)
    key = input_key(item)
    project.put_fit(scan_id, key, face)
    locked = item.landmarks.with_point("chin", replace(item.landmarks["chin"], locked=True))
    inner = [name for name in scheme_of("open").names if name not in scheme_of("closed").names]
    foreign = locked.with_points(LandmarkSet.placed(dict.fromkeys(inner, (80.0, 130.0))).points)
    project.change_scan(scan_id, landmarks=foreign)
    assert input_key(project.scan(scan_id)) == key and project.state(scan_id).kind == "fresh"
    project.change_scan(scan_id, scheme="open")
    assert project.state(scan_id) == ItemState("stale", "scheme changed")
    assert changes(key, key) == ()
    assert changes(key, key.replace("m1-", "m2-")) == ("made by another version",)


def test_results_are_bounded_but_the_last_of_every_scan_is_kept(scan: RangeImage, fiducials: Positions, face) -> None:
    project = Project(keep_fits=5)
    image_key = project.add_image(scan)
    for name in ("base", "car"):
        item = ScanItem(new_id(), name, image_key, landmarks=LandmarkSet.placed(fiducials))
        project.insert_scan(99, item)
    base, car = (item.id for item in project.scans)
    first = input_key(project.scan(base))
    project.put_fit(base, first, face)
    for step in range(20):
        project.change_scan(car, landmarks=project.scan(car).landmarks.moved("chin", 80.0, 150.0 + step))
        project.put_fit(car, input_key(project.scan(car)), face)
    assert project.has_fit(first)
    assert len(project._fits) == 5
    assert project.state(base).kind == project.state(car).kind == "fresh"


def test_results_are_bounded_in_bytes_too(make_project: Make, fiducials: Positions, face) -> None:
    project, scan_id = make_project(fiducials)
    project._keep_bytes = 3 * document._bytes(face)
    for step in range(9):
        project.change_scan(scan_id, landmarks=project.scan(scan_id).landmarks.moved("chin", 80.0, 150.0 + step))
        project.put_fit(scan_id, input_key(project.scan(scan_id)), face)
    assert len(project._fits) == 3 and project.state(scan_id).kind == "fresh"


def test_removed_scans_come_back_whole(make_project: Make, fiducials: Positions, face) -> None:
    project, scan_id = make_project(fiducials)
    project.put_fit(scan_id, input_key(project.scan(scan_id)), face)
    item = project.remove_scan(scan_id)
    assert project.scans == () and scan_id not in project
    project.insert_scan(0, item)
    assert project.state(scan_id).kind == "fresh" and project.fit(scan_id) is face
    with pytest.raises(InputError, match="already"):
        project.insert_scan(0, item)
    with pytest.raises(InputError, match="range image"):
        Project().insert_scan(0, item)


def test_subscribers_hear_every_side_that_changed_and_nothing_after_they_left(make_project: Make) -> None:
    project, scan_id = make_project()
    heard: list[Change] = []
    leave = project.subscribe(heard.append)
    project.change_scan(scan_id, name="car", scheme="open")
    assert heard == [Change("name", scan_id), Change("scheme", scan_id)]
    heard.clear()
    project.change_scan(scan_id, name="car")
    assert heard == []
    project.remove_scan(scan_id)
    assert heard == [Change("removed", scan_id)]
    leave()
    leave()
    project.insert_scan(0, ScanItem(new_id(), "new", next(iter(project._images))))
    assert len(heard) == 1


def test_names_are_made_unique(make_project: Make) -> None:
    project, scan_id = make_project()
    assert project.unique_name("car") == "car"
    assert project.unique_name("base") == "base 2"
    assert project.unique_name("base", besides=scan_id) == "base"


def test_content_key_tells_every_side_of_a_scan_apart(scan: RangeImage) -> None:
    points = scan.points.copy()
    points[5, 5, 2] = np.nextafter(points[5, 5, 2], 0.0)
    colour = scan.colour.copy()
    colour[0, 0, 0] ^= 1
    keys = {
        content_key(scan),
        content_key(RangeImage(points, scan.colour, scan.camera)),
        content_key(RangeImage(scan.points, colour, scan.camera)),
        content_key(RangeImage(scan.points, None, scan.camera)),
        content_key(RangeImage(scan.points, scan.colour)),
    }
    assert len(keys) == 5
    assert content_key(RangeImage(scan.points.copy(), scan.colour.copy(), scan.camera)) in keys


def test_fit_inputs_leave_out_what_is_not_placed(make_project: Make, scan: RangeImage, fiducials: Positions) -> None:
    project, scan_id = make_project(fiducials)
    set_points(project, scan_id, chin=LandmarkState.PROPOSED, jaw_left=LandmarkState.SKIPPED)
    inputs = inputs_of(project.scan(scan_id), scan)
    assert set(fiducials) - set(inputs.fiducials) == {"chin", "jaw_left"}


def test_option_defaults_are_those_of_the_engine_and_limits_hold() -> None:
    from engine.scan.repair import RepairOptions

    assert repair_options(FitOptions()) == RepairOptions()
    for field, bad in (("levels", 5), ("levels", -1), ("spike_mm", float("nan")), ("largest_gap_px", 0)):
        with pytest.raises(InputError, match=field):
            FitOptions.checked(**{field: bad})
    with pytest.raises(InputError, match="nonsense"):
        FitOptions.checked(nonsense=1)
