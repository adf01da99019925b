"""What the numbers of a mesh file mean: the caller's word, its own, or what makes it as large as a head."""

from __future__ import annotations

import re

import numpy as np

from engine.errors import InputError
from engine.files.scan_file import MM_PER_UNIT

SMALLEST_HEAD_MM, LARGEST_HEAD_MM = 90.0, 900.0
"""Largest side of what is taken for a face, a head, or a bust with shoulders."""

TYPICAL_HEAD_MM = 250.0
"""Largest side of a head, to which a mesh in no known unit is scaled."""

_NUMBER = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*mm\s*")


def mm_per_unit(unit: str) -> float:
    """Return the millimetres in one unit: ``mm``, ``cm``, ``m``, or a number of millimetres such as ``"85.3 mm"``.

    Raises
    ------
    InputError
        For anything else, and for a number that is not between 1e-6 and 1e6.
    """
    if unit in MM_PER_UNIT:
        return MM_PER_UNIT[unit]
    found = _NUMBER.fullmatch(str(unit)[:40])
    try:
        value = float(found[1]) if found else 0.0
    except ValueError:
        value = 0.0
    if not 1e-6 <= value <= 1e6:
        raise InputError("unit", f"{str(unit)[:40]!r} is not known", "choose mm, cm or m, or millimetres: '85.3 mm'")
    return value


def scaled_unit(millimetres: float) -> str:
    """Return the unit of ``millimetres`` as a word that ``mm_per_unit`` understands."""
    return next((name for name, value in MM_PER_UNIT.items() if value == millimetres), f"{millimetres:.6g} mm")


def mesh_unit(requested: str | None, named: str | None, extent: float) -> tuple[str, str, tuple[str, ...]]:
    """Return (unit, what was assumed, warnings) for a mesh.

    The caller's wish wins; then the file's own word, with a warning where no head is that large. Where the file says
    nothing it is the one of mm, cm and m in which it is a head; else a scale that makes it ``TYPICAL_HEAD_MM``.

    Parameters
    ----------
    requested, named : str, optional
        The caller's wish and the file's own word.
    extent : float
        Largest side of the mesh, in its own unit.
    """

    def size(unit: str) -> float:
        return extent * mm_per_unit(unit)

    if requested is not None:
        requested = scaled_unit(mm_per_unit(requested))
        warnings = () if _is_head(size(requested)) else (_unlikely(size(requested), requested, extent),)
        if named is not None and named != requested:
            warnings = (f"read in {requested} as asked, although the file names {named}", *warnings)
        return requested, f"{requested}, as asked", warnings
    if named is not None:
        warnings = () if _is_head(size(named)) else (_unlikely(size(named), named, extent),)
        return named, f"{named}, as in the file", warnings
    fitting = [unit for unit in MM_PER_UNIT if _is_head(size(unit))]
    if fitting:
        return fitting[0], f"{fitting[0]} assumed: it is {size(fitting[0]):.0f} mm large, as a head may be", ()
    unit = scaled_unit(float(f"{TYPICAL_HEAD_MM / extent:.4g}"))
    return unit, f"{unit} assumed for one unit: in mm, cm or m no head is {extent:.3g} units large", ()


def _is_head(millimetres: float) -> bool:
    return SMALLEST_HEAD_MM <= millimetres <= LARGEST_HEAD_MM


def _unlikely(millimetres: float, unit: str, extent: float) -> str:
    others = [f"{name}" for name, factor in MM_PER_UNIT.items() if name != unit and _is_head(extent * factor)]
    advice = f"its unit is rather {' or '.join(others)} than {unit}: choose it" if others else "check its unit"
    return f"the mesh is {np.format_float_positional(millimetres, 3, fractional=False, trim='-')} mm large: {advice}"
