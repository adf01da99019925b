"""What the user's hand does to fiducials becomes one undoable step each."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import QObject
from PySide6.QtGui import QUndoCommand

from engine.landmarks import LandmarkSet, LandmarkState
from studio.project.document import ScanItem
from studio.scan import edits
from studio.scan.commands import SetLandmark, SetLandmarks, SetOptions, SetScheme
from studio.scan.context import ScanContext
from studio.scan.job import item_scheme, template_for
from studio.scan.options import FitOptions


class FiducialEditor(QObject):
    """Turns intents into commands on the current scan.

    Every method raises `InputError` for what cannot be done, and then nothing has changed.
    """

    def __init__(self, context: ScanContext, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._context = context

    def placed_at(self, name: str, x: float, y: float) -> LandmarkSet:
        """Return what the fiducials would be with ``name`` at (x, y); for a drag that is not over."""
        item = self._item()
        return edits.moved(item.landmarks, item_scheme(item), name, (x, y), self._size(), self._propose(item))

    def place(self, name: str, x: float, y: float) -> None:
        """Place a fiducial by a click and go on to the next."""
        if self._push(self.placed_at(name, x, y), f"Place {name} on {self._item().name}"):
            self._context.select_fiducial(name)
            self._context.advance()

    def move(self, name: str, x: float, y: float) -> None:
        """Put a fiducial where a drag, or a typed number, ended."""
        self._push(self.placed_at(name, x, y), f"Move {name} on {self._item().name}")

    def nudge(self, name: str, dx: float, dy: float) -> None:
        """Move a fiducial by a fraction of a pixel; nudges that follow each other are one step."""
        item = self._item()
        old = item.landmarks[name]
        if not old.is_set or old.locked:
            return
        x, y = edits.inside(old.x + dx, old.y + dy, self._size())
        new = item.landmarks.moved(name, x, y)[name]
        self._stack(SetLandmark(self._context.project, item.id, name, old, new, nudge=True))

    def confirm(self, name: str | None) -> None:
        """Accept a proposed fiducial where it is and go on to the next."""
        item = self._item()
        if name is None or item.landmarks[name].state != LandmarkState.PROPOSED:
            return
        after = edits.confirmed(item.landmarks, item_scheme(item), (name,))
        self._push(self._follow(item, after), f"Confirm {name} on {item.name}")
        self._context.select_fiducial(name)
        self._context.advance()

    def confirm_all(self) -> None:
        """Accept every proposal."""
        item = self._item()
        self._push(edits.confirmed(item.landmarks, item_scheme(item)), f"Confirm all on {item.name}")

    def skip(self, name: str | None) -> None:
        """Leave a fiducial out, or take it in again, and go on."""
        if name is None:
            return
        item = self._item()
        after = edits.skipped(item.landmarks, name)
        verb = "Skip" if after[name].state == LandmarkState.SKIPPED else "Take in"
        if self._push(self._follow(item, after), f"{verb} {name} on {item.name}") and verb == "Skip":
            self._context.select_fiducial(name)
            self._context.advance()

    def lock(self, name: str | None) -> None:
        """Lock a placed fiducial, or free it."""
        if name is not None:
            item = self._item()
            verb = "Unlock" if item.landmarks[name].locked else "Lock"
            self._push(edits.lock_toggled(item.landmarks, name), f"{verb} {name} on {item.name}")

    def unset(self, name: str | None) -> None:
        """Take a fiducial off the picture."""
        if name is not None:
            item = self._item()
            after = edits.unset(item.landmarks, name)
            self._push(self._follow(item, after, besides=name), f"Unset {name} on {item.name}")

    def mirror(self) -> None:
        """Propose the points whose partner on the other side is placed."""
        from engine.scan.warp import mirror_proposals

        item = self._item()
        scheme = item_scheme(item)
        positions = mirror_proposals(scheme, edits.placed(item.landmarks, scheme))
        self._propose_all(item, positions, f"Mirror fiducials on {item.name}")

    def take(self, positions: Mapping[str, tuple[float, float]], subject: str) -> None:
        """Place the fiducials of a file."""
        item = self._item()
        scheme = item_scheme(item)
        after = edits.imported(item.landmarks, scheme, positions, self._size(), subject)
        self._push(self._follow(item, after), f"Import fiducials to {item.name}")

    def propose(self, positions: Mapping[str, tuple[float, float]], text: str) -> None:
        """Propose the fiducials of a file; what is placed, skipped or locked stays."""
        self._propose_all(self._item(), positions, text)

    def set_scheme(self, scheme: str) -> None:
        """Use another scheme; what it has beyond the old one is proposed at once where five points are placed."""
        item = self._item()
        if scheme == item.scheme:
            return
        stack = self._context.session.stack
        stack.beginMacro(f"Use scheme {scheme} on {item.name}")
        try:
            stack.push(SetScheme(self._context.project, item.id, scheme))
            item = self._item()
            self._push(self._follow(item, item.landmarks), "Propose the rest")
        finally:
            stack.endMacro()

    def set_options(self, changes: Mapping[str, object]) -> None:
        """Change options of the fit by name."""
        item = self._item()
        options = FitOptions.checked(**{**item.options.model_dump(), **changes})
        if options != item.options:
            self._stack(SetOptions(self._context.project, item.id, options))

    def _follow(self, item: ScanItem, after: LandmarkSet, besides: str | None = None) -> LandmarkSet:
        scheme = item_scheme(item)
        return edits.with_proposals(item.landmarks, after, scheme, self._size(), self._propose(item), besides)

    def _propose_all(self, item: ScanItem, positions: edits.Positions, text: str) -> None:
        self._push(edits.proposed(item.landmarks, item_scheme(item), positions, self._size()), text)
        self._context.advance()

    def _push(self, after: LandmarkSet, text: str) -> bool:
        item = self._item()
        before = item.landmarks
        changed = [name for name in dict.fromkeys((*before.points, *after.points)) if before[name] != after[name]]
        if not changed:
            return False
        if len(changed) == 1:
            (name,) = changed
            self._stack(SetLandmark(self._context.project, item.id, name, before[name], after[name], text))
        else:
            self._stack(SetLandmarks(self._context.project, item.id, before, after, text))
        return True

    def _stack(self, command: QUndoCommand) -> None:
        self._context.session.stack.push(command)

    def _item(self) -> ScanItem:
        item = self._context.item
        if item is None:
            raise LookupError("no scan is in view")
        return item

    def _size(self) -> tuple[int, int]:
        image = self._context.image
        assert image is not None
        return image.width, image.height

    def _propose(self, item: ScanItem) -> Callable[[edits.Positions], edits.Positions]:
        from engine.scan.warp import propose_fiducials  # with scipy, which the first paint need not wait for

        return lambda known: propose_fiducials(template_for(None, item_scheme(item)), item.scheme, known)
