"""The JSON header of a project file: every field declared once, and checked before it is believed."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from engine.landmarks import Landmark, LandmarkSet, LandmarkState
from studio.scan.options import FitOptions

Id = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
ArrayKey = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
Text = Annotated[str, Field(max_length=4096)]
InputKey = Annotated[str, Field(pattern=r"^[a-z0-9-]{1,160}$")]
Count = Annotated[int, Field(ge=0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
SchemeName = Annotated[str, Field(pattern="^(closed|open)$")]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class CameraHeader(_Model):
    """``engine.scan.range_image.Camera``, pixels."""

    fx: float = Field(gt=0)
    fy: float = Field(gt=0)
    cx: float
    cy: float


class ImageHeader(_Model):
    """A range image: ``points`` (H, W, 3) mm, or ``depth`` (H, W) mm where the camera gives exactly those points."""

    points: ArrayKey | None = None
    depth: ArrayKey | None = None
    colour: ArrayKey | None = None
    camera: CameraHeader | None = None


class PointHeader(_Model):
    """One fiducial, pixels; no place while it is unset."""

    x: float | None = None
    y: float | None = None
    state: LandmarkState
    locked: bool = False

    @classmethod
    def of(cls, point: Landmark) -> PointHeader:
        """Return the header of a landmark."""
        placed = math.isfinite(point.x) and math.isfinite(point.y)
        x, y = (point.x, point.y) if placed else (None, None)
        return cls(x=x, y=y, state=point.state, locked=point.locked)

    def landmark(self) -> Landmark:
        """Return the landmark of the header."""
        if self.x is None or self.y is None:
            return Landmark(state=self.state, locked=self.locked)
        return Landmark(self.x, self.y, self.state, self.locked)


class SourceHeader(_Model):
    """``document.SourceInfo``."""

    depth_file: Text = ""
    unit: Annotated[str, Field(max_length=16)] = "mm"
    assumed: Text = ""
    width: Count = 0
    height: Count = 0
    missing_fraction: Share = 0.0
    spikes: Count = 0


class ScanHeader(_Model):
    """``document.ScanItem``, with its range image and the keys of its results."""

    id: Id
    name: str
    word: Annotated[str, Field(max_length=120)] = ""
    held: Annotated[str, Field(max_length=120)] = ""
    source: SourceHeader
    image_key: ArrayKey
    image: ImageHeader
    scheme: SchemeName
    landmarks: dict[str, PointHeader]
    options: FitOptions
    fit: InputKey | None = None

    def landmark_set(self) -> LandmarkSet:
        """Return the fiducials."""
        return LandmarkSet({name: point.landmark() for name, point in self.landmarks.items()})


class RepairHeader(_Model):
    """``engine.scan.repair.RepairReport``."""

    missing_fraction: Share
    spikes: Count
    filled_pixels: Count
    unfilled_fraction: Share
    noise_mm: float = Field(default=0.0, ge=0)
    grid: Literal["camera", "grid", "irregular"] = "camera"


class FitHeader(_Model):
    """``engine.scan.fit.FaceFit``: arrays by key, the rest as it is."""

    vertices: ArrayKey
    faces: ArrayKey
    uv: ArrayKey
    normals: ArrayKey
    pixels: ArrayKey
    filled: ArrayKey
    deviation_mm: ArrayKey
    folded_faces: ArrayKey
    fiducial_residual_px: float = Field(ge=0)
    folded_fiducials: list[str] = Field(max_length=200)
    repair: RepairHeader
    levels: int = Field(ge=0, le=6)
    scheme: SchemeName


class ProjectHeader(_Model):
    """The whole project but for its arrays."""

    written_by: Annotated[str, Field(max_length=80)] = ""
    scans: list[ScanHeader] = Field(max_length=10_000)
    fits: dict[InputKey, FitHeader]
