"""What is left of a project after a crash: a small journal of every edit, and pieces that hold scans and results.

The journal is JSON, a few kilobytes, holds all that edits can change, and is written within a second of every step. A
range image is written once, when its scan is new. Should the end come before that, the image is still in the saved
project or in the file it was read from; its content key tells whether it is the same. No Qt.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import Field, ValidationError

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.complaint import bad_field
from engine.files.source import read_bytes
from engine.scan.range_image import RangeImage
from studio.project import header as h
from studio.project import store
from studio.project.basis_recovery import basis_pieces, items_of_pieces, restore_contents
from studio.project.basis_state import BasisState
from studio.project.checks import check_landmark, check_name
from studio.project.document import Project, ScanItem, content_key
from studio.project.lost_images import from_source, placeholder
from studio.project.path_text import plain
from studio.project.recovery_files import RecoveryFiles

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit

_LONGEST = 16_000_000
_Images = dict[str, RangeImage]


class Journal(h.SharedHeader):
    """The project as it is after a step.

    ``path`` is where it was stored as text (empty: nowhere; `place`), ``stamp`` what that file held then, ``time`` when
    the step was made (seconds since 1970), ``steps`` how many came since it was saved, ``in_view`` the scan that was
    looked at, ``fits`` the input key of every scan's result.
    """

    path: h.Text = ""
    stamp: Annotated[str, Field(pattern="^([0-9a-f]{64})?$")] = ""
    time: float = Field(0.0, ge=0.0, le=1e11)
    steps: int = Field(0, ge=0)
    in_view: h.Id | None = None
    fits: dict[h.Id, h.InputKey] = Field(default_factory=dict)
    scans: list[h.ItemHeader] = Field(max_length=10_000)

    @property
    def place(self) -> Path | None:
        """Where the project was stored."""
        return Path(plain(self.path)) if self.path else None


class Recovered(NamedTuple):
    """A project as it was at the last edit, where it was stored (not bound to that place yet), and what is lost."""

    project: Project
    path: Path | None
    lost: tuple[str, ...] = ()
    stamp: str = ""


def journal_of(
    project: Project, time: float = 0.0, steps: int = 0, in_view: str | None = None, stamp: str = ""
) -> Journal:
    """Return all of a project that edits can change."""
    keys = {item.id: project.fit_key(item.id) for item in project.scans}
    return Journal.of(
        project,
        fits={scan_id: key for scan_id, key in keys.items() if key is not None},
        path="" if project.path is None else str(project.path),
        stamp=stamp,
        time=time,
        steps=max(steps, 0),
        in_view=in_view,
        scans=[h.ItemHeader.of(item) for item in project.scans],
    )


def write_journal(journal: Journal, path: Path) -> None:
    """Write a journal, whole or not at all.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    with atomic_write(path) as handle:
        handle.write(journal.model_dump_json().encode())


def read_journal(path: Path) -> Journal:
    """Return a journal.

    Raises
    ------
    InputError
        When it cannot be read or is damaged.
    """
    data = read_bytes(path, _LONGEST)
    try:
        return Journal.model_validate_json(data)
    except ValidationError as error:
        raise bad_field(error, str(path)) from None


def copy_of(project: Project) -> Project:
    """Return a project of the same values, which another thread may write while this one is edited."""
    copy = Project()
    h.SharedHeader.of(project).give(copy)
    copy.basis.take_contents(project.basis)
    for index, item in enumerate(project.scans):
        copy.insert_scan(index, item, project.range_image(item.id))
        key, fit = project.fit_key(item.id), project.fit(item.id)
        if key is not None and fit is not None:
            copy.put_fit(item.id, key, fit)
    return copy


Piece = tuple[Path, Callable[[], object]]


def pieces_of(project: Project, files: RecoveryFiles) -> tuple[Piece, ...]:
    """Return where every piece of a project lies and what writes it, range images first.

    The writers hold values only, so that another thread may call them.
    """
    found: dict[Path, Callable[[], object]] = {}
    shared = h.SharedHeader.of(project).model_copy(update={"basis": None})  # rigs and performances have their own
    for item in project.scans:
        path = files.image(item.image_key)
        found[path] = _image_writer(shared, item, project.range_image(item.id), path)
    for item in project.scans:
        key, fit = project.fit_key(item.id), project.fit(item.id)
        if key is not None and fit is not None:
            path = files.fit(key)
            found[path] = _fit_writer(key, fit, path)
    return (*basis_pieces(project, files).items(), *found.items())


def recover(files: RecoveryFiles) -> Recovered:
    """Return what a session left, with what could not be found again.

    A scan whose range image is nowhere keeps its fiducials on an empty one, and is named in ``lost``. Without a
    readable journal the scans come back as they were when they were added. Of the pieces only those are read that the
    journal names.

    Raises
    ------
    InputError
        When there is nothing to recover.
    """
    lost: list[str] = []
    pieces, project = _Pieces(files), Project()
    try:
        journal = read_journal(files.journal)
    except InputError as error:
        if not pieces.items and not files.pieces("rig") and not files.pieces("motion"):
            raise
        lost.append(f"the journal ({error.problem}): the scans are as they were when they were added")
        journal = Journal(time=0.0, steps=0, scans=[h.ItemHeader.of(item) for item in pieces.items])
        items_of_pieces(project, files)
    journal.give(project)
    elsewhere = _Elsewhere(journal)
    lost += restore_contents(project, files, elsewhere.basis)
    for entry in journal.scans:
        item, image = entry.item(), pieces.image(entry.image_key)
        if image is None:
            image = elsewhere.find(item)
        if image is None:
            item, image = _without_image(item, pieces)
            lost.append(f"the range image of {item.name}")
        try:
            _insert(project, item, image)
        except InputError as error:
            lost.append(f"{item.name} ({error.subject} {error.problem})")
            continue
        _give_fit(project, item, journal.fits.get(item.id), files)
    return Recovered(project, journal.place, tuple(lost), journal.stamp)


class _Elsewhere:
    """Range images of scans that no piece was written of: in the saved project, or in the file they came from."""

    def __init__(self, journal: Journal) -> None:
        self._path = journal.place
        self._looked = False
        self._stored: Project | None = None

    def find(self, item: ScanItem) -> RangeImage | None:
        """Return the range image of exactly this content, if it is anywhere."""
        project = self._project()
        return (None if project is None else project.image(item.image_key)) or from_source(item)

    def basis(self) -> BasisState | None:
        """Return the rigs and performances of the saved project."""
        project = self._project()
        return None if project is None else project.basis

    def _project(self) -> Project | None:
        if not self._looked and self._path is not None:
            with contextlib.suppress(InputError, OSError):  # gone, or of a name that this machine does not take
                self._stored = store.load(self._path)
        self._looked = True
        return self._stored


class _Pieces:
    """The range images of a session, each read when it is asked for: those of removed scans may be many."""

    def __init__(self, files: RecoveryFiles) -> None:
        self._files = files
        self._images: _Images = {}
        self._read: dict[Path, tuple[ScanItem, ...]] = {}

    def image(self, key: str) -> RangeImage | None:
        """Return the range image of a content key, if there is a piece of it that can be read."""
        if key not in self._images and self._files.image(key).is_file():
            self._load(self._files.image(key))
        return self._images.get(key)

    @property
    def items(self) -> tuple[ScanItem, ...]:
        """The scans of all pieces, as they were when they were added."""
        return tuple(item for path in self._files.pieces("image") for item in self._load(path))

    def _load(self, path: Path) -> tuple[ScanItem, ...]:
        if path not in self._read:
            try:
                piece = store.load(path)
            except (InputError, OSError):  # whose it was, and whether it is found elsewhere, the journal knows
                self._read[path] = ()
                return ()
            self._images |= {item.image_key: piece.range_image(item.id) for item in piece.scans}
            self._read[path] = piece.scans
        return self._read[path]


def _give_fit(project: Project, item: ScanItem, key: str | None, files: RecoveryFiles) -> None:
    """Give a scan its result back; without one it is made again."""
    if key is None or not files.fit(key).is_file():
        return
    try:
        fit = store.load(files.fit(key)).kept_fit(key)
    except InputError:
        return
    if fit is not None:
        project.put_fit(item.id, key, fit)


def _without_image(item: ScanItem, pieces: _Pieces) -> tuple[ScanItem, RangeImage]:
    """Return a scan on the image it had before it was read again, or else on an empty one."""
    before = next((old for old in pieces.items if old.id == item.id), None)
    image = None if before is None else pieces.image(before.image_key)
    if before is not None and image is not None:
        return replace(item, image_key=before.image_key, source=before.source), image
    image = placeholder(item)
    return replace(item, image_key=content_key(image)), image


def _insert(project: Project, item: ScanItem, image: RangeImage) -> None:
    check_name(item.name)
    for name, point in item.landmarks.points.items():
        check_landmark(name, point, image.width, image.height, project.schemes.values())
    project.insert_scan(len(project.scans), item, image)


def _image_writer(shared: h.SharedHeader, item: ScanItem, image: RangeImage, path: Path) -> Callable[[], object]:
    def write() -> None:
        piece = Project()
        shared.give(piece)
        piece.insert_scan(0, item, image)
        store.save(piece, path)

    return write


def _fit_writer(key: str, fit: FaceFit, path: Path) -> Callable[[], object]:
    return lambda: store.save(Project(), path, fits={key: fit})
