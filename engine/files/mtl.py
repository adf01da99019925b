"""The materials of an OBJ file (MTL): a colour, a picture, or both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

from engine.errors import InputError
from engine.files.mesh_parts import MAX_MATERIALS
from engine.files.source import beside, read_bytes
from engine.files.textures import Material, PictureBudget
from engine.scan.range_image import ColourImage

_MAX_MTL_BYTES = 4 << 20
_VALUES = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-clamp": 1, "-bm": 1,
    "-imfchan": 1, "-type": 1, "-cc": 1, "-colorspace": 1,
}  # fmt: skip


@dataclass
class _Settings:
    colour: tuple[float, float, float] = (255.0, 255.0, 255.0)
    picture: str = ""


def read_materials(
    obj: Path, libraries: Sequence[str], names: Sequence[str]
) -> tuple[list[Material], tuple[Path, ...], tuple[str, ...]]:
    """Return the materials called ``names``, the files that were read, and what is missing, in words.

    A library or picture that is not there, cannot be read or lies elsewhere is no error: the mesh goes without it. A
    picture named by a path from another computer is looked for under its plain name beside the OBJ.
    """
    known: dict[str, _Settings] = {}
    files: list[Path] = []
    notes: list[str] = []
    left = _MAX_MTL_BYTES
    for library in dict.fromkeys(libraries):
        found = _find(obj, library, "mtllib", notes)
        if found is not None:
            files.append(found)
            known |= _parsed(found, left, notes)
            left = max(left - found.stat().st_size, 0)
    if len(names) > MAX_MATERIALS and any(known.get(name, _Settings()).picture for name in names):
        raise InputError(str(obj), f"uses {len(names)} materials", f"bake them into fewer than {MAX_MATERIALS}")
    if len(names) > MAX_MATERIALS:
        notes.append(f"uses {len(names)} materials: their colours were left out")
        return [Material()] * len(names), tuple(files), tuple(notes)
    pictures: dict[str, ColourImage | None] = {}
    budget = PictureBudget()
    materials = []
    for name in names:
        settings = known.get(name, _Settings())
        if settings.picture and settings.picture not in pictures:
            pictures[settings.picture] = _picture(obj, settings.picture, budget, files, notes)
        texture = pictures.get(settings.picture)
        # Kd beside a picture is a default of the exporter (a grey of 0.8 or so), and no program multiplies them.
        materials.append(Material(texture) if texture is not None else Material(None, settings.colour))
    return materials, tuple(files), tuple(notes)


def _find(obj: Path, name: str, field: str, notes: list[str]) -> Path | None:
    plain = name.strip().strip('"').replace("\\", "/")
    try:
        return beside(obj, plain, field)
    except InputError as error:
        short = PureWindowsPath(plain).name
        if short and short != plain:
            try:
                return beside(obj, short, field)
            except InputError:
                pass
        notes.append(f"{field} {name[:80]!r} {error.problem}: left out")
        return None


def _parsed(path: Path, largest: int, notes: list[str]) -> dict[str, _Settings]:
    known: dict[str, _Settings] = {}
    current = _Settings()
    try:
        text = read_bytes(path, largest).decode("utf-8-sig", "replace")
    except InputError as error:
        notes.append(f"mtllib {path.name!r} {error.problem}: left out")
        return known
    for line in text.splitlines():
        key, _, rest = line.strip().replace("\t", " ").partition(" ")
        rest = rest.strip()
        if key == "newmtl":
            current = known.setdefault(rest, _Settings())
        elif key == "Kd":
            current.colour = _colour(rest) or current.colour
        elif key.lower() == "map_kd" and rest:
            current.picture = _without_options(rest)
    return known


def _colour(text: str) -> tuple[float, float, float] | None:
    try:
        values = [min(max(float(word), 0.0), 1.0) for word in text.split(None, 3)[:3]]
    except ValueError:
        return None
    if len(values) != 3 or any(value != value for value in values):
        return None
    return values[0] * 255, values[1] * 255, values[2] * 255


def _without_options(text: str) -> str:
    words, place = text.split(" "), 0
    while place < len(words) and words[place] in _VALUES:
        option, place = words[place], place + 1
        count = _VALUES[option]
        if option in ("-o", "-s", "-t"):
            count = next((k for k, word in enumerate(words[place : place + 3]) if not _is_number(word)), 3)
        place += count
    return " ".join(words[place:]).strip()


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _picture(obj: Path, name: str, budget: PictureBudget, files: list[Path], notes: list[str]) -> ColourImage | None:
    found = _find(obj, name, "map_Kd", notes)
    if found is None:
        return None
    try:
        picture = budget.read(found)
    except InputError as error:
        notes.append(f"map_Kd {name[:80]!r} {error.problem}: left out")
        return None
    files.append(found)
    return picture
