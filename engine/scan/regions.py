"""The parts of a face: which vertices are brows, lids, nose, lips, cheeks, jaw, at every level of subdivision.

A region is a set of the template's triangles, so that its border runs along edges and stays where it is when triangles
are split. A vertex belongs to the region that most triangles around it are of (of equals to the one named first), so
that every vertex has exactly one region and both sides of the face are each other's mirror image.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from engine.errors import InputError
from engine.geometry.subdivide import unique_edges
from engine.mesh import BoolArray, IntArray, frozen
from engine.scan.region_names import MEANING, OTHER
from engine.scan.template import FaceTemplate

_GROUPS = {"brow": "brows", "eye": "lids", "nose": "nose", "lip": "lips", "mouth": "lips", "jaw": "jaw", "chin": "jaw"}
_CHEEK = ("eye_{}_outer", "nose_{}", "mouth_{}", "jaw_{}")
"""Fiducials whose mean is the middle of a cheek."""


@dataclass(frozen=True, eq=False)
class FaceRegions:
    """The regions of one template.

    Parameters
    ----------
    template : FaceTemplate
    names : tuple of str
        Their order is that of tables, and decides for vertices between regions.
    faces : (F,) int
        The region of every face of the template, an index into ``names``.
    assumed : str
        How the regions were found where the template does not state them; empty where it does.
    """

    template: FaceTemplate
    names: tuple[str, ...]
    faces: IntArray
    assumed: str = field(default="")

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", frozen(self.faces, "int64"))

    def vertices(self, levels: int = 0) -> IntArray:
        """Return the region (M,) of every vertex of the template subdivided ``levels`` times (0 to 6)."""
        return _vertices(self, levels)

    def mask(self, name: str, levels: int = 0) -> BoolArray:
        """Return which vertices (M,) belong to a region.

        Raises
        ------
        InputError
            Where the template has no such region.
        """
        if name not in self.names:
            raise InputError(f"region {name!r}", "is not on this template", f"use one of {', '.join(self.names)}")
        return np.asarray(self.vertices(levels) == self.names.index(name), dtype=np.bool_)


@lru_cache(maxsize=16)
def regions_of(template: FaceTemplate) -> FaceRegions:
    """Return the regions that a template states, or those nearest to its fiducials.

    Without stated regions, each triangle goes to the fiducial nearest to its middle in the template's first layout:
    brow, eye (the lids), nose, lips and mouth, jaw and chin, forehead. A cheek lies around the mean of the eye's outer
    corner, nose, corner of the mouth and jaw of its side. ``assumed`` then says so.
    """
    count = len(template.faces)
    if template.regions:
        names = tuple(template.regions)
        faces = np.full(count, -1, dtype=np.int64)
        for index, members in enumerate(template.regions.values()):
            faces[members] = index
        if (faces < 0).any():
            names = (*names, OTHER)
            faces[faces < 0] = len(names) - 1
        return FaceRegions(template, names, faces)
    return _by_fiducials(template)


def _by_fiducials(template: FaceTemplate) -> FaceRegions:
    layout = next(iter(template.layouts.values()), None)
    if layout is None or not layout.fiducials:
        return FaceRegions(
            template, (OTHER,), np.zeros(len(template.faces), "int64"), "no fiducials to tell regions by"
        )
    places = {name: layout.vertices[vertex] for name, vertex in layout.fiducials.items()}
    centres = [(_GROUPS.get(name.split("_")[0], "forehead"), place) for name, place in places.items()]
    for side in ("left", "right"):
        around = [places[name.format(side)] for name in _CHEEK if name.format(side) in places]
        if len(around) == len(_CHEEK):
            centres.append(("cheeks", np.mean(around, axis=0)))
    found = {region for region, _ in centres}
    names = tuple(name for name in MEANING if name in found)
    middle = layout.vertices[template.faces].mean(axis=1)
    distance = np.linalg.norm(middle[:, None] - np.array([place for _, place in centres])[None], axis=2)
    of_centre = np.array([names.index(region) for region, _ in centres])
    return FaceRegions(template, names, of_centre[distance.argmin(axis=1)], "by the nearest group of fiducials")


@lru_cache(maxsize=32)
def _vertices(regions: FaceRegions, levels: int) -> IntArray:
    fine = regions.template.refine(levels)
    of_face = regions.faces[fine.parent_faces]
    votes = np.zeros((int(fine.weights.shape[0]), len(regions.names)), dtype=np.int64)
    np.add.at(votes, (fine.faces.ravel(), np.repeat(of_face, 3)), 1)
    return frozen(votes.argmax(axis=1), "int64")


@lru_cache(maxsize=64)
def border(regions: FaceRegions, name: str, levels: int = 0) -> IntArray:
    """Return the edges (k, 2) around a region, as vertices of the template subdivided ``levels`` times.

    Raises
    ------
    InputError
        Where the template has no such region.
    """
    if name not in regions.names:
        raise InputError(f"region {name!r}", "is not on this template", f"use one of {', '.join(regions.names)}")
    fine = regions.template.refine(levels)
    faces = fine.faces[regions.faces[fine.parent_faces] == regions.names.index(name)]
    edges, side = unique_edges(faces)
    return frozen(edges[np.bincount(side.ravel(), minlength=len(edges)) == 1], "int64")
