"""What may be done to the shapes of a rig, as small values: for undo, for the project file, for scripts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, FiniteFloat, TypeAdapter, ValidationError

from engine.errors import InputError
from engine.mirror_map import MirrorMap
from engine.name_text import LONGEST_NAME
from engine.shape_table import ShapeTable
from engine.shapes import Rig

BORDER_MM = 20.0
"""Width in mm over which a shape that is split fades across the mid plane."""

Name = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME, pattern=r"\S")]
Names = Annotated[tuple[Name, ...], Field(min_length=1, max_length=5000)]
Weight = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]


_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True)
class Rename:
    """Give a shape another name."""

    name: Name
    to: Name
    kind: Literal["rename"] = "rename"

    __pydantic_config__ = _STRICT


@dataclass(frozen=True)
class Reorder:
    """Put all shapes in the order of ``names``."""

    names: Names
    kind: Literal["reorder"] = "reorder"

    __pydantic_config__ = _STRICT


@dataclass(frozen=True)
class Remove:
    """Take shapes out of the rig, which keeps at least one."""

    names: Names
    kind: Literal["remove"] = "remove"

    __pydantic_config__ = _STRICT


@dataclass(frozen=True)
class Duplicate:
    """Put the same shape behind itself under the name ``to``."""

    name: Name
    to: Name
    kind: Literal["duplicate"] = "duplicate"

    __pydantic_config__ = _STRICT


@dataclass(frozen=True)
class Mirror:
    """Make the shape that a mirror shows: in place where ``to`` is ``name``, else behind it, or in the place of ``to``.

    ``replace`` says that there may be a shape of the name ``to`` already.
    """

    name: Name
    to: Name
    replace: bool = False
    kind: Literal["mirror"] = "mirror"

    __pydantic_config__ = _STRICT


@dataclass(frozen=True)
class Split:
    """Part a shape into its left and its right half, which fade over ``border_mm`` across the mid plane.

    Left is the subject's left, +X. The halves take the place of the shape, or stand behind it where ``keep`` is set,
    and add up to it.
    """

    name: Name
    left: Name
    right: Name
    border_mm: Annotated[FiniteFloat, Field(ge=0, le=1000)] = BORDER_MM
    keep: bool = False
    kind: Literal["split"] = "split"

    __pydantic_config__ = _STRICT


@dataclass(frozen=True)
class Combine:
    """Make the weighted sum of shapes under the name ``to``, behind the last of them; or in their place.

    With a weight below 1 a single shape is toned down; ``keep`` says whether the shapes stay.
    """

    terms: Annotated[tuple[tuple[Name, Weight], ...], Field(min_length=1, max_length=5000)]
    to: Name
    keep: bool = True
    kind: Literal["combine"] = "combine"

    __pydantic_config__ = _STRICT


ShapeEdit = Annotated[Rename | Reorder | Remove | Duplicate | Mirror | Split | Combine, Field(discriminator="kind")]
"""One edit."""


def edit_to_json(edit: ShapeEdit) -> dict[str, Any]:
    """Return an edit as values that JSON can hold."""
    values: dict[str, Any] = TypeAdapter(type(edit)).dump_python(edit, mode="json")
    return values


def edit_from_json(values: Mapping[str, Any]) -> ShapeEdit:
    """Return the edit of plain values.

    Raises
    ------
    InputError
        When they are no edit; the message names the bad field.
    """
    try:
        edit: ShapeEdit = TypeAdapter(ShapeEdit).validate_python(dict(values))
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(str(part) for part in first["loc"][1:]) or "kind"
        raise InputError(f"shape edit, {place}", first["msg"].lower()[:200], "open a newer copy of the file") from error
    return edit


def apply_edits(rig: Rig, edits: Sequence[ShapeEdit], pairs: MirrorMap | None = None) -> Rig:
    """Return the rig with all edits done, one after the other; the same edits of the same rig give the same bits.

    Parameters
    ----------
    rig : Rig
        In mm.
    edits : sequence of ShapeEdit
        In their order.
    pairs : MirrorMap, optional
        The other side of the rig's vertices where it is known already; else it is found when an edit needs it.

    Raises
    ------
    InputError
        When an edit names a shape that is not there, takes a name that is, or leaves no shape; it names the shape.
    """
    table = ShapeTable(rig, pairs)
    for edit in edits:
        _apply(table, edit)
    return table.rig()


def _apply(table: ShapeTable, edit: ShapeEdit) -> None:
    match edit:
        case Rename():
            table.rename(edit.name, edit.to)
        case Reorder():
            table.reorder(edit.names)
        case Remove():
            table.remove(edit.names)
        case Duplicate():
            table.combine(((edit.name, 1.0),), edit.to, keep=True)
        case Mirror():
            table.mirror(edit.name, edit.to, edit.replace)
        case Split():
            table.split(edit.name, edit.left, edit.right, edit.border_mm, edit.keep)
        case Combine():
            table.combine(edit.terms, edit.to, edit.keep)
