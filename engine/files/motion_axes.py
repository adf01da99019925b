"""Which way a file's markers look and how large its unit is: stated, named by the file, or found from the points."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from engine.errors import InputError
from engine.files.mesh_unit import mm_per_unit, scaled_unit
from engine.files.scan_file import MM_PER_UNIT
from engine.mesh import BoolArray, FloatArray

SMALLEST_FACE_MM, LARGEST_FACE_MM = 70.0, 450.0
"""Largest side of what markers on a face, with or without some on the head, span."""

TYPICAL_FACE_MM = 200.0
"""Largest side of a face's markers, to which those in no known unit are scaled."""

AXES = ("x", "-x", "y", "-y", "z", "-z")

_CLEARLY = 0.02


@dataclass(frozen=True)
class Placing:
    """How a file's numbers become millimetres in our frame.

    Parameters
    ----------
    unit : str
        See ``engine.files.mesh_unit.mm_per_unit``.
    up, forward : str
        Axes of the file.
    assumed : str
        In words, where they came from.
    guessed : tuple of str
        Which of ``unit``, ``up``, ``forward`` nobody stated.
    warnings : tuple of str
        An unlikely size.
    """

    unit: str
    up: str
    forward: str
    assumed: str
    guessed: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def scale(self) -> float:
        """Millimetres in one of the file's units."""
        return mm_per_unit(self.unit)

    @property
    def rotation(self) -> FloatArray:
        """(3, 3) proper rotation from the file's frame into +Y up, +Z out of the face."""
        return axes_rotation(self.up, self.forward)

    def apply(self, positions: FloatArray) -> FloatArray:
        """Return positions (..., 3) of the file in mm in our frame; NaN stays NaN."""
        placed: FloatArray = positions @ self.rotation.T * self.scale
        return placed


def axes_rotation(up: str, forward: str) -> FloatArray:
    """Return the proper rotation (3, 3) that carries the axes ``up`` to +Y and ``forward`` to +Z.

    Raises
    ------
    InputError
        For names that are no axes, and for two along one line.
    """
    rows = [_direction(up), _direction(forward)]
    if abs(rows[0] @ rows[1]) > 0:
        raise InputError("forward", f"{forward!r} lies along the up axis {up!r}", "choose another axis")
    return np.array([np.cross(rows[0], rows[1]), *rows])


def _direction(name: str) -> FloatArray:
    name = axis_name(name)
    direction = np.zeros(3)
    direction["xyz".index(name[-1])] = -1.0 if name[0] == "-" else 1.0
    return direction


def axis_name(text: str) -> str:
    """Return an axis as ``x``, ``-x``, ... whatever the case and with or without ``+``.

    Raises
    ------
    InputError
        For anything else.
    """
    name = str(text).strip().lower().removeprefix("+")
    if name not in AXES:
        raise InputError("axis", f"{str(text)[:20]!r} is not known", "choose x, -x, y, -y, z or -z")
    return name


def place_markers(
    subject: str,
    positions: FloatArray,
    unit: str | None,
    named: str | None,
    up: str | None,
    forward: str | None,
    named_axes: tuple[str, str] | None = None,
) -> Placing:
    """Return how markers (L, K, 3), NaN where not seen, are to be placed.

    What is asked for wins, then what the file names. A unit that neither states is the one of mm, cm and m in which
    the markers are as large as a face, else a scale that makes them so. Axes that nobody states are those about which
    the markers are symmetric and bulge as a face does, +Y up and +Z forward unless others fit clearly better (ours).
    """
    cloud = typical_positions(positions)
    extent = float(np.ptp(cloud, axis=0).max()) if len(cloud) > 1 else 0.0
    unit, unit_said, guessed_unit, warnings = _unit(unit, named, extent)
    guessed: tuple[str, ...] = ()
    if up is None and forward is None and named_axes is not None:
        chosen = (axis_name(named_axes[0]), axis_name(named_axes[1]))
        axes_said = f"{chosen[0]} up and {chosen[1]} forward, as in the file"
    else:
        chosen, axes_said, guessed = _axes(cloud, up, forward)
    axes_rotation(*chosen)
    more = ("unit",) if guessed_unit else ()
    return Placing(unit, *chosen, f"{unit_said}; {axes_said}", (*more, *guessed), warnings)


def place_mesh(unit: str | None, named: str | None, up: str | None, forward: str | None, extent: float) -> Placing:
    """Return how a moving mesh is to be placed: +Y up and +Z forward unless asked otherwise, the unit by its size."""
    from engine.files.mesh_unit import mesh_unit

    found, said, warnings = mesh_unit(unit, named, extent)
    chosen_up = "y" if up is None else axis_name(up)
    default = {"y": "z", "z": "-y"}.get(chosen_up, "z")
    chosen_forward = default if forward is None else axis_name(forward)
    axes_rotation(chosen_up, chosen_forward)
    stated = up is not None or forward is not None
    guessed = tuple(name for name, free in (("unit", unit is None and named is None), ("up", not stated)) if free)
    said = f"{said}; {chosen_up} up and {chosen_forward} forward, {'as asked' if stated else 'as rigs have it'}"
    return Placing(found, chosen_up, chosen_forward, said, guessed, warnings)


def seen_in(positions: FloatArray) -> BoolArray:
    """Return where (L, K) positions (L, K, 3) have all three coordinates."""
    seen: BoolArray = np.asarray(np.isfinite(positions).all(axis=2), dtype=bool)
    return seen


def typical_positions(positions: FloatArray, most: int = 200) -> FloatArray:
    """Return the median place (k, 3) of every marker that is ever seen, relative to its frame's median marker."""
    if not len(positions):
        return np.zeros((0, 3))
    some = positions[np.linspace(0, len(positions) - 1, min(most, len(positions))).astype(np.int64)]
    seen = seen_in(some)
    full = seen.sum(axis=1)
    if not full.max():
        seen_any = seen_in(positions)
        if not seen_any.any():
            return np.zeros((0, 3))
        some, seen = positions[seen_any.any(axis=1)][:most], seen_any[seen_any.any(axis=1)][:most]
        full = seen.sum(axis=1)
    # Frames that show few markers have their middle elsewhere.
    rich = full >= 0.8 * full.max()
    some, seen = some[rich], seen[rich]
    centred = some - np.nanmedian(some, axis=1, keepdims=True)
    known = seen.any(axis=0)
    typical: FloatArray = np.nanmedian(centred[:, known], axis=0)
    return typical


def _unit(requested: str | None, named: str | None, extent: float) -> tuple[str, str, bool, tuple[str, ...]]:
    def size(unit: str) -> float:
        return extent * mm_per_unit(unit)

    if requested is not None or named is not None:
        unit = scaled_unit(mm_per_unit(requested if requested is not None else str(named)))
        said = f"{unit}, as asked" if requested is not None else f"{unit}, as in the file"
        if _is_face(size(unit)) or not extent:
            return unit, said, False, ()
        better = [name for name in MM_PER_UNIT if _is_face(size(name))]
        advice = f"its unit is rather {' or '.join(better)}: choose it" if better else "check the unit"
        return unit, said, False, (f"the markers span {size(unit):.4g} mm: {advice}",)
    fitting = [name for name in MM_PER_UNIT if _is_face(size(name))]
    if fitting:
        return fitting[0], f"{fitting[0]} assumed: the markers span {size(fitting[0]):.0f} mm, as on a face", True, ()
    if extent * 1e6 < TYPICAL_FACE_MM:
        return "mm", "mm assumed", True, ("all markers lie in one place",)
    unit = scaled_unit(float(f"{TYPICAL_FACE_MM / extent:.4g}"))
    problem = f"in mm, cm or m no face is {extent:.3g} units large: choose the unit (--unit) or fit the size (--scale)"
    return unit, f"{unit} assumed for one unit", True, (problem,)


def _is_face(millimetres: float) -> bool:
    return SMALLEST_FACE_MM <= millimetres <= LARGEST_FACE_MM


def _axes(cloud: FloatArray, up: str | None, forward: str | None) -> tuple[tuple[str, str], str, tuple[str, ...]]:
    up = None if up is None else axis_name(up)
    forward = None if forward is None else axis_name(forward)
    if up is not None and forward is not None:
        return (up, forward), f"{up} up and {forward} forward, as asked", ()
    guessed = tuple(name for name, given in (("up", up), ("forward", forward)) if given is None)
    choices = [
        (a, b)
        for a, b in itertools.product(("y", "z") if up is None else (up,), AXES if forward is None else (forward,))
        if a[-1] != b[-1]
    ]
    default = next((c for c in (("y", "z"), ("z", "-y")) if c in choices), choices[0])
    if len(cloud) < 6 or np.ptp(cloud, axis=0).max() == 0:
        return default, f"{default[0]} up and {default[1]} forward assumed", guessed
    cost = {choice: _unlike_a_face(cloud @ axes_rotation(*choice).T) for choice in choices}
    best = min(choices, key=lambda choice: cost[choice])
    chosen = default if cost[default] <= cost[best] + _CLEARLY else best
    return chosen, f"{chosen[0]} up and {chosen[1]} forward assumed from the shape of the points", guessed


def _unlike_a_face(cloud: FloatArray) -> float:
    """How little points (k, 3) look like a face whose x is sideways, y up and z forward; 0 for a perfect one."""
    cloud = (cloud - np.median(cloud, axis=0)) / np.ptp(cloud, axis=0).max()
    mirrored = []
    for middle in (0.0, float(cloud[:, 0].mean()), float(cloud[:, 0].min() + cloud[:, 0].max()) / 2):
        image = cloud * [-1, 1, 1] + [2 * middle, 0, 0]
        mirrored.append((float(np.mean(cKDTree(cloud).query(image)[0])), middle))
    asymmetry, middle = min(mirrored)
    # A face stands out most on its mid-line and falls back on both sides, at any height.
    side = (cloud[:, 0] - middle) ** 2
    table = np.stack([np.ones(len(cloud)), cloud[:, 1], side], axis=1)
    bulge = -float(np.linalg.lstsq(table, cloud[:, 2], rcond=None)[0][2])
    flat = float(np.ptp(cloud[:, 2]))
    return asymmetry - 0.1 * float(np.tanh(bulge)) + 0.02 * flat
