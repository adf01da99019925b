"""Long motion in little memory: what is allocated, what is read, and how soon it stops."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.basis.principal import principal_basis
from engine.errors import Cancelled, InputError
from engine.motion import MeshMotion
from tests.engine.basis.motions import dense, driven, factored, misaligned, streamed

MB = 2**20


def peak_mb(work: Callable[[], object]) -> float:
    """Return the most that ``work`` had allocated at once, MB."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1] / MB
    finally:
        tracemalloc.stop()


@pytest.fixture(scope="module")
def long_motion() -> MeshMotion:
    """2,400 frames of 1,500 vertices in single precision: 41 MB."""
    return dense(factored(vertices=1500, markers=12, frames=2400, fade=0.8), np.float32)


@pytest.mark.parametrize("memory", [6, 24])
def test_no_more_is_allocated_than_was_allowed_and_the_answer_is_the_same(long_motion: MeshMotion, memory: int) -> None:
    free = principal_basis(long_motion, count=8)
    assert peak_mb(lambda: principal_basis(long_motion, count=8, memory_mb=memory)) < memory
    tight = principal_basis(long_motion, count=8, memory_mb=memory)
    np.testing.assert_allclose(tight.eigenvalues[:8], free.eigenvalues[:8], rtol=1e-6)
    assert misaligned(tight.axes, free.axes) < 1e-5


def test_a_memory_mapped_file_is_read_in_pieces_and_not_copied(long_motion: MeshMotion, tmp_path: Path) -> None:
    assert long_motion.vertices is not None
    np.save(tmp_path / "take.npy", long_motion.vertices)
    mapped = np.load(tmp_path / "take.npy", mmap_mode="r")
    motion = MeshMotion.dense(mapped, long_motion.neutral, 120.0)
    assert motion.vertices is mapped
    assert peak_mb(lambda: principal_basis(motion, count=8, memory_mb=16)) < 16 < mapped.nbytes / MB
    assert np.array_equal(principal_basis(motion, count=8).axes, principal_basis(long_motion, count=8).axes)


def test_chunks_that_a_reader_makes_count_too(long_motion: MeshMotion) -> None:
    assert long_motion.vertices is not None
    positions = long_motion.vertices

    def read(start: int, stop: int) -> np.ndarray:
        return positions[start:stop].astype(np.float64)

    motion = MeshMotion.streamed(read, len(positions), long_motion.neutral, 120.0)
    assert peak_mb(lambda: principal_basis(motion, count=8, memory_mb=16)) < 16


def test_too_little_memory_says_how_many_axes_it_holds(long_motion: MeshMotion) -> None:
    with pytest.raises(InputError, match=r"memory: 2 MB hold at most \d axes of 1500 vertices, 20 are wanted; allow"):
        principal_basis(long_motion, count=20, memory_mb=2)
    with pytest.raises(InputError, match=r"memory: 1 MB hold at most \d axes of 1500 vertices, a coverage of 0.999"):
        principal_basis(long_motion, coverage=0.999, memory_mb=1)
    with pytest.raises(InputError, match=r"memory: 64 MB do not hold what the axes of 2400 frames need; allow \d+ MB"):
        principal_basis(long_motion, coverage=1.0, memory_mb=64)


@pytest.mark.parametrize("length", [200, 1200])
def test_cancelling_stops_after_the_piece_at_hand(length: int) -> None:
    motion, read = driven(vertices=300, frames=length), [0]
    whole = streamed(motion)

    def counting(start: int, stop: int) -> np.ndarray:
        read[0] += stop - start
        assert whole.read is not None
        return np.asarray(whole.read(start, stop))

    calls = [0]

    def cancel(fraction: float, text: str) -> None:
        calls[0] += 1
        if calls[0] == 3:
            raise Cancelled

    form = MeshMotion.streamed(counting, length, motion.neutral, 60.0)
    with pytest.raises(Cancelled):
        principal_basis(form, count=5, memory_mb=4, progress=cancel)
    stopped, read[0] = read[0], 0
    principal_basis(form, count=5, memory_mb=4)
    assert stopped <= read[0] / 2


@pytest.mark.parametrize("form", [driven, factored, lambda: dense(driven()), lambda: dense(driven(frames=50))])
def test_progress_only_rises_and_ends_at_one(form: Callable[[], MeshMotion]) -> None:
    told: list[float] = []
    principal_basis(form(), count=4, vertices=np.arange(40), progress=lambda fraction, text: told.append(fraction))
    assert told == sorted(told) and told[-1] == 1.0 and told[0] >= 0 and len(told) > 2
