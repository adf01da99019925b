"""Which shape and which frame the basis stage is at: the only state it keeps beside the project."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from engine.errors import InputError
from studio.project.basis_items import BasisSetup, MotionItem, RigItem
from studio.project.basis_state import BasisState
from studio.session import Session

if TYPE_CHECKING:
    from engine.shapes import Rig
    from studio.project.document import Project


class BasisContext(QObject):
    """The selection, and what is selected, read from the project anew each time."""

    shape_changed = Signal()
    """Another shape is in view, or none, or others are marked with it."""
    frame_changed = Signal()
    """Another frame is in view."""

    def __init__(self, session: Session, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.shape: str | None = None
        self.marked: tuple[str, ...] = ()
        self.frame = 0

    @property
    def project(self) -> Project:
        """The open project."""
        return self.session.project

    @property
    def basis(self) -> BasisState:
        """Its rigs and performances."""
        return self.session.project.basis

    @property
    def setup(self) -> BasisSetup:
        """What was chosen of them."""
        return self.basis.setup

    @property
    def hand(self) -> RigItem | None:
        """The hand-sculpted rig."""
        return self.basis.hand

    @property
    def motion(self) -> MotionItem | None:
        """The performance."""
        return self.basis.motion

    @property
    def rig(self) -> Rig | None:
        """The hand-sculpted rig with its edits; None where it is not there or they cannot be done."""
        item = self.hand
        try:
            return None if item is None else self.basis.rig(item)
        except InputError:
            return None

    @property
    def names(self) -> tuple[str, ...]:
        """The shapes of the hand-sculpted rig."""
        rig = self.rig
        return () if rig is None else rig.basis.names

    @property
    def chosen(self) -> tuple[str, ...]:
        """The shapes that an edit or the slider is about: those that are marked, or the one in view."""
        names = self.names
        marked = tuple(name for name in self.marked if name in names)
        if self.shape is not None and self.shape in marked:
            return marked
        return () if self.shape is None else (self.shape,)

    def select_shape(self, name: str | None) -> None:
        """Bring a shape into view."""
        if name is not None and name not in self.names:
            name = None
        if name != self.shape:
            self.shape = name
            self.shape_changed.emit()

    def mark(self, names: Sequence[str]) -> None:
        """Say which shapes are marked."""
        if tuple(names) != self.marked:
            self.marked = tuple(names)
            self.shape_changed.emit()

    def show_frame(self, frame: int) -> None:
        """Bring a frame into view, counted from 0."""
        if frame != self.frame:
            self.frame = frame
            self.frame_changed.emit()

    def follow(self) -> None:
        """Keep the selection valid after shapes came or went."""
        names = self.names
        if self.shape not in names:
            self.shape = names[0] if names else None
            self.shape_changed.emit()
