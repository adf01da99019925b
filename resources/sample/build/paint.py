"""Paints skin: tone, redness, freckles, pores, brows hair by hair, a knitted scan cap; and irises, teeth, tongue."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy.interpolate import PchipInterpolator, griddata
from scipy.ndimage import gaussian_filter, map_coordinates

FloatArray = NDArray[np.float64]
Colour = tuple[float, float, float]

# The chart is the head's front seen along Z, in mm of the subject's own frame: left, right, bottom, top.
CHART = (-92.0, 92.0, -134.0, 130.0)
TEXELS_PER_MM = 8.0
WIDTH, HEIGHT = int((CHART[1] - CHART[0]) * TEXELS_PER_MM), int((CHART[3] - CHART[2]) * TEXELS_PER_MM)
WHITE_SPOT = 12  # texels of the corner that stays white, for the parts that bring their own colour


@dataclass(frozen=True)
class Complexion:
    """The colours of a person, sRGB 0..255, and how much of what the skin carries."""

    tone: Colour
    blush: Colour
    shadow: Colour
    freckle: Colour
    lips: Colour
    mouth: Colour
    brow: Colour
    iris: Colour
    iris_inner: Colour
    freckles: int
    blush_amount: float
    brow_width: float
    brow_hairs: int
    cap: Colour
    seed: int


SUBJECT = Complexion(
    tone=(228, 182, 156), blush=(208, 124, 106), shadow=(196, 138, 118), freckle=(160, 100, 72),
    lips=(186, 104, 98), mouth=(112, 46, 44), brow=(70, 48, 38), iris=(98, 120, 112), iris_inner=(150, 138, 96),
    freckles=420, blush_amount=0.55, brow_width=0.9, brow_hairs=780, cap=(60, 62, 69), seed=7,
)  # fmt: skip
STRANGER = Complexion(
    tone=(150, 102, 76), blush=(142, 78, 60), shadow=(104, 66, 50), freckle=(84, 52, 38),
    lips=(134, 78, 70), mouth=(92, 40, 38), brow=(30, 24, 22), iris=(74, 48, 32), iris_inner=(98, 64, 38),
    freckles=150, blush_amount=0.35, brow_width=1.2, brow_hairs=1000, cap=(96, 98, 94), seed=11,
)  # fmt: skip


@dataclass(frozen=True)
class SkinPaint:
    """A painted skin: ``texture`` (h, w, 3) uint8, and where hair lets the scanner see nothing, (h, w) 0..1."""

    texture: NDArray[np.uint8]
    unseen: FloatArray


def chart_uv(positions: FloatArray) -> FloatArray:
    """Return texture coordinates (n, 2), origin top left, of the subject's neutral positions (n, 3), mm."""
    left, right, bottom, top = CHART
    return np.stack([(positions[:, 0] - left) / (right - left), (top - positions[:, 1]) / (top - bottom)], axis=1)


class _Painter:
    def __init__(self, person: Complexion) -> None:
        self.person = person
        self.rng = np.random.default_rng(person.seed)
        left, _, _, top = CHART
        self.x = (left + (np.arange(WIDTH) + 0.5) / TEXELS_PER_MM)[None, :]
        self.y = (top - (np.arange(HEIGHT) + 0.5) / TEXELS_PER_MM)[:, None]
        self.colour = np.ones((HEIGHT, WIDTH, 3)) * np.array(person.tone)

    def blob(self, x: float, y: float, width: float, height: float) -> FloatArray:
        return np.exp(-(((self.x - x) / width) ** 2) - ((self.y - y) / height) ** 2)

    def pair(self, x: float, y: float, width: float, height: float) -> FloatArray:
        return self.blob(x, y, width, height) + self.blob(-x, y, width, height)

    def noise(self, size_mm: float) -> FloatArray:
        field = gaussian_filter(self.rng.standard_normal((HEIGHT, WIDTH)), size_mm * TEXELS_PER_MM)
        even: FloatArray = field / field.std()
        return even

    def lay(self, amount: FloatArray, colour: Colour) -> None:
        amount = np.clip(amount, 0, 1)[..., None]
        self.colour = self.colour * (1 - amount) + np.array(colour) * amount

    def texel(self, x: float, y: float) -> tuple[float, float]:
        return (x - CHART[0]) * TEXELS_PER_MM, (CHART[3] - y) * TEXELS_PER_MM


def paint_skin(person: Complexion, neutral: FloatArray, normals: FloatArray) -> SkinPaint:
    """Paint a person's skin over the chart.

    ``neutral`` (n, 3) are the dense skin vertices of the subject at rest, mm, and their ``normals`` (n, 3): the cap's
    edge follows the head's shape.
    """
    p = _Painter(person)
    _flush(p)
    _grain(p)
    _freckles(p)
    _lip_lines(p)
    brows = _brows(p)
    cap_edge = _cap(p, neutral, normals)
    p.colour[:WHITE_SPOT, :WHITE_SPOT] = 255
    hair = gaussian_filter(brows, 3.0) * (1.15 + 0.5 * p.noise(0.9))
    unseen = np.maximum(hair, cap_edge)
    return SkinPaint(np.clip(np.rint(p.colour), 0, 255).astype(np.uint8), np.clip(unseen, 0, 1))


def _flush(p: _Painter) -> None:
    red = 0.5 * p.pair(46, -14, 21, 16) + 0.6 * p.blob(0, -13, 13, 10) + 0.32 * p.blob(0, -66, 20, 11)
    red += 0.3 * p.pair(29, 8, 15, 5) + 0.22 * p.pair(12, -26, 6, 6) + 0.15 * p.blob(0, 60, 45, 18)
    p.lay(red * p.person.blush_amount * (1 + 0.18 * p.noise(3.0)), p.person.blush)
    p.lay(0.35 * p.pair(30, 31, 19, 5) + 0.3 * p.pair(25, 9, 13, 3.2), p.person.shadow)
    p.lay(0.12 * p.blob(0, -66, 60, 26) + 0.10 * p.pair(42, -52, 20, 24), (150.0, 132.0, 124.0))


def _grain(p: _Painter) -> None:
    uneven = 0.012 * p.noise(2.8)[..., None] + 0.010 * p.noise(0.8)[..., None] * np.array([0.6, 1.0, 1.0])
    pores = p.noise(0.22)
    cheeks = 0.4 + p.pair(26, -10, 22, 24) + 0.8 * p.blob(0, -10, 18, 18) + 0.6 * p.blob(0, 52, 45, 20)
    pits = np.clip(pores - 1.1, 0, 2.5) * np.clip(cheeks, 0, 1)
    p.colour = p.colour * (1 + uneven + 0.012 * pores[..., None] - 0.045 * pits[..., None])


def _freckles(p: _Painter) -> None:
    spots = Image.new("L", (WIDTH, HEIGHT), 0)
    draw = ImageDraw.Draw(spots)
    for k in range(p.person.freckles):
        x, y = p.rng.choice([-1, 1]) * abs(p.rng.normal(34, 19)), p.rng.normal(-6, 10)
        if k % 3 == 0:
            x, y = p.rng.normal(0, 19), p.rng.normal(-2, 9)
        if k % 8 == 0:
            x, y = p.rng.normal(0, 46), p.rng.normal(10, 46)
        radius = p.rng.uniform(1.4, 4.0)
        a, b = p.texel(x, y)
        draw.ellipse((a - radius, b - radius * 0.9, a + radius, b + radius * 0.9), fill=int(p.rng.uniform(60, 190)))
    for x, y, radius in ((38.0, -44.0, 6.0), (-21.0, 12.0, 5.0), (-52.0, -28.0, 6.5), (16.0, 66.0, 5.0)):
        a, b = p.texel(x, y)
        draw.ellipse((a - radius, b - radius, a + radius, b + radius), fill=235)
    p.lay(gaussian_filter(np.asarray(spots, dtype=np.float64) / 255, 1.3) * 0.55, p.person.freckle)


def _lip_lines(p: _Painter) -> None:
    region = p.blob(0, -44.5, 24, 9)
    wave = np.sin(p.x * 3.4 + 0.05 * p.x * p.y + 1.6 * p.noise(1.4))
    p.colour = p.colour * (1 + (0.055 * wave * region)[..., None])


def _brows(p: _Painter) -> FloatArray:
    hairs = Image.new("L", (WIDTH, HEIGHT), 0)
    draw = ImageDraw.Draw(hairs)
    along = np.array([0, 0.25, 0.6, 1.0])
    middle_x = PchipInterpolator(along, [12.5, 24.0, 39.0, 53.0])
    middle_y = PchipInterpolator(along, [33.5, 36.5, 39.5, 32.5])
    half = PchipInterpolator(along, np.array([2.6, 3.6, 2.6, 0.6]) * p.person.brow_width)
    for side in (1, -1):
        for _ in range(p.person.brow_hairs):
            t = p.rng.uniform() ** 0.9
            across = p.rng.uniform(-1, 1)
            x, y = float(middle_x(t)) + p.rng.normal(0, 0.6), float(middle_y(t)) + across * float(half(t))
            angle = np.deg2rad(62 - 62 * min(t * 2.1, 1) - 50 * max(t - 0.55, 0) - 24 * across * (t > 0.2))
            length, steps = p.rng.uniform(2.8, 4.8), 5
            curl = [angle - 0.25 * i / steps for i in range(steps + 1)]
            path = [
                p.texel(side * (x + np.cos(a) * length * i / steps), y + np.sin(a) * length * i / steps)
                for i, a in enumerate(curl)
            ]
            draw.line(path, fill=int(p.rng.uniform(70, 190)), width=int(p.rng.choice([1, 2, 2, 3])))
    drawn = np.asarray(hairs, dtype=np.float64) / 255
    p.lay((gaussian_filter(drawn, 1.0) * 0.95 + gaussian_filter(drawn, 9) * 0.65) * 0.95, p.person.brow)
    return drawn


def _cap(p: _Painter, neutral: FloatArray, normals: FloatArray) -> FloatArray:
    """Paint the cap and return where its edge and loose stitches cannot be measured."""
    front = (normals[:, 2] > 0.02) & (neutral[:, 1] > -60)
    x, y = np.meshgrid(np.linspace(*CHART[:2], 64), np.linspace(CHART[3], CHART[2], 92))
    forward = griddata(neutral[front, :2], neutral[front, 2], (x, y), method="linear", fill_value=-40.0)
    rows, columns = np.linspace(0, 91, HEIGHT), np.linspace(0, 63, WIDTH)
    z = gaussian_filter(map_coordinates(forward, np.meshgrid(rows, columns, indexing="ij"), order=1), 12)
    z = (z + z[:, ::-1]) / 2
    edge = 80.0 + 5 * np.cos(p.x * 0.02) - np.clip(62 - z, 0, None) * 0.62
    behind = np.minimum(edge, 40 - 0.5 * np.clip(-5 - z, 0, None))
    backward = np.clip((-5 - z) / 25, 0, 1)
    edge = edge * (1 - backward) + behind * backward
    above = p.y - edge
    ear = (np.abs(p.x) > 73.5) & (p.y < 30) & (p.y > -33)
    cap = np.clip(above / 0.5 + 0.5, 0, 1) * ~ear
    p.colour *= (1 - 0.30 * np.exp(-np.clip(-above, 0, None) / 2.6) * (1 - cap) * ~ear)[..., None]
    knit = 1 + 0.13 * np.sin(p.y * 2.6) * np.cos(p.x * 2.2 + 0.6 * np.sin(p.y * 1.3)) + 0.05 * p.noise(0.3)
    hem = 1 - 0.38 * np.exp(-(((above - 5.0) / 0.55) ** 2)) + 0.10 * np.exp(-(((above - 2.4) / 1.6) ** 2))
    woven = np.array(p.person.cap) * (knit * hem)[..., None]
    p.colour = p.colour * (1 - cap[..., None]) + woven * cap[..., None]
    ragged = np.exp(-((above / 0.9) ** 2)) * (0.55 + 0.3 * p.noise(1.2))
    stitches = (p.noise(0.5) > 2.1) * cap
    unseen: FloatArray = np.clip(np.maximum(ragged * ~ear, stitches), 0, 1)
    return unseen


def eye_colours(person: Complexion, points: FloatArray, side: int) -> FloatArray:
    """Return sRGB colours (n, 3) of a unit eyeball's points (n, 3); side 1 is the subject's left."""
    x, y = points[:, 0] + side * 0.025, points[:, 1] - 0.01
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    front = points[:, 2] > 0
    colour = np.array([232.0, 224.0, 217.0]) - np.clip(radius - 0.5, 0, 0.5)[:, None] * np.array([50.0, 120.0, 116.0])
    veins = np.clip(np.sin(angle * 23 + 9 * radius + 2 * np.sin(angle * 7)) - 0.86, 0, 1) * np.clip(radius - 0.55, 0, 1)
    colour -= veins[:, None] * np.array([40.0, 240.0, 220.0])
    fibre = 0.5 + 0.5 * np.sin(angle * 37 + 3 * np.sin(angle * 5)) * np.sin(angle * 61 + radius * 20)
    iris = np.array(person.iris) * (0.72 + 0.42 * fibre[:, None])
    ring = np.exp(-(((radius - 0.225) / 0.075) ** 2))[:, None]
    iris = iris * (1 - 0.6 * ring) + np.array(person.iris_inner) * 0.6 * ring
    iris = iris * (1 - 0.68 * np.clip((radius - 0.35) / 0.09, 0, 1))[:, None]
    for amount, paint in (
        (np.clip((0.445 - radius) / 0.035, 0, 1) * front, iris),
        (np.clip((0.175 - radius) / 0.02, 0, 1) * front, np.array([14.0, 12.0, 12.0])),
    ):
        colour = colour * (1 - amount[:, None]) + paint * amount[:, None]
    lid_shadow = np.clip((points[:, 1] - 0.02) / 0.40, 0, 1) * 0.45
    shaded: FloatArray = np.clip(colour * (1 - lid_shadow[:, None]), 0, 255)
    return shaded


def teeth_colours(points: FloatArray) -> FloatArray:
    """Return sRGB colours (n, 3) of teeth at rest (n, 3), mm: a gap about every 8 mm along the arch, gums above."""
    arch = np.arctan2(points[:, 0], points[:, 2] - 55.0) * 40.0
    gap = np.exp(-((np.sin(arch * np.pi / 7.6) / 0.10) ** 2))
    darker = 0.30 * gap[:, None] * np.array([0.8, 0.95, 1.0])
    colours: FloatArray = np.array([240.0, 226.0, 202.0]) * (1 - darker)
    return colours
