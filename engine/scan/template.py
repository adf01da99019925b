"""The flat face that is warped onto a picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from engine.errors import InputError
from engine.geometry.subdivide import Subdivision, subdivision, unique_edges
from engine.landmarks import LandmarkScheme
from engine.mesh import FloatArray, IntArray, frozen


@dataclass(frozen=True)
class TemplateLayout:
    """Where the template's vertices lie for one fiducial scheme.

    Parameters
    ----------
    vertices : (N, 2) float
        Flat positions, +Y **down** like pixels, in units of the template's own.
    fiducials : mapping of str to int
        The vertex that carries each named fiducial.
    """

    vertices: FloatArray
    fiducials: Mapping[str, int]

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen(self.vertices, "float64"))
        object.__setattr__(self, "fiducials", MappingProxyType(dict(self.fiducials)))


@dataclass(frozen=True, eq=False)
class FaceTemplate:
    """One set of triangles with a layout per scheme; upper and lower lip have vertices of their own.

    Parameters
    ----------
    name : str
        Shown to the user.
    faces : (F, 3) int
        Triangles; positive signed area in every layout (clockwise on screen, as +Y points down).
    mirror : (N,) int
        The vertex of the other side; a mid-line vertex is its own mirror.
    layouts : mapping of str to TemplateLayout
        ``closed`` (both lips share the slit's line) and ``open`` (a slit of finite width).
    curves : mapping of str to (k,) int
        Vertices of the lips' borders from the subject's right corner to the left: ``lip_upper``, ``lip_lower`` (outer),
        ``lip_upper_inner``, ``lip_lower_inner``.
    regions : mapping of str to (k,) int
        Faces of the parts of the face (brows, lids, nose ...), each face in one of them; see ``engine.scan.regions``.

    Notes
    -----
    Yano & Harada 2009, figure 1: 441 vertices and 804 triangles around a lip slit.
    """

    name: str
    faces: IntArray
    mirror: IntArray
    layouts: Mapping[str, TemplateLayout]
    curves: Mapping[str, IntArray] = field(default_factory=dict)
    regions: Mapping[str, IntArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", frozen(self.faces, "int64"))
        object.__setattr__(self, "mirror", frozen(self.mirror, "int64"))
        object.__setattr__(self, "layouts", MappingProxyType(dict(self.layouts)))
        count = len(self.mirror)
        if len(self.faces) == 0 or self.faces.min() < 0 or self.faces.max() >= count:
            raise InputError(f"template {self.name}", "a face index is outside its vertices", "check faces and mirror")
        if count and (self.mirror.min() < 0 or self.mirror.max() >= count):
            raise InputError(f"template {self.name}", "a mirror index is outside its vertices", "check mirror")
        curves = {name: frozen(curve, "int64") for name, curve in self.curves.items()}
        object.__setattr__(self, "curves", MappingProxyType(curves))
        for name, curve in curves.items():
            if len(curve) < 3 or curve.min() < 0 or curve.max() >= count:
                raise InputError(f"template {self.name}, curve {name}", "has a vertex that does not exist", "check it")
        object.__setattr__(self, "regions", _checked_regions(self.name, self.regions, len(self.faces)))
        for scheme, layout in self.layouts.items():
            if len(layout.vertices) != count:
                raise InputError(
                    f"template {self.name}, layout {scheme}",
                    f"has {len(layout.vertices)} vertices, not {count}",
                    "give every layout the same vertices",
                )
            if any(not 0 <= vertex < count for vertex in layout.fiducials.values()):
                raise InputError(
                    f"template {self.name}, layout {scheme}", "a fiducial's vertex does not exist", "check its number"
                )
            check_lips(self.name, scheme, layout, curves)

    def layout(self, scheme: str) -> TemplateLayout:
        """Return the layout of ``scheme``; ``InputError`` names the ones there are."""
        try:
            return self.layouts[scheme]
        except KeyError:
            known = " or ".join(sorted(self.layouts))
            remedy = f"choose the scheme {known}, or another template" if known else "choose another template"
            raise InputError(f"template {self.name}", f"has no layout {scheme!r}", remedy) from None

    def with_scheme(self, scheme: LandmarkScheme) -> FaceTemplate:
        """Return a template in which the scheme's own name is a layout, so that warp, fit and proposals know it.

        Its vertices lie as in the layout that the scheme stands on; a fiducial without a vertex of its own takes that
        of the same name there.

        Raises
        ------
        InputError
            Naming the fiducial and the field that does not fit this template (``engine.scan.scheme_vertices``).
        """
        from engine.scan.scheme_vertices import template_with

        return template_with(self, scheme)

    @property
    def edges(self) -> IntArray:
        """Every edge (E, 2) of the template once."""
        return unique_edges(self.faces)[0]

    def refine(self, levels: int) -> Subdivision:
        """Return the 1-to-4 subdivision of the faces; kept for the next call."""
        return _refined(self, levels)


def lip_fiducials(lip: str) -> tuple[str, ...]:
    """Return the fiducials along the inner border of ``lip_upper`` or ``lip_lower``, from right to left corner."""
    return ("mouth_right", f"{lip}_inner_right", f"{lip}_inner", f"{lip}_inner_left", "mouth_left")


def check_lips(name: str, scheme: str, layout: TemplateLayout, curves: Mapping[str, IntArray]) -> None:
    """Raise ``InputError`` unless a layout with inner lip fiducials has them in order along the lip's border."""
    for lip in ("lip_upper", "lip_lower"):
        along = lip_fiducials(lip)
        inner = curves.get(f"{lip}_inner")
        if inner is None or lip not in curves or not {lip, *along} <= set(layout.fiducials):
            continue
        vertices = [layout.fiducials[fiducial] for fiducial in along]
        places = [int(np.flatnonzero(inner == vertex)[0]) if vertex in inner else -1 for vertex in vertices]
        steps = np.linalg.norm(np.diff(layout.vertices[inner], axis=0), axis=1)
        thickness = layout.vertices[layout.fiducials[lip], 1] - layout.vertices[layout.fiducials[f"{lip}_inner"], 1]
        if places != sorted(set(places)) or min(places) < 0 or not steps.all() or thickness == 0:
            raise InputError(
                f"template {name}, layout {scheme}",
                f"the fiducials of {lip} do not follow the curve {lip}_inner from corner to corner",
                "check curve and fiducials",
            )


def _checked_regions(name: str, regions: Mapping[str, IntArray], count: int) -> Mapping[str, IntArray]:
    """Return the regions frozen; ``InputError`` where a face does not exist or belongs to two of them."""
    result = {region: frozen(faces, "int64") for region, faces in regions.items()}
    taken = np.zeros(count, dtype=np.int64)
    for region, faces in result.items():
        if len(faces) == 0 or faces.min() < 0 or faces.max() >= count:
            raise InputError(f"template {name}, region {region}", "has no face, or one that does not exist", "check it")
        np.add.at(taken, faces, 1)
    if (taken > 1).any():
        twice = int((taken > 1).argmax())
        raise InputError(f"template {name}, regions", f"face {twice} is in them twice", "put every face into one")
    return MappingProxyType(result)


@lru_cache(maxsize=16)
def _refined(template: FaceTemplate, levels: int) -> Subdivision:
    return subdivision(template.faces, len(template.mirror), levels)
