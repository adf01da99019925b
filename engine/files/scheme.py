"""Fiducial schemes (TOML): which points there are, in clicking order."""

from __future__ import annotations

import tomllib
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from engine.errors import InputError
from engine.landmarks import LandmarkDefinition, LandmarkScheme, Side


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
        document = _Scheme.model_validate(tomllib.loads(Path(path).read_text(encoding="utf-8")))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(str(path), f"cannot be read as TOML ({error})", "choose a fiducial scheme") from error
    except ValidationError as error:
        raise InputError(str(path), first_problem(error), "compare with a bundled scheme") from error
    return LandmarkScheme(
        document.name, document.title, tuple(LandmarkDefinition(**dict(entry)) for entry in document.landmark)
    )


def first_problem(error: ValidationError) -> str:
    """Return the first finding of a validation as one clause that names its field."""
    finding = error.errors()[0]
    field = ".".join(str(part) for part in finding["loc"]) or "document"
    return f"field {field}: {finding['msg'][0].lower()}{finding['msg'][1:]}"
