"""What shapes are called: sides, the 52 ARKit names, FACS action units, and which of them a rig has."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Literal, NamedTuple

from engine.shape_name_tables import ACTION_UNITS, ALIASES, ARKIT, ActionUnit

Side = Literal["L", "R", ""]

_WORD = re.compile("A+(?=Aa)|A?a+|A+|o+|0+")
"""Words in a name written by the kinds of its letters: upper and lower case, letters without case, digits."""
_SIDES: dict[str, Side] = {
    "l": "L", "left": "L", "lft": "L", "lf": "L", "r": "R", "right": "R", "rgt": "R", "rt": "R",
}  # fmt: skip
_BARE = (["jaw"], ["mouth"])
"""Words that are no shape without a side, which for these is a direction."""
_LONG = {"L": "left", "R": "right", "": ""}
_SWAPPED = {
    "l": "r", "left": "right", "lft": "rgt", "lf": "rt", "r": "l", "right": "left", "rgt": "lft", "rt": "lf",
}  # fmt: skip
_UNIT = re.compile(r"(?:^|[\W\d_])(?:au|actionunit|action_unit)[ _-]?0*(\d{1,2})(?!\d)", re.IGNORECASE)


class _Hit(NamedTuple):
    """A standard name, the shape that showed it where several may, which half of that, and how it was recognised."""

    key: str
    source: str = ""
    half: str = ""
    alias: bool = False


@dataclass(frozen=True)
class NameMapping:
    """Which names of a rig stand for which names of a standard.

    Parameters
    ----------
    found : mapping of str to tuple of str
        Standard name -> names of the rig that stand for it; two where the rig has it in a left and a right half.
    missing : tuple of str
        Standard names that nothing stands for.
    double : mapping of str to tuple of str
        Standard names that several shapes of one side stand for.
    unknown : tuple of str
        Names of the rig that stand for nothing.
    names : mapping of str to str
        Name of the rig -> the standard name for it, of shapes that alone stand for one, or for a half of one
        (``AU12_L``).
    """

    found: MappingProxyType[str, tuple[str, ...]]
    missing: tuple[str, ...]
    double: MappingProxyType[str, tuple[str, ...]]
    unknown: tuple[str, ...]
    names: MappingProxyType[str, str]


def words(name: str) -> tuple[str, ...]:
    """Return the words of a name in lower case: ``EyeBlink_L`` and ``eye blink l`` are ``eye, blink, l``."""
    return tuple(name[start:end].lower() for start, end in _spans(name))


def _spans(name: str) -> list[tuple[int, int]]:
    kinds: list[str] = []
    for letter in name:
        kind = unicodedata.category(letter)
        if kind[0] == "M":  # an accent belongs to the letter before it
            kinds.append("a" if kinds and kinds[-1] == "A" else kinds[-1] if kinds else "_")
        elif kind[0] == "L":
            kinds.append({"Lu": "A", "Lt": "A", "Ll": "a"}.get(kind, "o"))
        else:
            kinds.append("0" if kind == "Nd" else "_")
    return [match.span() for match in _WORD.finditer("".join(kinds))]


def side(name: str) -> Side:
    """Return ``L`` or ``R`` for the name of a shape of one side, the subject's; empty where it says none."""
    sides = [_SIDES[word] for word in words(name) if word in _SIDES]
    return sides[-1] if sides else ""


def partner(name: str) -> str | None:
    """Return the name of the same shape on the other side, spelled alike; None where the name says no side.

    ``eyeBlinkLeft`` has ``eyeBlinkRight``, ``L_eye_blink`` has ``R_eye_blink``. Where a name says a side twice the
    last counts: ``eyeLookLeft_R`` is the right eye's.
    """
    places = [(start, end) for start, end in _spans(name) if name[start:end].lower() in _SIDES]
    if not places:
        return None
    start, end = places[-1]
    old = name[start:end]
    new = _SWAPPED[old.lower()]
    new = new.upper() if old.isupper() else new.capitalize() if old[0].isupper() else new
    return name[:start] + new + name[end:]


def arkit_mapping(names: Sequence[str]) -> NameMapping:
    """Return which of the 52 ARKit blendshapes a rig has, whatever it spells them like.

    ``eyeBlinkLeft``, ``eyeBlink_L``, ``EyeBlink_L``, ``L_eye_blink`` and ``head.eyeblinkleft`` are one. Two halves of
    a shape that ARKit has whole (``browInnerUp_L`` and ``_R``) stand for it together.
    """
    return _mapped(names, ARKIT, _arkit)


def facs_mapping(names: Sequence[str]) -> NameMapping:
    """Return which action units of the Facial Action Coding System a rig has, as ``AU12``.

    By number (``AU12_L``, ``au_01``), or by what the ARKit name means. A unit that takes several ARKit shapes, or one
    on each side, may have several names.
    """
    return _mapped(names, [unit.key for unit in ACTION_UNITS], _units)


def action_unit(key: str) -> ActionUnit | None:
    """Return the action unit of a key such as ``AU12``; None where there is none."""
    return next((unit for unit in ACTION_UNITS if unit.key == key), None)


def _mapped(names: Sequence[str], wanted: Sequence[str], find: Callable[[str], list[_Hit]]) -> NameMapping:
    short = _without_prefix(names)
    hits = [(name, hit) for name, plain in zip(names, short, strict=True) for hit in find(plain) or find(name)]
    exact = {hit[:3] for _, hit in hits if not hit.alias}
    hits = [(name, hit) for name, hit in hits if not hit.alias or hit[:3] not in exact]
    met: dict[str, dict[tuple[str, str], list[str]]] = {key: {} for key in wanted}
    for name, hit in hits:
        met[hit.key].setdefault((hit.source, hit.half), []).append(name)
    found = {key: tuple(name for group in kinds.values() for name in group) for key, kinds in met.items() if kinds}
    double = {key: twice for key, kinds in met.items() if (twice := _twice(kinds))}
    known = Counter(name for name, _ in hits)
    renamed = {
        group[0]: key + (f"_{half}" if half else "")
        for key, kinds in met.items()
        if len({source for source, _ in kinds}) == 1 and key not in double
        for (_, half), group in kinds.items()
        if known[group[0]] == 1
    }
    unknown = tuple(name for name in names if name not in known)
    missing = tuple(key for key in wanted if key not in found)
    return NameMapping(MappingProxyType(found), missing, MappingProxyType(double), unknown, MappingProxyType(renamed))


def _twice(kinds: Mapping[tuple[str, str], list[str]]) -> tuple[str, ...]:
    """Return names that are one too many: several for one half, or a whole shape beside its halves."""
    sources = {source for source, half in kinds if half and (source, "") in kinds}
    return tuple(n for (source, _), names in kinds.items() if len(names) > 1 or source in sources for n in names)


def _without_prefix(names: Sequence[str]) -> list[str]:
    """Return the names without what stands before a dot or colon, and without words that all of them begin with."""
    short = [re.split(r"[.:|]", name)[-1] or name for name in names]
    first, last = (min(short), max(short)) if len(short) > 2 else ("", "")
    length = next((k for k, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), min(len(first), len(last)))
    shared = first[:length]
    end = max((shared.rfind(mark) for mark in "_- "), default=-1) + 1
    return [name[end:] or name for name in short]


def _arkit(name: str) -> list[_Hit]:
    spoken, keys = list(words(name)), _arkit_keys()
    for key in (_key(spoken), "".join(spoken)):
        if key in keys:
            return [_Hit(keys[key][0], alias=keys[key][1])]
    own = side(name)
    if own:
        spoken.reverse()
        spoken.remove(next(word for word in spoken if word in _SIDES))
        whole = keys.get(_key(spoken))
        return [] if whole is None else [_Hit(whole[0], half=own, alias=whole[1])]
    both = [keys.get(_key([*spoken, word])) for word in ("left", "right")] if spoken not in _BARE else []
    return [_Hit(hit[0], alias=hit[1]) for hit in both if hit is not None]


def _units(name: str) -> list[_Hit]:
    number = _UNIT.search(name)
    if number is not None:
        key = f"AU{int(number[1])}"
        half = side(name[number.end() :]) or side(name[: number.start()])
        return [] if action_unit(key) is None else [_Hit(key, half=half)]
    shown = _arkit(name)
    spoken = _key(word for word in words(name) if word not in _SIDES)
    named = [_Hit(unit.key, half=side(name)) for unit in ACTION_UNITS if spoken == _key(words(unit.name))]
    if named and not any(hit for hit in shown if not hit.alias):
        return named
    return [
        _Hit(unit.key, re.sub("(Left|Right)$", "", hit.key), hit.half or side(hit.key), hit.alias)
        for hit in shown
        for unit in ACTION_UNITS
        if hit.key in unit.arkit
    ]


def _key(spoken: Iterable[str]) -> str:
    """Return one key for all orders of words and all spellings of the sides."""
    return " ".join(sorted(_LONG[_SIDES[word]] if word in _SIDES else word for word in spoken))


@cache
def _arkit_keys() -> dict[str, tuple[str, bool]]:
    """Return ARKit names by the keys of what they are called, words apart and in one; and whether that is an alias."""
    keys: dict[str, tuple[str, bool]] = {}
    for alias in (False, True):
        for name in ARKIT:
            own = side(name)
            plain = tuple(word for word in words(name) if word not in _SIDES)
            base = name.removesuffix("Left").removesuffix("Right")
            for spoken in ALIASES.get(base, ()) if alias else (plain,):
                marks = [(own.lower(),), (_LONG[own],)] if own else [()]
                for spelling in [way for mark in marks for way in ((*spoken, *mark), (*mark, *spoken))]:
                    keys.setdefault(_key(spelling), (name, alias))
                    keys.setdefault("".join(spelling), (name, alias))
    return keys
