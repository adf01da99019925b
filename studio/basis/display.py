"""From project, selection and results to the widgets of the basis stage; the only place that fills them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QObject, QTimer

from engine.basis.muscles import muscle_checklist
from engine.mesh import FloatArray
from studio.basis.advice_items import advice_items
from studio.basis.context import BasisContext
from studio.basis.follower import BasisFollower
from studio.basis.frames import FramePictures
from studio.basis.grid_rows import grid_rows, ratio
from studio.basis.workspace import BasisWorkspace
from widgets.basis.error_panel import BasisFigures
from widgets.basis.motion_panel import BasisChoices, MotionFacts
from widgets.basis.shape_panel import ShapeFacts
from widgets.basis.shapes_table import ShapeRow
from widgets.canvases.pictures import Picture

if TYPE_CHECKING:
    from engine.basis.compare import Comparison
    from engine.shapes import Rig
    from studio.basis.results import Analysis

WORST = 3
CLOUD_AXES, CLOUD_FRAMES = 3, 2_000


class BasisDisplay(QObject):
    """Fills the widgets; asks project and follower, changes neither."""

    def __init__(
        self, context: BasisContext, follower: BasisFollower, workspace: BasisWorkspace, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._context, self._follower, self._work = context, follower, workspace
        self.frames = FramePictures(context, follower)
        self._shown_rig: Rig | None = None
        self._preview: dict[str, float] = {}
        self._live = QTimer(self, singleShot=True, interval=0)
        self._live.timeout.connect(self.show_alpha)
        self._clip, self.eigenface = (0, 0.0), False
        self.worst: list[int] = []
        self._pictures: tuple[Rig, dict[str, Picture]] | None = None

    @property
    def analysis(self) -> Analysis | None:
        """The basis whose figures fit the shapes that are listed; None while there is none."""
        found = self._fitting
        return None if found is None or found.names != self._context.names else found

    @property
    def _fitting(self) -> Analysis | None:
        """The last basis that was made, where it is of the topology that is shown."""
        found, rig = self._follower.analysis, self._context.rig
        if found is None or rig is None:
            return None
        return found if found.hand.mesh.vertices.shape == rig.mesh.vertices.shape else None

    @property
    def comparison(self) -> Comparison | None:
        """Figures of the basis in use; of the quasi-eigen one while they are being worked out."""
        if self._follower.blend is not None:
            return self._follower.blend.comparison
        found = self._follower.analysis
        return None if found is None else found.result.comparison

    def amounts(self, analysis: Analysis) -> FloatArray:
        """Return how much of every shape is quasi-eigen (n,), with what a slider that is held would give."""
        setup = self._context.setup
        return np.array([self._preview.get(name, setup.amount(name)) for name in analysis.names])

    # -- inputs -----------------------------------------------------------------------------------------------

    def show_all(self) -> None:
        """Show everything anew."""
        self.show_rig()
        self.show_shapes()
        self.show_shape()
        self.show_motion()
        self.show_choices()
        self.show_figures()
        self.show_frame()

    def show_rig(self) -> None:
        """Show the neutral face of the hand-sculpted rig, unless it is there already."""
        rig, item = self._context.rig, self._context.hand
        before, self._shown_rig = self._shown_rig, rig
        if rig is None or item is None:
            if before is not None:
                self._work.views.set_rig(None)
            return
        if before is not None and before.mesh is rig.mesh:
            return
        content = self._context.basis.rig_content(item.content)
        texture = None if content is None else content.texture
        self._work.views.set_rig(rig.mesh, rig.skin, texture)

    def show_shapes(self) -> None:
        """List the shapes, with figures where they are known."""
        analysis, names, pictures = self.analysis, self._context.names, self._thumbnails()
        if analysis is None:
            rows = [ShapeRow(name, thumbnail=pictures.get(name)) for name in names]
        else:
            amounts, quasi = self.amounts(analysis), analysis.result.quasi
            changes, cosines = analysis.measures.change_mm(amounts), analysis.measures.cosine(amounts)
            rows = [
                ShapeRow(
                    name,
                    float(changes[i]),
                    float(cosines[i]),
                    _residual(quasi.residual_mm[i], amounts[i]),
                    pictures.get(name),
                )
                for i, name in enumerate(names)
            ]
        self._work.shapes.set_shapes(rows)
        self._work.shapes.set_current(self._context.shape)
        self._work.guide.set_checklist(muscle_checklist(names) if names else ())

    def _thumbnails(self) -> dict[str, Picture]:
        """Return the pictures of the shapes; those of another rig are drawn beside the window."""
        rig = self._context.rig
        if rig is None:
            return {}
        if self._pictures is not None and self._pictures[0] is rig:
            return self._pictures[1]
        known = {} if self._pictures is None else self._pictures[1]
        self._pictures = rig, known

        def done(found: dict[str, Picture]) -> None:
            if self._context.rig is rig:
                self._pictures = rig, found
                self.show_shapes()

        from studio.basis.thumbnails import shape_pictures

        self._context.session.tasks.submit(
            "Drawing the shapes",
            lambda progress: shape_pictures(rig, progress),
            done,
            failed=lambda _error: None,
            key="basis thumbnails",
            quiet=True,
        )
        return known

    def show_shape(self) -> None:
        """Show the shape in view, by hand and as it is in use; an eigenface goes."""
        self.eigenface = False
        name, rig, work = self._context.shape, self._context.rig, self._work
        work.projection.set_current(name)
        work.cloud.set_current(name)
        work.shapes.set_current(name)
        if name is None or rig is None:
            work.shape.set_shape(None)
            work.views.set_shape("", None, None)
            return
        analysis, index = self.analysis, rig.basis.names.index(name)
        amount = self._preview.get(name, self._context.setup.amount(name))
        count = max(1, len(self._context.chosen))
        if analysis is None:
            by_hand = rig.basis.displacements[index]
            work.views.set_shape(name, by_hand if rig.basis.mean is None else by_hand + rig.basis.mean, None)
            work.shape.set_shape(ShapeFacts(name, amount), count)
            work.shape.set_available(False, "there is no basis yet")
            return
        by_hand, quasi = analysis.hand_shapes[index], analysis.quasi_shapes[index]
        used = quasi if amount == 1.0 else (1 - amount) * by_hand + amount * quasi
        work.views.set_shape(name, by_hand, used, "" if amount == 1.0 else f"{amount:.2f}")
        amounts, found = self.amounts(analysis), analysis.result.quasi
        facts = ShapeFacts(
            name,
            amount,
            float(analysis.measures.change_mm(amounts)[index]),
            float(found.residual_mm[index]),
            float(found.residual_fraction[index]),
            float(analysis.measures.cosine(amounts)[index]),
        )
        work.shape.set_shape(facts, count)
        work.shape.set_available(True)
        if not self._preview:
            self.show_advice()

    def preview(self, amounts: Mapping[str, float]) -> None:
        """Show what would be if the slider were let go now; nothing in ``amounts``: what is."""
        self._preview = dict(amounts)
        self.show_shape()
        self._live.start()  # of moves that wait the latest is told

    def end_preview(self) -> None:
        """Forget what a slider would have given; what is follows from the project."""
        self._preview = {}
        self._live.stop()

    def show_grid(self) -> None:
        """Show all shapes at once, where they are wanted so."""
        views, rig, analysis = self._work.views, self._context.rig, self.analysis
        if views.state.mode != "grid" or rig is None:
            return
        views.set_grid(grid_rows(rig, analysis, None if analysis is None else self.amounts(analysis)))

    def show_alpha(self) -> None:
        """Show the error of the basis in use beside the slider: exact, or at once while it is held or worked out."""
        blend, live, analysis = self._follower.blend, self._follower.live, self.analysis
        if blend is None or self._preview:
            if live is None or analysis is None:
                self._work.shape.set_live_alpha(None)
            else:
                self._work.shape.set_live_alpha(*live.alpha(self.amounts(analysis)))
            return
        error = blend.comparison.errors["quasi_eigen"][self._context.setup.options.bounds]
        self._work.shape.set_live_alpha(error.alpha_mean, error.alpha_pooled)

    def show_motion(self) -> None:
        """Show the performance, as it is recorded and as it lies on the rig."""
        item, prepared, work = self._context.motion, self._follower.prepared, self._work
        rigs = [(rig.id, rig.name) for rig in self._context.basis.rigs]
        driver = self._context.basis.driver
        work.motion.set_rigs(rigs, None if driver is None else driver.id)
        work.views.set_message(*(() if item is None else ("Open a hand-sculpted rig to lay it on", item.name)))
        if item is None:
            work.motion.set_motion(None)
            self._set_clip(0, 0.0)
            return
        bound = None if prepared is None else prepared.bound
        head = len(item.options.head or ()) if bound is None else len(bound.head_labels)
        markers = item.count if item.kind == "markers" else 0
        lacking = self._context.basis.lacks(item) if item.link is None or prepared is None else ""
        facts = MotionFacts(
            Path(item.source.replace("\\", "/")).name or item.name,
            item.frames if prepared is None else len(prepared.motion),
            item.fps,
            "mesh" if item.kind == "dense" else item.kind,
            (markers - head if bound is None else len(bound.binding)) if markers else 0,
            head if markers else 0,
            tuple(note for note in (lacking, item.assumed, *(() if prepared is None else prepared.notes)) if note),
            item.kind == "weights" and driver is None,
        )
        work.motion.set_motion(facts)
        frames = 0 if prepared is None else len(prepared.motion)
        self._set_clip(frames, item.fps)
        if self._context.frame >= frames:
            self._context.frame = 0
        if work.timeline.frame != self._context.frame:
            work.timeline.set_frame(self._context.frame)

    def _set_clip(self, frames: int, fps: float) -> None:
        """Show another clip; the same one plays on and stays zoomed."""
        if (frames, fps) != self._clip:
            self._clip = frames, fps
            self._work.timeline.set_clip(frames, fps)

    def show_choices(self) -> None:
        """Show how axes are chosen and weights are solved."""
        options, work = self._context.setup.options, self._work
        work.motion.set_choices(
            BasisChoices(options.train, options.coverage, options.count, options.bounds, options.affine, options.ridge)
        )
        work.error.set_bounds(options.bounds)

    # -- figures ----------------------------------------------------------------------------------------------

    def show_figures(self) -> None:
        """Show what is known of the basis: axes, projection, errors, curves, advice."""
        analysis, comparison, work = self._fitting, self.comparison, self._work
        if analysis is None or comparison is None:
            self._show_no_figures()
            return
        bounds = self._context.setup.options.bounds
        principal, quasi = analysis.result.principal, analysis.result.quasi
        work.motion.set_axes(principal.count, principal.coverage)
        work.projection.set_projection(quasi.projection, quasi.basis.names)
        work.projection.set_spectrum(principal.eigenvalues, principal.cumulative, principal.count, principal.coverage)
        self._show_errors(analysis, comparison, bounds)
        self._show_axes(analysis, comparison)
        work.timeline.set_trained(*principal.train)
        if not self._follower.shows_motion:
            self._show_no_curves()
        self.show_advice()
        self.show_alpha()

    def show_advice(self) -> None:
        """Say what may be done next."""
        analysis, advice, shape = self._fitting, self._follower.advice, self._context.shape
        items = None if analysis is None else advice_items(analysis, self.amounts(analysis), advice, shape)
        self._work.advice.set_advice(items)

    def _show_errors(self, analysis: Analysis, comparison: Comparison, bounds: str) -> None:
        work, errors = self._work, comparison.errors
        table = {
            basis: {key: (error.alpha_mean, error.alpha_pooled) for key, error in rows.items()}
            for basis, rows in errors.items()
        }
        work.error.set_alpha(table)
        hand, used, best = errors["hand"][bounds], errors["quasi_eigen"][bounds], errors["pca"]["free"]
        work.error.set_measure(analysis.result.skin_name, len(hand.alpha_frames))
        cosines = analysis.measures.cosine(self.amounts(analysis))
        moving = cosines[np.isfinite(cosines)]
        quasi = analysis.result.quasi
        work.error.set_figures(
            BasisFigures(
                ratio(hand.alpha_mean, used.alpha_mean),
                ratio(used.alpha_mean, best.alpha_mean),
                comparison.p99["quasi_eigen"][bounds],
                float(np.median(moving)) if len(moving) else None,
                quasi.rank,
                len(analysis.names),
                analysis.result.principal.count,
            )
        )
        shown = {"hand": hand, "quasi_eigen": used, "pca": best}
        work.timeline.set_curves(
            {key: error.alpha_frames for key, error in shown.items()},
            {key: shown[key].rms_frames for key in ("hand", "quasi_eigen")},
        )
        self.worst = [int(frame) for frame in used.worst_frames(WORST)]
        work.timeline.set_worst(self.worst)
        for key, error in shown.items():
            work.views.set_clip_heat(error.rms_vertices, key, len(error.rms_frames))

    def _show_axes(self, analysis: Analysis, comparison: Comparison) -> None:
        work, principal, quasi = self._work, analysis.result.principal, analysis.result.quasi
        variances = np.maximum(principal.eigenvalues[: principal.count], 0.0)
        deviations = np.sqrt(variances)
        own = comparison.weights["pca"]["free"]
        start, stop = principal.train
        trained = own[start:stop]
        ranges = np.stack([trained.min(axis=0), trained.max(axis=0)], axis=1)
        work.eigen.set_axes(deviations, variances / principal.total_variance, ranges)
        count = min(CLOUD_AXES, principal.count)
        frames = np.unique(np.linspace(0, len(own) - 1, min(CLOUD_FRAMES, len(own))).round().astype(np.int64))
        # Lengths over all vertices measured, as the coordinates are: RMS times the root of their number.
        root = float(np.sqrt(len(analysis.hand.skin)))
        beyond = comparison.errors["pca"]["free"].rms_frames[frames] * root
        work.cloud.set_cloud(own[frames, :count] * deviations[:count], frames.astype(np.float64), beyond)
        directions = {"quasi_eigen": quasi.projection[:, :count], "pca": np.diag(deviations[:count])}
        neutral = principal.coordinates(np.zeros_like(principal.neutral))[:count]
        work.cloud.set_directions(directions, analysis.names, neutral, quasi.residual_mm * root)

    def _show_no_figures(self) -> None:
        work = self._work
        work.motion.set_axes(None)
        work.projection.set_projection(None)
        work.projection.set_spectrum(None)
        work.error.set_alpha(None)
        work.error.set_figures(None)
        work.eigen.set_axes(None)
        work.cloud.set_cloud(None)
        work.cloud.set_directions({})
        self._show_no_curves()
        work.advice.set_advice(None)
        work.shape.set_live_alpha(None)

    def _show_no_curves(self) -> None:
        """Take away what is told by frame: it is of another performance, or not there."""
        self._work.timeline.set_curves({}, {})
        self._work.timeline.set_worst([])
        self.worst = []

    def show_frame(self) -> None:
        """Show the frame in view and its reconstructions."""
        found, views = self.frames.picture(self._context.frame), self._work.views
        if found is None:
            views.set_frame(0, None)
            views.set_markers(None)
        else:
            placed = found.original, found.by_hand, found.by_quasi
            views.set_frame(found.index, *placed, found.rms_mm, found.by_pca, found.markers)
        self._work.cloud.set_frame(self._context.frame)

    def show_eigenface(self, values: FloatArray) -> None:
        """Show the mean of the motion, and what the axes make of it; values (m,) in standard deviations."""
        analysis = self._follower.analysis
        if analysis is None:
            return
        self.eigenface = True
        principal = analysis.result.principal
        deviations = np.sqrt(np.maximum(principal.eigenvalues[: principal.count], 0.0))
        moved = principal.mean + np.tensordot(values * deviations, principal.axes, axes=1)
        self._work.views.set_shape("", principal.mean, moved, titles=("Mean of the motion", _axes_title(values)))


def _axes_title(values: FloatArray) -> str:
    """Return what stands over a face that axes make, by their coordinates (m,) in standard deviations."""
    used = np.flatnonzero(np.abs(values) >= 0.05)
    if len(used) == 1:
        return f"Axis {used[0] + 1}, {values[used[0]]:+.1f} std. dev."
    return f"{len(used)} axes together" if len(used) else "No axis"


def _residual(residual_mm: float, amount: float) -> str:
    text = f"{residual_mm:.2f} mm of it cannot be shown by the axes"
    return text if amount == 1.0 else f"{text}; {100 * amount:.0f} % quasi-eigen"
