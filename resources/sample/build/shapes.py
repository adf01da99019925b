"""The two people of the sample, and the mouths of one of them, mixed from the wheel's shapes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from resources.sample.build.source import FloatArray, HeadSource

EYES_AT = np.array([0.0, 21.5, 70.4])
"""Middle between the eyeballs in the head's own frame, mm: the frame starts near the middle of the head."""

SUBJECT = {
    "macrodetails/caucasian-female-young": 1.0,
    "macrodetails/universal-female-young-averagemuscle-averageweight": 1.0,
}
STRANGER = {
    "macrodetails/african-male-young": 0.45,
    "macrodetails/african-male-old": 0.3,
    "macrodetails/asian-male-old": 0.25,
    "macrodetails/universal-male-young-averagemuscle-averageweight": 1.0,
    "head/head-square": 0.25,
    "head/head-fat-incr": 0.25,
    "nose/nose-width3-incr": 0.15,
    "nose/nose-hump-incr": 0.35,
    "chin/chin-prominent-incr": 0.35,
    "chin/chin-height-incr": 0.25,
    "forehead/forehead-scale-vert-incr": 0.1,
    "mouth/mouth-scale-horiz-incr": 0.2,
    "mouth/mouth-lowerlip-volume-incr": 0.25,
    "eyes/l-eye-height2-incr": 0.4,
    "eyes/r-eye-height2-incr": 0.4,
}
# Lids as of somebody looking at the scanner at rest; the sculpted neutral stares.
RESTING_LIDS = {"eyeBlinkLeft": 0.04, "eyeBlinkRight": 0.04, "eyeSquintLeft": 0.06, "eyeSquintRight": 0.06}
# The sculpted neutral's lips stand a little apart.
CLOSED_LIPS = {"jawOpen": -0.03, "mouth-retraction": 0.3, "mouthPucker": 0.3}
# part: (scale of x, shift y, shift z): teeth that close in a bite behind the lips, tongue low in the mouth
MOUTH_PARTS = {"teeth_upper": (0.84, -4.6, -3.0), "teeth_lower": (0.82, 0.8, -3.4), "tongue": (0.90, -9.0, -10.0)}

POSES: dict[str, dict[str, float]] = {
    "car": {
        "jawOpen": 0.62,
        "mouthLowerDown": 0.3,
        "mouthUpperUp": 0.7,
        "mouth-retraction": -0.25,
        "mouthStretch": 0.25,
    },
    "man": {"jawOpen": 0.30, "mouthSmile": 0.12, "mouthStretch": 0.35, "mouthUpperUp": 0.9, "mouthLowerDown": 0.5},
    "she": {
        "mouthFunnel": 0.7,
        "mouth-protusion": 0.24,
        "mouthUpperUp": 0.4,
        "mouthLowerDown": 0.1,
        "mouth-retraction": -0.22,
        "mouth-pursing": 0.1,
    },
    "eel": {
        "jawOpen": 0.05,
        "mouth-retraction": 0.35,
        "mouthSmile": 0.3,
        "mouthStretch": 0.35,
        "mouthUpperUp": 1.0,
        "mouthLowerDown": 1.0,
        "mouth-part-later": 0.15,
    },
    "too": {"jawOpen": 0.07, "mouth-pursing": 0.4, "mouthPucker": 0.4, "mouthFunnel": 0.55, "mouth-retraction": -0.3},
}
BOTH_SIDES = ("mouthLowerDown", "mouthUpperUp", "mouthSmile", "mouthStretch")


def neutral(source: HeadSource, identity: Mapping[str, float]) -> FloatArray:
    """Return somebody's resting face with closed lips, on the original vertices in the head's frame, mm."""
    positions = source.positions + sum(weight * source.target(name) for name, weight in identity.items())
    positions = positions + expression(source, RESTING_LIDS)
    lips = expression(source, CLOSED_LIPS)
    for part, (scale, up, forward) in MOUTH_PARTS.items():
        own = source.used[np.unique(source.quads[part])]
        positions[own] = positions[own] * [scale, 1, 1] + [0, up, forward]
        lips[own] = 0
    placed: FloatArray = positions + lips + (EYES_AT - eyeballs(source, positions)[:, :3].mean(axis=0))
    return placed


def expression(source: HeadSource, weights: Mapping[str, float]) -> FloatArray:
    """Return the displacements (n, 3) of a mixture of expression units, mm."""
    total = np.zeros_like(source.positions)
    for name, weight in weights.items():
        for side in ("Left", "Right") if name in BOTH_SIDES else ("",):
            total += weight * source.unit(name + side)
    return total


def eyeballs(source: HeadSource, positions: FloatArray) -> FloatArray:
    """Return centre and radius (2, 4) of both eyeballs, subject's left first, set back behind the lids, mm."""
    balls = []
    for own in source.eye_vertices:
        low, high = positions[own].min(axis=0), positions[own].max(axis=0)
        radius = (high[0] - low[0]) / 2
        balls.append([*(low[:2] + high[:2]) / 2, high[2] - radius - 2.1, radius])
    return np.array(balls)
