"""The undoable edits of the scan stage, one class each.

A command holds ids, keys and small old and new values. It is validated when it is made (``InputError``), so that what
has been pushed always works. Range images and fits stay in the project, by content key.
"""

from __future__ import annotations

import time
from collections.abc import Mapping

from PySide6.QtGui import QUndoCommand

from engine.errors import InputError
from engine.landmarks import UNSET, Landmark, LandmarkSet, LandmarkState
from engine.scan.range_image import RangeImage
from studio.project.checks import check_landmark, check_name
from studio.project.document import Project, ScanItem, SourceInfo
from studio.project.schemes import find_scheme
from studio.scan.options import FitOptions

NUDGE_SECONDS = 1.0
"""Nudges of one point, or values of one option, that follow each other faster than this are one step."""

_NUDGE_ID, _OPTION_ID = 1, 2


class AddScan(QUndoCommand):
    """Put a scan at the end of the list, or at ``index``.

    ``item.image_key`` must be the content key of ``scan``; the name must be free.
    """

    def __init__(
        self, project: Project, item: ScanItem, scan: RangeImage | None = None, index: int | None = None, text: str = ""
    ) -> None:
        super().__init__(text or f"Add {item.name}")
        _check_name(project, item.name, item.id)
        find_scheme(project.schemes, item.scheme)
        if item.id in project:
            raise InputError(f"scan {item.name}", "is already in the project", "add it once")
        if scan is not None:
            if project.add_image(scan) != item.image_key:
                raise InputError(f"scan {item.name}", "its range image is not the one it names", "read the file again")
        elif project.image(item.image_key) is None:
            raise InputError(f"scan {item.name}", "comes without its range image", "add it from its file again")
        width, height = _size(project, item)
        for name, point in item.landmarks.points.items():
            check_landmark(name, point, width, height, project.schemes.values())
        self._project, self._item = project, item
        self._index = len(project.scans) if index is None else index

    def redo(self) -> None:
        """Insert the scan."""
        self._project.insert_scan(self._index, self._item)

    def undo(self) -> None:
        """Take it out again."""
        self._project.remove_scan(self._item.id)


class RemoveScan(QUndoCommand):
    """Take a scan out of the list; its fiducials and fit come back on undo."""

    def __init__(self, project: Project, scan_id: str, text: str = "") -> None:
        self._item = _item(project, scan_id)
        super().__init__(text or f"Remove {self._item.name}")
        self._project = project
        self._index = project.index(scan_id)

    def redo(self) -> None:
        """Remove the scan."""
        self._project.remove_scan(self._item.id)

    def undo(self) -> None:
        """Put it back where it was."""
        self._project.insert_scan(self._index, self._item)


class RenameScan(QUndoCommand):
    """Change the name of a scan, and the word and the held letters that it stands for (None: unchanged)."""

    def __init__(
        self,
        project: Project,
        scan_id: str,
        name: str,
        word: str | None = None,
        held: str | None = None,
        text: str = "",
    ) -> None:
        item = _item(project, scan_id)
        name = name.strip()
        _check_name(project, name, scan_id)
        super().__init__(text or (f"Rename {item.name} to {name}" if name != item.name else f"Describe {name}"))
        self._project, self._id = project, scan_id
        self._old = (item.name, item.word, item.held)
        self._new = (name, item.word if word is None else word.strip(), item.held if held is None else held.strip())

    def redo(self) -> None:
        """Set the new names."""
        self._set(self._new)

    def undo(self) -> None:
        """Set the old names."""
        self._set(self._old)

    def _set(self, names: tuple[str, str, str]) -> None:
        self._project.change_scan(self._id, name=names[0], word=names[1], held=names[2])


class SetLandmark(QUndoCommand):
    """Change one fiducial: place, drag, nudge, confirm, skip, unset, lock.

    Every drag is a step of its own. With ``nudge`` the step joins the one before it when that was a nudge of the
    same point less than a second ago.
    """

    def __init__(
        self,
        project: Project,
        scan_id: str,
        name: str,
        old: Landmark,
        new: Landmark,
        text: str = "",
        *,
        nudge: bool = False,
    ) -> None:
        item = _item(project, scan_id)
        _check_edits(project, item, {name: old}, {name: new})
        super().__init__(text or f"{_verb(old, new, nudge)} {name} on {item.name}")
        self._project, self._id, self._name = project, scan_id, name
        self._old, self._new = old, new
        self._nudge, self._time = nudge, time.monotonic()

    def id(self) -> int:
        """Return the number of what may be merged: nudges only."""
        return _NUDGE_ID if self._nudge else -1

    def mergeWith(self, other: QUndoCommand) -> bool:
        """Take a nudge of the same point in, when it came soon enough."""
        if not isinstance(other, SetLandmark) or not (self._nudge and other._nudge):
            return False
        same = (other._project, other._id, other._name) == (self._project, self._id, self._name)
        if not same or other._time - self._time > NUDGE_SECONDS:
            return False
        self._new, self._time = other._new, other._time
        return True

    def redo(self) -> None:
        """Set the new place."""
        self._set(self._new)

    def undo(self) -> None:
        """Set the old place."""
        self._set(self._old)

    def _set(self, point: Landmark) -> None:
        landmarks = self._project.scan(self._id).landmarks
        self._project.change_scan(self._id, landmarks=landmarks.with_point(self._name, point))


class SetLandmarks(QUndoCommand):
    """Change many fiducials at once: confirm all, carry over, mirror, propose, import. Only the differing are kept."""

    def __init__(self, project: Project, scan_id: str, old: LandmarkSet, new: LandmarkSet, text: str = "") -> None:
        item = _item(project, scan_id)
        names = [n for n in dict.fromkeys((*old.points, *new.points)) if old[n] != new[n]]
        self._old, self._new = {n: old[n] for n in names}, {n: new[n] for n in names}
        _check_edits(project, item, self._old, self._new)
        super().__init__(text or f"Change {len(names)} fiducials on {item.name}")
        self._project, self._id = project, scan_id

    def redo(self) -> None:
        """Set the new places."""
        self._set(self._new)

    def undo(self) -> None:
        """Set the old places."""
        self._set(self._old)

    def _set(self, points: Mapping[str, Landmark]) -> None:
        landmarks = self._project.scan(self._id).landmarks
        self._project.change_scan(self._id, landmarks=landmarks.with_points(points))


class SetScheme(QUndoCommand):
    """Choose the fiducial scheme of a scan; points that the other scheme has beyond it stay for when it comes back."""

    def __init__(self, project: Project, scan_id: str, scheme: str, text: str = "") -> None:
        item = _item(project, scan_id)
        find_scheme(project.schemes, scheme)
        super().__init__(text or f"Use scheme {scheme} on {item.name}")
        self._project, self._id = project, scan_id
        self._old, self._new = item.scheme, scheme

    def redo(self) -> None:
        """Set the new scheme."""
        self._project.change_scan(self._id, scheme=self._new)

    def undo(self) -> None:
        """Set the old scheme."""
        self._project.change_scan(self._id, scheme=self._old)


class SetSource(QUndoCommand):
    """Put another reading of a scan's file in the place of its range image: the same pixels in another unit."""

    def __init__(self, project: Project, scan_id: str, source: SourceInfo, scan: RangeImage, text: str = "") -> None:
        item = _item(project, scan_id)
        for name, point in item.landmarks.points.items():
            check_landmark(name, point, scan.width, scan.height, project.schemes.values())
        super().__init__(text or f"Read {item.name} in {source.unit}")
        self._project, self._id = project, scan_id
        self._old, self._new = (item.source, item.image_key), (source, project.add_image(scan))

    def redo(self) -> None:
        """Take the new reading."""
        self._set(self._new)

    def undo(self) -> None:
        """Take the old reading."""
        self._set(self._old)

    def _set(self, reading: tuple[SourceInfo, str]) -> None:
        self._project.change_scan(self._id, source=reading[0], image_key=reading[1])


class SetOptions(QUndoCommand):
    """Change the fit options of a scan; values of one option that follow within a second are one step."""

    def __init__(self, project: Project, scan_id: str, options: FitOptions, text: str = "") -> None:
        item = _item(project, scan_id)
        new = FitOptions.checked(**options.model_dump())
        names = [n for n in FitOptions.model_fields if getattr(new, n) != getattr(item.options, n)]
        if len(names) == 1:
            title, value = FitOptions.model_fields[names[0]].title or names[0], getattr(new, names[0])
            shown = ("on" if value else "off") if isinstance(value, bool) else f"{value:g}"
            label = f"Set {title[:1].lower() + title[1:]} to {shown} on {item.name}"
        else:
            label = f"Change fit options on {item.name}"
        super().__init__(text or label)
        self._project, self._id = project, scan_id
        self._old, self._new = item.options, new
        self._names, self._time = names, time.monotonic()

    def id(self) -> int:
        """Return the number of what may be merged: a single option."""
        return _OPTION_ID if len(self._names) == 1 else -1

    def mergeWith(self, other: QUndoCommand) -> bool:
        """Take the next value of the same option in, when it came soon enough."""
        if not isinstance(other, SetOptions):
            return False
        same = (other._project, other._id, other._names) == (self._project, self._id, self._names)
        if not same or other._time - self._time > NUDGE_SECONDS:
            return False
        self._new, self._time = other._new, other._time
        self.setText(other.text())
        return True

    def redo(self) -> None:
        """Set the new options."""
        self._project.change_scan(self._id, options=self._new)

    def undo(self) -> None:
        """Set the old options."""
        self._project.change_scan(self._id, options=self._old)


def _item(project: Project, scan_id: str) -> ScanItem:
    if scan_id not in project:
        raise InputError("scan", "is not in the project any more", "choose another")
    return project.scan(scan_id)


def _size(project: Project, item: ScanItem) -> tuple[int, int]:
    image = project.image(item.image_key)
    if image is None:
        raise InputError(f"scan {item.name}", "comes without its range image", "add it from its file again")
    return image.width, image.height


def _check_name(project: Project, name: str, scan_id: str) -> None:
    check_name(name)
    if project.unique_name(name, besides=scan_id) != name:
        raise InputError(f"name {name!r}", "belongs to another scan", "choose another")


def _check_edits(project: Project, item: ScanItem, old: Mapping[str, Landmark], new: Mapping[str, Landmark]) -> None:
    width, height = _size(project, item)
    for name, point in new.items():
        before = item.landmarks[name]
        if before != old[name]:
            raise ValueError(f"fiducial {name} on {item.name} has changed since the edit began")
        check_landmark(name, point, width, height, project.schemes.values())
        moved = (before.state, before.x, before.y) != (point.state, point.x, point.y)
        if before.locked and point.locked and moved:
            raise InputError(f"fiducial {name}", "is locked", "unlock it to move it")


def _verb(old: Landmark, new: Landmark, nudge: bool) -> str:
    if nudge:
        return "Nudge"
    if new == UNSET or new.state == LandmarkState.UNSET:
        return "Unset"
    if new.state != old.state:
        if new.state == LandmarkState.PLACED:
            confirmed = old.state == LandmarkState.PROPOSED and (old.x, old.y) == (new.x, new.y)
            return "Confirm" if confirmed else "Place"
        return "Skip" if new.state == LandmarkState.SKIPPED else "Propose"
    if (old.x, old.y) == (new.x, new.y) and old.locked != new.locked:
        return "Lock" if new.locked else "Unlock"
    return "Move"
