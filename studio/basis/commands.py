"""The undoable edits of the basis stage, one class each.

A command holds ids, keys and small old and new values. It is validated when it is made (``InputError``), so that what
has been pushed always works. Shapes and motion stay in the project, by content key; results are never pushed.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from PySide6.QtGui import QUndoCommand

from engine.errors import InputError
from studio.basis.options import BasisOptions
from studio.project.basis_items import MOST_EDITS, MotionItem, RigContent, RigItem, check_amount
from studio.project.basis_state import BasisItems
from studio.project.checks import check_name
from studio.project.document import Project

if TYPE_CHECKING:
    from engine.shape_edits import ShapeEdit
    from studio.project.basis_items import MotionData

MERGE_SECONDS = 1.0
"""Values of one option, or of one slider by keys, that follow each other faster than this are one step."""
_OPTION_ID, _AMOUNT_ID = 11, 12

Role = Literal["hand", "motion", "driver"]
Item = RigItem | MotionItem
_ROLE_WORDS = {"hand": "the hand-sculpted rig", "motion": "the performance", "driver": "the driving rig"}


class AddRig(QUndoCommand):
    """Put a rig at the end of the list; ``item.content`` must be the key of ``content``, and the name free."""

    def __init__(self, project: Project, item: RigItem, content: RigContent | None = None, text: str = "") -> None:
        super().__init__(text or f"Add rig {item.name}")
        _check_new(project.basis.rigs, item)
        if content is not None:
            project.basis.keep_rig(content, item.content)
        if project.basis.rig_content(item.content) is None:
            raise InputError(f"rig {item.name}", "comes without its shapes", "open its file again")
        self._list: BasisItems[RigItem] = project.basis.rigs
        self._item, self._index = item, len(project.basis.rigs)

    def redo(self) -> None:
        """Insert the rig."""
        self._list.insert(self._index, self._item)

    def undo(self) -> None:
        """Take it out again."""
        self._list.remove(self._item.id)


class AddMotion(QUndoCommand):
    """Put a performance at the end of the list; ``data`` are kept under ``item.content``, and the name must be free."""

    def __init__(self, project: Project, item: MotionItem, data: MotionData | None = None, text: str = "") -> None:
        super().__init__(text or f"Add performance {item.name}")
        _check_new(project.basis.motions, item)
        if data is not None:
            project.basis.keep_motion(item.content, data)
        if project.basis.motion_data(item.content) is None:
            raise InputError(f"performance {item.name}", "comes without its data", "open its file again")
        self._list: BasisItems[MotionItem] = project.basis.motions
        self._item, self._index = item, len(project.basis.motions)

    def redo(self) -> None:
        """Insert the performance."""
        self._list.insert(self._index, self._item)

    def undo(self) -> None:
        """Take it out again."""
        self._list.remove(self._item.id)


class RemoveItem(QUndoCommand):
    """Take a rig or a performance out of its list; where it was chosen, the choice is empty until undo."""

    def __init__(self, project: Project, item_id: str, text: str = "") -> None:
        self._list, self._item = _find(project, item_id)
        super().__init__(text or f"Remove {self._item.name}")
        self._index = self._list.index(item_id)

    def redo(self) -> None:
        """Remove it."""
        self._list.remove(self._item.id)

    def undo(self) -> None:
        """Put it back where it was."""
        self._list.insert(self._index, self._item)


class RenameItem(QUndoCommand):
    """Give a rig or a performance another name."""

    def __init__(self, project: Project, item_id: str, name: str, text: str = "") -> None:
        self._list, item = _find(project, item_id)
        name = name.strip()
        _check_free(self._list, name, item_id)
        super().__init__(text or f"Rename {item.name} to {name}")
        self._id, self._old, self._new = item_id, item.name, name

    def redo(self) -> None:
        """Set the new name."""
        self._list.change(self._id, name=self._new)

    def undo(self) -> None:
        """Set the old name."""
        self._list.change(self._id, name=self._old)


class ChooseInput(QUndoCommand):
    """Choose the hand-sculpted rig, the performance, or the rig that weight curves drive (None: none).

    A training range that does not lie in the performance goes with the one it was set for.
    """

    def __init__(self, project: Project, role: Role, item_id: str | None, text: str = "") -> None:
        items: BasisItems[Any] = project.basis.motions if role == "motion" else project.basis.rigs
        if item_id is not None and item_id not in items:
            raise InputError(items.word, "is not in the project any more", "choose another")
        name = "nothing" if item_id is None else items[item_id].name
        super().__init__(text or f"Use {name} as {_ROLE_WORDS[role]}")
        setup = project.basis.setup
        self._basis = project.basis
        self._old: dict[str, Any] = {role: getattr(setup, role)}
        self._new: dict[str, Any] = {role: item_id}
        item = items.get(item_id)
        if isinstance(item, MotionItem):
            _train_within(setup.options, item, self._old, self._new)

    def redo(self) -> None:
        """Choose the new one."""
        self._basis.change_setup(**self._new)

    def undo(self) -> None:
        """Choose the old one."""
        self._basis.change_setup(**self._old)


class SetBasisOptions(QUndoCommand):
    """Change how axes are chosen and weights are solved; values of one option within a second are one step."""

    def __init__(self, project: Project, values: Mapping[str, object], text: str = "") -> None:
        old = project.basis.setup.options
        new = BasisOptions.checked(**{**old.model_dump(), **values})
        self._names = tuple(name for name in BasisOptions.model_fields if getattr(new, name) != getattr(old, name))
        super().__init__(text or _option_text(new, self._names))
        self._basis, self._old, self._new, self._time = project.basis, old, new, time.monotonic()

    @property
    def changes(self) -> bool:
        """Whether it changes anything."""
        return bool(self._names)

    def id(self) -> int:
        """Return the number of what may be merged: a single option."""
        return _OPTION_ID if len(self._names) == 1 else -1

    def mergeWith(self, other: QUndoCommand) -> bool:
        """Take the next value of the same option in, when it came soon enough."""
        if not isinstance(other, SetBasisOptions):
            return False
        same = (other._basis, other._names) == (self._basis, self._names)
        if not same or other._time - self._time > MERGE_SECONDS:
            return False
        self._new, self._time = other._new, other._time
        self.setText(other.text())
        self.setObsolete(self._new == self._old)
        return True

    def redo(self) -> None:
        """Set the new options."""
        self._basis.change_setup(options=self._new)

    def undo(self) -> None:
        """Set the old options."""
        self._basis.change_setup(options=self._old)


class SetAmounts(QUndoCommand):
    """Move shapes between hand (0) and quasi-eigen (1).

    A drag is one step: its values are pushed when the slider is let go. By keys, values of the same shapes within a
    second are one step.
    """

    def __init__(self, project: Project, amounts: Mapping[str, float], text: str = "") -> None:
        setup = project.basis.setup
        if not amounts:
            raise InputError("amounts", "name no shape", "choose one")
        for name, value in amounts.items():
            check_amount(name, value)
        named = next(iter(amounts))
        what = named if len(amounts) == 1 else f"{len(amounts)} shapes"
        super().__init__(text or f"Set {what} to {amounts[named]:.2f} quasi-eigen")
        self._basis = project.basis
        self._old = {name: setup.amount(name) for name in amounts}
        self._new = {name: float(value) for name, value in amounts.items()}
        self._time = time.monotonic()

    def id(self) -> int:
        """Return the number of what may be merged."""
        return _AMOUNT_ID

    def mergeWith(self, other: QUndoCommand) -> bool:
        """Take the next values of the same shapes in, when they came soon enough."""
        if (
            not isinstance(other, SetAmounts)
            or other._basis is not self._basis
            or other._new.keys() != self._new.keys()
        ):
            return False
        if other._time - self._time > MERGE_SECONDS:
            return False
        self._new, self._time = other._new, other._time
        self.setText(other.text())
        self.setObsolete(self._new == self._old)
        return True

    def redo(self) -> None:
        """Set the new amounts."""
        self._set(self._new)

    def undo(self) -> None:
        """Set the old amounts."""
        self._set(self._old)

    def _set(self, amounts: Mapping[str, float]) -> None:
        self._basis.change_setup(amounts={**self._basis.setup.amounts, **amounts})


class EditShapes(QUndoCommand):
    """Do something to the shapes of a rig: rename, reorder, remove, mirror, split, combine.

    The edits are tried on the rig when the command is made. The amounts of the hand-sculpted rig's shapes go along
    (`amounts_after`).
    """

    def __init__(
        self,
        project: Project,
        rig_id: str,
        edits: Sequence[ShapeEdit],
        text: str = "",
    ) -> None:
        from dataclasses import replace

        item = project.basis.rigs.get(rig_id)
        if item is None:
            raise InputError("rig", "is not in the project any more", "choose another")
        if len(item.edits) + len(edits) > MOST_EDITS:
            raise InputError(f"rig {item.name}", f"has more than {MOST_EDITS} edits", "export it and open the file")
        new = replace(item, edits=(*item.edits, *edits))
        if project.basis.rig(new) is None:
            raise InputError(f"rig {item.name}", "has lost its shapes", "choose its file again")
        super().__init__(text or f"Edit shapes of {item.name}")
        self._basis, self._id = project.basis, rig_id
        amounts = project.basis.setup.amounts
        moved = amounts_after(edits, amounts) if rig_id == project.basis.setup.hand else dict(amounts)
        self._old, self._new = (item.edits, dict(amounts)), (new.edits, moved)
        self._moves = moved != dict(amounts)

    def redo(self) -> None:
        """Do it."""
        self._set(self._new)

    def undo(self) -> None:
        """Leave it."""
        self._set(self._old)

    def _set(self, values: tuple[tuple[ShapeEdit, ...], dict[str, float]]) -> None:
        if self._moves:
            self._basis.change_setup(amounts=values[1])
        self._basis.rigs.change(self._id, edits=values[0])


class SetMotion(QUndoCommand):
    """Put another reading, or other options, in the place of a performance: unit, axes, rate, head, pairs, its file."""

    def __init__(self, project: Project, item: MotionItem, data: MotionData | None = None, text: str = "") -> None:
        old = project.basis.motions.get(item.id)
        if old is None:
            raise InputError("performance", "is not in the project any more", "choose another")
        if data is not None:
            project.basis.keep_motion(item.content, data)
        _check_free(project.basis.motions, item.name, item.id)
        super().__init__(text or f"Set up {item.name}")
        self._list, self._old, self._new = project.basis.motions, old, item

    def redo(self) -> None:
        """Set the new reading."""
        self._list.put(self._new)

    def undo(self) -> None:
        """Set the old reading."""
        self._list.put(self._old)


class SetRig(QUndoCommand):
    """Put another reading in the place of a rig: in another unit, or from its file again; its edits stay."""

    def __init__(self, project: Project, item: RigItem, content: RigContent | None = None, text: str = "") -> None:
        old = project.basis.rigs.get(item.id)
        if old is None:
            raise InputError("rig", "is not in the project any more", "choose another")
        if content is not None:
            project.basis.keep_rig(content, item.content)
        if project.basis.rig(item) is None:  # also where its edits cannot be done to these shapes
            raise InputError(f"rig {item.name}", "comes without its shapes", "open its file again")
        _check_free(project.basis.rigs, item.name, item.id)
        super().__init__(text or f"Read {item.name} again")
        self._list, self._old, self._new = project.basis.rigs, old, item

    def redo(self) -> None:
        """Set the new reading."""
        self._list.put(self._new)

    def undo(self) -> None:
        """Set the old reading."""
        self._list.put(self._old)


def amounts_after(edits: Sequence[ShapeEdit], amounts: Mapping[str, float]) -> dict[str, float]:
    """Return how much of every shape is quasi-eigen after edits, by name; 1 is not told.

    A name carries its amount, halves have their parent's, what is removed has none, and shapes that are made of others
    begin at 1.
    """
    from engine.shape_edits import Combine, Duplicate, Mirror, Remove, Rename, Split

    found = dict(amounts)
    for edit in edits:
        match edit:
            case Rename(name=name, to=to):
                if name in found:
                    found[to] = found.pop(name)
            case Remove(names=names):
                for name in names:
                    found.pop(name, None)
            case Split():
                own = found.get(edit.name) if edit.keep else found.pop(edit.name, None)
                if own is not None:
                    found[edit.left] = found[edit.right] = own
            case Mirror(name=name, to=to):
                if to != name:
                    found.pop(to, None)
            case Duplicate(to=to):
                found.pop(to, None)
            case Combine():
                for name in () if edit.keep else (name for name, _ in edit.terms):
                    found.pop(name, None)
                found.pop(edit.to, None)
    return found


def _train_within(options: BasisOptions, item: MotionItem, old: dict[str, Any], new: dict[str, Any]) -> None:
    """Let go of a training range that does not lie in a performance."""
    if options.train is not None and 0 < item.frames < options.train[1]:
        old["options"], new["options"] = options, options.model_copy(update={"train": None})


def _find(project: Project, item_id: str) -> tuple[BasisItems[Any], Item]:
    for items in (project.basis.rigs, project.basis.motions):
        if item_id in items:
            return items, items[item_id]
    raise InputError("item", "is not in the project any more", "choose another")


def _check_new(items: BasisItems[Any], item: Item) -> None:
    _check_free(items, item.name, item.id)
    if item.id in items:
        raise InputError(f"{items.word} {item.name}", "is already in the project", "add it once")


def _check_free(items: BasisItems[Any], name: str, item_id: str) -> None:
    check_name(name)
    if items.unique_name(name, besides=item_id) != name:
        raise InputError(f"name {name!r}", f"belongs to another {items.word}", "choose another")


def _option_text(options: BasisOptions, names: tuple[str, ...]) -> str:
    if len(names) != 1:
        return "Change the options of the basis"
    name, value = names[0], getattr(options, names[0])
    title = BasisOptions.model_fields[name].title or name
    if name == "train":
        shown = "all frames" if value is None else f"{value[0] + 1} to {value[1]}"
    elif isinstance(value, bool):
        shown = "on" if value else "off"
    elif value is None:
        shown = "what the coverage needs"
    else:
        shown = f"{value:g}" if isinstance(value, (int, float)) else str(value)
    return f"Set {title[:1].lower() + title[1:]} to {shown}"
