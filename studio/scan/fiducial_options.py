"""The options of reading landmarks, declared once for command line and dialogs. Loads neither numpy nor Qt."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

AS_IT_IS = "none"
"""The mapping that keeps a file's own points and names."""

_Pixels = Annotated[int, Field(ge=1, le=1_000_000)]


class FiducialOptions(BaseModel):
    """How a file of landmarks is understood: names, defaults, limits and texts for every caller."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    mapping: str = Field(
        default="",
        title="Mapping",
        description="Which points are which fiducials: a shipped mapping, 'by name', or a .toml or .json file.",
    )
    group: str | None = Field(
        default=None, title="Group", description="Which group of an .ljson, or row of a table; the first if left out."
    )
    origin: float | None = Field(
        default=None,
        ge=0.0,
        le=1.0,
        title="Origin",
        description="What the file calls the centre of the top left pixel: 0, 0.5 or 1; if left out, 1 for .pts.",
    )
    image_size: tuple[_Pixels, _Pixels] | None = Field(
        default=None,
        title="Picture",
        description="Width and height of the picture the points were placed on, where the file does not say.",
    )
    scale: bool = Field(
        default=False, title="Scale", description="Scale points that were placed on the picture at another size."
    )


def as_convert_command(
    source: Path, out: str, scan: str, scheme: str, options: FiducialOptions, mapping: str, placing: Sequence[str] = ()
) -> str:
    """Return the command line that brings a file to a scan's fiducials, with what differs from the defaults.

    ``placing`` are the words for the scan's unit and the view of its mesh.
    """
    words = ["quasiface", "fiducials", "convert", str(source), "--scan", scan]
    if scheme != "closed":
        words += ["--scheme", scheme]
    if mapping:
        words += ["--mapping", mapping]
    if options.group is not None:
        words += ["--group", options.group]
    if options.origin is not None:
        words += ["--origin", f"{options.origin:g}"]
    if options.image_size is not None:
        words += ["--image-size", *map(str, options.image_size)]
    if options.scale:
        words.append("--scale")
    return shlex.join([*words, *placing, "--out", out])


def as_export_command(source: str, out: str, scheme: str, mapping: str, origin: float | None) -> str:
    """Return the command line that writes fiducials as another tool's points."""
    words = ["quasiface", "fiducials", "convert", source]
    if scheme != "closed":
        words += ["--scheme", scheme]
    words += ["--mapping", mapping or AS_IT_IS]
    if origin is not None:
        words += ["--out-origin", f"{origin:g}"]
    return shlex.join([*words, "--out", out])
