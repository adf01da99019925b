"""Fiducial schemes (TOML): which points there are, in clicking order, and where they lie on the template."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.complaint import bad_field
from engine.files.toml_text import load_toml
from engine.landmarks import LandmarkDefinition, LandmarkScheme, Side
from engine.scheme_checks import LAYOUTS, MOST

LARGEST_FILE = 1 << 20


class LandmarkEntry(BaseModel):
    """``engine.landmarks.LandmarkDefinition`` as it stands in a file."""

    model_config = ConfigDict(extra="forbid")
    name: str
    group: str
    side: Side
    mirror: str
    hint: str = ""
    vertex: Annotated[int, Field(ge=0, le=10_000_000, strict=True)] | None = None


class SchemeEntry(BaseModel):
    """``engine.landmarks.LandmarkScheme`` as it stands in a file; its layout may be left out where the name tells it.

    ``scheme`` makes the value of it, ``of`` an entry of a value.
    """

    model_config = ConfigDict(extra="forbid")
    name: str
    title: str = ""
    layout: Literal["closed", "open"] | None = None
    landmark: Annotated[list[LandmarkEntry], Field(max_length=MOST)]

    def scheme(self) -> LandmarkScheme:
        """Return the scheme; ``InputError`` names the fiducial and the field that is wrong."""
        landmarks = tuple(LandmarkDefinition(**dict(entry)) for entry in self.landmark)
        layout = self.layout or (self.name if self.name in LAYOUTS else "closed")
        return LandmarkScheme(self.name, self.title, landmarks, layout)

    @classmethod
    def of(cls, scheme: LandmarkScheme) -> SchemeEntry:
        """Return the entry of a scheme."""
        entries = [LandmarkEntry(**vars(landmark)) for landmark in scheme]
        layout: Literal["closed", "open"] = "open" if scheme.layout == "open" else "closed"
        return cls(name=scheme.name, title=scheme.title, layout=layout, landmark=entries)


def read_scheme(path: str | Path) -> LandmarkScheme:
    """Read a scheme.

    Raises
    ------
    InputError
        Names the file and the field that is wrong.
    """
    try:
        document = SchemeEntry.model_validate(load_toml(path, "choose a fiducial scheme", LARGEST_FILE))
    except ValidationError as error:
        raise bad_field(error, str(path), "compare with a bundled scheme") from error
    try:
        return document.scheme()
    except InputError as error:
        raise InputError(f"{path}, {error.subject}", error.problem, error.remedy) from None


def write_scheme(path: str | Path, scheme: LandmarkScheme) -> None:
    """Write a scheme; ``read_scheme`` returns the same value.

    Raises
    ------
    InputError
        When the file cannot be written; what stood there is then as before.
    """
    lines = [f"name = {_quoted(scheme.name)}", f"title = {_quoted(scheme.title)}", f"layout = {_quoted(scheme.layout)}"]
    for landmark in scheme:
        lines += ["", "[[landmark]]"]
        lines += [
            f"{key} = {_quoted(str(getattr(landmark, key)))}" for key in ("name", "group", "side", "mirror", "hint")
        ]
        if landmark.vertex is not None:
            lines.append(f"vertex = {landmark.vertex}")
    with atomic_write(path) as handle:
        handle.write(("\n".join(lines) + "\n").encode("utf-8"))


def _quoted(text: str) -> str:
    """Return a TOML basic string; its escapes are those of JSON for everything that a scheme may hold."""
    return json.dumps(text, ensure_ascii=False)
