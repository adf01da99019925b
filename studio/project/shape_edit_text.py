"""Edits of shapes as plain values, for the project file and the journal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from engine.shape_edits import ShapeEdit


def edits_text(edits: Sequence[ShapeEdit]) -> list[dict[str, Any]]:
    """Return edits as values that JSON can hold."""
    if not edits:
        return []
    from engine.shape_edits import edit_to_json

    return [edit_to_json(edit) for edit in edits]


def edits_from(values: Sequence[Mapping[str, Any]]) -> tuple[ShapeEdit, ...]:
    """Return the edits of plain values.

    Raises
    ------
    InputError
        When one of them is no edit.
    """
    if not values:
        return ()
    from engine.shape_edits import edit_from_json

    return tuple(edit_from_json(value) for value in values)
