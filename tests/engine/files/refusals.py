"""What every test of damaged files asks: one ``InputError`` of one line, or a value."""

from __future__ import annotations

import pytest

from engine.errors import InputError

SMALL = {"width": 8, "height": 6}


def refused(reader, path) -> str:
    """The message of the InputError that ``reader`` raises; anything else fails the test."""
    with pytest.raises(InputError) as caught:
        reader(path)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 400 + len(str(path)) * 2
    return message


def refused_or_read(reader, path) -> None:
    """Read, or be refused: damage that happens to be legal cannot be told from data."""
    try:
        reader(path)
    except InputError as error:
        assert "\n" not in str(error)
