"""What the subject performs: weights of the 52 face units over 50 seconds, and soft tissue that follows late."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from resources.sample.build.source import FloatArray

FPS = 120.0
FRAMES = 6000
SEED = 7
LIVELY = 1.15
"""How far the performer goes beyond the fully sculpted unit."""

Pose = Mapping[str, float]
"""Amounts of units; a name of ``PAIRED`` stands for the left and the right one."""

PAIRED = {
    "smile": "mouthSmile", "frown": "mouthFrown", "stretch": "mouthStretch", "upperUp": "mouthUpperUp",
    "lowerDown": "mouthLowerDown", "sneer": "noseSneer", "cheeks": "cheekSquint", "squint": "eyeSquint",
    "wide": "eyeWide", "blink": "eyeBlink", "browDown": "browDown", "browOuterUp": "browOuterUp",
    "press": "mouthPress", "dimple": "mouthDimple",
}  # fmt: skip

VISEMES: dict[str, Pose] = {
    "-": {},
    "a": {"jawOpen": 0.24, "lowerDown": 0.30, "upperUp": 0.25, "stretch": 0.08},
    "e": {"jawOpen": 0.12, "stretch": 0.50, "smile": 0.10, "lowerDown": 0.40, "upperUp": 0.12},
    "i": {"jawOpen": 0.05, "stretch": 0.60, "smile": 0.18, "lowerDown": 0.25, "upperUp": 0.30},
    "o": {"jawOpen": 0.15, "mouthFunnel": 0.60, "mouthPucker": 0.15},
    "u": {"jawOpen": 0.06, "mouthPucker": 0.55, "mouthFunnel": 0.25},
    "m": {"press": 0.08, "mouthRollLower": 0.05, "frown": 0.08},
    "f": {"jawOpen": 0.03, "upperUp": 0.45, "mouthRollLower": 0.06},
    "s": {"jawOpen": 0.03, "lowerDown": 0.60, "upperUp": 0.35, "stretch": 0.25},
    "sh": {"jawOpen": 0.05, "mouthFunnel": 0.65, "upperUp": 0.30, "lowerDown": 0.25},
    "l": {"jawOpen": 0.12, "lowerDown": 0.25, "upperUp": 0.12},
    "r": {"jawOpen": 0.08, "mouthPucker": 0.32, "mouthFunnel": 0.28, "upperUp": 0.08},
    "t": {"jawOpen": 0.06, "lowerDown": 0.35, "upperUp": 0.12, "stretch": 0.10},
}
PHONE_S = 0.115
# (start in s, phones): what is said, roughly "my wife remembers she sealed ...", phone by phone.
SPEECH: tuple[tuple[float, str], ...] = (
    (15.2, "m a i f e i t r e m e m b e r s"),
    (17.9, "sh i s a l o f u l i t u d e"),
    (20.6, "l u k a t m i a m s o r i t o t e l i u"),
    (24.2, "s u t sh i l a f t a m o m e n t"),
    (27.0, "u o t e r f a l s o f e r t e r o k s"),
    (30.3, "i t i s r e l i a sh e i m i u s e"),
    (33.2, "o n o t a t a g e n p l i s"),
    (36.2, "r i t s a f u n i s t o r i i u n o"),
    (39.4, "m a m a f o r s u r s t e i h o m t u m o r o"),
)
# (start, rise, hold, fall in s, what): the range of motion first, then emotions while speaking.
GESTURES: tuple[tuple[float, float, float, float, Pose], ...] = (
    (1.0, 0.30, 0.25, 0.40, {"browInnerUp": 0.95, "browOuterUp": 0.9, "wide": 0.12}),
    (2.1, 0.30, 0.20, 0.35, {"browDown": 0.95, "squint": 0.10}),
    (3.0, 0.30, 0.15, 0.35, {"browInnerUp": 1.0}),
    (3.8, 0.25, 0.15, 0.30, {"browOuterUpLeft": 1.0, "browDownRight": 0.5}),
    (4.5, 0.25, 0.15, 0.30, {"browOuterUpRight": 1.0, "browDownLeft": 0.4}),
    (5.2, 0.25, 0.20, 0.30, {"cheeks": 0.9, "squint": 0.12}),
    (6.0, 0.20, 0.15, 0.30, {"cheekSquintLeft": 1.0, "eyeBlinkLeft": 0.9}),
    (6.7, 0.20, 0.15, 0.30, {"cheekSquintRight": 0.9, "eyeBlinkRight": 0.85}),
    (7.4, 0.25, 0.15, 0.30, {"sneer": 1.0, "upperUp": 0.4}),
    (8.1, 0.22, 0.12, 0.28, {"noseSneerLeft": 1.0, "mouthUpperUpLeft": 0.7}),
    (8.7, 0.22, 0.12, 0.28, {"noseSneerRight": 0.9, "mouthUpperUpRight": 0.8}),
    (9.3, 0.30, 0.20, 0.35, {"smile": 0.55, "cheeks": 0.25}),
    (10.1, 0.28, 0.12, 0.32, {"mouthSmileLeft": 0.65}),
    (10.8, 0.28, 0.12, 0.32, {"mouthSmileRight": 0.60}),
    (11.5, 0.28, 0.15, 0.32, {"frown": 1.0}),
    (12.2, 0.25, 0.10, 0.30, {"stretch": 1.0, "mouthFrownLeft": 0.3}),
    (12.9, 0.25, 0.12, 0.28, {"lowerDown": 1.0}),
    (13.5, 0.30, 0.15, 0.40, {"jawOpen": 0.50, "browInnerUp": 0.3}),
    (14.4, 0.22, 0.10, 0.30, {"mouthPucker": 0.80}),
    (15.5, 0.50, 1.60, 0.60, {"smile": 0.22, "cheeks": 0.30, "browOuterUp": 0.25}),
    (18.2, 0.45, 1.50, 0.50, {"browInnerUp": 0.55, "frown": 0.35}),
    (20.5, 0.55, 2.20, 0.60, {"browInnerUp": 0.85, "frown": 0.50, "browDown": 0.25}),
    (24.3, 0.25, 1.30, 0.50, {"smile": 0.38, "cheeks": 0.65, "squint": 0.10}),
    (26.9, 0.35, 2.40, 0.50, {"browDown": 0.90, "sneer": 0.50, "cheeks": 0.15}),
    (30.2, 0.30, 1.10, 0.45, {"browInnerUp": 0.70, "browOuterUp": 0.95, "wide": 0.15, "jawOpen": 0.06}),
    (31.9, 0.30, 0.70, 0.40, {"browOuterUpLeft": 0.9, "mouthSmileRight": 0.30, "browDownRight": 0.4}),
    (33.1, 0.25, 1.90, 0.45, {"browDown": 0.7, "sneer": 0.75, "stretch": 0.30}),
    (36.1, 0.40, 2.10, 0.60, {"smile": 0.30, "cheeks": 0.45, "browOuterUp": 0.35, "dimple": 0.06}),
    (39.3, 0.40, 1.50, 0.50, {"browInnerUp": 0.45, "mouthFrownRight": 0.4}),
    (42.3, 0.25, 0.50, 0.50, {"browOuterUp": 1.0, "browInnerUp": 0.9, "jawOpen": 0.35, "wide": 0.2}),
    (43.6, 0.30, 0.50, 0.40, {"sneer": 1.0, "mouthUpperUpLeft": 0.6, "browDown": 0.5, "mouthFrownLeft": 0.3}),
    (44.9, 0.40, 0.60, 0.60, {"frown": 0.9, "browInnerUp": 0.9, "mouthShrugLower": 0.08, "browDown": 0.3}),
    (46.6, 0.35, 1.10, 0.90, {"smile": 0.60, "cheeks": 0.80, "jawOpen": 0.12, "upperUp": 0.3, "squint": 0.12}),
)
# Small things a face does beside: unit, largest amount.
FIDGETS = {
    "mouthLeft": 0.011, "mouthRight": 0.011, "jawLeft": 0.011, "jawForward": 0.008, "mouthRollUpper": 0.011,
    "mouthShrugUpper": 0.013, "cheekPuff": 0.006, "mouthClose": 0.002,
    "eyeLookUpLeft": 0.021, "eyeLookUpRight": 0.021,
    "eyeLookDownLeft": 0.021, "eyeLookDownRight": 0.021, "eyeLookInLeft": 0.063, "eyeLookOutRight": 0.063,
}  # fmt: skip


def weights(names: Sequence[str], seed: int = SEED) -> FloatArray:
    """Return the weights (6000, n) of face units, by name: speech over emotions, blinks and small fidgets."""
    rng = np.random.default_rng(seed)
    time = np.arange(FRAMES) / FPS
    total = np.zeros((FRAMES, len(names)))
    place = {name: k for k, name in enumerate(names)}

    def add(curve: FloatArray, pose: Pose, uneven: float) -> None:
        for name, amount in pose.items():
            if name not in PAIRED:
                total[:, place[name]] += amount * curve
                continue
            lean = 1 + uneven * rng.standard_normal()
            late = int(rng.integers(0, 4))
            total[:, place[PAIRED[name] + "Left"]] += amount * lean * curve
            total[:, place[PAIRED[name] + "Right"]] += amount * (2 - lean) * np.roll(curve, late)

    for start, rise, hold, fall, pose in GESTURES:
        add(_swell(time, start, rise, hold, fall), pose, 0.12)
    for start, said in SPEECH:
        for viseme, curve in _speech(time, start, said.split(), rng):
            add(curve, VISEMES[viseme], 0.06)
    for start in _blinks(rng):
        add(_swell(time, start, 0.07, 0.02, 0.11), {"blink": float(rng.uniform(0.85, 1.0))}, 0.02)
    for name, most in FIDGETS.items():
        total[:, place[name]] += most * np.clip(_drift(rng, 1.4), 0, None)
    for pair in ("browOuterUp", "browDown"):
        for side in ("Left", "Right"):
            total[:, place[pair + side]] += 0.04 * np.clip(_drift(rng, 1.0), 0, None)
    total *= 1 + 0.04 * np.stack([_drift(rng, 2.0) for _ in names], axis=1)
    # The clip begins at rest: that is what markers are bound by.
    return np.asarray(np.clip(LIVELY * total, 0.0, LIVELY) * _swell(time, 0.3, 0.6, 1e3, 1.0)[:, None])


def head_motion(seed: int = SEED) -> tuple[FloatArray, FloatArray]:
    """Return rotation vectors (6000, 3) in radians and translations (6000, 3) in mm of the head: nods, turns, sway."""
    rng = np.random.default_rng(seed + 1)
    time = np.arange(FRAMES) / FPS
    turn = np.stack([size * _drift(rng, slow) for size, slow in ((0.06, 0.9), (0.09, 1.1), (0.035, 1.3))], axis=1)
    for start, rise, hold, fall, axis, amount in (
        (16.4, 0.25, 0.05, 0.3, 0, 0.16), (17.1, 0.22, 0.05, 0.3, 0, 0.10), (22.0, 0.4, 0.3, 0.5, 2, 0.12),
        (25.0, 0.25, 0.0, 0.3, 0, -0.18), (28.0, 0.2, 0.05, 0.25, 1, 0.22), (28.5, 0.2, 0.05, 0.25, 1, -0.22),
        (29.0, 0.2, 0.05, 0.25, 1, 0.18), (34.0, 0.2, 0.0, 0.22, 0, 0.15), (42.3, 0.25, 0.3, 0.4, 0, -0.14),
        (47.0, 0.3, 0.1, 0.3, 0, -0.16), (47.8, 0.3, 0.1, 0.5, 0, 0.12),
    ):  # fmt: skip
        turn[:, axis] += amount * _swell(time, start, rise, hold, fall)
    sway = np.stack([size * _drift(rng, 1.6) for size in (9.0, 4.0, 7.0)], axis=1)
    ease = _swell(time, 0.6, 1.2, 60.0, 1.0)[:, None]
    return turn * ease, sway * ease


def late_tissue(drives: FloatArray, hertz: Sequence[float], damping: float = 0.22) -> FloatArray:
    """Return what soft tissue (L, k) does when ``drives`` (L, k) shake it: damped springs that stiffen, RMS 1."""
    late = np.zeros_like(drives)
    for k, frequency in enumerate(hertz):
        omega, step = 2 * np.pi * frequency, 1 / FPS
        place = speed = 0.0
        for frame, drive in enumerate(drives[:, k]):
            speed += step * (-(omega**2) * place - 2 * damping * omega * speed + drive)
            place += step * speed
            late[frame, k] = place
    late = np.tanh(late / (1.5 * np.percentile(np.abs(late), 85, axis=0)))
    return np.asarray(late / np.sqrt((late**2).mean(axis=0)))


def _swell(time: FloatArray, start: float, rise: float, hold: float, fall: float) -> FloatArray:
    """Return 0..1..0 with minimum-jerk ramps (Flash & Hogan 1985)."""
    up = np.clip((time - start) / rise, 0, 1)
    down = np.clip((time - start - rise - hold) / fall, 0, 1)

    def ramp(x: FloatArray) -> FloatArray:
        return x**3 * (10 - 15 * x + 6 * x**2)

    return np.asarray(ramp(up) - ramp(down))


def _speech(
    time: FloatArray, start: float, phones: Sequence[str], rng: np.random.Generator
) -> list[tuple[str, FloatArray]]:
    """Return the share of each phone over time: dominance functions that overlap (Cohen & Massaro 1993)."""
    centres = start + PHONE_S * (0.5 + np.arange(len(phones)) + 0.18 * rng.standard_normal(len(phones)))
    widths = PHONE_S * rng.uniform(0.50, 0.66, len(phones))
    dominance = np.exp(-0.5 * ((time[:, None] - centres) / widths) ** 2)
    strength = rng.uniform(0.8, 1.15, len(phones))
    end = start + PHONE_S * len(phones)
    voiced = _swell(time, start - 0.1, 0.2, end - start - 0.05, 0.3)
    share = dominance / (dominance.sum(axis=1, keepdims=True) + 0.15) * strength * voiced[:, None]
    return [(phone if phone in VISEMES else "t", share[:, k]) for k, phone in enumerate(phones)]


def _blinks(rng: np.random.Generator) -> list[float]:
    found, now = [], 0.55
    while now < FRAMES / FPS - 0.5:
        found.append(now)
        now += float(rng.uniform(1.6, 4.2))
        if rng.random() < 0.15:
            found.append(now - 1.25)
    return sorted(found)


def _drift(rng: np.random.Generator, seconds: float) -> FloatArray:
    """Return a smooth random curve (6000,) of RMS 1 that changes over about ``seconds``."""
    frequency = np.fft.rfftfreq(FRAMES, 1 / FPS)
    noise = rng.standard_normal(len(frequency)) + 1j * rng.standard_normal(len(frequency))
    curve = np.fft.irfft(noise * np.exp(-0.5 * (frequency * 2 * seconds) ** 2), FRAMES)
    curve -= curve.mean()
    return np.asarray(curve / np.sqrt((curve**2).mean()))
