"""From a few clicked points to the whole flat template on the picture: warp, fold-overs, proposals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial.distance import cdist

from engine.errors import InputError
from engine.geometry.normals import signed_areas
from engine.geometry.thin_plate import warp_operator
from engine.landmarks import LandmarkScheme, inside
from engine.mesh import FloatArray, IntArray, frozen
from engine.scan.lips import lip_guides
from engine.scan.template import FaceTemplate

Positions = Mapping[str, tuple[float, float]]
FEWEST_TO_WARP = 3
FEWEST_TO_PROPOSE = 5
STIFFNESS, CLICK_NOISE = 0.2, 3e-3


@dataclass(frozen=True, eq=False)
class TemplateWarp:
    """The template on the picture.

    ``vertices`` (N, 2) in pixels; ``folded`` (k,) the triangles that turned over; ``suspects`` the fiducials beside
    them, most likely culprit first; ``residual_px`` the largest distance of a template fiducial from its click.
    """

    vertices: FloatArray
    folded: IntArray
    suspects: tuple[str, ...]
    residual_px: float


def warp_template(template: FaceTemplate, scheme: str, fiducials: Positions) -> TemplateWarp:
    """Return ``template`` warped so that each fiducial lies on its pixel.

    Takes a fraction of a millisecond once the same names were warped before, so it can follow a drag.

    Parameters
    ----------
    template : FaceTemplate
        The flat face.
    scheme : str
        Its layout, ``closed`` or ``open``.
    fiducials : mapping of str to (x, y)
        Pixel positions by name, at least three, not all of the scheme's needed.

    Raises
    ------
    InputError
        On a name that the layout does not have, too few points, two at one place, or all on a line.

    Notes
    -----
    Yano & Harada 2009, section 3.1: thin-plate spline with r^2 log r. The lips' guides (``engine.scan.lips``) are ours.
    """
    layout = template.layout(scheme)
    names = _checked_names(template, scheme, fiducials)
    target = np.array([fiducials[name] for name in names], dtype=np.float64)
    vertices = _operator(template, scheme, names) @ target
    folded = np.flatnonzero(signed_areas(vertices, template.faces) <= 0)
    residual = np.linalg.norm(vertices[[layout.fiducials[name] for name in names]] - target, axis=1).max()
    return TemplateWarp(vertices, folded, _suspects(template, scheme, names, target, folded), float(residual))


def propose_fiducials(template: FaceTemplate, scheme: str, placed: Positions) -> dict[str, tuple[float, float]]:
    """Return a place for every fiducial of the scheme that is not among ``placed``.

    The template is laid over the placed points by a similarity; what is left is carried on by a stiff affine and
    thin-plate part, so that five points crowded around the brows do not throw the chin about. This step is ours.

    Raises
    ------
    InputError
        With fewer than five placed points, or as ``warp_template``.
    """
    layout = template.layout(scheme)
    names = _checked_names(template, scheme, placed)
    if len(names) < FEWEST_TO_PROPOSE:
        raise InputError(
            "fiducials", f"{len(names)} are placed", f"place {FEWEST_TO_PROPOSE} before asking for the rest"
        )
    rest = [name for name in layout.fiducials if name not in placed]
    source = layout.vertices[[layout.fiducials[name] for name in names]]
    where = layout.vertices[[layout.fiducials[name] for name in rest]].reshape(-1, 2)
    target = np.array([placed[name] for name in names], dtype=np.float64)

    centre, size = source.mean(axis=0), float(np.ptp(layout.vertices, axis=0).max())
    near, far = (source - centre) / size, (where - centre) / size
    base = _similarity(near, target)
    left = target - _apply_similarity(base, near)
    # A Gaussian process whose covariance is a stiff affine part and a smooth local one.
    kernel = STIFFNESS * near @ near.T + 0.05 * np.exp(-0.5 * (cdist(near, near) / 0.25) ** 2)
    reach = STIFFNESS * far @ near.T + 0.05 * np.exp(-0.5 * (cdist(far, near) / 0.25) ** 2)
    weights = np.linalg.solve(kernel + CLICK_NOISE * np.eye(len(names)), left)
    places = _apply_similarity(base, far) + reach @ weights
    return {name: (float(x), float(y)) for name, (x, y) in zip(rest, places, strict=True)}


def mirror_proposals(scheme: LandmarkScheme, placed: Positions) -> dict[str, tuple[float, float]]:
    """Return places for points whose mirror partner is placed, reflected in the face's mid-line.

    The line is fitted to the mid-line points and to the middles of complete pairs.

    Raises
    ------
    InputError
        When fewer than two such points are placed.
    """
    on_line = [placed[mark.name] for mark in scheme if mark.mirror == mark.name and mark.name in placed]
    for mark in scheme:
        if mark.name < mark.mirror and mark.name in placed and mark.mirror in placed:
            on_line.append(tuple(0.5 * (np.array(placed[mark.name]) + np.array(placed[mark.mirror]))))
    line = np.array(on_line, dtype=np.float64).reshape(-1, 2)
    if len(line) < 2 or np.ptp(line, axis=0).max() < 1.0:
        raise InputError("mid-line", "fewer than two points lie on it", "place forehead, nose or chin first")
    centre = line.mean(axis=0)
    along = np.linalg.svd(line - centre)[2][0]
    reflect = 2 * np.outer(along, along) - np.eye(2)
    found = {}
    for mark in scheme:
        if mark.mirror in placed and mark.name not in placed:
            x, y = centre + reflect @ (np.array(placed[mark.mirror]) - centre)
            found[mark.name] = (float(x), float(y))
    return found


def check_inside(fiducials: Positions, width: int, height: int) -> None:
    """Raise ``InputError`` for a fiducial outside the picture or not a finite number."""
    for name, (x, y) in fiducials.items():
        if not (np.isfinite(x) and np.isfinite(y)):
            raise InputError(f"fiducial {name}", "has no place", "place it first")
        if not inside(x, y, width, height):
            raise InputError(
                f"fiducial {name}", f"({x:.1f}, {y:.1f}) lies outside the {width} x {height} picture", "move it inside"
            )


def _checked_names(template: FaceTemplate, scheme: str, fiducials: Positions) -> tuple[str, ...]:
    layout = template.layout(scheme)
    unknown = [name for name in fiducials if name not in layout.fiducials]
    if unknown:
        raise InputError(
            f"fiducial {unknown[0]}", f"is not in the {scheme} scheme", "rename it or choose another scheme"
        )
    names = tuple(name for name in layout.fiducials if name in fiducials)
    if len(names) < FEWEST_TO_WARP:
        raise InputError("fiducials", f"{len(names)} are placed", f"place at least {FEWEST_TO_WARP}")
    target = np.array([fiducials[name] for name in names], dtype=np.float64)
    if not np.isfinite(target).all():
        bad = names[int(np.flatnonzero(~np.isfinite(target).all(axis=1))[0])]
        raise InputError(f"fiducial {bad}", "is not a finite position", "place it again")
    distance = cdist(target, target)
    distance[np.diag_indices(len(names))] = np.inf
    first, second = np.unravel_index(int(distance.argmin()), distance.shape)
    if distance[first, second] < 1e-3:
        raise InputError(f"fiducials {names[first]} and {names[second]}", "lie at one place", "move one of them")
    spread = np.linalg.svd(target - target.mean(axis=0), compute_uv=False)
    if spread[-1] <= 1e-3 * spread[0]:
        raise InputError("fiducials", "all lie on one line", "check the order of x and y, or place them again")
    return names


@lru_cache(maxsize=256)
def _operator(template: FaceTemplate, scheme: str, names: tuple[str, ...]) -> FloatArray:
    vertices, carried = lip_guides(template, scheme, names)
    layout = template.layout(scheme)
    nodes = [layout.fiducials[name] for name in names] + vertices
    return frozen(
        warp_operator(layout.vertices[nodes], layout.vertices) @ np.vstack([np.eye(len(names)), carried]), "float64"
    )


def _suspects(
    template: FaceTemplate, scheme: str, names: tuple[str, ...], target: FloatArray, folded: IntArray
) -> tuple[str, ...]:
    """Name the fiducials nearest to folded triangles, the one that fits the others worst first."""
    if not len(folded):
        return ()
    layout = template.layout(scheme)
    source = layout.vertices[[layout.fiducials[name] for name in names]]
    middles = layout.vertices[template.faces[folded]].mean(axis=1)
    beside = np.unique(cdist(middles, source).argsort(axis=1)[:, :2])
    surprise = {}
    for index in beside:
        others = np.delete(np.arange(len(names)), index)
        if len(others) < FEWEST_TO_WARP:
            return tuple(names[k] for k in beside)
        expected = warp_operator(source[others], source[index : index + 1]) @ target[others]
        surprise[names[index]] = float(np.linalg.norm(expected[0] - target[index]))
    return tuple(sorted(surprise, key=lambda name: -surprise[name])[:4])


def _similarity(source: FloatArray, target: FloatArray) -> tuple[complex, complex]:
    """Return (a, b) of the least-squares similarity w = a z + b, with points as complex numbers."""
    z, w = source[:, 0] + 1j * source[:, 1], target[:, 0] + 1j * target[:, 1]
    zc, wc = z - z.mean(), w - w.mean()
    a = complex((np.conj(zc) @ wc) / (np.conj(zc) @ zc))
    return a, complex(w.mean() - a * z.mean())


def _apply_similarity(similarity: tuple[complex, complex], points: FloatArray) -> FloatArray:
    moved = similarity[0] * (points[:, 0] + 1j * points[:, 1]) + similarity[1]
    return np.stack([moved.real, moved.imag], axis=1)
