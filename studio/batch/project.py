"""The scans of a project as items of a batch. No Qt."""

from __future__ import annotations

import re
import string
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from engine.errors import InputError
from studio.batch.job import ItemResult, ScanItem
from studio.batch.sources import check_results, project_sources
from studio.scan.job import inputs_of

if TYPE_CHECKING:
    from studio.project.document import Project
    from studio.project.document import ScanItem as ProjectScan

FIELDS = ("name", "number", "word", "held")
"""What a pattern may name in braces."""


def project_items(
    project: Project,
    out: Path | None,
    ending: str = "glb",
    pattern: str = "{name}",
    kept: Sequence[Path] = (),
) -> tuple[list[ScanItem], list[ItemResult]]:
    """Return the items of all scans that can be fitted, and a failure for every other one that says what it needs.

    Parameters
    ----------
    out : Path or None
        Folder of the faces; None writes none.
    ending, pattern : str
        ``glb`` or ``obj``; names of the faces with ``{name}``, ``{number}``, ``{word}``, ``{held}``.
    kept : sequence of Path
        Files that no face may replace, beside those that the scans were read from.

    Raises
    ------
    InputError
        On a pattern that is wrong or gives two scans one name, and where a face would replace a file that a scan of the
        project was read from.
    """
    from studio.project.document import needs

    items, left_out = [], []
    names = face_names(project.scans, pattern) if out is not None else {}
    sources = (*project_sources(project), *kept) if out is not None else ()
    if out is not None:
        results = [(f"scan {scan.name}", out / f"{names[scan.id]}.{ending}") for scan in project.scans]
        check_results(str(out), results, sources)
    for scan in project.scans:
        needed = needs(scan)
        if needed:
            left_out.append(ItemResult(scan.name, "failed", error=f"scan {scan.name}: {needed}; finish its fiducials"))
            continue
        image = project.range_image(scan.id)
        fresh = project.fit(scan.id) if project.state(scan.id).kind == "fresh" else None
        path = None if out is None else out / f"{names[scan.id]}.{ending}"
        items.append(ScanItem(scan.name, image, inputs_of(scan, image), scan.options, path, fresh, sources))
    return items, left_out


def face_names(scans: tuple[ProjectScan, ...], pattern: str) -> dict[str, str]:
    """Return the file name, without its ending, of every scan by its id.

    Raises
    ------
    InputError
        On a field that is not known, a name that is no file name, or one that two scans share.
    """
    subject = f"name pattern {pattern[:60]!r}"
    try:
        fields = [name for _, name, spec, how in string.Formatter().parse(pattern) if name is not None]
    except ValueError as error:
        raise InputError(subject, f"cannot be read ({error})", "put names in braces, such as {name}") from None
    unknown = [name for name in fields if name not in FIELDS]
    if unknown:
        known = ", ".join(f"{{{name}}}" for name in FIELDS)
        raise InputError(subject, f"{{{unknown[0]}}} is not known", f"use {known}")
    found: dict[str, str] = {}
    for number, scan in enumerate(scans, start=1):
        values = {"name": scan.name, "number": f"{number:02d}", "word": scan.word, "held": scan.held}
        text = re.sub(r"\{(\w+)\}", lambda match, values=values: values[match[1]], pattern)  # type: ignore[misc]
        # What a file name may not hold on some system is written as an underscore.
        name = re.sub(r'[<>:"/\\|?*\x00-\x1f]', "_", text).strip(" .")[:120]
        if not name:
            raise InputError(subject, f"gives {scan.name!r} no name", "add {name}")
        twin = next((key for key, other in found.items() if other.casefold() == name.casefold()), None)
        if twin is not None:
            raise InputError(subject, f"gives two scans the name {name!r}", "add {name} or {number}")
        found[scan.id] = name
    return found
