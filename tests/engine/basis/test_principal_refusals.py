"""Requests and motions without principal axes: each is refused in one line that says what is possible."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from engine.basis.principal import PrincipalBasis, principal_basis
from engine.errors import InputError
from engine.motion import MeshMotion
from tests.engine.basis.motions import FORMS, dense, factored


@pytest.mark.parametrize("form", ["factored", "driven", "dense", "streamed", "dense, few frames"])
def test_what_does_not_move_is_said_to_and_no_axis_is_made_up(form: str) -> None:
    motion = FORMS[form]()
    still = motion.displacements(7, 8)[0]
    if form == "factored":
        assert motion.phi is not None and motion.markers is not None
        frozen = MeshMotion.factored(motion.phi, np.repeat(motion.markers[7:8], 300, axis=0), motion.neutral, 120.0)
    elif form == "driven":
        assert motion.basis is not None and motion.weights is not None
        frozen = MeshMotion.driven(motion.basis, np.repeat(motion.weights[7:8], 300, axis=0), 120.0)
    else:
        length = 20 if "few" in form else 300
        positions = np.repeat((motion.neutral + still)[None], length, axis=0)
        frozen = MeshMotion.dense(positions, motion.neutral, 120.0)
    with pytest.raises(
        InputError, match=r"motion: frames 1 to \d+ do not differ.*choose a range in which the face moves"
    ):
        principal_basis(frozen)


@pytest.mark.parametrize("form", ["factored", "dense", "streamed, few frames", "dense, few frames"])
def test_more_axes_than_there_are_says_how_many_are_possible(form: str) -> None:
    with pytest.raises(InputError, match="count: is 28, but the frames differ along 27 axes only; give at most 27"):
        principal_basis(FORMS[form](), count=28)
    assert principal_basis(FORMS[form](), count=27).count == 27


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"coverage": 0.0}, "coverage: is 0; give a share above 0"),
        ({"coverage": 1.5}, "coverage: is 1.5"),
        ({"coverage": float("nan")}, "coverage: is nan"),
        ({"count": 0}, "count: is 0; give a whole number"),
        ({"count": 2.5}, "count: is 2.5"),
        ({"train": (0, 321)}, "training range: frames 1 to 321 do not lie in 1 to 320"),
        ({"train": (-1, 20)}, "training range: frames 0 to 20 do not lie"),
        ({"train": (20, 20)}, "training range: frames 21 to 20 do not lie"),
        ({"train": (20, 21)}, "training range: has one frame; give at least two"),
        ({"vertices": []}, "vertices: have shape"),
        ({"vertices": [0, 120]}, "vertices: run from 0 to 120, the mesh has 120"),
        ({"memory_mb": 0}, "memory: is 0 MB"),
    ],
)
@pytest.mark.parametrize("form", [factored, lambda: dense(factored())])
def test_wrong_requests_are_refused_in_one_line(
    form: Callable[[], MeshMotion], arguments: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message) as refused:
        principal_basis(form(), **arguments)  # type: ignore[arg-type]
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("length", [60, 400])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_position_that_is_not_finite_is_named_by_its_frame(bad: float, length: int) -> None:
    motion = dense(factored(frames=length))
    assert motion.vertices is not None
    positions = motion.vertices.copy()
    positions[41, 3, 1] = bad
    positions[43, 3, 1] = -bad
    broken = MeshMotion.dense(positions, motion.neutral, 120.0)
    for form in (broken, MeshMotion.streamed(lambda a, b: positions[a:b], length, motion.neutral, 120.0)):
        with pytest.raises(InputError, match="motion, frame 42: holds positions that are not finite"):
            principal_basis(form, train=(10, length))
        assert principal_basis(form, train=(44, length)).count


def test_coordinates_of_another_topology_are_refused() -> None:
    found = principal_basis(factored(), count=3)
    with pytest.raises(InputError, match=r"displacements: have shape \(7, 3\) for 120 vertices"):
        found.coordinates(np.zeros((7, 3)))
    assert found.coordinates(found.mean).shape == (3,)
    assert isinstance(found, PrincipalBasis) and not found.axes.flags.writeable
