"""Project files (``.qface``): one SQLite database, written whole or not at all, and believed only after checks.

The header is one JSON text with a digest; arrays are ``.npy`` bytes under their content key in chunks of at most 64 MB
(colour pictures too: they open faster than PNG and cost 0.9 MB at 640 x 480). The header stands in front, so that a
file that was cut off still says what it held. Of the fits, each scan's present one is stored, so that a project opens
with its results and needs no fitting.

Order of writing, for a loss of power: all bytes under a temporary name, ``fsync``, then the rename, then ``fsync`` of
the folder. At any moment the name therefore stands for the whole old file or the whole new one. No Qt.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import secrets
import sqlite3
import stat
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray
from pydantic import ValidationError

from engine.errors import InputError
from engine.files.complaint import bad_field
from engine.scan.range_image import RangeImage
from studio.project import header as h
from studio.project.arrays import write_array
from studio.project.basis_store import contents_of
from studio.project.document import Project, array_key
from studio.project.migrations import migrate, write_header
from studio.project.reading import opened, read
from studio.project.thumbnail import write_picture

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit

_FIT_ARRAYS = ("normals", "pixels", "filled", "deviation_mm", "folded_faces")
_HEX = re.compile("[0-9a-f]{8}")
_Arrays = dict[str, NDArray[Any]]


def save(
    project: Project,
    path: Path | None = None,
    *,
    fits: Mapping[str, FaceFit] | None = None,
    picture: bytes | None = None,
) -> Path:
    """Write the project to ``path``, or to where it lies; that file is replaced only when the new one is complete.

    Parameters
    ----------
    project : Project
        Its path is set to the file that was written.
    path : Path, optional
        The file; a symbolic link is followed, and the rights of a file that is replaced are kept.
    fits : mapping, optional
        Results by input key that are stored besides those of the scans.
    picture : bytes, optional
        A PNG that shows the project in lists (``thumbnail.picture_of``).

    Raises
    ------
    InputError
        When there is no path, it cannot be written, or a value is one that no project has; the file that was there
        is then as before.
    """
    target = path or project.path
    if target is None:
        raise InputError("project", "has no file yet", "save it under a name")
    target = Path(target)
    resolved = target.resolve()
    if resolved.is_dir():
        raise InputError(str(target), "is a folder", "give the project a file name")
    temporary = resolved.with_name(f"{_beginning(resolved)}{secrets.token_hex(4)}.part")
    try:
        rights = _rights(resolved, target)
        _write(project, temporary, resolved.parent, fits or {}, picture)
        if rights is not None:
            temporary.chmod(rights)
        _sync(temporary)
        temporary.replace(resolved)
    except ValidationError as error:
        raise bad_field(error, str(target), "change this value, or take back the step it came with") from None
    except (sqlite3.Error, OSError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        problem = f"cannot be written ({reason})"
        raise InputError(str(target), problem, "check the folder, its rights and space") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
    with contextlib.suppress(OSError):  # some systems cannot open a folder, and lose nothing but the guarantee
        _sync(resolved.parent)
    project.set_path(target)
    return target


def load(path: Path) -> Project:
    """Return the project of a file, with its results.

    Raises
    ------
    InputError
        When the file is not a project, was written by a newer version, is cut off or damaged, or holds a value that
        no project has (the field is named).
    """
    path = Path(path)
    try:
        with opened(path) as connection:
            return read(connection, path)
    except (sqlite3.Error, UnicodeDecodeError) as error:
        raise InputError(str(path), f"is damaged ({error})", "open an older copy of the project") from error


def remove_remains(path: Path) -> int:
    """Delete what a saving of ``path`` left that was killed in the middle, and return how many files that were.

    Only for who holds the lock of the project: nobody else is saving it then.
    """
    resolved, count = path.resolve(), 0
    beginning = _beginning(resolved)
    with contextlib.suppress(OSError):
        for file in resolved.parent.iterdir():
            middle = file.name[len(beginning) : -len(".part")]
            if file.name.startswith(beginning) and file.name.endswith(".part") and _HEX.fullmatch(middle):
                file.unlink()
                count += 1
    return count


def _beginning(resolved: Path) -> str:
    """Return how the temporary files of a file begin: readable, and by its whole name no other file's."""
    whole = hashlib.sha256(os.fsencode(resolved.name)).hexdigest()[:8]
    return f".{resolved.name[:50]}.{whole}."


def _rights(resolved: Path, target: Path) -> int | None:
    """Return the rights of the file that is to be replaced; a rename would go past a write protection."""
    try:
        rights = stat.S_IMODE(resolved.stat().st_mode)
    except FileNotFoundError:
        return None
    if not rights & 0o222 or not os.access(resolved, os.W_OK):
        raise InputError(str(target), "is write-protected", "save the project under another name")
    return rights


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _write(project: Project, path: Path, folder: Path, fits: Mapping[str, FaceFit], picture: bytes | None) -> None:
    connection = sqlite3.connect(path)
    try:
        # Nobody else sees this file before it is whole, so a journal would only cost time.
        connection.execute("PRAGMA journal_mode = OFF")
        connection.execute("PRAGMA synchronous = OFF")
        migrate(connection)
        arrays: _Arrays = {}
        write_header(connection, _header(project, folder, fits, arrays).model_dump_json())
        if picture is not None:
            write_picture(connection, picture)
        for key, array in arrays.items():
            write_array(connection, array, key)
        connection.commit()
    finally:
        connection.close()


def _header(project: Project, folder: Path, more: Mapping[str, FaceFit], arrays: _Arrays) -> h.ProjectHeader:
    from importlib.metadata import PackageNotFoundError, version

    try:
        program = f"quasiface-studio {version('quasiface-studio')}"
    except PackageNotFoundError:
        program = "quasiface-studio"
    scans, fits = [], {key: _fit_header(fit, arrays) for key, fit in more.items()}
    for item in project.scans:
        key, fit = project.fit_key(item.id), project.fit(item.id)
        if key is not None and fit is not None:
            fits[key] = _fit_header(fit, arrays)
        image = _image_header(project.range_image(item.id), arrays)
        scans.append(h.ScanHeader.of(item, image=image, fit=key))
    contents = contents_of(project.basis, lambda array: _keep(arrays, array))
    return h.ProjectHeader.of(project, folder, written_by=program, scans=scans, fits=fits, contents=contents)


def _image_header(scan: RangeImage, arrays: _Arrays) -> h.ImageHeader:
    result = h.ImageHeader()
    if scan.camera is not None:
        camera = scan.camera
        result.camera = h.CameraHeader(fx=camera.fx, fy=camera.fy, cx=camera.cx, cy=camera.cy)
        depth = -scan.points[..., 2]
        # A third of the size, but only where not a single bit of the points is lost.
        if camera.points(depth).tobytes() == scan.points.tobytes():
            result.depth = _keep(arrays, depth)
    if result.depth is None:
        result.points = _keep(arrays, scan.points)
    if scan.colour is not None:
        result.colour = _keep(arrays, scan.colour)
    return result


def _fit_header(fit: FaceFit, arrays: _Arrays) -> h.FitHeader:
    mesh = fit.mesh
    found: dict[str, Any] = {"vertices": mesh.vertices, "faces": mesh.faces, "uv": mesh.uv}
    found |= {name: getattr(fit, name) for name in _FIT_ARRAYS}
    keys = {name: _keep(arrays, array) for name, array in found.items()}
    report = {name: getattr(fit.repair, name) for name in h.RepairHeader.model_fields}
    return h.FitHeader(
        **keys,
        fiducial_residual_px=fit.fiducial_residual_px,
        folded_fiducials=list(fit.folded_fiducials),
        repair=h.RepairHeader(**report),
        levels=fit.levels,
        scheme=fit.scheme,
    )


def _keep(arrays: _Arrays, array: NDArray[Any]) -> str:
    key = array_key(array)
    arrays[key] = array
    return key
