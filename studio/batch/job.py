"""One scan of a batch, from its inputs to figures and files: the job of window, command line and workers. No Qt."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from engine.errors import Cancelled, InputError
from engine.files.source import checked_file
from engine.progress import Progress, part, silent
from engine.scan.limits import Limits
from studio.batch.options import FileItem
from studio.batch.sources import is_regular, item_sources, resolved
from studio.scan.job import METHOD, FitInputs, check_overwrites, export_face, face_files, run, template_for
from studio.scan.judged_figures import judged, measured
from studio.scan.options import FitOptions

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from engine.scan.range_image import RangeImage

State = Literal["done", "skipped", "failed", "cancelled"]


@dataclass(frozen=True, eq=False)
class ScanItem:
    """One scan of a batch that is in memory already, as the window and project files have it.

    ``out`` names the face to write, or None where only the fit is wanted; ``fit`` is one that is fresh already, which
    only has to be written; ``sources`` are files that the face must not replace.
    """

    name: str
    scan: RangeImage
    inputs: FitInputs
    options: FitOptions
    out: Path | None = None
    fit: FaceFit | None = None
    sources: tuple[Path, ...] = ()


@dataclass(frozen=True)
class ItemResult:
    """What became of one item.

    ``figures`` are those of the fit with its regions and the worst verdict; ``files`` what was written; ``error`` one
    line that says which file or value, what is wrong and what to do; ``own_fault`` whether the program itself failed;
    ``key`` and ``sources`` what the face was made from; ``measured`` the figures before anything was judged.
    """

    name: str
    state: State
    figures: dict[str, Any] = field(default_factory=dict)
    files: tuple[Path, ...] = ()
    error: str = ""
    own_fault: bool = False
    seconds: float = 0.0
    key: str = ""
    sources: tuple[Path, ...] = ()
    measured: dict[str, Any] = field(default_factory=dict)


def attempt(
    item: FileItem | ScanItem, limits: Limits, progress: Progress = silent
) -> tuple[ItemResult, FaceFit | None]:
    """Fit one item and write its face; a failure becomes a result, so that the others go on.

    Raises
    ------
    Cancelled
        From ``progress``; no file is then half written.
    """
    started = time.monotonic()
    try:
        result, fit = _done(item, limits, progress)
        return replace(result, seconds=time.monotonic() - started), fit
    except Cancelled:
        raise
    except (InputError, OSError) as error:
        where = getattr(error, "filename", None)
        text = str(error) if where is None else f"{where}: {getattr(error, 'strerror', error)}; check it"
        return ItemResult(item.name, "failed", error=text, seconds=time.monotonic() - started), None
    except Exception as error:
        text = f"failed by a fault of the program: {type(error).__name__}: {error}"
        return ItemResult(item.name, "failed", error=text, own_fault=True, seconds=time.monotonic() - started), None


def _done(item: FileItem | ScanItem, limits: Limits, progress: Progress) -> tuple[ItemResult, FaceFit]:
    key = ""
    if isinstance(item, FileItem):
        progress(0.0, "reading")
        scan, inputs, sources, key = _read(item)
        fit = None
    else:
        scan, inputs, fit, sources = item.scan, item.inputs, item.fit, item.sources
    if item.out is not None:
        _make_folder(item.out)
        check_overwrites(face_files(item.out, scan.colour is not None), sources)
    if fit is None:
        fit = run(inputs, item.options, part(progress, 0.05, 0.85))
    found = measured(fit, inputs.template)
    judgement = judged(found, limits)
    files: tuple[Path, ...] = ()
    if item.out is not None:
        files = export_face(fit, scan, item.out, part(progress, 0.85, 1.0), sources=sources)
    return ItemResult(item.name, "done", judgement, files, key=key, sources=sources, measured=found), fit


def _read(item: FileItem) -> tuple[RangeImage, FitInputs, tuple[Path, ...], str]:
    """Return the scan of an item, what its fit is made of, all files that were read, and the key of all that."""
    from engine.files.scan import read_scan
    from studio.scan.fiducial_files import fiducials_for_fit
    from studio.scan.fiducial_options import FiducialOptions
    from studio.scan.scheme_cli import scheme_files, scheme_from

    known = item_sources(item)
    # Hashed before they are read: what is written in between makes the item count as changed.
    for source in (item.scan, item.fiducials, *scheme_files(item.scheme)):
        checked_file(source)
    digests = digests_of(known)
    scheme = scheme_from(item.scheme)
    file = read_scan(item.scan, item.unit)
    sources = tuple(dict.fromkeys((*file.source_files, item.fiducials, *scheme_files(item.scheme))))
    template_for(None, scheme)
    placed, _, _ = fiducials_for_fit(item.fiducials, scheme, file.scan, FiducialOptions(), file.view, file.unit)
    return file.scan, FitInputs(file.scan, placed, scheme), sources, content_key(item, sources, digests)


def digests_of(sources: Iterable[Path]) -> dict[Path, bytes]:
    """Return the SHA-256 of files by where they lead; what is no regular file has none."""
    digests = {}
    for source in filter(is_regular, resolved(sources)):
        with source.open("rb") as handle:
            digests[source] = hashlib.file_digest(handle, "sha256").digest()
    return digests


def content_key(item: FileItem, sources: Iterable[Path], digests: Mapping[Path, bytes] | None = None) -> str:
    """Return the key of all that an item's face depends on: bytes of its files, scheme, unit, options, method.

    ``digests`` are those of files that were hashed before.

    Raises
    ------
    InputError
        When a source is missing or is no regular file, which might never end.
    """
    digest = hashlib.sha256()
    settings = {"method": METHOD, "scheme": Path(item.scheme).name, "unit": item.unit, **item.options.model_dump()}
    digest.update(json.dumps(settings, sort_keys=True).encode())
    known = dict(digests or {})
    for source in sorted({path.resolve() for path in sources}):
        if source not in known:
            known |= digests_of([checked_file(source)])
        digest.update(known[source])
    return digest.hexdigest()


def _make_folder(out: Path) -> None:
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(str(out), f"its folder cannot be made ({error.strerror})", "choose another place") from None
