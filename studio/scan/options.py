"""The options of a fit, declared once for command line, dock and project file. Loads neither numpy nor Qt."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.files.complaint import bad_field


class FitOptions(BaseModel):
    """How a scan is repaired and fitted: names, defaults, limits and texts for every caller."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    levels: int = Field(
        default=2, ge=0, le=4, title="Levels", description="How often every triangle is split into four."
    )
    remove_spikes: bool = Field(
        default=True, title="Remove spikes", description="Take out points that stand far off their neighbours."
    )
    spike_mm: float = Field(
        default=2.5,
        ge=0.3,
        le=100.0,
        allow_inf_nan=False,
        title="Spike height (mm)",
        description="How far along the ray a point must stand off its neighbours to be a spike, in mm.",
    )
    fill_gaps: bool = Field(
        default=True, title="Fill gaps", description="Fill small gaps in the scan from what is around them."
    )
    largest_gap_px: int = Field(
        default=12, ge=1, le=200, title="Largest gap (px)", description="The widest gap that is filled, in pixels."
    )
    smooth: bool = Field(
        default=True, title="Smooth", description="Calm the scanner's noise before the face is sampled."
    )
    smooth_px: float = Field(
        default=1.2, ge=0.3, le=3.0, title="Smoothing radius (px)", description="Reach of the smoothing, in pixels."
    )
    matte_threshold: float = Field(
        default=0.2, ge=0.01, le=0.9, title="Matte threshold", description="When a pixel of a gap counts as reached."
    )
    matte_kernel_px: int = Field(
        default=3, ge=3, le=15, title="Matte kernel (px)", description="Width of the blur, odd pixels."
    )

    @classmethod
    def checked(cls, **values: object) -> FitOptions:
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
