"""Data the program ships, and the one loader that finds it in a checkout and in an installed wheel."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path


def _path(*parts: str) -> Path:
    return Path(str(files("resources").joinpath(*parts)))


def template_path() -> Path:
    """Return the face template (JSON)."""
    return _path("template", "face.json")


def scheme_path(name: str) -> Path:
    """Return the fiducial scheme ``closed`` or ``open`` (TOML)."""
    return _path("schemes", f"{name}.toml")


def mapping_paths() -> tuple[Path, ...]:
    """Return the landmark mappings (TOML), in the order they are offered."""
    return tuple(sorted(_path("mappings").glob("*.toml")))


def sample_path(*parts: str) -> Path:
    """Return a file of the bundled sample."""
    return _path("sample", *parts)


def icon_path(name: str) -> Path:
    """Return an icon file by its file name."""
    return _path("icons", name)
