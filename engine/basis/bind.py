"""The steps of binding a clip to a face, one after the other."""

from __future__ import annotations

import numpy as np

from engine.basis.binding import BoundMarkers, MarkerBinding, Pairs
from engine.basis.gaps import FilledMarkers, fill_gaps
from engine.basis.head import HeadMotion, head_motion
from engine.basis.place import Surface, place_by_pairs, place_on_face
from engine.errors import InputError, some
from engine.mesh import FloatArray, TriangleMesh
from engine.motion import MarkerClip
from engine.progress import Progress

_HEAD_MOVES_MM = 10.0
_SMALLEST_SPAN, _LARGEST_SPAN = 0.01, 5.0


def bound(
    mesh: TriangleMesh,
    clip: MarkerClip,
    pairs: Pairs | None,
    head: tuple[str, ...],
    rest_frame: int | None,
    scale: bool,
    farthest_mm: float,
    longest_gap_s: float,
    progress: Progress,
) -> BoundMarkers:
    """Return the clip bound to the mesh; see ``engine.basis.markers.bind_markers``."""
    _check_labels(clip, pairs, head)
    if rest_frame is not None and not 0 <= rest_frame < len(clip):
        raise InputError("rest frame", f"{rest_frame + 1} of {len(clip)}", "choose a frame of the clip")
    warnings: list[str] = []
    progress(0.0, "following the head")
    face = [k for k, label in enumerate(clip.labels) if label not in set(head)]
    if len(face) < 3:
        raise InputError("markers", f"{len(face)} are left for the face", "choose fewer head markers")
    poses = head_motion(clip, head, rest_frame) if head else None
    positions = clip.positions[:, face] if poses is None else poses.remove(clip.positions[:, face])
    if poses is not None:
        warnings += _about_head(poses)
    progress(0.3, "filling gaps")
    filled = fill_gaps(positions, round(longest_gap_s * clip.fps))
    labels = [clip.labels[face[k]] for k in filled.markers]
    left_out = [clip.labels[face[k]] for k in range(len(face)) if k not in set(filled.markers.tolist())]
    warnings += _about_gaps(filled, left_out, clip)
    if poses is None:
        warnings += _about_no_head(filled.positions)
    rest_index = _rest_index(filled, positions, rest_frame, warnings)
    rest = filled.positions[rest_index]
    if not scale:
        _check_size(rest, mesh)
    progress(0.6, "finding the face")
    pairs_used = tuple(pair for pair in pairs or () if pair.label in labels)
    lost = [pair.label for pair in pairs or () if pair.label not in labels and pair.label not in head]
    if lost:
        warnings.append(f"{some(lost)}: paired, but hardly ever seen")
    surface = Surface.of(mesh)
    targets = _targets(mesh, pairs_used)
    if pairs is not None:
        own = [labels.index(pair.label) for pair in pairs_used]
        placement = place_by_pairs(rest[own], targets, scale)
        unpaired = [label for k, label in enumerate(labels) if k not in own]
        if unpaired:
            warnings.append(f"{some(unpaired)}: not paired, bound to the nearest surface point")
    else:
        placement = place_on_face(rest, mesh, scale)
    progress(0.9, "binding")
    binding = _binding(mesh, surface, labels, placement.apply(rest), pairs_used, targets)
    far = [f"{label} {d:.0f}" for label, d in zip(labels, binding.distance_mm, strict=True) if d > farthest_mm]
    if far:
        warnings.append(f"further than {farthest_mm:g} mm from the face: {some(far)} mm")
    captured = placement.apply(positions[filled.frames][:, filled.markers])
    displacements = placement.turn(filled.positions - rest)
    return BoundMarkers(
        binding,
        displacements,
        clip.fps,
        captured,
        placement,
        filled.frames,
        head=None if poses is None else poses.at(filled.frames).seen_from(placement),
        head_labels=head,
        rest_frame=int(filled.frames[rest_index]),
        filled=filled.short + filled.long,
        filled_short=filled.short,
        filled_long=filled.long,
        left_out=tuple(left_out),
        head_filled=0 if poses is None else int(poses.filled[filled.frames].sum()),
        warnings=tuple(warnings),
    )


def _check_size(rest: FloatArray, mesh: TriangleMesh) -> None:
    """Markers many times as large as the face, or a small part of it, were read in a wrong unit."""
    markers, face = (float(np.ptp(points, axis=0).max()) for points in (rest, mesh.vertices))
    if not _SMALLEST_SPAN * face <= markers <= _LARGEST_SPAN * face:
        problem = f"span {markers:.4g} mm, the face {face:.4g} mm"
        raise InputError("markers", problem, "choose another unit (--unit), or fit the size (--scale)")


def _check_labels(clip: MarkerClip, pairs: Pairs | None, head: tuple[str, ...]) -> None:
    unknown = [pair.label for pair in pairs or () if pair.label not in clip.labels]
    if unknown:
        raise InputError(f"pairs, marker {some(unknown)}", "is not in the clip", f"it has {some(clip.labels)}")
    both = [pair.label for pair in pairs or () if pair.label in head]
    if both:
        raise InputError(f"pairs, marker {some(both)}", "is a head marker too", "pair only markers on the face")
    paired = [pair.label for pair in pairs or ()]
    double = sorted({label for label in paired if paired.count(label) > 1})
    if double:
        raise InputError(f"pairs, marker {some(double)}", "is paired twice", "give one pair a marker")


def _rest_index(filled: FilledMarkers, positions: FloatArray, rest_frame: int | None, warnings: list[str]) -> int:
    frames = filled.frames
    if rest_frame is not None:
        place = int(np.abs(frames - rest_frame).argmin())
        if frames[place] != rest_frame:
            warnings.append(f"frame {rest_frame + 1} shows too little: {frames[place] + 1} is taken for rest")
        return place
    shown = np.isfinite(positions[frames][:, filled.markers]).all(axis=2).sum(axis=1)
    return int(shown.argmax())


def _targets(mesh: TriangleMesh, pairs: Pairs) -> FloatArray:
    targets = np.empty((len(pairs), 3))
    for k, pair in enumerate(pairs):
        if isinstance(pair.target, int):
            if not 0 <= pair.target < len(mesh.vertices):
                problem = f"vertex {pair.target} is outside 0..{len(mesh.vertices) - 1}"
                raise InputError(f"pairs, marker {pair.label}", problem, "give a vertex of the neutral face")
            targets[k] = mesh.vertices[pair.target]
        else:
            targets[k] = pair.target
    return targets


def _binding(
    mesh: TriangleMesh,
    surface: Surface,
    labels: list[str],
    rest: FloatArray,
    pairs: Pairs,
    targets: FloatArray,
) -> MarkerBinding:
    wanted = rest.copy()
    own = [labels.index(pair.label) for pair in pairs]
    wanted[own] = targets
    near, faces = surface.nearest(wanted)
    weights = barycentric(near, mesh.vertices[mesh.faces[faces]])
    for k, pair in zip(own, pairs, strict=True):
        if isinstance(pair.target, int):
            at = np.argwhere(mesh.faces == pair.target)
            if not len(at):
                problem = f"vertex {pair.target} is in no face"
                raise InputError(f"pairs, marker {pair.label}", problem, "give a vertex on the skin")
            faces[k], weights[k] = at[0, 0], np.eye(3)[at[0, 1]]
            near[k] = mesh.vertices[pair.target]
    distance = np.linalg.norm(rest - near, axis=1)
    return MarkerBinding(tuple(labels), faces, weights, rest, distance)


def barycentric(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return barycentric coordinates (K, 3) of points in their triangles (K, 3, 3); non-negative, rows sum to 1."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    offset = points - corners[:, 0]
    gram = np.stack([np.stack([_dot(first, first), _dot(first, second)], 1),
                     np.stack([_dot(first, second), _dot(second, second)], 1)], 1)  # fmt: skip
    right = np.stack([_dot(first, offset), _dot(second, offset)], axis=1)
    solved = np.einsum("kij,kj->ki", np.linalg.pinv(gram), right)
    weights = np.clip(np.column_stack([1 - solved.sum(axis=1), solved]), 0.0, 1.0)
    normalised: FloatArray = weights / weights.sum(axis=1, keepdims=True)
    return normalised


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = np.einsum("ki,ki->k", a, b)
    return product


def _about_head(poses: HeadMotion) -> list[str]:
    said = []
    if poses.filled.any():
        said.append(
            f"{int(poses.filled.sum())} of {len(poses)} head poses interpolated: fewer than 3 head markers there"
        )
    if poses.strays:
        said.append(f"{poses.strays} positions of head markers strayed from the others and had no say")
    return said


def _about_gaps(filled: FilledMarkers, left_out: list[str], clip: MarkerClip) -> list[str]:
    said = []
    total = filled.positions.shape[0] * filled.positions.shape[1]
    if filled.short or filled.long:
        said.append(
            f"{filled.short} positions filled between neighbouring frames, {filled.long} from the other markers "
            f"({100 * (filled.short + filled.long) / total:.1f} %; longest gap {filled.longest} frames)"
        )
    if left_out:
        said.append(f"{some(left_out)}: seen in less than a tenth of the frames, left out")
    if len(filled.frames) < len(clip):
        said.append(f"{len(clip) - len(filled.frames)} of {len(clip)} frames show too few markers and were left out")
    return said


def _about_no_head(positions: FloatArray) -> list[str]:
    middle = np.median(positions, axis=1)
    moves = float(np.percentile(np.linalg.norm(middle - np.median(middle, axis=0), axis=1), 95))
    if moves > _HEAD_MOVES_MM:
        return [f"the whole face moves by {moves:.0f} mm and no head markers are chosen: choose some"]
    return []
