"""The true surfaces of the bundled scans, for whatever a test compares with them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

import resources
from engine.files.landmarks_json import read_fiducials
from engine.files.scan import read_scan
from engine.mesh import FloatArray, IntArray, TriangleMesh
from engine.scan.range_image import Camera, RangeImage
from resources.sample.head import Heads

SUBJECT_SCANS = ("base", "car", "man", "she", "eel", "too")
STRANGER = "stranger"
SCANS = (*SUBJECT_SCANS, STRANGER)
OPEN = ("car", "man", "she", "eel", "too")


@dataclass(frozen=True)
class TrueScan:
    """What a bundled scan ought to say.

    Attributes
    ----------
    mesh : TriangleMesh
        The true surface before its scanner, mm, with its parts.
    face_skin : (k,) int
        Faces of the visible skin between forehead and chin.
    skin : (s,) int
        All skin faces.
    fiducials, anatomy : mapping of str to int
        Vertices of the mesh: all scheme points as this scan shows them, and ten others.
    """

    name: str
    mesh: TriangleMesh
    face_skin: IntArray
    skin: IntArray
    fiducials: dict[str, int]
    anatomy: dict[str, int]

    def position(self, name: str) -> FloatArray:
        """Return the true place (3,) of a fiducial or an anatomical point, mm."""
        place: FloatArray = self.mesh.vertices[(self.fiducials | self.anatomy)[name]]
        return place

    def face_skin_mesh(self) -> TriangleMesh:
        """Return the face skin alone, same vertices."""
        return TriangleMesh(self.mesh.vertices, self.mesh.faces[self.face_skin])

    def face_skin_points(self) -> FloatArray:
        """Return the corners (p, 3) of the face skin, mm."""
        return self.mesh.vertices[np.unique(self.mesh.faces[self.face_skin])]


@cache
def heads() -> Heads:
    """Return the sample's true heads."""
    return Heads.load(resources.sample_path("truth.npz"))


@cache
def true_scan(name: str) -> TrueScan:
    """Return the truth of a bundled scan: one of ``SCANS``."""
    surface = heads().surface(name)
    mesh = TriangleMesh(surface.vertices, surface.faces, surface.uv, parts=surface.parts)
    fiducials = dict(heads().fiducials_of(name))
    return TrueScan(name, mesh, surface.face_skin, surface.parts["skin"], fiducials, heads().anatomy)


@cache
def bundled_scan(name: str) -> tuple[RangeImage, dict[str, tuple[float, float]]]:
    """Return the stored range image and fiducials of a bundled scan."""
    folder, file = ("stranger", "base") if name == STRANGER else ("subject", name)
    scan = read_scan(resources.sample_path(folder, f"{file}.json")).scan
    fiducials, _ = read_fiducials(resources.sample_path(folder, f"{file}_fiducials.json"))
    return scan, dict(fiducials)


def camera(name: str) -> Camera:
    """Return the camera of a bundled scan."""
    found = bundled_scan(name)[0].camera
    assert found is not None
    return found


def scheme_of(name: str) -> str:
    """Return the scheme, ``open`` or ``closed``, that a bundled scan's fiducials follow."""
    return "open" if name in OPEN else "closed"
