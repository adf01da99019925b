"""Weight curves from a GLB: the animation of its morph targets, sampled at even frames."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from engine.errors import InputError, some
from engine.files.glb_morphs import mean_name, target_names
from engine.files.glb_scene import numbers_of
from engine.files.gltf_data import GltfData
from engine.files.motion_file import MAX_FRAMES, MotionFile, choose_fps, settled_rate
from engine.mesh import FloatArray
from engine.motion import WeightCurves

_FORMS = ("LINEAR", "STEP", "CUBICSPLINE")
_MOST_VALUES = 200_000_000


def read_glb_animation(
    path: str | Path,
    *,
    unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    fps: float | None = None,
) -> MotionFile:
    """Read the weights animation of a GLB, from its first key to its last, sampled at even frames.

    Linear, stepped and cubic keys as glTF 2.0, appendix C, has them. Several meshes (face, teeth) may be driven:
    shapes of one name are taken from the mesh with the most of them. Without ``fps`` even keys are the frames
    themselves, at the rate that ``extras.fps`` states or the keys have; of uneven ones the usual distance counts. The
    rig inside is what the curves drive; unit and axes play no part. The curve of a mean, always 1, is left out.

    Raises
    ------
    InputError
        Without an animation of weights; on keys that do not go on in time, or arrays that do not fit.
    """
    path = Path(path)
    data = GltfData(path)
    number, animation, more = _chosen(data)
    where = f"animations[{number}]"
    tracks = [_Track(data, where, channel, animation) for channel in _weight_channels(animation)]
    tracks.sort(key=lambda track: -len(track.names))
    times = np.concatenate([track.times for track in tracks])
    start, stop = float(times.min()), float(times.max())
    named, keyed, said_so = _key_rate(tracks, _stated_rate(animation))
    rate, said, guessed = choose_fps(str(path), fps, named)
    if named is not None and fps is None:
        said = said_so
    keyed = keyed and fps is None
    count = len(tracks[0].times) if keyed else round((stop - start) * rate) + 1
    names: dict[str, _Track] = {}
    for track in tracks:
        for name in track.names:
            if name != track.mean:
                names.setdefault(name, track)
    if not names:
        raise data.wrong(where, "drives no shape but the mean")
    if count > MAX_FRAMES or count * len(names) > _MOST_VALUES:
        raise data.wrong(where, f"lasts {stop - start:g} s, {count} frames", "cut it, or state a lower frame rate")
    times = tracks[0].times if keyed else start + np.arange(count) / rate
    sampled = {id(track): track.values if keyed else track.sample(times) for track in tracks}
    weights = np.column_stack([sampled[id(track)][:, track.names.index(name)] for name, track in names.items()])
    if not np.isfinite(weights).all():
        raise data.wrong(where, "holds weights that are not finite")
    warnings = [f"{some(more)}: other animations, passed over"] if more else []
    return MotionFile(
        WeightCurves(tuple(names), weights, rate),
        "weights",
        "glb",
        "",
        f"{said}; from {start:g} to {stop:g} s, the rig inside is the driver",
        (path,),
        up="",
        forward="",
        guessed=("fps",) if guessed else (),
        warnings=tuple(warnings),
    )


class _Track:
    """The keys of one mesh's weights: ``times`` (k,), ``values`` (k, n), and tangents of cubic ones."""

    def __init__(self, data: GltfData, where: str, channel: dict[str, Any], animation: dict[str, Any]) -> None:
        node = data.item("nodes", channel["target"].get("node"))
        self.names, self.mean = _names(data, node.get("mesh"))
        samplers = animation.get("samplers")
        index = channel.get("sampler")
        if not isinstance(samplers, list) or not isinstance(index, int) or not 0 <= index < len(samplers):
            raise data.wrong(where, f"there is no sampler {str(index)[:20]}")
        sampler = samplers[index] if isinstance(samplers[index], dict) else {}
        where = f"{where}.samplers[{index}]"
        self.form = sampler.get("interpolation", "LINEAR")
        if self.form not in _FORMS:
            raise data.wrong(where, f"interpolates by {str(self.form)[:20]!r}")
        self.times = numbers_of(*data.accessor(sampler.get("input"), ("SCALAR",)))[:, 0]
        values = numbers_of(*data.accessor(sampler.get("output"), ("SCALAR",)))[:, 0]
        each = 3 if self.form == "CUBICSPLINE" else 1
        keys, count = len(self.times), len(self.names)
        if not keys or len(values) != keys * count * each:
            problem = f"has {len(values)} values for {keys} keys of {count} shapes"
            raise data.wrong(where, problem)
        if not np.isfinite(self.times).all() or (np.diff(self.times) <= 0).any():
            raise data.wrong(where, "its keys do not go on in time")
        table = values.reshape(keys, each, count)
        self.values = table[:, each // 2]
        self.tangents = (table[:, 0], table[:, 2]) if each == 3 else None

    def sample(self, times: FloatArray) -> FloatArray:
        """Return the weights (L, n) at times; the first and last key hold outside."""
        if len(self.times) == 1:
            return np.repeat(self.values, len(times), axis=0)
        times = np.clip(times, self.times[0], self.times[-1])
        # A time a rounding error before its key belongs to the key: a stepped curve would show the frame before.
        close = 1e-6 * max(float(np.diff(self.times).min()), 1e-9)
        left = np.clip(np.searchsorted(self.times, times + close, side="right") - 1, 0, len(self.times) - 2)
        span = self.times[left + 1] - self.times[left]
        share = np.clip((times - self.times[left]) / span, 0.0, 1.0)[:, None]
        first, last = self.values[left], self.values[left + 1]
        if self.form == "STEP":
            return np.where(share >= 1, last, first)
        if self.tangents is None:
            return first + share * (last - first)
        leaving, arriving = self.tangents[1][left] * span[:, None], self.tangents[0][left + 1] * span[:, None]
        square, cube = share**2, share**3
        curve: FloatArray = (
            (2 * cube - 3 * square + 1) * first
            + (cube - 2 * square + share) * leaving
            + (3 * square - 2 * cube) * last
            + (cube - square) * arriving
        )
        return curve


def _stated_rate(animation: dict[str, Any]) -> float | None:
    extras = animation.get("extras")
    fps = extras.get("fps") if isinstance(extras, dict) else None
    usable = isinstance(fps, int | float) and not isinstance(fps, bool) and np.isfinite(fps) and 0 < fps <= 1e5
    return float(fps) if usable and fps is not None else None


def _key_rate(tracks: list[_Track], stated: float | None) -> tuple[float | None, bool, str]:
    """Return the rate of the keys, whether they are the frames themselves (even, alike on all meshes), and in words."""
    times = tracks[0].times
    steps = np.diff(times)
    if not len(steps):
        return stated, stated is not None, "" if stated is None else f"{stated:g} frames a second, as in the file"
    usual, each = float(np.median(steps)), float(times[-1] - times[0]) / len(steps)
    grid = times[0] + each * np.arange(len(times))
    alike = all(len(t.times) == len(times) and np.abs(t.times - times).max() < 0.05 * each for t in tracks)
    if alike and each >= 1e-5 and bool((np.abs(times - grid) < 0.05 * each).all()):
        if stated is not None and abs(stated * each - 1) <= max(1e-3, float(np.spacing(np.float32(times[-1]))) / each):
            return stated, True, f"{stated:g} frames a second, as in the file; its keys are the frames"
        rate, snapped = settled_rate(1 / each, 1e-3)
        near = f" (measured: {1 / each:.6g})" if snapped else ""
        return rate, True, f"{rate:g} frames a second{near}; its keys are the frames"
    if stated is not None:
        return stated, False, f"{stated:g} frames a second, as in the file"
    even = bool((np.abs(steps / usual - np.rint(steps / usual)) < 0.05).all())
    if not even or not 5 <= 1 / usual <= 1000:
        return None, False, ""
    measured = float(np.rint(steps / usual).sum()) / float(times[-1] - times[0])
    rate = settled_rate(measured, 1e-3)[0]
    return rate, False, f"{rate:g} frames a second, the distance of its keys"


def has_weight_animation(data: GltfData) -> bool:
    """Return whether a GLB animates weights."""
    return any(_weight_channels(animation) for animation in data.items("animations") if isinstance(animation, dict))


def _chosen(data: GltfData) -> tuple[int, dict[str, Any], list[str]]:
    found = []
    for number, animation in enumerate(data.items("animations")):
        if isinstance(animation, dict) and _weight_channels(animation):
            found.append((number, animation, str(animation.get("name", f"animation {number + 1}"))[:60]))
    if not found:
        problem = "has no animation of weights"
        raise InputError(str(data.path), problem, "export the shape keys' animation, or give curves beside it")
    number, animation, _ = found[0]
    return number, animation, [name for _, _, name in found[1:]]


def _weight_channels(animation: dict[str, Any]) -> list[dict[str, Any]]:
    channels = animation.get("channels")
    if not isinstance(channels, list):
        return []
    return [
        channel
        for channel in channels[:1000]
        if isinstance(channel, dict)
        and isinstance(channel.get("target"), dict)
        and channel["target"].get("path") == "weights"
    ]


def _names(data: GltfData, index: Any) -> tuple[list[str], str | None]:
    """Return the names of a mesh's targets as rigs are read, and which of them is the mean."""
    mesh = data.item("meshes", index)
    primitives = mesh.get("primitives")
    first = primitives[0] if isinstance(primitives, list) and primitives else {}
    targets = first.get("targets") if isinstance(first, dict) else None
    if not isinstance(targets, list) or not targets:
        raise data.wrong(f"meshes[{index}]", "has no targets although its weights are animated")
    return target_names(data, index, mesh, first, len(targets))[0], mean_name(mesh)
