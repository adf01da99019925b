"""Fiducials carried by what the pictures show: planted motion is found, and what cannot be seen is not claimed."""

from __future__ import annotations

import itertools

import cv2
import numpy as np
import pytest

from engine.scan.carry import carry_fiducials
from engine.scan.mouth import INNER_FRACTIONS, find_opening
from engine.scan.range_image import RangeImage
from tests.engine.scan.truth import OPEN, STRANGER, bundled_scan

Places = dict[str, tuple[float, float]]
PAIRS = [*itertools.product(["base"], OPEN), ("car", "eel"), ("eel", "base"), ("too", "man")]


def misses(found: Places, true: Places) -> np.ndarray:
    """Return how far the points that both know are apart, pixels."""
    return np.array([np.hypot(*np.subtract(found[name], true[name])) for name in true if name in found])


@pytest.mark.parametrize("coloured", [True, False])
@pytest.mark.parametrize("shift", [(9, -6), (-40, 25)])
def test_a_shifted_picture_carries_its_points_along(shift: tuple[int, int], coloured: bool) -> None:
    scan, fiducials = bundled_scan("man")
    source = RangeImage(scan.points, scan.colour if coloured else None)
    points = np.roll(scan.points, shift[::-1], axis=(0, 1))
    colour = np.roll(scan.colour, shift[::-1], axis=(0, 1)) if coloured else None
    carried = carry_fiducials(source, fiducials, RangeImage(points, colour))
    outer = {name: (x + shift[0], y + shift[1]) for name, (x, y) in fiducials.items() if name not in INNER_FRACTIONS}
    assert misses(carried.positions, outer).max() < (0.3 if coloured else 1.5)
    assert len(carried.certain) >= len(outer) - 2


def test_another_size_of_picture_is_no_matter() -> None:
    scan, fiducials = bundled_scan("base")
    factor = 1.5
    size = round(scan.width * factor), round(scan.height * factor)
    points = cv2.resize(scan.points, size, interpolation=cv2.INTER_NEAREST)
    target = RangeImage(points, cv2.resize(scan.colour, size, interpolation=cv2.INTER_LINEAR))
    carried = carry_fiducials(scan, fiducials, target)
    true = {name: (factor * (x + 0.5) - 0.5, factor * (y + 0.5) - 0.5) for name, (x, y) in fiducials.items()}
    assert misses(carried.positions, true).max() < 1.5


def test_one_expression_leads_to_another() -> None:
    certain, rest, copied, claimed = [], [], [], 0
    for one, two in PAIRS:
        (source, start), (target, true) = bundled_scan(one), bundled_scan(two)
        carried = carry_fiducials(source, start, target)
        assert not carried.certain & INNER_FRACTIONS.keys()
        claimed += len(carried.certain)
        certain.append(misses({n: carried.positions[n] for n in carried.certain}, true))
        rest.append(misses({n: p for n, p in carried.positions.items() if n not in carried.certain}, true))
        copied.append(misses(start, true))
    sure, others, lazy = map(np.concatenate, (certain, rest, copied))
    assert claimed / len(PAIRS) > 16
    assert np.median(sure) < 0.5 and np.percentile(sure, 95) < 4.0
    assert np.median(np.concatenate([sure, others])) < 1.0
    assert np.median(lazy) > 10 * np.median(sure)  # the control: the same pixels as before


def test_a_picture_of_something_else_is_not_believed() -> None:
    (source, start), (target, _) = bundled_scan("base"), bundled_scan("man")
    rng = np.random.default_rng(3)
    noise = cv2.GaussianBlur(rng.integers(0, 256, target.colour.shape).astype(np.uint8), (0, 0), 2)
    carried = carry_fiducials(source, start, RangeImage(target.points, noise))
    assert len(carried.certain) <= len(start) // 3


def test_the_opening_of_the_mouth_gives_the_inner_lips() -> None:
    for name in OPEN:
        scan, fiducials = bundled_scan(name)
        opening = find_opening(scan, fiducials)
        assert opening is not None, name
        away = misses(dict(opening.inner), {n: p for n, p in fiducials.items() if n in INNER_FRACTIONS})
        assert len(away) == 6 and np.median(away) < 4.0 and away.max() < 6.0, (name, away)
    for name in ("base", STRANGER):
        assert find_opening(*bundled_scan(name)) is None, name


def test_without_the_lips_there_is_no_opening() -> None:
    scan, fiducials = bundled_scan("car")
    assert find_opening(scan, {n: p for n, p in fiducials.items() if n != "lip_lower"}) is None
    assert find_opening(scan, fiducials | {"mouth_left": fiducials["mouth_right"]}) is None
    outside = {name: (x + 5000.0, y) for name, (x, y) in fiducials.items()}
    assert find_opening(scan, outside) is None
    assert carry_fiducials(scan, {}, scan).positions == {}
