"""Constants outlive any number of calls into bindings that forget to count them."""

from __future__ import annotations

import sys

import pytest
from PySide6.QtCore import QObject, Signal

import widgets
from widgets.constants_guard import PLENTY, protect

mortal = pytest.mark.skipif(sys.version_info >= (3, 12), reason="from Python 3.12 on these constants cannot die")


class Bell(QObject):
    rung = Signal(float)


@mortal
@pytest.mark.parametrize("constant", [None, True, False, NotImplemented])
def test_the_counts_are_beyond_what_a_session_can_use_up(constant: object) -> None:
    assert widgets.protect is protect
    assert sys.getrefcount(constant) > PLENTY // 2


@mortal
def test_protecting_twice_changes_nothing() -> None:
    before = sys.getrefcount(None)
    protect()
    assert abs(sys.getrefcount(None) - before) < 1000


def test_a_hundred_thousand_calls_without_a_result_are_survived(qapp: object) -> None:
    bell, heard = Bell(), []
    bell.rung.connect(heard.append)
    for _ in range(100_000):
        bell.setObjectName("bell")
    for _ in range(5_000):
        bell.rung.emit(1.0)
    assert len(heard) == 5_000
    assert bell.objectName() == "bell"
