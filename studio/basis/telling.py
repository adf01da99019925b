"""What the basis stage says of itself: the next step, its state, notes beside the docks' titles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from studio.basis.job import LEAST_COSINE
from studio.basis.next_step import BasisStep, next_basis_step
from studio.basis.results import state_of
from studio.project.document import ItemState

if TYPE_CHECKING:
    from studio.basis.controller import BasisStage


class BasisTeller:
    """Reads the stage and tells the window; changes nothing."""

    def __init__(self, stage: BasisStage) -> None:
        self._stage = stage

    @property
    def state(self) -> ItemState:
        """How far the stage is."""
        follower = self._stage.follower
        made = None if follower.analysis is None else follower.analysis.key
        state = state_of(self._stage.context.basis, made, follower.trouble)
        if state.kind == "fresh" and follower.blend is None:
            working = "its figures are being worked out" if follower.busy else "its figures are not worked out"
            return ItemState("stale", follower.trouble or working)
        return state

    def weak_shapes(self) -> list[str]:
        """Return the shapes in use that no longer look like their hand shape, the least like it first."""
        analysis, display = self._stage.display.analysis, self._stage.display
        if analysis is None:
            return []
        cosines = analysis.measures.cosine(display.amounts(analysis))
        return [analysis.names[i] for i in np.argsort(cosines) if cosines[i] < LEAST_COSINE]

    def tell(self) -> None:
        """Tell all of it anew."""
        stage, window, work = self._stage, self._stage.window, self._stage.centre
        state = self.state
        window.set_stage_state("basis", state.kind, state.reason)
        for dock, panel in (
            ("shapes", work.shapes), ("shape", work.shape), ("error", work.error),
            ("projection", work.projection), ("eigenfaces", work.eigen), ("guide", work.guide),
        ):  # fmt: skip
            window.set_dock_note(dock, panel.note)
        if window.stage_id == "basis":
            window.status.set_fit(*self._figure(state))
        self.tell_next()
        if window.stage_id == "basis":
            window.actions_.refresh()
        stage.told = state

    def tell_next(self) -> None:
        """Tell the next step alone."""
        window = self._stage.window
        if window.stage_id != "basis":
            return
        step = self._next()
        window.status.set_next(step.text, window.actions_.shortcut_text(step.action) if step.action else "")

    def do_next(self) -> None:
        """Do the next step, or go where it is done."""
        window, step = self._stage.window, self._next()
        if step.action and window.stage_id == "basis":
            window.actions_[step.action].trigger()

    def _next(self) -> BasisStep:
        stage = self._stage
        return next_basis_step(stage.context.project, self.state, self.weak_shapes(), LEAST_COSINE, stage.follower.busy)

    def _figure(self, state: ItemState) -> tuple[str, str]:
        comparison = self._stage.display.comparison
        if comparison is None:
            return "missing", "" if self._stage.context.basis.is_empty else state.reason
        if self._stage.follower.blend is None:
            return state.kind, f"basis {state.kind}: {state.reason}"
        bounds = self._stage.context.setup.options.bounds
        alpha = comparison.errors["quasi_eigen"][bounds].alpha_mean
        text = f"basis {state.kind}, α {alpha:.2f} %"
        extremes = self._stage.follower.extremes
        if extremes is not None:
            within = f"{extremes.percentile:.0f} % within {extremes.percentile_mm:.2f} mm"
            text += f", {within}, at most {extremes.max_mm:.1f} mm"
        return state.kind, text if state.kind == "fresh" else f"{text}: {state.reason}"
