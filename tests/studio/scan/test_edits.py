"""What clicks mean: proposals follow the placed points, and nothing the user has decided is ever overwritten."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.landmarks import UNSET, Landmark, LandmarkSet, LandmarkState
from studio.project.checks import check_landmark
from studio.scan import edits
from studio.scan.job import scheme_of

SCHEME = scheme_of("closed")
SIZE = (640, 480)
REST = {name: np.array([200.0 + 12.0 * (k % 5), 120.0 + 40.0 * (k // 5)]) for k, name in enumerate(SCHEME.names)}


def propose(known: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Shift the resting positions by the mean shift of the known points."""
    shift = np.mean([np.array(position) - REST[name] for name, position in known.items()], axis=0)
    return {n: tuple(map(float, REST[n] + shift)) for n in SCHEME.names if n not in known}


def place(landmarks: LandmarkSet, count: int, shift: float = 10.0) -> LandmarkSet:
    for name in SCHEME.names[:count]:
        landmarks = edits.moved(landmarks, SCHEME, name, tuple(REST[name] + shift), SIZE, propose)
    return landmarks


def test_the_rest_is_proposed_from_the_fifth_point_on() -> None:
    four, five = place(LandmarkSet({}), 4), place(LandmarkSet({}), 5)
    assert len(edits.located(four, SCHEME)) == 4
    assert len(edits.placed(five, SCHEME)) == 5 and len(edits.located(five, SCHEME)) == 20
    for name in SCHEME.names[5:]:
        assert (five[name].x, five[name].y) == pytest.approx(REST[name] + 10.0)
        assert five[name].state == LandmarkState.PROPOSED


def test_proposals_follow_but_carried_and_decided_points_stay() -> None:
    landmarks = place(LandmarkSet({}), 5)
    carried = Landmark(300.0, 300.0, LandmarkState.PROPOSED)
    landmarks = landmarks.with_points({"chin": carried, "jaw_left": Landmark(state=LandmarkState.SKIPPED)})
    after = edits.moved(landmarks, SCHEME, SCHEME.names[5], tuple(REST[SCHEME.names[5]] + 70.0), SIZE, propose)
    assert after["chin"] == carried and after["jaw_left"].state == LandmarkState.SKIPPED
    assert (after["nose_tip"].x, after["nose_tip"].y) == pytest.approx(REST["nose_tip"] + 20.0)
    assert all(after[name] == landmarks[name] for name in SCHEME.names[:5])


STATES = st.sampled_from([LandmarkState.UNSET, LandmarkState.PROPOSED, LandmarkState.PLACED, LandmarkState.SKIPPED])


@st.composite
def landmark_sets(draw: st.DrawFn) -> LandmarkSet:
    points = {}
    for name in SCHEME.names:
        state, locked = draw(STATES), draw(st.booleans())
        if state in (LandmarkState.PLACED, LandmarkState.PROPOSED):
            x, y = draw(st.floats(0, 639)), draw(st.floats(0, 479))
            points[name] = Landmark(x, y, state, locked)
        elif state == LandmarkState.SKIPPED:
            points[name] = Landmark(state=state)
    return LandmarkSet(points)


def same(first: Landmark, second: Landmark) -> bool:
    places = np.array_equal((first.x, first.y), (second.x, second.y), equal_nan=True)
    return places and (first.state, first.locked) == (second.state, second.locked)


@settings(max_examples=60, deadline=None)
@given(landmark_sets(), st.sampled_from(SCHEME.names), st.floats(-100, 800), st.floats(-100, 800))
def test_placing_one_point_touches_no_other_decision(before: LandmarkSet, name: str, x: float, y: float) -> None:
    after = edits.moved(before, SCHEME, name, (x, y), SIZE, propose)
    for other in SCHEME.names:
        decided = before[other].state in (LandmarkState.PLACED, LandmarkState.SKIPPED) or before[other].locked
        if decided and (other != name or before[name].locked):
            assert same(after[other], before[other])
        if after[other].is_set and not same(after[other], before[other]):
            assert 0 <= after[other].x <= 639 and 0 <= after[other].y <= 479


@settings(max_examples=60, deadline=None)
@given(landmark_sets())
def test_confirming_moves_nothing_and_mirror_overwrites_nothing(before: LandmarkSet) -> None:
    after = edits.confirmed(before, SCHEME)
    assert not after.names(LandmarkState.PROPOSED, order=SCHEME.names)
    np.testing.assert_array_equal(after.positions(SCHEME.names), before.positions(SCHEME.names))
    everywhere = dict.fromkeys(SCHEME.names, (5.0, 5.0))
    offered = edits.proposed(before, SCHEME, everywhere, SIZE)
    for name in SCHEME.names:
        if before[name].state in (LandmarkState.PLACED, LandmarkState.SKIPPED) or before[name].locked:
            assert same(offered[name], before[name])
        else:
            assert offered[name] == Landmark(5.0, 5.0, LandmarkState.PROPOSED)


def test_skip_and_unset_come_back_and_respect_the_lock() -> None:
    landmarks = place(LandmarkSet({}), 3)
    name = SCHEME.names[0]
    once = edits.skipped(landmarks, name)
    assert once[name].state == LandmarkState.SKIPPED and edits.skipped(once, name)[name] == UNSET
    locked = edits.lock_toggled(landmarks, name)
    assert locked[name].locked and edits.unset(locked, name) is locked and edits.skipped(locked, name) is locked
    assert edits.moved(locked, SCHEME, name, (1.0, 1.0), SIZE, propose) is locked
    assert edits.lock_toggled(locked, name) == landmarks


def test_import_places_points_of_the_scheme_and_refuses_others() -> None:
    after = edits.imported(LandmarkSet({}), SCHEME, {"chin": (10.5, 20.25), "elbow": (1, 1)}, SIZE, "f.json")
    assert after.points == {"chin": Landmark(10.5, 20.25, LandmarkState.PLACED)}
    with pytest.raises(InputError, match="no point of scheme"):
        edits.imported(LandmarkSet({}), SCHEME, {"elbow": (1, 1)}, SIZE, "f.json")
    with pytest.raises(InputError, match=r"chin at .* lies outside"):
        edits.imported(LandmarkSet({}), SCHEME, {"chin": (640.0, 3.0)}, SIZE, "f.json")


def test_import_takes_the_whole_border_pixels_as_every_other_check_does() -> None:
    for place, fits in (((-0.5, -0.3), True), ((639.5, 479.4), True), ((-0.51, 3.0), False), ((3.0, 479.6), False)):
        if fits:
            after = edits.imported(LandmarkSet({}), SCHEME, {"chin": place}, SIZE, "f.json")
            assert (after["chin"].x, after["chin"].y) == place
            check_landmark("chin", after["chin"], *SIZE)
        else:
            with pytest.raises(InputError, match="lies outside"):
                edits.imported(LandmarkSet({}), SCHEME, {"chin": place}, SIZE, "f.json")
            with pytest.raises(InputError, match="outside"):
                check_landmark("chin", Landmark(*place, LandmarkState.PLACED), *SIZE)
