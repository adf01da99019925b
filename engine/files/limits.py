"""Limits of a fit as TOML: one table for the whole face, one for every region. What a file leaves out is as shipped."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from engine.files.atomic import atomic_write
from engine.files.complaint import bad_field
from engine.files.toml_text import load_toml
from engine.scan.limits import LARGEST, WHOLE, Bounds, Limits, RegionLimits

LARGEST_FILE = 1 << 20

Length = Annotated[float, Field(ge=0, le=LARGEST)]
Share = Annotated[float, Field(ge=0, le=1)]
RegionName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_ ]{0,31}$")]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class BoundsModel(_Model):
    """``engine.scan.limits.Bounds``."""

    warn: Length
    fail: Length

    @model_validator(mode="after")
    def _ordered(self) -> BoundsModel:
        if self.fail < self.warn:
            raise ValueError(f"fail {self.fail:g} is below warn {self.warn:g}")
        return self


class RegionModel(_Model):
    """``engine.scan.limits.RegionLimits``; a figure that is left out keeps the bounds it has."""

    median_mm: BoundsModel | None = None
    p95_mm: BoundsModel | None = None
    max_mm: BoundsModel | None = None
    filled_fraction: BoundsModel | None = None


class FaceModel(_Model):
    """The figures of the whole face; what is left out keeps its limit."""

    median_mm: Length | None = None
    p99_mm: Length | None = None
    max_mm: Length | None = None
    filled_fraction: Share | None = None
    folded_faces: Annotated[int, Field(ge=0, le=1000)] | None = None
    noise_mm: Length | None = None
    tolerance: Annotated[float, Field(ge=1, le=LARGEST)] | None = None


class LimitsModel(_Model):
    """``engine.scan.limits.Limits`` as files have it: limits files and the header of a project."""

    face: FaceModel = FaceModel()
    regions: dict[RegionName, RegionModel] = Field(default={}, max_length=64)

    @classmethod
    def of(cls, limits: Limits) -> LimitsModel:
        """Return limits as a file has them, every figure written out."""
        face = FaceModel(**{name: getattr(limits, name) for name in (*WHOLE, "tolerance")})
        return cls(face=face, regions={name: _region_model(region) for name, region in limits.regions.items()})

    def limits(self) -> Limits:
        """Return the limits; what was left out is as shipped."""
        result = replace(Limits(), **self.face.model_dump(exclude_none=True))
        for name, region in self.regions.items():
            given = {figure: Bounds(**bounds) for figure, bounds in region.model_dump(exclude_none=True).items()}
            result = result.with_region(name, replace(result.region(name), **given))
        return result


def read_limits(path: str | Path) -> Limits:
    """Read limits from a TOML file.

    Raises
    ------
    InputError
        Naming the file and the field that is wrong in it.
    """
    values = load_toml(path, "choose a limits file (.toml)", LARGEST_FILE)
    try:
        return LimitsModel.model_validate(values).limits()
    except ValidationError as error:
        raise bad_field(error, str(path), "see the file that the limits dialog exports") from None


def limits_toml(limits: Limits) -> str:
    """Return limits as the text of a TOML file; ``read_limits`` gives the same limits back."""
    model = LimitsModel.of(limits)
    lines = [
        "# Limits of a fit. Distances to the scan in mm; filled_fraction is a share, 0 to 1.",
        "# The whole face: up to the limit ok, up to tolerance times the limit a warning, beyond it a failure.",
        "[face]",
    ]
    lines += [f"{name} = {_number(value)}" for name, value in model.face.model_dump().items()]
    for name, region in model.regions.items():
        lines += ["", f"[regions.{_key(name)}]"]
        for figure, bounds in region.model_dump().items():
            lines.append(f"{figure} = {{ warn = {_number(bounds['warn'])}, fail = {_number(bounds['fail'])} }}")
    return "\n".join(lines) + "\n"


def write_limits(path: str | Path, limits: Limits) -> Path:
    """Write limits to a TOML file, whole or not at all; ``InputError`` where that is not possible."""
    with atomic_write(path) as handle:
        handle.write(limits_toml(limits).encode("utf-8"))
    return Path(path)


def _region_model(region: RegionLimits) -> RegionModel:
    given = {name: BoundsModel(warn=b.warn, fail=b.fail) for name, b in vars(region).items()}
    return RegionModel(**given)


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else f'"{name}"'


def _number(value: Any) -> str:
    return repr(float(value)) if isinstance(value, float) else str(value)
