"""Face templates (JSON): faces, mirror table, and a layout with fiducials per scheme."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from engine.errors import InputError
from engine.files.scheme import first_problem
from engine.scan.template import FaceTemplate, TemplateLayout

LARGEST_FILE = 64 << 20

Index = Annotated[int, Field(ge=0)]


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
    layouts: dict[str, _Layout]


def read_template(path: Path) -> FaceTemplate:
    """Read a face template.

    Raises
    ------
    InputError
        Names the file and the field that is wrong.
    """
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InputError(str(path), "is larger than 64 MB", "choose a face template")
        document = _Template.model_validate_json(path.read_bytes())
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "choose a face template") from error
    except ValidationError as error:
        raise InputError(str(path), first_problem(error), "choose a face template") from error
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
    )
