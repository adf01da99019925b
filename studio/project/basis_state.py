"""The rigs, performances and basis setup of an open project, with the meshes and motion they stand for. No Qt.

Only commands (``studio.basis.commands``) change it; `Project.basis` holds it, and a project tells its changes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

from engine.errors import InputError
from studio.project.basis_items import MOST_ITEMS, BasisSetup, MotionItem, RigContent, RigItem

if TYPE_CHECKING:
    from engine.shapes import Rig
    from studio.project.basis_items import MotionData

BasisKind = Literal["rigs", "rig", "motions", "motion", "setup"]
"""What changed: a list, one item of it (its id is told), or the setup."""
BASIS_KINDS: frozenset[str] = frozenset({"rigs", "rig", "motions", "motion", "setup"})
Tell = Callable[[BasisKind, str], None]
Item = TypeVar("Item", bound=RigItem | MotionItem)
KEPT_RIGS = 6


class BasisItems(Generic[Item]):
    """Rigs or performances in their order, each under an id and a name of its own.

    Parameters
    ----------
    word : str
        What one of them is called in messages.
    many, one : str
        The kinds of change that are told when the list, or one item of it, is another.
    tell : callable
        Takes the kind and the id.
    """

    def __init__(self, word: str, many: BasisKind, one: BasisKind, tell: Tell) -> None:
        self.word = word
        self._many, self._one, self._tell = many, one, tell
        self._items: tuple[Item, ...] = ()

    def __iter__(self) -> Any:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __contains__(self, item_id: object) -> bool:
        return any(item.id == item_id for item in self._items)

    def __getitem__(self, item_id: str) -> Item:
        for item in self._items:
            if item.id == item_id:
                return item
        raise KeyError(item_id)

    @property
    def all(self) -> tuple[Item, ...]:
        """All of them, in order."""
        return self._items

    def get(self, item_id: str | None) -> Item | None:
        """Return the one of this id; None where there is none."""
        return next((item for item in self._items if item.id == item_id), None)

    def index(self, item_id: str) -> int:
        """Return the place of one; KeyError when there is none of this id."""
        return self._items.index(self[item_id])

    def unique_name(self, wanted: str, besides: str | None = None) -> str:
        """Return ``wanted``, with a number behind it where another than ``besides`` has that name."""
        taken = {item.name for item in self._items if item.id != besides}
        name, number = wanted, 2
        while name in taken:
            name, number = f"{wanted} {number}", number + 1
        return name

    def insert(self, index: int, item: Item) -> None:
        """Put one into the list.

        Raises
        ------
        InputError
            When its id is there already, or there are too many.
        """
        if item.id in self:
            raise InputError(f"{self.word} {item.name}", "is already in the project", "add it once")
        if len(self._items) >= MOST_ITEMS:
            raise InputError(f"{self.word} {item.name}", f"would be more than {MOST_ITEMS}", "remove one first")
        index = max(0, min(index, len(self._items)))
        self._items = (*self._items[:index], item, *self._items[index:])
        self._tell(self._many, item.id)

    def remove(self, item_id: str) -> Item:
        """Take one out of the list; what it stands for stays for undo."""
        item = self[item_id]
        self._items = tuple(other for other in self._items if other.id != item_id)
        self._tell(self._many, item_id)
        return item

    def put(self, item: Item) -> None:
        """Put a changed item in the place of the one with its id."""
        old = self[item.id]
        if old != item:
            self._items = tuple(item if other is old else other for other in self._items)
            self._tell(self._one, item.id)

    def change(self, item_id: str, **fields: Any) -> None:
        """Replace some fields of one."""
        self.put(replace(self[item_id], **fields))


class BasisState:
    """What a project holds for the basis stage.

    Contents are kept by key beside the undo stack as long as the project is open. An item whose content is not there
    (a linked file that is missing, or what a crash has lost) stays in its list; `lacks` says what to do about it.

    Parameters
    ----------
    tell : callable
        Takes the kind of a change and the id it is about.

    Attributes
    ----------
    rigs, motions : BasisItems
        The rigs and the performances.
    """

    def __init__(self, tell: Tell) -> None:
        self._tell = tell
        self.rigs: BasisItems[RigItem] = BasisItems("rig", "rigs", "rig", tell)
        self.motions: BasisItems[MotionItem] = BasisItems("performance", "motions", "motion", tell)
        self._setup = BasisSetup()
        self._rig_contents: dict[str, RigContent] = {}
        self._motion_data: dict[str, MotionData] = {}
        self._edited: dict[tuple[str, Any], Rig] = {}

    @property
    def setup(self) -> BasisSetup:
        """Which rig, which performance, and how."""
        return self._setup

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing in it that saving would have to keep."""
        return not self.rigs.all and not self.motions.all and self._setup == BasisSetup()

    @property
    def hand(self) -> RigItem | None:
        """The hand-sculpted rig that was chosen."""
        return self.rigs.get(self._setup.hand)

    @property
    def motion(self) -> MotionItem | None:
        """The performance that was chosen."""
        return self.motions.get(self._setup.motion)

    @property
    def driver(self) -> RigItem | None:
        """The rig that weight curves drive: the one that was chosen, else the hand-sculpted one."""
        return self.rigs.get(self._setup.driver) or self.hand

    def set_setup(self, setup: BasisSetup) -> None:
        """Set which rig, which performance, and how."""
        if setup != self._setup:
            self._setup = setup
            self._tell("setup", "")

    def change_setup(self, **fields: Any) -> None:
        """Replace some fields of the setup."""
        self.set_setup(replace(self._setup, **fields))

    # -- contents -------------------------------------------------------------------------------------------------

    def keep_rig(self, content: RigContent, key: str = "") -> str:
        """Keep a rig beside the undo stack and return its key; changes nothing that is seen."""
        key = key or content.key
        self._rig_contents.setdefault(key, content)
        return key

    def keep_motion(self, key: str, data: MotionData) -> None:
        """Keep the data of a performance under its key; changes nothing that is seen."""
        self._motion_data.setdefault(key, data)

    def rig_content(self, key: str) -> RigContent | None:
        """Return the rig of a content key as it was read, if it is there."""
        return self._rig_contents.get(key)

    def motion_data(self, key: str) -> MotionData | None:
        """Return the data of a content key, if they are there."""
        return self._motion_data.get(key)

    def rig(self, item: RigItem) -> Rig | None:
        """Return a rig with its edits done, mm; None while its content is not there.

        Raises
        ------
        InputError
            When the edits cannot be done to it.
        """
        content = self._rig_contents.get(item.content)
        if content is None or not item.edits:
            return None if content is None else content.rig
        key = (item.content, item.edits)
        if key not in self._edited:
            from engine.shape_edits import apply_edits

            while len(self._edited) >= KEPT_RIGS:
                self._edited.pop(next(iter(self._edited)))
            self._edited[key] = apply_edits(content.rig, item.edits)
        return self._edited[key]

    def lacks(self, item: RigItem | MotionItem) -> str:
        """Return what is missing of an item and what to do, in words; empty where nothing is."""
        if isinstance(item, RigItem):
            there = item.content in self._rig_contents
            return "" if there else f"the shapes of {item.name} are lost: choose its file again"
        if item.content in self._motion_data:
            return ""
        if item.link is None:
            return f"the data of {item.name} are lost: choose its file again"
        found = item.link.state()
        if found == "there":
            return f"{item.link.path.name} has not been read yet"
        wrong = "is not where it was" if found == "missing" else "has changed since it was linked"
        return f"{item.link.path.name} {wrong}: choose the file again"

    @property
    def missing(self) -> tuple[RigItem | MotionItem, ...]:
        """What was chosen and lacks its content, so that its file has to be found; the hand rig first."""
        driver = None if self._setup.driver == self._setup.hand else self.rigs.get(self._setup.driver)
        chosen: tuple[RigItem | MotionItem | None, ...] = (self.hand, self.motion, driver)
        return tuple(item for item in chosen if item is not None and self.lacks(item) and not self._can_be_read(item))

    @staticmethod
    def _can_be_read(item: RigItem | MotionItem) -> bool:
        return isinstance(item, MotionItem) and item.link is not None and item.link.state() == "there"

    def take_contents(self, other: BasisState) -> None:
        """Share what another project has read: the arrays are read-only."""
        self._rig_contents.update(other._rig_contents)
        self._motion_data.update(other._motion_data)
