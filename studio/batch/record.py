"""What a batch has done so far, beside its jobs file, so that it can go on where it was stopped. No Qt."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.source import read_bytes
from engine.scan.limits import Limits
from studio.batch.job import ItemResult, content_key
from studio.batch.options import FileItem, record_path
from studio.batch.sources import written_files
from studio.output import plain
from studio.scan.judged_figures import judged
from studio.scan.scheme_cli import scheme_files

LARGEST_FILE = 256 << 20
INTERVAL = 1.0
"""Seconds between two writings of the record while items come in."""


class _Stamp(BaseModel):
    model_config = ConfigDict(extra="forbid")
    size: Annotated[int, Field(ge=0)]
    mtime_ns: int


class _Done(BaseModel):
    model_config = ConfigDict(extra="forbid")
    key: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    files: dict[str, _Stamp]
    sources: list[str]
    figures: dict[str, Any]


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid")
    done: dict[str, _Done] = {}


class BatchRecord:
    """The finished items of a jobs file, by the file they wrote; kept in ``<jobs>.done.json`` beside it.

    A record that cannot be read counts as none: every item is then done again.
    """

    def __init__(self, jobs: Path) -> None:
        self.path = record_path(jobs)
        self._folder = jobs.parent.resolve()
        self._record = _Record()
        self._written = 0.0
        if self.path.is_file():
            try:
                self._record = _Record.model_validate_json(read_bytes(self.path, LARGEST_FILE))
            except (ValidationError, InputError):
                self._record = _Record()

    def finished(self, item: FileItem, limits: Limits) -> ItemResult | None:
        """Return the result of an item that need not be done again: same inputs, files as they were written.

        Its figures are judged anew, against ``limits``. The record is a file like any other: what it names counts only
        where the item itself would read or write it, and never leads out of the folder.
        """
        done = self._record.done.get(self._name(item.out))
        if done is None:
            return None
        own = {self._name(path): path for path in written_files(item.out)}
        try:
            if self._name(item.out) not in done.files or not own.keys() >= done.files.keys():
                return None
            if any(_stamp(own[name]) != stamp for name, stamp in done.files.items()):
                return None
            named = [*map(self._inside, done.sources), item.scan, item.fiducials, *scheme_files(item.scheme)]
            if content_key(item, named) != done.key:
                return None
            figures = judged(done.figures, limits)
        except (OSError, InputError, KeyError, TypeError, ValueError):
            return None
        files = tuple(own[name] for name in done.files)
        return ItemResult(item.name, "skipped", figures, files, key=done.key, measured=done.figures)

    def _inside(self, name: str) -> Path:
        """Return a path of the record; InputError where it leads out of the folder."""
        path = self._folder / name
        if Path(name).is_absolute() or not path.resolve().is_relative_to(self._folder):
            raise InputError(str(self.path), f"{name[:80]!r} leads out of the folder", "fit the item again")
        return path

    def add(self, item: FileItem, result: ItemResult) -> None:
        """Note a finished item; the record is written at most once a second, and by ``save``."""
        stamps = {self._name(path): _stamp(path) for path in result.files}
        named = [self._name(path) for path in result.sources]
        self._record.done[self._name(item.out)] = _Done(
            key=result.key, files=stamps, sources=named, figures=plain(result.measured)
        )
        if time.monotonic() - self._written > INTERVAL:
            self.save()

    def save(self) -> None:
        """Write the record; InputError where that is not possible."""
        self._written = time.monotonic()
        with atomic_write(self.path) as handle:
            handle.write(json.dumps(self._record.model_dump()).encode())

    def _name(self, path: Path) -> str:
        """Return a path relative to the folder where it lies in it, so that the folder can be moved."""
        resolved = path.resolve()
        return str(resolved.relative_to(self._folder) if resolved.is_relative_to(self._folder) else resolved)


def _stamp(path: Path) -> _Stamp:
    status = path.stat()
    return _Stamp(size=status.st_size, mtime_ns=status.st_mtime_ns)
