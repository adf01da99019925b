"""What a batch is made of: its jobs file and its options, declared once. Loads neither numpy nor Qt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.errors import InputError
from engine.files.complaint import bad_field
from engine.files.source import beside
from engine.files.toml_text import load_toml
from studio.scan.options import FitOptions

LARGEST_FILE = 8 << 20
MOST_ITEMS = 10_000
STAGES = ("scan",)

Unit = Literal["mm", "cm", "m"]
Name = Annotated[str, Field(min_length=1, max_length=1024)]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ItemModel(_Model):
    """One ``[[item]]`` of a jobs file; paths are relative to the file and stay in its folder."""

    scan: Name
    fiducials: Name
    scheme: Name = "closed"
    unit: Unit | None = None
    out: Name
    options: dict[str, Any] = {}


class JobsModel(_Model):
    """A jobs file."""

    stage: str
    options: dict[str, Any] = {}
    limits: Name | None = None
    item: list[ItemModel] = Field(min_length=1, max_length=MOST_ITEMS)


@dataclass(frozen=True)
class FileItem:
    """One scan of a batch, by its files.

    ``scheme`` is ``closed``, ``open`` or the path of a scheme's ``.toml``; ``out`` names the face to write.
    """

    name: str
    scan: Path
    fiducials: Path
    out: Path
    options: FitOptions
    scheme: str = "closed"
    unit: Unit | None = None


@dataclass(frozen=True)
class Jobs:
    """What a jobs file asks for; ``limits`` is the file of the limits, if it names one."""

    path: Path
    items: tuple[FileItem, ...]
    limits: Path | None = None


def record_path(jobs: Path) -> Path:
    """Return where it is noted what a batch has done so far."""
    return jobs.with_name(f"{jobs.stem}.done.json")


def read_jobs(path: str | Path, keep: Sequence[Path] = ()) -> Jobs:
    """Read a jobs file (TOML).

    Parameters
    ----------
    path : str or Path
        The file.
    keep : sequence of Path
        Further files that no item may replace.

    Raises
    ------
    InputError
        Naming the file and the field that is wrong: no TOML, another stage, an option out of its limits, a path that
        leads out of the file's folder, two items that write one file, a face that would replace what any is made from.
    """
    path = Path(path)
    values = load_toml(path, "give a jobs file (.toml)", LARGEST_FILE)
    try:
        model = JobsModel.model_validate(values)
    except ValidationError as error:
        raise bad_field(error, str(path)) from None
    if model.stage not in STAGES:
        raise InputError(f"{path}, stage", f"{model.stage[:40]!r} cannot be run in a batch", f"give {STAGES[0]!r}")
    items = tuple(_item(path, number, item, model.options) for number, item in enumerate(model.item))
    limits = None if model.limits is None else beside(path, model.limits, "limits")
    _check_results(path, items, [path, *([limits] if limits is not None else []), *keep])
    return Jobs(path, items, limits)


def _item(path: Path, number: int, item: ItemModel, common: dict[str, Any]) -> FileItem:
    where = f"item.{number}"
    try:
        options = FitOptions.model_validate(common | item.options)
    except ValidationError as error:
        raise bad_field(error, f"{path}, {where}.options") from None
    scheme = item.scheme
    if scheme.lower().endswith(".toml"):
        scheme = str(beside(path, scheme, f"{where}.scheme"))
    elif scheme not in ("closed", "open"):
        remedy = "give closed, open or the .toml of a scheme"
        raise InputError(f"{path}, {where}.scheme", f"{scheme[:40]!r} is no scheme", remedy)
    # What is missing on the disk is that item's own failure, told when its turn comes.
    scan, fiducials, out = (_inside(path, getattr(item, name), f"{where}.{name}") for name in _PATHS)
    if out.suffix.lower() not in (".glb", ".obj"):
        raise InputError(f"{path}, {where}.out", "has no ending that tells the format", "end it in .glb or .obj")
    return FileItem(out.stem, scan, fiducials, out, options, scheme, item.unit)


_PATHS = ("scan", "fiducials", "out")


def _inside(document: Path, name: str, field: str) -> Path:
    """Return a path named by a jobs file; it need not exist, but must lie in the file's folder or below."""
    posix, windows = PurePosixPath(name), PureWindowsPath(name)
    outside = posix.is_absolute() or windows.drive or windows.root or ".." in (*posix.parts, *windows.parts)
    subject = f"{document}, {field}"
    if not name.strip() or "\0" in name or outside:
        raise InputError(subject, f"{name[:80]!r} does not lie beside the file", "give a relative path without '..'")
    target = document.parent / name
    try:
        inside = target.resolve().is_relative_to(document.parent.resolve())
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(subject, f"{name[:80]!r} cannot be followed", "check the link") from error
    if not inside:
        raise InputError(subject, f"{name[:80]!r} leads out of the folder", "name a file in it")
    return target


def _check_results(path: Path, items: tuple[FileItem, ...], others: Sequence[Path]) -> None:
    """Raise an InputError where two items write one file, or one writes what another reads."""
    from studio.batch.sources import check_results, item_sources, resolved

    sources = [*others, *(source for item in items for source in item_sources(item))]
    results = [(f"item.{number}.out", item.out) for number, item in enumerate(items)]
    check_results(str(path), results, [*sources, record_path(path)])
    record = record_path(path)
    if record.resolve() in resolved(sources):
        raise InputError(str(record), "is read by an item, but notes what is done", "rename one of the two files")
