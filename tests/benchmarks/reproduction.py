"""Projection, weights and errors of a long performance: times, memory, and the peer that solves one frame at a time."""

from __future__ import annotations

import json
import subprocess
import sys
import time

import numpy as np
from scipy.optimize import lsq_linear

from engine.basis.compare import KEYS, compare, compare_again
from engine.basis.extremes import error_extremes
from engine.basis.live import LiveAlpha
from engine.basis.principal import principal_basis
from engine.basis.quasi_eigen import blend, project
from engine.basis.reduce import reduce_motion
from engine.basis.weights import solve_reduced
from engine.motion import MeshMotion
from engine.shapes import ExpressionBasis
from tests.benchmarks.figures import fastest, line, peak_mb
from tests.benchmarks.principal import VERTICES, performance

FRAMES, SHAPES, PEER_FRAMES, RUNS = 35_000, 18, 400, 3


def hand_shapes(motion: MeshMotion, count: int = SHAPES) -> ExpressionBasis:
    """Return frames of the performance, each re-sculpted by a field of 30 % of its size that its markers can show."""
    random = np.random.default_rng(1)
    assert motion.phi is not None and motion.markers is not None
    chosen = motion.markers[random.choice(len(motion), count, replace=False)]
    fields = random.normal(size=chosen.shape)
    fields *= (
        0.3 * np.linalg.norm(chosen, axis=(1, 2), keepdims=True) / np.linalg.norm(fields, axis=(1, 2), keepdims=True)
    )
    shapes = np.einsum("vk,skc->svc", motion.phi, chosen + fields)
    return ExpressionBasis(motion.neutral, [f"shape {i + 1}" for i in range(count)], shapes)


def reproduction(vertices: int = VERTICES) -> None:
    """Print what `make bench` says about projection, weights, errors and the slider."""
    command = [sys.executable, "-m", "tests.benchmarks.reproduction", "process", str(vertices)]
    whole = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    line("axes, projection, nine reconstructions, 35,000 frames", whole["seconds"], "s", 5)
    line("  peak memory, interpreter included", whole["peak_mb"], "MB", 1000)
    line("maxima and percentiles of three bases", whole["extremes"], "s", 60)

    motion = performance(vertices, FRAMES)
    hand = hand_shapes(motion)
    principal = principal_basis(motion)
    quasi = project(hand, principal)
    reduced = reduce_motion(motion, quasi.basis.displacements)
    for bounds in ((0.0, 1.0), (-1.0, 2.0)):
        ours = fastest(lambda b=bounds: solve_reduced(reduced.frames, reduced.shapes, b), RUNS) / 1e3
        found = solve_reduced(reduced.frames, reduced.shapes, bounds)
        chosen = np.linspace(0, FRAMES - 1, PEER_FRAMES).astype(int)
        start = time.perf_counter()
        peers = [lsq_linear(reduced.shapes.T, reduced.frames[k], bounds) for k in chosen]
        peer = (time.perf_counter() - start) * FRAMES / PEER_FRAMES
        left = np.sum((found[chosen] @ reduced.shapes - reduced.frames[chosen]) ** 2, axis=1)
        excess = np.max((left - [2 * other.cost for other in peers]) / (left + reduced.outside[chosen]))
        name = f"weights of 35,000 frames, 18 shapes, {bounds[0]:g}..{bounds[1]:g}"
        line(name, ours, "s", None, f"{peer / ours:.0f} x scipy lsq_linear (at least 50)")
        line("  squared error above the peer's, largest share", 1e6 * excess, "1e-6", 1)
    live = LiveAlpha(hand, quasi, motion, (-1, 2))
    amounts = iter(np.random.default_rng(0).uniform(0, 1, (100, SHAPES)))
    line("slider to alpha on 500 frames", fastest(lambda: live.alpha(next(amounts))), "ms", 60)
    first = compare(hand, quasi, principal, motion)
    half = blend(hand, quasi.basis, np.full(SHAPES, 0.5))
    line("  exact figures after release", fastest(lambda: compare_again(first, half, motion), RUNS) / 1e3, "s", 1)


def _process(vertices: int) -> dict[str, float]:
    motion = performance(vertices, FRAMES)
    hand = hand_shapes(motion)
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        principal = principal_basis(motion)
        found = compare(hand, project(hand, principal), principal, motion)
        times.append(time.perf_counter() - start)
    peak = peak_mb()
    start = time.perf_counter()
    for key in KEYS:
        error_extremes(found.bases[key], motion, found.weights[key]["-1..2"])
    return {"seconds": min(times), "peak_mb": peak, "extremes": time.perf_counter() - start}


if __name__ == "__main__":
    if sys.argv[1:2] == ["process"]:
        print(json.dumps(_process(int(sys.argv[2]))))
    else:
        reproduction(*map(int, sys.argv[1:]))
