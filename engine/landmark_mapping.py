"""Which points of a file are which fiducials: mappings, how they are used both ways, and how one is chosen."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from engine.errors import InputError
from engine.landmark_names import plain, words
from engine.mesh import FloatArray

Source = int | str
"""A point of a file: its index from 0, or its label."""

Sources = tuple[Source, ...]

BY_NAME = "by name"
"""The name of the mapping that `by_name` makes."""


@dataclass(frozen=True)
class LandmarkMapping:
    """Which points of a file make which fiducials.

    Parameters
    ----------
    name : str
        What the mapping is called.
    entries : mapping of str to tuple of (int or str)
        For each fiducial the file's points, by index from 0 or by label; of several the mean is taken, and a point
        named twice counts twice.
    title : str
        What people read in a list of mappings.
    count : int, optional
        How many points a file of this layout has.
    layout : mapping of str to int
        The labels of the layout in order, with how many points each has; empty where points have indices only.
    note : str
        What is not quite the same point, in words.

    Raises
    ------
    InputError
        Naming the fiducial whose sources are missing, negative or of another kind.
    """

    name: str
    entries: Mapping[str, Sources]
    title: str = ""
    count: int | None = None
    layout: Mapping[str, int] = field(default_factory=dict)
    note: str = ""

    def __post_init__(self) -> None:
        entries: dict[str, Sources] = {}
        for target, sources in self.entries.items():
            subject = f"mapping {self.name}, {target}"
            if not sources:
                raise InputError(subject, "names no point of the file", "name one, or leave the fiducial out")
            for source in sources:
                if isinstance(source, bool) or not isinstance(source, int | str):
                    raise InputError(subject, f"{source!r} is no point", "give an index from 0 or a label")
                if isinstance(source, int) and (source < 0 or (self.count is not None and source >= self.count)):
                    most = "" if self.count is None else f" to {self.count - 1}"
                    raise InputError(subject, f"there is no point {source}", f"indices go from 0{most}")
            entries[target] = tuple(sources)
        if self.layout and self.count is not None and sum(self.layout.values()) != self.count:
            total = sum(self.layout.values())
            raise InputError(f"mapping {self.name}, labels", f"have {total} points of {self.count}", "correct them")
        object.__setattr__(self, "entries", MappingProxyType(entries))
        object.__setattr__(self, "layout", MappingProxyType(dict(self.layout)))

    def __hash__(self) -> int:
        return hash((self.name, self.count, tuple(self.entries.items())))

    @property
    def labels(self) -> tuple[str, ...]:
        """What a file of this layout calls its points: ``leye.0``, or the index as text; empty without a count."""
        if self.layout:
            named = [(label, size) for label, size in self.layout.items()]
            return tuple(label if size == 1 else f"{label}.{k}" for label, size in named for k in range(size))
        return tuple(str(k) for k in range(self.count or 0))

    def with_entry(self, target: str, sources: Sources) -> LandmarkMapping:
        """Return the mapping in which ``target`` is made of ``sources``; of none, it is left out."""
        entries = {name: known for name, known in self.entries.items() if name != target or sources}
        if sources:
            entries[target] = sources
        return LandmarkMapping(self.name, entries, self.title, self.count, self.layout, self.note)


@dataclass(frozen=True)
class Mapped:
    """What a mapping made of a file's points.

    ``positions`` (2 or 3 coordinates each) by fiducial, in the order asked for; ``unmapped`` are fiducials the mapping
    does not know, ``absent`` those whose points the file does not have or gives no place, with the point that lacks.
    """

    positions: Mapping[str, tuple[float, ...]]
    unmapped: tuple[str, ...]
    absent: Mapping[str, str]


def index_of(source: Source, labels: Sequence[str]) -> int | None:
    """Return the place of a source among a file's labels; None where it is not there, or not clearly."""
    if isinstance(source, int):
        return source if 0 <= source < len(labels) else None
    if source in labels:
        return list(labels).index(source)
    wanted = plain(source)
    alike = [k for k, label in enumerate(labels) if plain(label) == wanted] if wanted else []
    return alike[0] if len(alike) == 1 else None


def apply_mapping(
    mapping: LandmarkMapping, points: FloatArray, labels: Sequence[str], targets: Iterable[str]
) -> Mapped:
    """Return where a mapping puts the fiducials.

    Parameters
    ----------
    mapping : LandmarkMapping
        Which points make which fiducial.
    points : (n, 2) or (n, 3) float
        The file's points; NaN where it gives none.
    labels : sequence of str
        What the file calls them.
    targets : iterable of str
        The fiducials that are wanted, in the order of the result.
    """
    positions: dict[str, tuple[float, ...]] = {}
    unmapped: list[str] = []
    absent: dict[str, str] = {}
    for target in targets:
        sources = mapping.entries.get(target)
        if sources is None:
            unmapped.append(target)
            continue
        indices = [index_of(source, labels) for source in sources]
        lacking = [
            str(source)
            for source, index in zip(sources, indices, strict=True)
            if index is None or not np.isfinite(points[index]).all()
        ]
        if lacking:
            absent[target] = lacking[0]
            continue
        place = np.mean([points[index] for index in indices if index is not None], axis=0)
        positions[target] = tuple(float(value) for value in place)
    return Mapped(MappingProxyType(positions), tuple(unmapped), MappingProxyType(absent))


@dataclass(frozen=True)
class Unmapped:
    """Fiducials in a file's order: ``points`` (n, 2) with NaN for holes, ``labels``, and ``lost``: those without a
    place in it, because the mapping does not know them or does not say where each of their points is."""

    points: FloatArray
    labels: tuple[str, ...]
    lost: tuple[str, ...]

    @property
    def holes(self) -> int:
        """How many points of the layout no fiducial fills."""
        return int((~np.isfinite(self.points).all(axis=1)).sum())


def invert_mapping(mapping: LandmarkMapping, positions: Mapping[str, tuple[float, float]]) -> Unmapped:
    """Return fiducials as the points of the layout that a mapping reads.

    A fiducial made from several points tells one of them, where the other fiducials tell the rest; else it is lost.

    Raises
    ------
    InputError
        When the mapping names no place for any of the fiducials.
    """
    labels = list(mapping.labels)
    if not labels:
        for sources in mapping.entries.values():
            labels += [str(s) for s in sources if isinstance(s, str) and s not in labels and len(sources) == 1]
        largest = max((s for sources in mapping.entries.values() for s in sources if isinstance(s, int)), default=-1)
        labels = [str(k) for k in range(largest + 1)] if largest >= 0 else labels
    points = np.full((len(labels), 2), np.nan)
    waiting = {target: [index_of(s, labels) for s in mapping.entries.get(target, ())] for target in positions}
    while True:
        # A mean tells its one point that is not known yet, once the others are.
        solved = [target for target, indices in waiting.items() if _solve(points, indices, positions[target])]
        if not solved:
            break
        for target in solved:
            del waiting[target]
    lost = [target for target in positions if target in waiting]
    if len(lost) == len(positions):
        raise InputError(f"mapping {mapping.name}", "has no place for these fiducials", "choose another mapping")
    points.flags.writeable = False
    return Unmapped(points, tuple(labels), tuple(lost))


def _solve(points: FloatArray, indices: Sequence[int | None], position: tuple[float, float]) -> bool:
    """Set the one point of ``points`` that ``position``, the mean of ``indices``, leaves open; False without one."""
    if not indices or None in indices:
        return False
    known = [index for index in indices if index is not None]
    open_ones = {index for index in known if np.isnan(points[index, 0])}
    if len(open_ones) != 1:
        return False
    (index,) = open_ones
    others = sum((points[k] for k in known if k != index), start=np.zeros(2))
    points[index] = (np.asarray(position) * len(known) - others) / known.count(index)
    return True


def by_name(labels: Sequence[str], targets: Iterable[str]) -> LandmarkMapping:
    """Return the mapping of the points whose name says the same as a fiducial's, in any spelling and order of words.

    A name that two points share, or that could be two fiducials, is left to the user.
    """
    wanted = list(targets)
    said: dict[frozenset[str], list[str]] = {}
    for label in labels:
        said.setdefault(words(label), []).append(label)
    entries: dict[str, Sources] = {}
    for target in wanted:
        if target in labels:
            entries[target] = (target,)
            continue
        alike = [label for label in said.get(words(target), ()) if label not in wanted]
        if len(alike) == 1 and words(target):
            entries[target] = (alike[0],)
    return LandmarkMapping(BY_NAME, entries, "By name", note="Points whose names say the same.")


def choose_mapping(
    mappings: Iterable[LandmarkMapping], labels: Sequence[str], targets: Sequence[str]
) -> tuple[LandmarkMapping, str]:
    """Return the mapping that fits a file's points best, and why, in a few words.

    Names that say what they are win; then a layout whose labels the file has; then one with its count of points. Where
    nothing fits, what the names give is returned, if only nothing.
    """
    named = by_name(labels, targets)
    best, rank = (named, f"{len(named.entries)} names are alike"), (len(named.entries), 1)
    indexed = all(label == str(k) for k, label in enumerate(labels))
    present = set(labels)
    for mapping in mappings:
        found = sum(target in mapping.entries for target in targets)
        if mapping.layout:
            fits, score, why = present >= set(mapping.labels), (found, 2), "its labels"
        else:
            fits = mapping.count == len(labels) and (indexed or not named.entries)
            score, why = (found, 0), f"{mapping.count} points"
        if fits and score > rank:
            best, rank = (mapping, why), score
    return best
