"""Face templates (JSON): faces, mirror table, and a layout with fiducials per scheme."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from engine.errors import InputError
from engine.files.complaint import bad_field
from engine.files.source import read_bytes
from engine.scan.template import FaceTemplate, TemplateLayout

LARGEST_FILE = 64 << 20

Index = Annotated[int, Field(ge=0, le=10_000_000)]


class _Layout(BaseModel):
    model_config = ConfigDict(extra="forbid")
    vertices: list[tuple[FiniteFloat, FiniteFloat]]
    fiducials: dict[str, Index]


class _Template(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: str
    faces: list[tuple[Index, Index, Index]]
    mirror: list[Index]
    curves: dict[str, list[Index]] = {}
    regions: dict[Annotated[str, Field(pattern=r"^[a-z][a-z0-9_ ]{0,31}$")], list[Index]] = Field({}, max_length=64)
    layouts: dict[str, _Layout]


def read_template(path: str | Path) -> FaceTemplate:
    """Read a face template.

    Raises
    ------
    InputError
        Names the file and what is wrong with it: no regular file, larger than ``LARGEST_FILE``, a bad field.
    """
    try:
        document = _Template.model_validate_json(read_bytes(path, LARGEST_FILE))
    except ValidationError as error:
        raise bad_field(error, str(path), "choose a face template") from error
    try:
        return _template(document)
    except InputError as error:
        raise InputError(f"{path}, {error.subject}", error.problem, error.remedy) from None


def _template(document: _Template) -> FaceTemplate:
    layouts = {
        name: TemplateLayout(np.array(layout.vertices).reshape(-1, 2), layout.fiducials)
        for name, layout in document.layouts.items()
    }
    return FaceTemplate(
        document.name,
        np.array(document.faces).reshape(-1, 3),
        np.array(document.mirror),
        layouts,
        {name: np.array(curve, dtype=np.int64) for name, curve in document.curves.items()},
        {name: np.array(faces, dtype=np.int64) for name, faces in document.regions.items()},
    )
