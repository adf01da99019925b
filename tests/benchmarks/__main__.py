"""``python -m tests.benchmarks``: the figures of ``make bench``.

Every line is the smallest of five runs in this process (starts: the median of five processes), compute only unless it
says otherwise. A ratio is the peer's time over ours, both measured in this run.
"""

from __future__ import annotations

import json
import os
import shutil
import statistics
import subprocess
import sys
import time

import numpy as np
import trimesh
from scipy.interpolate import RBFInterpolator
from scipy.ndimage import map_coordinates

import resources
from engine.files.landmarks_json import read_fiducials
from engine.files.scan import read_scan
from engine.files.template import read_template
from engine.geometry.sampling import sample_bilinear
from engine.geometry.subdivide import subdivision
from engine.scan.fit import fit_template
from engine.scan.repair import repair
from engine.scan.warp import warp_template
from tests.benchmarks.figures import RUNS, fastest, line
from tests.benchmarks.principal import principal
from tests.benchmarks.reproduction import reproduction
from tests.engine.basis import proof

TEMPLATE = read_template(resources.template_path())


def fits() -> None:
    """Warp, refit and full fit on the sample, with peers for their parts."""
    scan = read_scan(resources.sample_path("subject", "base.json")).scan
    places = read_fiducials(resources.sample_path("subject", "base_fiducials.json")).positions
    layout = TEMPLATE.layout("closed")
    names = list(layout.fiducials)
    source = layout.vertices[[layout.fiducials[name] for name in names]]
    target = np.array([places[name] for name in names])
    repaired = repair(scan)

    warp = fastest(lambda: warp_template(TEMPLATE, "closed", places))
    peer = fastest(lambda: RBFInterpolator(source, target, kernel="thin_plate_spline", degree=1)(layout.vertices))
    line("warp of the template", warp, "ms", None, f"{peer / warp:.1f} x scipy RBFInterpolator")
    line("  and redraw of its wire over the picture", warp + redraw(), "ms", 16)
    refit = fastest(lambda: fit_template(repaired, places, TEMPLATE, levels=2))
    line("refit at two levels, normals and figures included", refit, "ms", 40)
    full = fastest(lambda: fit_template(scan, places, TEMPLATE, levels=3))
    line("full fit at three levels with repair", full, "ms", 600)

    vertices = np.pad(layout.vertices, ((0, 0), (0, 1)))
    ours = fastest(lambda: subdivision(TEMPLATE.faces, 441, 3).apply(vertices))
    peer = fastest(lambda: trimesh.remesh.subdivide_loop(vertices, TEMPLATE.faces, iterations=3))
    line("subdivision, three levels", ours, "ms", None, f"{peer / ours:.1f} x trimesh subdivide_loop")
    pixels = np.random.default_rng(0).uniform(0, 470, (26040, 2))
    image = np.nan_to_num(scan.points)
    ours = fastest(lambda: sample_bilinear(image, pixels, scan.valid))
    peer = fastest(lambda: [map_coordinates(image[..., k], pixels.T[::-1], order=1) for k in range(3)])
    line("sampling of 26,040 vertices, by validity", ours, "ms", None, f"{peer / ours:.2f} x scipy map_coordinates")


def accuracy() -> None:
    """Print the distances between fit and truth of every bundled scan, mm."""
    from tests.engine.scan.test_proof import SCANS, anatomy_errors, fit, surface_distance, to_truth, true_scan

    print(f"{'mm':<10} visible: median   p99    max   filled: p95   true skin to fit: p95")
    for name in SCANS:
        face, skin = fit(name), true_scan(name).face_skin_points()
        distance = to_truth(name, face.mesh.vertices)
        seen, filled = distance[~face.filled], distance[face.filled]
        back = surface_distance(skin[:: max(len(skin) // 3000, 1)], face.mesh.vertices, face.mesh.faces)
        print(
            f"{name:<10} {np.median(seen):15.3f} {np.percentile(seen, 99):6.3f} {seen.max():6.3f}"
            f" {np.percentile(filled, 95):13.2f} {np.percentile(back, 95):23.2f}"
        )
    errors = anatomy_errors(lambda name: fit(name).mesh.vertices)
    print(f"ten anatomical points on the other head: median {np.median(errors):.2f} mm, largest {max(errors):.2f} mm")


def redraw() -> float:
    """Return the time of one redraw of the wire over the colour picture, ms."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6.QtWidgets import QApplication

    from widgets.canvases.image_canvas import ImageCanvas

    app = QApplication.instance() or QApplication([])
    scan = read_scan(resources.sample_path("subject", "base.json")).scan
    places = read_fiducials(resources.sample_path("subject", "base_fiducials.json")).positions
    canvas = ImageCanvas()
    canvas.resize(600, 800)
    canvas.set_image(np.asarray(scan.colour))
    vertices = warp_template(TEMPLATE, "closed", places).vertices
    canvas.set_template(TEMPLATE.edges, vertices)
    canvas.show()
    app.processEvents()
    shift = [0.0]

    def draw() -> None:
        shift[0] += 0.1
        canvas.set_template_vertices(vertices + shift[0])
        canvas.viewport().repaint()

    result = fastest(draw)
    canvas.close()
    return result


def starts() -> None:
    """Start whole processes: help, import, window."""

    def process(*command: str) -> float:
        start = time.perf_counter()
        subprocess.run([sys.executable, *command], check=True, capture_output=True)
        return time.perf_counter() - start

    process("-m", "studio", "--help")
    line("quasiface --help", statistics.median(process("-m", "studio", "--help") for _ in range(RUNS)), "s", 0.8)
    code = "import time; t = time.perf_counter(); import engine; print(time.perf_counter() - t)"
    seconds = [
        float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)
        for _ in range(RUNS)
    ]
    line("import engine", statistics.median(seconds), "s", 0.3)
    display = (
        [] if os.environ.get("DISPLAY") else [shutil.which("xvfb-run") or "", "-a", "-s", "-screen 0 1600x1000x24"]
    )
    if display and not display[0]:
        print("window: skipped, neither a display nor xvfb-run is here")
        return
    environment = {name: value for name, value in os.environ.items() if name != "QT_QPA_PLATFORM"}
    runs = []
    for _ in range(RUNS + 1):
        done = subprocess.run(
            [*display, "sh", "-c", f'exec "{sys.executable}" -m tests.benchmarks.window_start "$(date +%s.%N)"'],
            capture_output=True,
            text=True,
            check=True,
            env=environment,
        )
        runs.append(json.loads(done.stdout.splitlines()[-1]))
    warm = runs[1:]
    for name, key, unit, limit in (
        ("window painted", "painted_s", "s", 1.5),
        ("3-D there", "scene_s", "s", 4),
        ("idle CPU over 3 s", "idle_cpu_percent", "%", None),
    ):
        line(name, statistics.median(run[key] for run in warm), unit, limit)


if __name__ == "__main__":
    print(f"{os.cpu_count()} cores, numpy {np.__version__}")
    accuracy()
    fits()
    principal()
    reproduction()
    print("\n".join(proof.report()))
    starts()
