"""Reads what can be read of a damaged project file; what is lost is counted, never guessed. No Qt."""

from __future__ import annotations

import json
import sqlite3
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from engine.errors import InputError
from engine.files.complaint import bad_field
from studio.project import header as h
from studio.project.basis_header import ContentsHeader
from studio.project.basis_recovery import salvage_contents
from studio.project.document import Project
from studio.project.lost_images import from_source, placeholder
from studio.project.reading import add_scan, header_text, opened, read_fit

_Found = tuple[list[h.ScanHeader], dict[str, h.FitHeader], int, ContentsHeader | None]


@dataclass(frozen=True)
class Salvaged:
    """A project without a path, so that the damaged file is not saved over, and what is not in it.

    ``whole`` of ``total`` scans, and ``more_whole`` of ``more`` rigs and performances, have everything they had;
    ``lost`` names what is gone, in words.
    """

    project: Project
    whole: int
    total: int
    lost: tuple[str, ...]
    more_whole: int = 0
    more: int = 0

    @property
    def summary(self) -> str:
        """What was saved and what was lost, in a sentence."""
        parts = [f"{self.whole} of {self.total} scans"] if self.total or not self.more else []
        parts += [f"{self.more_whole} of {self.more} rigs and performances"] if self.more else []
        text = f"{' and '.join(parts)} are whole"
        return f"{text}; lost: {'; '.join(self.lost)}" if self.lost else text


def salvage(path: Path) -> Salvaged:
    """Return what can still be read of a project file.

    Raises
    ------
    InputError
        When it is no project of this program, of a newer version, or nothing of it can be read.
    """
    path = Path(path)
    lost: list[str] = []
    project = Project(path.stem)
    try:
        with opened(path, whole=False) as connection:
            text, sound = header_text(connection, path)
            scans, fits, total, contents = _header(text, project, path, lost)
            if not sound:
                lost.append("the certainty of small values: the header is not as it was written, look at the fiducials")
            whole = sum(_scan(project, scan, connection, path, lost) for scan in scans)
            more = len(project.basis.rigs) + len(project.basis.motions)
            more_whole = salvage_contents(project, contents, connection, lost)
            for key, fit in fits.items():
                _fit(project, scans, key, fit, connection, lost)
    except (sqlite3.Error, UnicodeDecodeError) as error:
        raise InputError(str(path), f"is damaged ({error})", "open an older copy of the project") from error
    if not project.scans and not more:
        raise InputError(str(path), "holds no scan that can be read", "open an older copy of the project")
    return Salvaged(project, whole, total, tuple(lost), more_whole, more)


def _header(text: str, project: Project, path: Path, lost: list[str]) -> _Found:
    """Return the scans and fits whose fields are sound, how many scans there were, and the arrays of rigs."""
    try:
        header = h.ProjectHeader.model_validate_json(text)
    except ValidationError:
        return _fields(text, project, path, lost)
    header.give(project, path.resolve().parent)
    return header.scans, dict(header.fits), len(header.scans), header.contents


def _fields(text: str, project: Project, path: Path, lost: list[str]) -> _Found:
    try:
        fields = json.loads(text)
    except ValueError:
        raise InputError(str(path), "its header is damaged", "open an older copy of the project") from None
    if not isinstance(fields, dict) or not isinstance(fields.get("scans"), list):
        raise InputError(str(path), "its header is damaged", "open an older copy of the project")
    shared = {name: fields[name] for name in h.SharedHeader.model_fields if name in fields}
    for name, value in shared.items():
        try:
            h.SharedHeader.model_validate({name: value}).give(project, path.resolve().parent)
        except ValidationError as error:
            lost.append(f"{name} ({bad_field(error, name).problem})")
    scans = []
    for index, entry in enumerate(fields["scans"]):
        called = str(entry.get("name")) if isinstance(entry, dict) else f"scan {index + 1}"
        try:
            scans.append(h.ScanHeader.model_validate_json(json.dumps(entry)))
        except ValidationError as error:
            wrong = bad_field(error, called[:40])
            lost.append(f"{wrong.subject} ({wrong.problem})")
    return scans, _sound_fits(fields.get("fits")), len(fields["scans"]), _sound_contents(fields.get("contents"))


def _sound_contents(entry: Any) -> ContentsHeader | None:
    try:
        return ContentsHeader.model_validate_json(json.dumps(entry))
    except ValidationError:
        return None  # its rigs and performances are looked for in their files


def _sound_fits(entries: Any) -> dict[str, h.FitHeader]:
    found = {}
    for key, entry in entries.items() if isinstance(entries, dict) else ():
        try:
            found[key] = h.FitHeader.model_validate_json(json.dumps(entry))
        except ValidationError:
            continue  # its scan shows that it has no fit, and makes it again
    return found


def _scan(project: Project, scan: h.ScanHeader, connection: sqlite3.Connection, path: Path, lost: list[str]) -> bool:
    """Read one scan as far as possible; returns whether it is whole."""
    try:
        add_scan(project, scan, connection, path)
        return True
    except (InputError, sqlite3.Error) as error:
        problem = error.problem if isinstance(error, InputError) else str(error)
    item = scan.item()
    image = from_source(item)
    try:
        add_scan(project, scan, connection, path, image or placeholder(item))
    except (InputError, sqlite3.Error):
        lost.append(f"{scan.name[:40]} ({problem})")
        return False
    if image is None:
        lost.append(f"the range image of {scan.name[:40]}, its fiducials are kept ({problem})")
    return image is not None


def _fit(
    project: Project,
    scans: list[h.ScanHeader],
    key: str,
    fit: h.FitHeader,
    connection: sqlite3.Connection,
    lost: list[str],
) -> None:
    names = [scan.name[:40] for scan in scans if scan.fit == key]
    try:
        project.keep_fit(key, read_fit(fit, connection, f"fit {key}"))
    except (InputError, sqlite3.Error):
        lost.append(f"the fitted face of {', '.join(names) or 'no scan'}")
        return
    for scan in scans:
        if scan.fit == key and scan.id in project:
            project.set_last(scan.id, key)
