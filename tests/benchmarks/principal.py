"""Principal axes against scikit-learn: factored in this process, dense in a process for each, for its peak memory."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from engine.basis.principal import principal_basis
from engine.motion import MeshMotion
from tests.benchmarks.figures import fastest, line, peak_mb

VERTICES, MARKERS, FRAMES = 26_719, 66, 6_000
DENSE_RUNS = 3


def performance(vertices: int, frames: int) -> MeshMotion:
    """Return markers that move along 40 fading directions, with 0.1 mm of noise, spread over a ball."""
    random = np.random.default_rng(0)
    points = random.normal(size=(vertices, 3))
    points *= 90 / np.linalg.norm(points, axis=1, keepdims=True)
    centres = points[random.choice(vertices, MARKERS, replace=False)]
    distance = np.linalg.norm(points[:, None] - centres, axis=2)
    phi = np.exp(-((distance / 35) ** 2))
    phi /= np.maximum(phi.sum(axis=1, keepdims=True), 0.3)
    time_s = np.arange(frames) / 120
    waves = [np.sin(2 * np.pi * (0.1 + 0.15 * i) * time_s + i) ** (1 + i % 3) * 0.89**i for i in range(40)]
    markers = np.einsum("it,ikc->tkc", waves, 1.5 * random.normal(size=(40, MARKERS, 3)))
    return MeshMotion.factored(phi, markers + 0.1 * random.normal(size=markers.shape), points, 120.0)


def principal(vertices: int = VERTICES) -> None:
    """Print times and memory of factored and dense analysis, and what scikit-learn takes for the same frames."""
    motion = performance(vertices, FRAMES)
    found = principal_basis(motion)
    ours = fastest(lambda: principal_basis(motion)) / 1e3
    longest = _longest(vertices)
    with tempfile.TemporaryDirectory() as folder:
        frames = Path(folder) / "frames.npy"
        positions = np.lib.format.open_memmap(frames, "w+", np.float32, (FRAMES, vertices, 3))
        for start, moved in motion.chunks():
            positions[start : start + len(moved)] = moved + motion.neutral
        positions.flush()
        del positions
        np.save(Path(folder) / "neutral.npy", motion.neutral)
        dense, peer = (_process(way, frames, found.count) for way in ("ours", "peer"))
    line(f"principal axes, factored, {vertices:,} x {FRAMES:,}", ours, "s", None, _ratio(peer["seconds"] / ours, 20))
    line("principal axes, factored, 35,000 frames", longest, "s")
    seconds, memory = peer["seconds"] / dense["seconds"], dense["peak_mb"] / peer["peak_mb"]
    line("principal axes, dense in single precision", dense["seconds"], "s", None, _ratio(seconds, 2.5))
    at_most = f"{memory:.2f} of scikit-learn's (at most 0.6)"
    line("  peak memory, frames and interpreter included", dense["peak_mb"], "MB", None, at_most)
    share = abs(dense["covered"] - found.coverage) / found.coverage
    line("  coverage, relative difference from factored", 1e6 * share, "1e-6")


def _longest(vertices: int) -> float:
    motion = performance(vertices, 35_000)
    return fastest(lambda: principal_basis(motion)) / 1e3


def _ratio(value: float, least: float) -> str:
    return f"{value:.1f} x scikit-learn's randomised PCA (at least {least:g})"


def _process(way: str, frames: Path, count: int) -> dict[str, float]:
    command = [sys.executable, "-m", "tests.benchmarks.principal", way, str(frames), str(count)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    answer: dict[str, float] = json.loads(done.stdout)
    return answer


def _analyse(way: str, frames: Path, count: int) -> dict[str, float]:
    positions, neutral = np.load(frames), np.load(frames.with_name("neutral.npy"))
    covered, times = 0.0, []
    for _ in range(DENSE_RUNS):
        start = time.perf_counter()
        if way == "ours":
            covered = principal_basis(MeshMotion.dense(positions, neutral, 120.0), count=count).coverage
        else:
            from sklearn.decomposition import PCA

            peer = PCA(count, svd_solver="randomized", random_state=0).fit(positions.reshape(len(positions), -1))
            covered = float(peer.explained_variance_ratio_.sum())
        times.append(time.perf_counter() - start)
    return {"seconds": min(times), "peak_mb": peak_mb(), "covered": covered}


if __name__ == "__main__":
    if len(sys.argv) == 4:
        print(json.dumps(_analyse(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]))))
    else:
        principal(*map(int, sys.argv[1:]))
