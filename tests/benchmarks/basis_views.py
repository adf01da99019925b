"""``python -m tests.benchmarks.basis_views``: what scrubbing costs in the views of the basis stage.

Needs a display (``xvfb-run`` where there is none). Updating is all that happens before the frame is drawn: copies,
normals, upload into the buffers of VTK, words. Drawing is the frame after it, drawn by the processor where there is no
graphics card. Every line is the smallest of twenty runs in this process.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from PySide6.QtWidgets import QApplication

import resources
from engine.files.rig import read_rig
from engine.geometry.normals import vertex_normals
from widgets import theme
from widgets.basis.views import BasisViews
from widgets.scene.basis_rig import RigLook

RUNS = 20


def fastest(work: Callable[[], Any]) -> float:
    """Return the smallest time of twenty runs after one to warm up, ms."""
    work()
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        work()
        times.append(1e3 * (time.perf_counter() - start))
    return min(times)


def line(name: str, value: float, limit: float | None = None, note: str = "") -> None:
    """Print one figure in ms and its limit."""
    bound = "" if limit is None else f"limit {limit:g}"
    print(f"{name:<52} {value:9.2f} ms    {bound:<12} {note}", flush=True)


def main() -> None:
    """Scrub the sample's rig in a window of the size it has at 1440 x 900."""
    app = QApplication.instance() or QApplication([])
    assert isinstance(app, QApplication)
    theme.apply(app, theme.DARK)
    rig = read_rig(resources.sample_path("performance", "animator_24.npz")).rig
    shapes, neutral = rig.basis.displacements, rig.mesh.vertices
    print(f"{len(neutral):,} vertices, {len(rig.mesh.faces):,} triangles")
    look = RigLook(rig.mesh, rig.skin)
    line("rig made ready, occlusion baked", fastest(lambda: RigLook(rig.mesh, rig.skin)))
    peer = fastest(lambda: vertex_normals(neutral, rig.mesh.faces))
    ours = fastest(lambda: look.pose(neutral))
    line("points and normals of one face", ours, None, f"{peer / ours:.1f} x engine.geometry.normals")

    views = BasisViews()
    views.resize(896, 616)
    views.show()
    views.set_rig(rig.mesh, rig.skin)
    while views.scene is None:
        app.processEvents()
    views.set_shape(rig.basis.names[0], shapes[0], 0.9 * shapes[0])
    frames = [neutral + shapes[k % len(shapes)] + 0.5 * shapes[(k + 5) % len(shapes)] for k in range(2 * RUNS + 4)]
    turn = [0]

    def one() -> None:
        turn[0] += 1
        views.set_frame(turn[0], frames[turn[0] % len(frames)])

    def four() -> None:
        turn[0] += 1
        k = turn[0]
        placed = [frames[(k + j) % len(frames)] for j in range(4)]
        views.set_frame(k, placed[0], placed[1], placed[2], (1.0, 0.1, 0.1), placed[3])

    def drawn(work: Callable[[], Any]) -> Callable[[], None]:
        def run() -> None:
            work()
            app.processEvents()

        return run

    line("scrub: one face updated", fastest(one), 25.0)
    line("  and its view drawn", fastest(drawn(one)))
    views.set_pca_visible(True)
    line("scrub: four faces updated", fastest(four), 60.0)
    line("  and their views drawn", fastest(drawn(four)))
    line("flip, drawn", fastest(drawn(lambda: views.set_flipped(not views.state.flipped))))
    line("all views drawn", fastest(drawn(views.viewer.redraw)))
    views.close()


if __name__ == "__main__":
    main()
