"""Windows for the journeys: shown, driven, closed, and nothing left of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from studio.app import make_window
from studio.settings import Settings
from tests.journeys.driver import Hand


@pytest.fixture
def hands(qtbot: Any, monkeypatch: pytest.MonkeyPatch, own_home: Any) -> Iterator[Callable[[], Hand]]:
    """Return what opens a window with 3-D and gives it to a hand; all are closed without a question."""
    opened: list[Hand] = []

    def open_window() -> Hand:
        hand = Hand(make_window(Settings()), qtbot, monkeypatch)
        opened.append(hand)
        hand.show()
        return hand

    yield open_window
    for hand in opened:
        close(hand)


@pytest.fixture
def hand(hands: Callable[[], Hand]) -> Hand:
    """Return the hand of one shown window."""
    return hands()


def close(hand: Hand) -> None:
    """Close a window for good."""
    import shiboken6

    if shiboken6.isValid(hand.window):
        hand.window.session.stack.setClean()
        hand.window.close()
        hand.window.deleteLater()
