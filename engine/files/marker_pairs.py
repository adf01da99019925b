"""Which marker sits where on a face: pairs files (JSON)."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from engine.basis.binding import MarkerPair, Pairs
from engine.errors import InputError, some
from engine.files.json_text import checked, load_json
from engine.name_text import LONGEST_NAME

_Coordinate = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
_Point = tuple[_Coordinate, _Coordinate, _Coordinate]


class _Pair(BaseModel):
    model_config = ConfigDict(strict=True, extra="ignore")

    source: str = Field(min_length=1, max_length=LONGEST_NAME)
    target: Annotated[int, Field(ge=0)] | tuple[_Coordinate, _Coordinate, _Coordinate] = Field(
        union_mode="left_to_right"
    )


class _PairsFile(BaseModel):
    model_config = ConfigDict(extra="ignore")

    pairs: list[_Pair] = Field(min_length=1, max_length=10_000)


def read_marker_pairs(path: str | Path) -> Pairs:
    """Read ``{"pairs": [{"source": "<marker label>", "target": [x, y, z] | vertex}]}``; mm on the neutral face.

    Raises
    ------
    InputError
        Naming the bad field; when it is no JSON, or pairs a label twice.
    """
    raw = load_json(path)
    for number, entry in enumerate(raw.get("pairs", []) if isinstance(raw.get("pairs"), list) else [], start=1):
        if isinstance(entry, dict) and isinstance(entry.get("target"), list):
            target = entry["target"] = tuple(entry["target"])
            if any(isinstance(value, float) and not isfinite(value) for value in target):
                remedy = "give a vertex number or three finite numbers"
                raise InputError(f"{path}, pair {number}", "its target is not finite", remedy)
    pairs = [MarkerPair(pair.source, pair.target) for pair in checked(_PairsFile, raw, path).pairs]
    labels = [pair.label for pair in pairs]
    double = sorted({label for label in labels if labels.count(label) > 1})
    if double:
        raise InputError(str(path), f"pairs {some(double)} twice", "leave one of them out")
    return tuple(pairs)
