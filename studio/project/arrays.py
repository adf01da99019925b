"""Arrays in the project file: ``.npy`` bytes under their content key, in chunks; never a pickle."""

from __future__ import annotations

import io
import math
import re
import sqlite3
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from studio.project.document import array_key

CHUNK_BYTES = 64 * 1024 * 1024
LARGEST_BYTES = 2 * 1024**3

# The header that numpy writes for plain numbers, taken literally: nothing of it is evaluated.
_HEADER = re.compile(
    rb"\x93NUMPY\x01\x00(..)"
    rb"\{'descr': '(<f8|<f4|<i8|\|u1|\|b1)', 'fortran_order': False, 'shape': \(([0-9, ]{0,60})\), \} *\n",
    re.DOTALL,
)


def write_array(connection: sqlite3.Connection, array: NDArray[Any], key: str | None = None) -> str:
    """Store an array once and return its content key; ``key`` saves working it out again."""
    key = key or array_key(array)
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
    begin = _HEADER.match(data)
    if begin is None:
        raise InputError(subject, f"array {key[:12]} is not plain numbers", "open an older copy of the project")
    dtype, shape = np.dtype(begin[2].decode()), tuple(int(n) for n in begin[3].split(b",") if n.strip())
    if int.from_bytes(begin[1], "little") != begin.end() - 10 or len(shape) > 3:
        raise damaged
    if math.prod(shape) * dtype.itemsize != len(data) - begin.end():
        raise damaged
    array = np.frombuffer(data, dtype=dtype, offset=begin.end()).reshape(shape)
    array.flags.writeable = False
    if array_key(array) != key:
        raise damaged
    return array
