"""Reads a project's database: nothing of it is believed before it is checked. No Qt.

With a list of losses, one scan that cannot be read does not keep the others from being read (``salvage``).
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from engine.errors import InputError
from engine.files.complaint import bad_field
from engine.files.source import kind_of
from engine.mesh import TriangleMesh
from engine.scan.range_image import Camera, RangeImage
from studio.project import header as h
from studio.project.arrays import CHUNK_BYTES, LARGEST_BYTES, read_array
from studio.project.basis_store import read_contents
from studio.project.checks import check_landmark, check_name
from studio.project.document import SUFFIX, Project, content_key
from studio.project.migrations import APPLICATION_ID, digest_of, migrate, schema, schema_of, version_now

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit

_MAGIC = b"SQLite format 3\0"
_MOST_PIXELS = 64_000_000


@contextlib.contextmanager
def opened(path: Path, *, whole: bool = True) -> Iterator[sqlite3.Connection]:
    """Open a file for reading after checking that it is one of ours; an older version is migrated in memory.

    ``whole`` also refuses a file that is shorter than it says.
    """
    version = version_of(path, whole=whole)
    connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        if not whole and _is_short(path):
            connection.close()
            connection = _cut_off(path)
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


def _is_short(path: Path) -> bool:
    with path.open("rb") as handle:
        head = handle.read(100)
    return path.stat().st_size < int.from_bytes(head[28:32], "big") * _page(head)


def _page(head: bytes | bytearray) -> int:
    size = int.from_bytes(head[16:18], "big")
    return 65536 if size == 1 else size


def _cut_off(path: Path) -> sqlite3.Connection:
    """Return a copy in memory of the pages that are there: SQLite opens no file that is shorter than it says."""
    if path.stat().st_size > LARGEST_BYTES:
        raise InputError(str(path), "is cut off, and too large to look into", "open an older copy of the project")
    data = bytearray(path.read_bytes())
    page = _page(data)
    if page < 512 or len(data) < page:
        raise InputError(str(path), "is cut off", "open an older copy of the project")
    count = len(data) // page
    data[28:32] = count.to_bytes(4, "big")
    connection = sqlite3.connect(":memory:")
    connection.deserialize(bytes(data[: count * page]))
    return connection


def version_of(path: Path, *, whole: bool = True) -> int:
    """Return the version of a project file, read from its first 100 bytes (SQLite file format, section 1.3).

    Raises
    ------
    InputError
        When it is no project, of a newer version, or (``whole``) shorter than it says.
    """
    if kind_of(path) == "other":
        raise InputError(str(path), "is not a regular file", f"open a {SUFFIX} file")
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
        raise InputError(str(path), problem, "update the program, or open an older copy of the project")
    if version < 1 or (whole and size < number["pages"] * _page(head)):
        raise InputError(str(path), "is cut off", "copy it again, or open an older copy of the project")
    return version


_HEAD = {"pages": 28, "user_version": 60, "application_id": 68}


def header_text(connection: sqlite3.Connection, path: Path) -> tuple[str, bool]:
    """Return the header of an open project as text, and whether it is as it was written.

    Raises
    ------
    InputError
        When there is none.
    """
    sql = "SELECT value FROM project WHERE key = ? AND typeof(value) = 'text'"
    row = connection.execute(sql, ("header",)).fetchone()
    if row is None:
        raise InputError(str(path), "has no header", "open an older copy of the project")
    return str(row[0]), connection.execute(sql, ("digest",)).fetchone() == (digest_of(row[0]),)


def read(connection: sqlite3.Connection, path: Path) -> Project:
    """Return the project of an open database; nothing of it may be damaged."""
    text, sound = header_text(connection, path)
    try:
        header = h.ProjectHeader.model_validate_json(text)
    except ValidationError as error:
        raise bad_field(error, str(path)) from None
    if not sound:
        raise InputError(str(path), "is damaged (its header is not as it was written)", "open an older copy of it")
    project = Project(path.stem, path)
    header.give(project, path.resolve().parent)
    for scan in header.scans:
        add_scan(project, scan, connection, path)
    read_contents(project.basis, header.contents, connection, str(path))
    for key, fit in header.fits.items():
        project.keep_fit(key, read_fit(fit, connection, f"{path}, fit {key}"))
    for scan in header.scans:
        if scan.fit is not None and project.has_fit(scan.fit):
            project.set_last(scan.id, scan.fit)
    return project


def add_scan(
    project: Project, scan: h.ScanHeader, connection: sqlite3.Connection, path: Path, image: RangeImage | None = None
) -> None:
    """Read one scan into a project; ``image`` takes the place of the range image in the file.

    Raises
    ------
    InputError
        Naming the scan and the field; the project is then as before.
    """
    subject = f"{path}, scan {scan.name[:40]!r}"
    image = image or _image(scan.image, connection, subject)
    try:
        check_name(scan.name)
        if project.unique_name(scan.name) != scan.name:
            raise InputError("name", "belongs to two scans", "rename one")
        landmarks = scan.landmark_set()
        for name, point in landmarks.points.items():
            check_landmark(name, point, image.width, image.height, project.schemes.values())
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


def read_fit(fit: h.FitHeader, connection: sqlite3.Connection, subject: str) -> FaceFit:
    """Return a result; an InputError about ``subject`` names what is wrong with it."""
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
