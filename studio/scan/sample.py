"""The bundled sample as the studio opens it. No Qt."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

import resources
from engine.errors import InputError


@dataclass(frozen=True)
class SampleScan:
    """One scan of the sample: its files, what it is called, the word that was spoken and its letters that were held."""

    path: Path
    fiducials: Path | None
    name: str
    word: str
    held: str
    scheme: str


def sample_scans(person: str = "subject") -> tuple[SampleScan, ...]:
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
        SampleScan(
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
