"""Twenty studios are killed in the middle of their work; what was done more than a second before is there again."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from studio.recovery_keeper import recovery_folder
from studio.restore import RestoreDialog
from tests.journeys.driver import Hand
from tests.journeys.kill.killer import MOMENTS, Killed, find_rest, kill_one, make_material, recovery_folder_of
from tests.journeys.kill.stalls import USUAL, Stalls, held_up
from tests.journeys.kill.state import digest

KILLS, AT_ONCE = 20, 3


@pytest.fixture(scope="module")
def killed(qapp: Any, tmp_path_factory: pytest.TempPathFactory) -> list[Killed]:
    """Kill twenty studios, at any time and in the middle of a saving, of writing a piece, and of a fit."""
    folder = tmp_path_factory.mktemp("kill")
    material = make_material(folder / "material")
    seed = secrets.randbelow(10**6)
    print(f"kill test, first seed {seed}")
    with Stalls(folder) as stalls, ThreadPoolExecutor(AT_ONCE) as pool:
        seeds = range(seed, seed + KILLS)
        return list(pool.map(lambda one: kill_one(one, material, folder / str(one), stalls), seeds))


@pytest.mark.timeout(600)
def test_nothing_older_than_a_second_is_lost_and_nothing_is_left_lying_about(killed: list[Killed]) -> None:
    assert len({one.moment for one in killed}) >= 2 and sum(len(one.states) for one in killed) > 2 * KILLS
    left = [find_rest(one) for one in killed[:-1]]
    assert any(one.restored for one in left), "no studio was killed with unsaved work: the test says nothing"


@pytest.mark.timeout(300)
def test_the_window_offers_what_a_killed_studio_left(
    killed: list[Killed],
    hands: Callable[[], Hand],
    qtbot: Any,
) -> None:
    one = killed[-1]
    recovery_folder().parent.mkdir(parents=True, exist_ok=True)
    if recovery_folder_of(one).is_dir():
        shutil.copytree(recovery_folder_of(one), recovery_folder())
    hand = hands()
    dialogs = [dialog for dialog in hand.window.findChildren(RestoreDialog) if dialog.isVisible()]
    if dialogs:
        QTest.keyClick(dialogs[0], Qt.Key.Key_Return)
        hand.rest()
    elif (file := one.folder / "work" / "face.qface").exists():
        hand.window.open_project(file)
    assert digest(hand.window.session.project) in one.allowed, str(one)


def test_a_state_that_is_too_old_would_be_noticed(tmp_path: Path) -> None:
    """The control: of a line of states only those of the last second, and the one before them, will do.

    That the studio itself said nothing for long excuses nothing; only what the machine was held up for is added.
    """
    reports = tuple({"t": time, "digest": f"{time}"} for time in (1.0, 5.0, 8.0, 9.5))

    def allowed(killed: float, stalled: float = 0.0) -> set[str]:
        return Killed(0, tmp_path, reports, MOMENTS[0], killed, stalled).allowed

    assert allowed(10.0) == {"8.0", "9.5"}
    assert allowed(20.0) == {"9.5"}
    assert allowed(1.5) == {"1.0", "5.0", "8.0", "9.5"}
    assert allowed(10.0, stalled=1.5) == {"5.0", "8.0", "9.5"}


def test_only_gaps_of_the_machine_count_and_only_within_the_time_asked_for() -> None:
    times = [0.0, 0.1, 0.2, 2.2, 2.3, 5.3]
    assert held_up(times, 0.0, 2.5) == pytest.approx(2.0 - USUAL)
    assert held_up(times, 1.2, 2.5) == pytest.approx(1.0)
    assert held_up(times, 0.0, 3.3) == pytest.approx(2.0 - USUAL + 1.0 - USUAL)
    assert held_up(times, 0.0, 0.15) == 0.0 and held_up([], 0.0, 9.0) == 0.0
