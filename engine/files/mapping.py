"""Landmark mappings as TOML or JSON: ``[fiducials]`` with a point's index, its label, or a list of either."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.json_text import checked, load_json
from engine.files.landmark_file import MAX_POINTS, checked_name
from engine.files.toml_text import load_toml
from engine.landmark_mapping import LandmarkMapping, Source, Sources

LARGEST_FILE = 1 << 20

_Count = Annotated[int, Field(ge=1, le=MAX_POINTS)]
_Source = Annotated[int, Field(ge=0, lt=MAX_POINTS)] | Annotated[str, Field(min_length=1, max_length=400)]


class _Mapping(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")
    name: Annotated[str, Field(min_length=1, max_length=100)]
    title: Annotated[str, Field(max_length=200)] = ""
    note: Annotated[str, Field(max_length=2000)] = ""
    count: _Count | None = None
    labels: Annotated[dict[str, _Count], Field(max_length=MAX_POINTS)] = {}
    fiducials: dict[str, Any]


class _Sources(BaseModel):
    model_config = ConfigDict(strict=True)
    sources: Annotated[list[_Source], Field(min_length=1, max_length=100)]


def read_mapping(path: str | Path) -> LandmarkMapping:
    """Read a mapping from ``.toml``, or ``.json`` of the same fields.

    Raises
    ------
    InputError
        Names the file and the field that is wrong.
    """
    path = Path(path)
    fields = checked(_Mapping, _document(path), path)
    entries: dict[str, Sources] = {}
    for name, value in fields.fiducials.items():
        target = checked_name(name, f"{path}, fiducials")
        several = value if isinstance(value, list) else [value]
        try:
            entries[target] = tuple(_Sources.model_validate({"sources": several}).sources)
        except ValueError:
            problem = f"{str(value)[:40]!r} is no point"
            raise InputError(
                f"{path}, fiducials.{target}", problem, "give an index from 0, a label, or a list"
            ) from None
    layout = {checked_name(label, f"{path}, labels"): size for label, size in fields.labels.items()}
    count = fields.count if fields.count is not None or not layout else sum(layout.values())
    if count is not None and count > MAX_POINTS:
        raise InputError(f"{path}, labels", f"have more than {MAX_POINTS} points", "correct them")
    try:
        return LandmarkMapping(fields.name, entries, fields.title or fields.name, count, layout, fields.note)
    except InputError as error:
        raise InputError(f"{path}, {error.subject}", error.problem, error.remedy) from None


def _document(path: Path) -> dict[str, Any]:
    if path.suffix.lower() == ".json":
        return load_json(path)
    if path.suffix.lower() != ".toml":
        raise InputError(str(path), "is not a mapping", "give a .toml or .json file")
    return load_toml(path, "correct it", LARGEST_FILE)


def write_mapping(path: str | Path, mapping: LandmarkMapping) -> None:
    """Write a mapping atomically, so that reading gives an equal one; the ending chooses TOML or JSON.

    Raises
    ------
    InputError
        On another ending, and where the file cannot be written.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in (".toml", ".json"):
        raise InputError(str(path), "has no ending that tells the format", "end it in .toml or .json")
    fields: dict[str, Any] = {"name": mapping.name, "title": mapping.title or mapping.name, "note": mapping.note}
    if mapping.count is not None:
        fields["count"] = mapping.count
    if mapping.layout:
        fields["labels"] = dict(mapping.layout)
    fields["fiducials"] = {target: _plain(sources) for target, sources in mapping.entries.items()}
    text = json.dumps(fields, indent=1, ensure_ascii=False) if kind == ".json" else _toml(fields)
    with atomic_write(path) as handle:
        handle.write((text.rstrip("\n") + "\n").encode())


def _plain(sources: Sources) -> Source | list[Source]:
    return sources[0] if len(sources) == 1 else list(sources)


def _toml(fields: dict[str, Any]) -> str:
    lines = [f"{key} = {_value(value)}" for key, value in fields.items() if not isinstance(value, dict)]
    for key, value in fields.items():
        if isinstance(value, dict):
            lines += ["", f"[{key}]", *(f"{_value(name)} = {_value(entry)}" for name, entry in value.items())]
    return "\n".join(lines)


def _value(value: Any) -> str:
    """Return a text, number or list as TOML has it; its strings escape as JSON's do, once DEL is escaped too."""
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if not isinstance(value, str):
        return str(value)
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
