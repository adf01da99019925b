"""What Blender reads of a rig we wrote: ``make test-clients``; it runs in an environment of its own that has ``bpy``.

``python -m tests.clients.blender RIG.glb TRUTH.npz`` imports the GLB as an artist would and compares names, neutral
face and displacements with the truth (an ``.npz`` rig), vertex by vertex through the attribute ``_SOURCE``.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

TOLERANCE_MM = 1e-3
"""Float32 metres of a head are good to 1e-5 mm."""


def main(rig: str, truth: str) -> int:
    """Compare, print what was found, and return 1 where Blender has another rig."""
    import bpy  # type: ignore[import-not-found, unused-ignore]

    wanted = np.load(truth, allow_pickle=False)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=rig)
    worst, seen = 0.0, set()
    for thing in bpy.data.objects:
        if thing.type != "MESH":
            continue
        keys = thing.data.shape_keys.key_blocks
        source = _values(thing.data.attributes["_SOURCE"].data, "value", 1).astype(int).ravel()
        names = [key.name for key in keys][1:]
        if names != [str(name) for name in wanted["names"]]:
            print(f"{thing.name}: shape keys are {names}")
            return 1
        base = _values(keys[0].data, "co", 3)
        worst = max(worst, float(np.abs(_ours(base) - wanted["neutral"][source]).max()))
        for key, shape in zip(list(keys)[1:], wanted["displacements"], strict=True):
            moved = _ours(_values(key.data, "co", 3)) - _ours(base)
            worst = max(worst, float(np.abs(moved - shape[source]).max()))
        seen |= set(source.tolist())
    print(
        f"Blender {bpy.app.version_string}: {len(wanted['names'])} shapes, {len(seen)} vertices, off by {worst:.1e} mm"
    )
    return int(worst > TOLERANCE_MM or len(seen) != len(wanted["neutral"]))


def _values(data: Any, name: str, width: int) -> Any:
    found = np.empty(len(data) * width, dtype=np.float32)
    data.foreach_get(name, found)
    return found.reshape(-1, width).astype(np.float64)


def _ours(points: Any) -> Any:
    """Return Blender's metres, +Z up, as mm, +Y up."""
    return np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1) * 1000.0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
