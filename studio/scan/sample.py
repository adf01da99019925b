"""The bundled sample as the studio opens it. No Qt."""

from __future__ import annotations

import tomllib

import resources
from engine.errors import InputError
from studio.scan.dropped import ScanToRead


def sample_scans(person: str = "subject") -> tuple[ScanToRead, ...]:
    """Return the scans of one person of the sample, the base first.

    Raises
    ------
    InputError
        When the sample is not installed.
    """
    index = resources.sample_path("sample.toml")
    if not index.is_file():
        raise InputError(str(index), "the sample is not installed", "install the program again")
    with index.open("rb") as handle:
        table = tomllib.load(handle)
    return tuple(
        ScanToRead(
            index.parent / entry["scan"],
            index.parent / entry["fiducials"],
            entry["name"],
            entry["word"],
            entry["held"],
            entry["scheme"],
        )
        for entry in table["scan"]
        if entry["subject"] == person
    )
