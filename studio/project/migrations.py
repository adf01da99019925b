"""Versions of the project file: one function takes a database from each version to the next. No Qt.

Version 0 is an empty database, so saving runs all of them (a step finds no rows then) and a file of any age is opened
by running the rest. Opening an older file never changes it: the steps run on a copy in memory.
"""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Callable

APPLICATION_ID = 0x51464143
"""The bytes ``QFAC`` in the database header tell a project from any other SQLite file."""


def _tables(connection: sqlite3.Connection) -> None:
    """0 -> 1: one JSON header, and arrays as ``.npy`` bytes in chunks."""
    connection.execute("CREATE TABLE project (key TEXT PRIMARY KEY, value TEXT NOT NULL)")
    connection.execute("CREATE TABLE chunks (key TEXT, part INTEGER, data BLOB NOT NULL, PRIMARY KEY (key, part))")


def _digest_and_pictures(connection: sqlite3.Connection) -> None:
    """1 -> 2: a digest of the header, so that no flipped digit passes for a value, and a picture for lists."""
    connection.execute("CREATE TABLE pictures (name TEXT PRIMARY KEY, png BLOB NOT NULL)")
    rows = connection.execute("SELECT value FROM project WHERE key = 'header' AND typeof(value) = 'text'").fetchall()
    for (header,) in rows:
        connection.execute("INSERT OR REPLACE INTO project VALUES ('digest', ?)", (digest_of(header),))


def _basis(_connection: sqlite3.Connection) -> None:
    """2 -> 3: the header may name rigs, performances and a basis setup; tables and older headers stay as they are."""


MIGRATIONS: list[Callable[[sqlite3.Connection], None]] = [_tables, _digest_and_pictures, _basis]


def version_now() -> int:
    """Return the version that this program writes."""
    return len(MIGRATIONS)


def digest_of(header: str) -> str:
    """Return what stands beside a header to tell whether it is as it was written: SHA-256 in hex."""
    return hashlib.sha256(header.encode()).hexdigest()


def write_header(connection: sqlite3.Connection, header: str) -> None:
    """Store the header of a project with its digest in a database of the present version."""
    rows = [("header", header), ("digest", digest_of(header))]
    connection.executemany("INSERT OR REPLACE INTO project VALUES (?, ?)", rows)


def migrate(connection: sqlite3.Connection) -> None:
    """Bring an open, writable database to the version of this program."""
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    for step in MIGRATIONS[version:]:
        step(connection)
    connection.execute(f"PRAGMA user_version = {version_now()}")
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.commit()


def schema(connection: sqlite3.Connection) -> set[tuple[str, str, str]]:
    """Return what a database contains: (type, name, definition) of everything in it."""
    rows = connection.execute("SELECT type, name, coalesce(sql, '') FROM sqlite_schema")
    return {(str(kind), str(name), " ".join(str(sql).split())) for kind, name, sql in rows}


def schema_of(version: int) -> set[tuple[str, str, str]]:
    """Return what a database of ``version`` contains when it was written here."""
    connection = sqlite3.connect(":memory:")
    try:
        for step in MIGRATIONS[:version]:
            step(connection)
        return schema(connection)
    finally:
        connection.close()
