"""The JSON header of a project file: every field declared once, and checked before it is believed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator

from engine.files.limits import LimitsModel
from engine.files.scheme import SchemeEntry
from engine.landmarks import Landmark, LandmarkSet, LandmarkState
from engine.scan.limits import Limits
from engine.scheme_checks import SCHEME_NAME
from studio.project import schemes as rules
from studio.project.basis_header import BasisHeader, ContentsHeader
from studio.project.document import Project, ScanItem, SourceInfo
from studio.project.path_text import escaped, plain
from studio.scan.options import FitOptions

if TYPE_CHECKING:
    from engine.scan.mesh_view import MeshView

Id = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
ArrayKey = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
Text = Annotated[
    str, Field(max_length=20_000), BeforeValidator(lambda value: escaped(value) if isinstance(value, str) else value)
]
"""A path, or what names one: the model holds it as `path_text.escaped`."""
InputKey = Annotated[str, Field(pattern=r"^[a-z0-9-]{1,160}$")]
Count = Annotated[int, Field(ge=0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
SchemeName = Annotated[str, Field(pattern=SCHEME_NAME)]
Angle = Annotated[float, Field(ge=-10.0, le=10.0)]
Place = Annotated[float, Field(ge=-1e7, le=1e7)]


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


class ViewHeader(_Model):
    """``engine.scan.mesh_view.MeshView``."""

    rotation: tuple[Angle, Angle, Angle]
    look_at_mm: tuple[Place, Place, Place]
    distance_mm: float = Field(ge=10, le=100_000)
    field_of_view_deg: float = Field(ge=1, le=120)
    width: int = Field(ge=16, le=4000)
    height: int = Field(ge=16, le=4000)

    def view(self) -> MeshView:
        """Return the view of the header."""
        from engine.scan.mesh_view import MeshView

        return MeshView(**self.model_dump())


class SourceHeader(_Model):
    """``document.SourceInfo``."""

    depth_file: Text = ""
    unit: Annotated[str, Field(max_length=16)] = "mm"
    assumed: Text = ""
    width: Count = 0
    height: Count = 0
    missing_fraction: Share = 0.0
    spikes: Count = 0
    view: ViewHeader | None = None
    view_asked: bool = False

    @classmethod
    def of(cls, source: SourceInfo) -> SourceHeader:
        """Return the header of a source."""
        view = None if source.view is None else ViewHeader(**vars(source.view))
        return cls(**{**vars(source), "view": view})

    def info(self) -> SourceInfo:
        """Return the source of the header."""
        view = None if self.view is None else self.view.view()
        texts = {name: plain(value) for name, value in self.model_dump().items() if isinstance(value, str)}
        found: dict[str, Any] = {**self.model_dump(), **texts, "view": view}
        return SourceInfo(**found)


class ItemHeader(_Model):
    """``document.ScanItem``: all of a scan that edits can change. A field added here is also in the journal."""

    id: Id
    name: str
    word: Annotated[str, Field(max_length=120)] = ""
    held: Annotated[str, Field(max_length=120)] = ""
    source: SourceHeader
    image_key: ArrayKey
    scheme: SchemeName
    landmarks: dict[str, PointHeader]
    options: FitOptions

    @classmethod
    def of(cls, item: ScanItem, **more: Any) -> Self:
        """Return the header of a scan; ``more`` are fields of a subclass."""
        return cls(
            id=item.id,
            name=item.name,
            word=item.word,
            held=item.held,
            source=SourceHeader.of(item.source),
            image_key=item.image_key,
            scheme=item.scheme,
            landmarks={name: PointHeader.of(point) for name, point in item.landmarks.points.items()},
            options=item.options,
            **more,
        )

    def item(self, image_key: str | None = None) -> ScanItem:
        """Return the scan of the header; ``image_key`` is what its range image really is, where that may differ."""
        return ScanItem(
            id=self.id,
            name=self.name,
            image_key=image_key or self.image_key,
            word=self.word,
            held=self.held,
            source=self.source.info(),
            scheme=self.scheme,
            landmarks=self.landmark_set(),
            options=self.options,
        )

    def landmark_set(self) -> LandmarkSet:
        """Return the fiducials."""
        return LandmarkSet({name: point.landmark() for name, point in self.landmarks.items()})


class ScanHeader(ItemHeader):
    """A scan as the project file holds it: with its range image and the key of its result."""

    image: ImageHeader
    fit: InputKey | None = None


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


class SharedHeader(_Model):
    """What belongs to the project as a whole and edits can change. A field added here is also in the journal."""

    limits: LimitsModel | None = None
    schemes: list[SchemeEntry] = Field(default_factory=list, max_length=rules.MOST)
    basis: BasisHeader | None = None

    @field_validator("schemes")
    @classmethod
    def _check_schemes(cls, entries: list[SchemeEntry]) -> list[SchemeEntry]:
        rules.checked(entry.scheme() for entry in entries)
        return entries

    @classmethod
    def of(cls, project: Project, folder: Path | None = None, **more: Any) -> Self:
        """Return the header of what the scans of a project share; ``more`` are fields of a subclass.

        ``folder`` is where the project is about to be written: linked files are named from there.
        """
        limits = None if project.limits == Limits() else LimitsModel.of(project.limits)
        schemes = [SchemeEntry.of(scheme) for scheme in project.schemes.values()]
        return cls(limits=limits, schemes=schemes, basis=BasisHeader.of(project.basis, folder), **more)

    def give(self, project: Project, folder: Path | None = None) -> None:
        """Set what there is of it in a project that has no scans yet; ``folder`` is where the project lies."""
        if self.limits is not None:
            project.set_limits(self.limits.limits())
        if self.schemes:
            project.set_schemes({entry.name: entry.scheme() for entry in self.schemes})
        if self.basis is not None:
            self.basis.give(project.basis, folder)


class ProjectHeader(SharedHeader):
    """The whole project but for its arrays."""

    written_by: Annotated[str, Field(max_length=80)] = ""
    scans: list[ScanHeader] = Field(max_length=10_000)
    fits: dict[InputKey, FitHeader]
    contents: ContentsHeader | None = None
