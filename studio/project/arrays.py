"""Arrays in the project file: ``.npy`` bytes under their content key, in chunks; never a pickle."""

from __future__ import annotations

import io
import sqlite3
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from studio.project.document import array_key

CHUNK_BYTES = 64 * 1024 * 1024
LARGEST_BYTES = 2 * 1024**3
_TYPES = ("<f8", "<i8", "|u1", "|b1")


def write_array(connection: sqlite3.Connection, array: NDArray[Any]) -> str:
    """Store an array once and return its content key."""
    key = array_key(array)
    if connection.execute("SELECT 1 FROM chunks WHERE key = ? LIMIT 1", (key,)).fetchone():
        return key
    buffer = io.BytesIO()
    np.save(buffer, np.ascontiguousarray(array), allow_pickle=False)
    data = buffer.getbuffer()
    for part, start in enumerate(range(0, len(data), CHUNK_BYTES)):
        row = (key, part, data[start : start + CHUNK_BYTES])
        connection.execute("INSERT INTO chunks (key, part, data) VALUES (?, ?, ?)", row)
    return key


def read_array(connection: sqlite3.Connection, key: str, subject: str) -> NDArray[Any]:
    """Return the read-only array of a content key.

    Raises
    ------
    InputError
        About file ``subject``: when the array is absent, is not plain numbers, has another size than its
        header says, or other content than its key says.
    """
    damaged = InputError(subject, f"array {key[:12]} is damaged", "open an older copy of the project")
    sizes = connection.execute(
        "SELECT part, typeof(data), length(data) FROM chunks WHERE key = ? ORDER BY part", (key,)
    ).fetchall()
    if not sizes:
        raise InputError(subject, f"array {key[:12]} is not in it", "open an older copy of the project")
    if [part for part, _, _ in sizes] != list(range(len(sizes))) or any(kind != "blob" for _, kind, _ in sizes):
        raise damaged
    total = sum(length for _, _, length in sizes)
    if total > LARGEST_BYTES or max(length for _, _, length in sizes) > CHUNK_BYTES:
        raise InputError(subject, f"array {key[:12]} is larger than a project may hold", "open an older copy of it")
    data = bytearray()
    for (chunk,) in connection.execute("SELECT data FROM chunks WHERE key = ? ORDER BY part", (key,)):
        data += chunk
    buffer = io.BytesIO(bytes(data[:4096]))
    try:
        if np.lib.format.read_magic(buffer) != (1, 0):
            raise damaged
        shape, fortran, dtype = np.lib.format.read_array_header_1_0(buffer)
    except (ValueError, SyntaxError, TypeError, EOFError, KeyError):
        raise damaged from None
    if dtype.str not in _TYPES or fortran or len(shape) > 3 or any(n < 0 for n in shape):
        raise InputError(subject, f"array {key[:12]} is not plain numbers", "open an older copy of the project")
    count = 1
    for n in shape:
        count *= int(n)
    if count * dtype.itemsize != len(data) - buffer.tell():
        raise damaged
    array = np.frombuffer(data, dtype=dtype, offset=buffer.tell()).reshape(shape)
    array.flags.writeable = False
    if array_key(array) != key:
        raise damaged
    return array
