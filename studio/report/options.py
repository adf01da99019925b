"""The options of a report, declared once for window and command line. Loads neither numpy nor Qt."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class ReportOptions(BaseModel):
    """What a report holds: names, defaults, limits and texts for every caller."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    fit_missing: bool = Field(
        default=True,
        title="Fit what is missing",
        description="Fit scans that have no fit or a stale one first; else they are named with what they lack.",
    )
    contact_sheet: bool = Field(
        default=True,
        title="Contact sheet",
        description="Write a PNG with all faces and verdicts beside the report (NAME_sheet.png).",
    )
    heat_mm: float = Field(
        default=0.2,
        ge=0.01,
        le=100.0,
        allow_inf_nan=False,
        title="Colours up to (mm)",
        description="Distance at the upper end of the colour bar, in mm, the same for all scans.",
    )
