"""What is left of a project after a crash: a snapshot with its range images, and a small journal of every edit since.

The snapshot is a project file and is written again only when scans come or go; the journal is JSON, a few kilobytes,
and holds all that edits can change. No Qt.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pydantic import ValidationError

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.complaint import bad_field
from studio.project import header as h
from studio.project import store
from studio.project.checks import check_landmark, check_name
from studio.project.document import Project
from studio.project.recovery_files import RecoveryFiles

_LONGEST = 16_000_000


def copy_of(project: Project) -> Project:
    """Return a project of the same scans, which another thread may write while this one is edited."""
    copy = Project()
    for index, item in enumerate(project.scans):
        copy.insert_scan(index, item, project.range_image(item.id))
    return copy


def contents(project: Project) -> tuple[tuple[str, str], ...]:
    """Return what a snapshot depends on: id and content key of every scan."""
    return tuple(sorted((item.id, item.image_key) for item in project.scans))


def write_journal(project: Project, path: Path) -> None:
    """Write down all that edits can change.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    scans = [h.ItemHeader.of(item) for item in project.scans]
    journal = h.Journal.of(project, path="" if project.path is None else str(project.path), scans=scans)
    with atomic_write(path) as handle:
        handle.write(journal.model_dump_json().encode())


def recover(files: RecoveryFiles) -> tuple[Project, Path | None]:
    """Return the project as it was at the last edit, and where it was stored; it is not bound to that place yet.

    Raises
    ------
    InputError
        When snapshot or journal are damaged.
    """
    snapshot = store.load(files.snapshot)
    try:
        if files.journal.stat().st_size > _LONGEST:
            raise InputError(str(files.journal), "is far too long for a journal", "open the project as it was saved")
        journal = h.Journal.model_validate_json(files.journal.read_bytes())
    except OSError as error:
        raise InputError(str(files.journal), f"cannot be read ({error.strerror})", "open the saved project") from error
    except ValidationError as error:
        raise bad_field(error, str(files.journal)) from None
    project = Project()
    journal.give(project)
    for entry in journal.scans:
        if entry.id not in snapshot:
            continue
        image, stored = snapshot.range_image(entry.id), snapshot.scan(entry.id)
        item = entry.item(stored.image_key)
        if entry.image_key != stored.image_key:  # read again in another unit, and the snapshot came no more
            item = replace(item, source=stored.source)
        check_name(item.name)
        for name, point in item.landmarks.points.items():
            check_landmark(name, point, image.width, image.height)
        project.insert_scan(len(project.scans), item, image)
    return project, Path(journal.path) if journal.path else None
