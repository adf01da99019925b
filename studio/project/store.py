"""Project files (``.qface``): one SQLite database, written whole or not at all, and believed only after checks.

The header is one JSON text; arrays are ``.npy`` bytes under their content key in chunks of at most 64 MB (colour
pictures too: they open faster than PNG and cost 0.9 MB at 640 x 480). Of the fits, each scan's present one is stored,
so that a project opens with its results and needs no fitting.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from engine.errors import InputError
from engine.files.complaint import bad_field
from engine.mesh import TriangleMesh
from engine.scan.range_image import Camera, RangeImage
from studio.project import header as h
from studio.project.arrays import CHUNK_BYTES, read_array, write_array
from studio.project.checks import check_landmark, check_name
from studio.project.document import SUFFIX, Project, content_key
from studio.project.migrations import APPLICATION_ID, migrate, schema, schema_of, version_now

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit

_MAGIC = b"SQLite format 3\0"
_FIT_ARRAYS = ("normals", "pixels", "filled", "deviation_mm", "folded_faces")
_MOST_PIXELS = 64_000_000


def save(project: Project, path: Path | None = None) -> Path:
    """Write the project to ``path``, or to where it lies; that file is replaced only when the new one is complete.

    Raises
    ------
    InputError
        When there is no path, or it cannot be written; the file that was there is then as before.
    """
    target = path or project.path
    if target is None:
        raise InputError("project", "has no file yet", "save it under a name")
    target = Path(target)
    resolved = target.resolve()
    if resolved.is_dir():
        raise InputError(str(target), "is a folder", "give the project a file name")
    temporary = resolved.with_name(f".{resolved.name[:100]}.{secrets.token_hex(4)}.part")
    try:
        _write(project, temporary)
        temporary.replace(resolved)
    except (sqlite3.Error, OSError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        problem = f"cannot be written ({reason})"
        raise InputError(str(target), problem, "check the folder, its rights and space") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
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
        with _opened(path) as connection:
            return _read(connection, path)
    except (sqlite3.Error, UnicodeDecodeError) as error:
        raise InputError(str(path), f"is damaged ({error})", "open an older copy of the project") from error


def _write(project: Project, path: Path) -> None:
    connection = sqlite3.connect(path)
    try:
        # Nobody else sees this file before it is whole, so a journal would only cost time.
        connection.execute("PRAGMA journal_mode = OFF")
        connection.execute("PRAGMA synchronous = OFF")
        migrate(connection)
        header = _header(project, connection)
        connection.execute("INSERT INTO project VALUES ('header', ?)", (header.model_dump_json(),))
        connection.commit()
    finally:
        connection.close()
    with path.open("rb+") as handle:
        os.fsync(handle.fileno())


def _header(project: Project, connection: sqlite3.Connection) -> h.ProjectHeader:
    from importlib.metadata import PackageNotFoundError, version

    try:
        program = f"quasiface-studio {version('quasiface-studio')}"
    except PackageNotFoundError:
        program = "quasiface-studio"
    scans, fits = [], {}
    for item in project.scans:
        key, fit = project.fit_key(item.id), project.fit(item.id)
        if key is not None and fit is not None:
            fits[key] = _fit_header(fit, connection)
        image = _image_header(project.range_image(item.id), connection)
        scans.append(h.ScanHeader.of(item, image=image, fit=key))
    return h.ProjectHeader.of(project, written_by=program, scans=scans, fits=fits)


def _image_header(scan: RangeImage, connection: sqlite3.Connection) -> h.ImageHeader:
    result = h.ImageHeader()
    if scan.camera is not None:
        camera = scan.camera
        result.camera = h.CameraHeader(fx=camera.fx, fy=camera.fy, cx=camera.cx, cy=camera.cy)
        depth = -scan.points[..., 2]
        # A third of the size, but only where not a single bit of the points is lost.
        if camera.points(depth).tobytes() == scan.points.tobytes():
            result.depth = write_array(connection, depth)
    if result.depth is None:
        result.points = write_array(connection, scan.points)
    if scan.colour is not None:
        result.colour = write_array(connection, scan.colour)
    return result


def _fit_header(fit: FaceFit, connection: sqlite3.Connection) -> h.FitHeader:
    mesh = fit.mesh
    arrays: dict[str, Any] = {"vertices": mesh.vertices, "faces": mesh.faces, "uv": mesh.uv}
    arrays |= {name: getattr(fit, name) for name in _FIT_ARRAYS}
    keys = {name: write_array(connection, array) for name, array in arrays.items()}
    report = {name: getattr(fit.repair, name) for name in h.RepairHeader.model_fields}
    return h.FitHeader(
        **keys,
        fiducial_residual_px=fit.fiducial_residual_px,
        folded_fiducials=list(fit.folded_fiducials),
        repair=h.RepairHeader(**report),
        levels=fit.levels,
        scheme=fit.scheme,
    )


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    """Open a file for reading after checking that it is one of ours; an older version is migrated in memory."""
    version = _check_file(path)
    connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, CHUNK_BYTES + 4096)
        connection.execute("PRAGMA trusted_schema = OFF")
        if schema(connection) != schema_of(version):
            raise InputError(str(path), "holds other tables than a project", "open a file saved by this program")
        if version < version_now():
            older, connection = connection, sqlite3.connect(":memory:")
            older.backup(connection)
            older.close()
            migrate(connection)
        yield connection
    finally:
        connection.close()


def _check_file(path: Path) -> int:
    """Return the version of a project file, read from its first 100 bytes (SQLite file format, section 1.3)."""
    try:
        with path.open("rb") as handle:
            head = handle.read(100)
            size = os.fstat(handle.fileno()).st_size
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(str(path), f"cannot be opened ({reason})", "check the name and the folder") from error
    if size == 0:
        raise InputError(str(path), "is empty", "open an older copy of the project")
    number = {name: int.from_bytes(head[at : at + 4], "big") for name, at in _HEAD.items()}
    if len(head) < 100 or not head.startswith(_MAGIC) or number["application_id"] != APPLICATION_ID:
        raise InputError(str(path), "is not a Quasiface Studio project", f"open a {SUFFIX} file")
    version = number["user_version"]
    if version > version_now():
        problem = f"was written by a newer version (file version {version}, this program reads {version_now()})"
        raise InputError(str(path), problem, "update the program")
    page = int.from_bytes(head[16:18], "big")
    if version < 1 or size < number["pages"] * (65536 if page == 1 else page):
        raise InputError(str(path), "is cut off", "copy it again, or open an older copy of the project")
    return version


_HEAD = {"pages": 28, "user_version": 60, "application_id": 68}


def _read(connection: sqlite3.Connection, path: Path) -> Project:
    row = connection.execute("SELECT value FROM project WHERE key = 'header' AND typeof(value) = 'text'").fetchone()
    if row is None:
        raise InputError(str(path), "has no header", "open an older copy of the project")
    try:
        header = h.ProjectHeader.model_validate_json(row[0])
    except ValidationError as error:
        raise bad_field(error, str(path)) from None
    project = Project(path.stem, path)
    header.give(project)
    for scan in header.scans:
        _add_scan(project, scan, connection, path)
    for key, fit in header.fits.items():
        project.keep_fit(key, _fit(fit, connection, f"{path}, fit {key}"))
    for scan in header.scans:
        if scan.fit is not None and project.has_fit(scan.fit):
            project.set_last(scan.id, scan.fit)
    return project


def _add_scan(project: Project, scan: h.ScanHeader, connection: sqlite3.Connection, path: Path) -> None:
    subject = f"{path}, scan {scan.name[:40]!r}"
    image = _image(scan.image, connection, subject)
    try:
        check_name(scan.name)
        if project.unique_name(scan.name) != scan.name:
            raise InputError("name", "belongs to two scans", "rename one")
        landmarks = scan.landmark_set()
        for name, point in landmarks.points.items():
            check_landmark(name, point, image.width, image.height)
        # Not the stored key: should it not agree, the results show as stale instead of belonging to another scan.
        item = scan.item(content_key(image))
        project.insert_scan(len(project.scans), item, image)
    except InputError as error:
        raise InputError(f"{subject}, {error.subject}", error.problem, error.remedy) from None


def _image(image: h.ImageHeader, connection: sqlite3.Connection, subject: str) -> RangeImage:
    camera = None if image.camera is None else Camera(**image.camera.model_dump())
    if image.depth is not None and camera is not None:
        depth = _array(connection, image.depth, subject, "<f8", 2)
        points = camera.points(depth)
    elif image.points is not None:
        points = _array(connection, image.points, subject, "<f8", 3)
    else:
        raise InputError(subject, "has neither points nor depth with a camera", "open an older copy of the project")
    if points.shape[0] * points.shape[1] > _MOST_PIXELS:
        raise InputError(subject, "has more pixels than a project may hold", "scale the scan down")
    colour = None if image.colour is None else _array(connection, image.colour, subject, "|u1", 3)
    try:
        return RangeImage(points, colour, camera)
    except InputError as error:
        raise InputError(f"{subject}, {error.subject}", error.problem, error.remedy) from None


def _fit(fit: h.FitHeader, connection: sqlite3.Connection, subject: str) -> FaceFit:
    from engine.scan.fit import FaceFit
    from engine.scan.repair import RepairReport

    vertices = _array(connection, fit.vertices, subject, "<f8", 2)
    faces = _array(connection, fit.faces, subject, "<i8", 2)
    count = len(vertices)
    arrays = {
        "normals": _array(connection, fit.normals, subject, "<f8", 2, (count, 3)),
        "pixels": _array(connection, fit.pixels, subject, "<f8", 2, (count, 2)),
        "filled": _array(connection, fit.filled, subject, "|b1", 1, (count,)),
        "deviation_mm": _array(connection, fit.deviation_mm, subject, "<f8", 1, (count,)),
        "folded_faces": _array(connection, fit.folded_faces, subject, "<i8", 1),
    }
    folded = arrays["folded_faces"]
    if len(folded) and (folded.min() < 0 or folded.max() >= len(faces)):
        raise InputError(subject, "names a folded face that is not there", "open an older copy of the project")
    try:
        mesh = TriangleMesh(vertices, faces, _array(connection, fit.uv, subject, "<f8", 2, (count, 2)))
    except InputError as error:
        raise InputError(f"{subject}, {error.subject}", error.problem, error.remedy) from None
    return FaceFit(
        mesh=mesh,
        **arrays,
        fiducial_residual_px=fit.fiducial_residual_px,
        folded_fiducials=tuple(fit.folded_fiducials),
        repair=RepairReport(**fit.repair.model_dump()),
        levels=fit.levels,
        scheme=fit.scheme,
    )


def _array(
    connection: sqlite3.Connection,
    key: str,
    subject: str,
    dtype: str,
    dimensions: int,
    shape: tuple[int, ...] | None = None,
) -> NDArray[Any]:
    array = read_array(connection, key, subject)
    if array.dtype != np.dtype(dtype) or array.ndim != dimensions or (shape is not None and array.shape != shape):
        wrong = f"array {key[:12]} is {array.dtype} {array.shape}"
        raise InputError(subject, wrong, "open an older copy of the project")
    return array
