"""Edits of the shapes of the hand-sculpted rig, as the shapes panel and the menu ask for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from engine.errors import InputError
from engine.shape_edits import Rename, Reorder, ShapeEdit
from engine.shape_names import arkit_mapping, facs_mapping
from engine.shape_proposals import proposed_edits, rename_edits
from studio.basis.commands import EditShapes

if TYPE_CHECKING:
    from studio.basis.controller import BasisStage


class ShapeEditor:
    """Turns wishes into `EditShapes` commands; InputErrors say what cannot be."""

    def __init__(self, stage: BasisStage) -> None:
        self._stage = stage

    def rename(self, name: str, new: str) -> None:
        """Give a shape another name; it stays in view."""
        new = new.strip()
        if new == name:
            return
        self._push((Rename(name, new),), f"Rename {name} to {new}")
        if self._stage.context.shape in (name, None) or self._stage.context.shape not in self._stage.context.names:
            self._stage.context.select_shape(new)

    def reorder(self, names: Sequence[str]) -> None:
        """Put the shapes into another order."""
        if tuple(names) != self._stage.context.names:
            self._push((Reorder(tuple(names)),), "Reorder the shapes")

    def edit(self, kind: str, names: Sequence[str]) -> None:
        """Mirror, split, combine, duplicate or remove shapes."""
        if not names:
            raise InputError(kind, "needs a shape", "choose one in the list")
        what = names[0] if len(names) == 1 else f"{len(names)} shapes"
        edits = proposed_edits(kind, tuple(names), self._stage.context.names)
        self._push(edits, f"{kind.capitalize()} {what}")
        made = [getattr(edit, "to", None) or getattr(edit, "left", None) for edit in edits]
        if kind != "remove" and made[0] is not None:
            self._stage.context.select_shape(made[0])

    def edit_chosen(self, kind: str) -> None:
        """Do it to the shapes that are marked, or to the one in view."""
        self.edit(kind, self._stage.context.chosen)

    def map_names(self, scheme: str) -> None:
        """Rename shapes to the names of ARKit or of FACS where they mean the same, and tell what is missing."""
        names = self._stage.context.names
        found = (arkit_mapping if scheme == "arkit" else facs_mapping)(names)
        edits = rename_edits(found.names, names)
        if edits:
            self._push(edits, f"Name shapes by {_SCHEMES[scheme]}")
        missing = len(found.missing)
        text = f"{len(found.found)} of the {len(found.found) + missing} {_SCHEMES[scheme]} names are there"
        more = f"; the {missing} that are missing are listed under Guide"
        if missing:
            self._stage.centre.guide.show_missing(_SCHEMES[scheme], found.missing)
            self._stage.window.docks["guide"].show()
            self._stage.window.docks["guide"].raise_()
        self._stage.window.message.tell("info", text + (more if missing else ""))

    def _push(self, edits: Sequence[ShapeEdit], text: str) -> None:
        hand = self._stage.context.hand
        if hand is None:
            raise InputError("shapes", "are not there yet", "open a hand-sculpted rig")
        self._stage.window.session.stack.push(EditShapes(self._stage.context.project, hand.id, edits, text))


_SCHEMES = {"arkit": "ARKit", "facs": "FACS"}
