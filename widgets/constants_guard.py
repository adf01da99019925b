"""Keeps ``None``, ``True``, ``False`` and ``NotImplemented`` alive under bindings that forget to count them.

PySide6 6.12 returns these constants without taking a reference, which is right from CPython 3.12 on, where they cannot
die. Under 3.11 every call without a result takes one reference of ``None`` away, and after some thousand of them the
interpreter aborts ("deallocating None"). A count no session can use up makes them as lasting as they are in 3.12.
"""

from __future__ import annotations

import ctypes
import sys

PLENTY = 1 << 40


def protect() -> None:
    """Raise the reference counts of the four constants where they are mortal; once is enough."""
    if sys.version_info >= (3, 12) or sys.implementation.name != "cpython":
        return
    for constant in (None, True, False, NotImplemented):
        count = ctypes.c_ssize_t.from_address(id(constant))
        if abs(count.value - sys.getrefcount(constant)) < 64 and count.value < PLENTY:
            count.value += PLENTY
