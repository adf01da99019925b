"""Fiducial schemes (TOML): which points there are, in clicking order."""

from __future__ import annotations

import tomllib
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from engine.errors import InputError
from engine.files.complaint import bad_field
from engine.files.source import read_bytes
from engine.landmarks import LandmarkDefinition, LandmarkScheme, Side

LARGEST_FILE = 1 << 20


class _Landmark(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: str
    group: str
    side: Side
    mirror: str
    hint: str


class _Scheme(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: str
    title: str
    landmark: list[_Landmark]


def read_scheme(path: Path) -> LandmarkScheme:
    """Read a scheme.

    Raises
    ------
    InputError
        Names the file and the field that is wrong.
    """
    try:
        document = _Scheme.model_validate(tomllib.loads(read_bytes(path, LARGEST_FILE).decode("utf-8")))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(str(path), f"cannot be read as TOML ({error})", "choose a fiducial scheme") from error
    except ValidationError as error:
        raise bad_field(error, str(path), "compare with a bundled scheme") from error
    landmarks = tuple(LandmarkDefinition(**dict(entry)) for entry in document.landmark)
    try:
        return LandmarkScheme(document.name, document.title, landmarks)
    except InputError as error:
        raise InputError(f"{path}, {error.subject}", error.problem, error.remedy) from None
