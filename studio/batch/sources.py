"""What a batch reads and must not replace: scans with the files beside them, fiducials, schemes, limits. No Qt."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from engine.errors import InputError
from studio.scan.scheme_cli import scheme_files

if TYPE_CHECKING:
    from studio.batch.options import FileItem
    from studio.project.document import Project

_LARGEST_HEADER = 4 << 20
_HEAD = 1 << 20
"""Bytes of an OBJ in which its materials are named."""


def with_companions(scan: Path) -> tuple[Path, ...]:
    """Return a scan's file and those that it names: images of a ``.json``, materials and pictures of an ``.obj``.

    What is missing or cannot be read names nothing; the reader says what is wrong with it.
    """
    try:
        if not scan.is_file():
            return (scan,)
        named = {".json": _images, ".obj": _materials}.get(scan.suffix.lower(), lambda _scan: [])(scan)
    except (OSError, ValueError, RecursionError):
        return (scan,)
    return (scan, *(scan.parent / name for name in named if name and "\0" not in name))


def _images(scan: Path) -> list[str]:
    if scan.stat().st_size > _LARGEST_HEADER:
        return []
    values = json.loads(scan.read_bytes())
    fields = [values.get(name) for name in ("depth", "disparity", "colour")] if isinstance(values, dict) else []
    return [field for field in fields if isinstance(field, str)]


def _materials(scan: Path) -> list[str]:
    with scan.open("rb") as handle:
        libraries = _after(("mtllib",), handle.read(_HEAD))
    found = list(libraries)
    for name in libraries:
        library = scan.parent / name
        if library.is_file() and library.stat().st_size <= _LARGEST_HEADER:
            # A picture's options stand before its name, and names have spaces: every tail of the line may be it.
            for line in _after(("map_", "bump", "disp", "decal", "norm"), library.read_bytes()):
                words = line.split(" ")
                found += [" ".join(words[k:]) for k in range(min(len(words), 16))]
    return found


def _after(keys: tuple[str, ...], data: bytes) -> list[str]:
    """Return what follows one of ``keys`` (beginnings of a line's first word), without quotes."""
    found = []
    for line in data.decode("utf-8-sig", "replace").splitlines()[:1_000_000]:
        key, _, rest = line.strip().replace("\t", " ").partition(" ")
        if rest and key.lower().startswith(keys):
            found.append(rest.strip().strip('"').replace("\\", "/"))
    return found


def item_sources(item: FileItem) -> tuple[Path, ...]:
    """Return the files that an item of a jobs file is made from."""
    return (*with_companions(item.scan), item.fiducials, *scheme_files(item.scheme))


def project_sources(project: Project) -> tuple[Path, ...]:
    """Return the files that a project's scans were read from, and the project's own."""
    found = [] if project.path is None else [Path(project.path)]
    for scan in project.scans:
        name = scan.source.depth_file
        if name and "\0" not in name:
            places = [Path(name)]
            if project.path is not None:
                places.append(Path(project.path).parent / name)
            found += [path for place in places for path in with_companions(place)]
    return tuple(dict.fromkeys(found))


def check_results(subject: str, results: Sequence[tuple[str, Path]], sources: Iterable[Path]) -> None:
    """Raise an InputError where two results write one file, or one replaces a file that the batch reads.

    Parameters
    ----------
    subject : str
        What names the results, such as the jobs file.
    results : sequence of (str, Path)
        Where each face is named, and the face; the ``.mtl`` and picture of an ``.obj`` count as well.
    sources : iterable of Path
        All files that are read; links are followed.
    """
    written: dict[Path, str] = {}
    kept = resolved(sources)
    for where, out in results:
        for file in written_files(out):
            target = file.resolve()
            if target in kept:
                problem = f"would replace an input ({kept[target]})"
                raise InputError(f"{subject}, {where}", problem, "choose another name or folder")
            if target in written:
                problem = f"{file.name!r} is also written by {written[target]}"
                raise InputError(f"{subject}, {where}", problem, "give every face a file of its own")
            written[target] = where


def resolved(paths: Iterable[Path]) -> Mapping[Path, Path]:
    """Return the paths by where they lead; those that lead nowhere are left out."""
    found = {}
    for path in paths:
        try:
            found[path.resolve()] = path
        except (OSError, RuntimeError, ValueError):
            continue
    return found


def is_regular(path: Path) -> bool:
    """Return whether a regular file stands at ``path``; a device, a pipe and what cannot be looked at are none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def written_files(out: Path) -> tuple[Path, ...]:
    """Return all files that a face may write: of an ``.obj`` also its material and picture."""
    from engine.files.obj import obj_files

    return obj_files(out, textured=True) if out.suffix.lower() == ".obj" else (out,)
