"""What the commands of the basis stage have in common, as pydantic models: help and limits come from one place."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from pydantic import BaseModel, ConfigDict, Field

from engine.errors import InputError
from studio.basis.options import Axis, BasisOptions, MotionOptions


class ReadingArguments(BaseModel):
    """How a performance is read and laid onto a rig."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    unit: str | None = Field(
        default=None, max_length=20, description="What its numbers mean: mm, cm, m, or millimetres as '85.3 mm'."
    )
    up: Axis | None = Field(default=None, description="Its axis that points up.")
    forward: Axis | None = Field(default=None, description="Its axis that points out of the face.")
    fps: float | None = Field(default=None, gt=0, le=1e5, description="Frames a second, where it does not say.")
    head: Annotated[tuple[str, ...], Parameter(negative="")] = Field(
        default=(), description="A marker that moves with the head alone; may be repeated; else found out."
    )
    keep_head: Annotated[bool, Parameter(negative="")] = Field(
        default=False, description="Leave the head's motion in: it was removed before."
    )
    scale: Annotated[bool, Parameter(negative="")] = Field(
        default=False, description="Bring the performer's markers to the size of the rig's face."
    )
    rest_frame: int | None = Field(default=None, ge=1, description="Its frame with the neutral face, counted from 1.")
    pairs: Path | None = Field(
        default=None, description="Which marker lies where on the rig (.json); else the nearest place."
    )

    def options(self) -> MotionOptions:
        """Return the options of the job; reads the pairs.

        Raises
        ------
        InputError
            When the unit is not known, the pairs cannot be read, or head markers are named and kept at once.
        """
        known = None
        if self.unit is not None:
            from engine.files.mesh_unit import mm_per_unit

            try:
                mm_per_unit(self.unit)
            except InputError as error:
                raise InputError(f"--unit {self.unit!r}", "is not known", error.remedy) from error
        if self.pairs is not None:
            from engine.files.marker_pairs import read_marker_pairs

            known = {pair.label: pair.target for pair in read_marker_pairs(self.pairs)}
        if self.keep_head and self.head:
            raise InputError("--keep-head", "is given together with --head", "give one of them")
        head = () if self.keep_head else self.head or None
        rest = None if self.rest_frame is None else self.rest_frame - 1
        return MotionOptions.checked(
            unit=self.unit,
            up=self.up,
            forward=self.forward,
            fps=self.fps,
            head=head,
            rest_frame=rest,
            pairs=known,
            scale=self.scale,
        )


class AxesArguments(BaseModel):
    """How many principal axes are found, and in which frames."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    coverage: float = Field(default=0.995, gt=0, le=1, description="Share of the variance that the axes explain.")
    count: int | None = Field(default=None, ge=1, le=10_000, description="Number of axes, in place of the coverage.")
    train: str | None = Field(default=None, description="Frames to learn from, first:last, counted from 1.")
    memory_mb: float = Field(default=512.0, gt=0, le=1e6, description="Most memory that finding the axes takes, MB.")

    def options(self, *, affine: bool = False, ridge: float = 0.0) -> BasisOptions:
        """Return the options of the job.

        Raises
        ------
        InputError
            When the range of frames is none.
        """
        from studio.basis.motions import frame_range

        span = None if self.train is None else frame_range(self.train)
        return BasisOptions.checked(
            coverage=self.coverage,
            count=self.count,
            train=span,
            affine=affine,
            ridge=ridge,
            memory_mb=self.memory_mb,
        )
