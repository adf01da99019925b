"""Carries fiducials from one scan to others beside the window, and pushes what came of it as one step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from engine.errors import InputError
from engine.landmarks import LandmarkSet, LandmarkState
from engine.progress import Progress, part
from studio.project.document import ScanItem
from studio.scan import edits
from studio.scan.commands import SetLandmarks, SetScheme
from studio.scan.context import ScanContext
from studio.scan.job import item_scheme, scheme_of

if TYPE_CHECKING:
    from engine.scan.carry import Carried

CLOSED, OPEN = "closed", "open"


class Carrier(QObject):
    """Proposes the fiducials of one scan on others, found by what the pictures show.

    Nothing placed, skipped or locked is touched. A scan without any fiducial whose mouth turns out to be open changes
    from the scheme of a closed mouth to that of an open one.
    """

    told = Signal(str, str)
    """A message: kind and text."""

    def __init__(self, context: ScanContext, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._context = context

    def targets(self) -> list[ScanItem]:
        """Return the other scans that still have something to propose, in the order of the list."""
        return [item for item in self._context.project.scans if item.id != self._context.scan_id and _is_open(item)]

    def carry(self, source_id: str, target_ids: Sequence[str]) -> None:
        """Propose the fiducials of one scan on others, as one step.

        Raises
        ------
        InputError
            When the source has no fiducials.
        """
        project = self._context.project
        source, image = project.scan(source_id), project.range_image(source_id)
        positions = edits.located(source.landmarks, item_scheme(source))
        if not positions:
            raise InputError(f"scan {source.name}", "has no fiducials to carry", "place some first")
        items = [project.scan(target) for target in target_ids]
        images = [project.range_image(target) for target in target_ids]
        what = items[0].name if len(items) == 1 else f"{len(items)} scans"

        def work(progress: Progress) -> list[Carried]:
            from engine.scan.carry import carry_fiducials

            found = []
            for number, (item, other) in enumerate(zip(items, images, strict=True)):
                part(progress, number / len(items), (number + 1) / len(items))(0.0, item.name)
                found.append(carry_fiducials(image, positions, other))
            return found

        def done(found: list[Carried]) -> None:
            if self._context.project is project:
                self._push(source, items, found, f"Carry fiducials from {source.name} to {what}")

        title = f"Carrying fiducials to {what}"
        self._context.session.tasks.submit(title, work, done, key=f"carry {'' if len(items) > 1 else items[0].id}")

    def _push(self, source: ScanItem, items: Sequence[ScanItem], found: Sequence[Carried], text: str) -> None:
        project, stack = self._context.project, self._context.session.stack
        same = {item.id for item in project.scans if any(item.image_key == old.image_key for old in items)}
        pairs = [(old, carried) for old, carried in zip(items, found, strict=True) if old.id in same]
        if not pairs:
            return
        changes = [(old.id, carried, *self._proposed(project.scan(old.id), carried)) for old, carried in pairs]
        if all(project.scan(scan_id).landmarks == after for scan_id, _, _, after in changes):
            self.told.emit("info", f"The fiducials of {source.name} propose nothing new")
            return
        stack.beginMacro(text)
        try:
            for scan_id, _, scheme, after in changes:
                if project.scan(scan_id).scheme != scheme:
                    stack.push(SetScheme(project, scan_id, scheme))
                stack.push(SetLandmarks(project, scan_id, project.scan(scan_id).landmarks, after))
        finally:
            stack.endMacro()
        sure = total = 0
        for scan_id, carried, _, after in changes:
            proposed = after.names(LandmarkState.PROPOSED, order=item_scheme(project.scan(scan_id)).names)
            total += len(proposed)
            sure += len(carried.certain & set(proposed))
            self._context.doubtful[scan_id] = frozenset(proposed) - carried.certain
        self._context.advance()
        doubtful = f", {total - sure} of them doubtful: Next goes to these first" if total > sure else ""
        self.told.emit("info", f"Proposed {total} fiducials from {source.name}{doubtful}")

    def _proposed(self, item: ScanItem, carried: Carried) -> tuple[str, LandmarkSet]:
        """Return the scheme and the fiducials that a scan is to have."""
        opens = item.scheme == CLOSED and carried.opening is not None and not item.landmarks.points
        scheme = scheme_of(OPEN) if opens else item_scheme(item)
        image = self._context.project.range_image(item.id)
        return scheme.name, edits.proposed(item.landmarks, scheme, carried.positions, (image.width, image.height))


def _is_open(item: ScanItem) -> bool:
    names = item_scheme(item).names
    return bool(item.landmarks.names(LandmarkState.UNSET, LandmarkState.PROPOSED, order=names))
