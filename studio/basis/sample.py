"""The performance and the hand-sculpted rigs that come with the program. No Qt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import resources
from engine.progress import Progress, part, silent
from studio.basis.loading import LoadedMotion, LoadedRig, load_motion, load_rig
from studio.basis.options import MotionOptions

FOLDER = "performance"
HAND, OTHER = "animator_24.npz", "mpfb_34.npz"
"""The performer's own units as an animator sculpted them, and another artist's expression units."""
CLIP, PAIRS = "speech_emotion.c3d", "MARKERS.json"
SKIN = ("subject", "skin.jpg")
"""What the scanned subject's skin looks like; the rigs have its chart."""
HEAD_PREFIX = "head_"


def sample_path(name: str) -> Path:
    """Return a file of the sample performance."""
    return resources.sample_path(FOLDER, name)


def load_sample(progress: Progress = silent) -> tuple[LoadedRig, LoadedMotion]:
    """Read the animator's rig and the recorded performance, bound by its pairs and freed of the head's motion."""
    from engine.files.images import read_image
    from engine.files.marker_pairs import read_marker_pairs

    rig = painted(load_rig(sample_path(HAND), part(progress, 0.0, 0.4)), read_image(resources.sample_path(*SKIN)))
    pairs = {pair.label: pair.target for pair in read_marker_pairs(sample_path(PAIRS))}
    first = load_motion(sample_path(CLIP), None, part(progress, 0.4, 1.0))
    labels = tuple(getattr(first.data, "labels", ()))
    head = tuple(label for label in labels if label.startswith(HEAD_PREFIX))
    return rig, laid(first, MotionOptions(pairs=pairs, head=head))


def painted(loaded: LoadedRig, picture: NDArray[np.uint8]) -> LoadedRig:
    """Return a rig with a picture (H, W, 3) uint8 on its chart."""
    from dataclasses import replace

    content = replace(loaded.content, texture=picture)
    return replace(loaded, item=replace(loaded.item, content=content.key), content=content)


def laid(loaded: LoadedMotion, options: MotionOptions) -> LoadedMotion:
    """Return a performance that was read, with other options of how it lies on the rig."""
    from dataclasses import replace

    return replace(loaded, item=replace(loaded.item, options=options))
