"""Edits of the shapes of the hand-sculpted rig, as the shapes panel and the menu ask for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from engine.errors import InputError
from studio.basis.commands import EditShapes

if TYPE_CHECKING:
    from engine.shape_edits import ShapeEdit

    from studio.basis.controller import BasisStage


class ShapeEditor:
    """Turns wishes into `EditShapes` commands; InputErrors say what cannot be."""

    def __init__(self, stage: BasisStage) -> None:
        self._stage = stage

    def rename(self, name: str, new: str) -> None:
        """Give a shape another name; it stays in view."""
        from engine.shape_edits import Rename

        new = new.strip()
        if new == name:
            return
        self._push((Rename(name, new),), f"Rename {name} to {new}", {name: new})
        if self._stage.context.shape in (name, None) or self._stage.context.shape not in self._stage.context.names:
            self._stage.context.select_shape(new)

    def reorder(self, names: Sequence[str]) -> None:
        """Put the shapes into another order."""
        from engine.shape_edits import Reorder

        if tuple(names) != self._stage.context.names:
            self._push((Reorder(tuple(names)),), "Reorder the shapes")

    def edit(self, kind: str, names: Sequence[str]) -> None:
        """Mirror, split, combine, duplicate or remove shapes."""
        if not names:
            raise InputError(kind, "needs a shape", "choose one in the list")
        what = names[0] if len(names) == 1 else f"{len(names)} shapes"
        edits = self._edits(kind, tuple(names))
        self._push(edits, f"{kind.capitalize()} {what}")

    def edit_chosen(self, kind: str) -> None:
        """Do it to the shapes that are marked, or to the one in view."""
        self.edit(kind, self._stage.context.chosen)

    def map_names(self, scheme: str) -> None:
        """Rename shapes to the names of ARKit or of FACS where they mean the same, and tell what is missing."""
        from engine.shape_edits import Rename
        from engine.shape_names import arkit_mapping, facs_mapping

        names = self._stage.context.names
        found = (arkit_mapping if scheme == "arkit" else facs_mapping)(names)
        renames = {old: new for old, new in found.names.items() if old != new}
        if renames:
            self._push(tuple(Rename(old, new) for old, new in renames.items()), f"Name by {scheme}", renames)
        missing = len(found.missing)
        text = f"{len(found.names)} shapes have {_SCHEMES[scheme]} names"
        more = f"; {missing} are missing: {', '.join(found.missing[:6])}{' ...' if missing > 6 else ''}"
        self._stage.window.message.tell("info", text + (more if missing else ""))

    def _edits(self, kind: str, names: tuple[str, ...]) -> tuple[ShapeEdit, ...]:
        raise NotImplementedError

    def _push(self, edits: Sequence[ShapeEdit], text: str, renames: dict[str, str] | None = None) -> None:
        hand = self._stage.context.hand
        if hand is None:
            raise InputError("shapes", "are not there yet", "open a hand-sculpted rig")
        self._stage.window.session.stack.push(EditShapes(self._stage.context.project, hand.id, edits, text, renames))


_SCHEMES = {"arkit": "ARKit", "facs": "FACS"}
