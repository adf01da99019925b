"""The options of a basis and a performance, declared once for command line, dock and project. No numpy, no Qt."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from engine.files.complaint import bad_field
from engine.name_text import LONGEST_NAME

BoundsKey = Literal["0..1", "-1..2", "free"]
BOUNDS: dict[str, tuple[float, float] | None] = {"0..1": (0.0, 1.0), "-1..2": (-1.0, 2.0), "free": None}
"""The bounds of weights by their key."""

Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
Label = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]
Coordinate = Annotated[float, Field(ge=-1e7, le=1e7)]
Target = Annotated[int, Field(ge=0)] | tuple[Coordinate, Coordinate, Coordinate]
"""Where a marker sits on the rig: a vertex, or a place in mm."""


class _Options(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @classmethod
    def checked(cls, **values: object) -> Self:
        """Return options of ``values``.

        Raises
        ------
        InputError
            Naming the first option that is out of its limits.
        """
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            raise bad_field(error, "options") from None


class BasisOptions(_Options):
    """How the axes are chosen, and how weights are solved and compared."""

    coverage: float = Field(
        default=0.995, gt=0.0, le=1.0, title="Coverage", description="Share of the motion's variance the axes hold."
    )
    count: int | None = Field(
        default=None, ge=1, le=10_000, title="Axes", description="Number of axes, in place of the coverage."
    )
    train: tuple[int, int] | None = Field(
        default=None, title="Training range", description="First frame and the one after the last, from 0; all without."
    )
    affine: bool = Field(default=False, title="Affine", description="Keep the mean of the motion apart (ours).")
    bounds: BoundsKey = Field(default="-1..2", title="Bounds", description="Limits of the weights that are shown.")
    ridge: float = Field(default=0.0, ge=0.0, le=1e6, title="Ridge", description="Weight of small weights (ours).")

    memory_mb: float = Field(
        default=512.0, gt=0.0, le=1e6, title="Memory", description="Most memory that finding the axes takes, MB."
    )

    @field_validator("train")
    @classmethod
    def _check_train(cls, train: tuple[int, int] | None) -> tuple[int, int] | None:
        if train is not None and not 0 <= train[0] < train[1]:
            raise ValueError("the first frame must lie before the last")
        return train


class MotionOptions(_Options):
    """How a performance is read and laid onto a rig; None: as the file says, or as it is found out."""

    unit: Annotated[str, Field(max_length=20)] | None = Field(
        default=None, title="Unit", description="Unit of the file: mm, cm, m, or the millimetres of one unit."
    )
    up: Axis | None = Field(default=None, title="Up", description="The file's axis that points up.")
    forward: Axis | None = Field(
        default=None, title="Forward", description="The file's axis that points out of the face."
    )
    fps: float | None = Field(default=None, gt=0, le=1e5, title="Frame rate", description="Frames a second.")
    head: tuple[Label, ...] | None = Field(
        default=None,
        max_length=1_000,
        title="Head markers",
        description="Markers that move with the skull alone: found out without, none where empty.",
    )
    pairs: dict[Label, Target] | None = Field(
        default=None, max_length=10_000, title="Pairs", description="Where markers sit on the rig; the nearest without."
    )
    rest_frame: int | None = Field(
        default=None, ge=0, title="Rest frame", description="The frame with the neutral face, from 0."
    )
    scale: bool = Field(
        default=False, title="Fit the size", description="Bring the performer's markers to the size of the rig's face."
    )
