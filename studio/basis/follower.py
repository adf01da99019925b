"""The basis follows its inputs: every change starts the analysis anew beside the window, and the latest wins."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from engine.errors import InputError
from engine.progress import Progress
from studio.basis.options import BOUNDS
from studio.basis.results import Analysis, Blend, Ingredients, InputsKey, analyse, blended, inputs_key, prepare_motion
from studio.project.basis_state import BasisState
from studio.tasks import Task, TaskRunner, TaskState, describe

if TYPE_CHECKING:
    from engine.basis.advice import Advice
    from engine.basis.extremes import Extremes
    from engine.basis.live import LiveAlpha
    from studio.basis.motions import PreparedMotion

DELAY_MS = 10
"""Changes that follow each other faster than this start one analysis."""
KEPT = 4
LIVE_FRAMES, MOST_EXACT = 500, 8_000
"""So many evenly spaced frames tell the error while a slider is dragged; all of them where that is fast enough."""
LIVE_SECONDS = 0.05
"""What one answer about all frames may take."""
ANALYSIS, BLEND, EXTREMES = "basis analysis", "basis blend", "basis extremes"
LIVE, ADVICE = "basis live", "basis advice"
DEPENDENT = (BLEND, EXTREMES, LIVE, ADVICE)


class BasisFollower(QObject):
    """Keeps motion, basis and figures up to date with what was chosen.

    Results are kept by the key of their inputs: undo finds them again. They never go onto the undo stack.

    Attributes
    ----------
    prepared : PreparedMotion or None
        The motion of the chosen rig, as soon as it is there; never that of a performance chosen before.
    analysis : Analysis or None
        The last basis that was made; ``key`` tells of what.
    blend : Blend or None
        The basis in use with its figures; None while they are not those of `analysis` and of the present amounts.
    extremes : Extremes or None
        Maxima and percentiles of the basis in use under the bounds in use.
    advice : Advice or None
        What to sculpt next, for the quasi-eigen basis under the bounds in use.
    live : LiveAlpha or None
        What tells the error while a slider is dragged.
    trouble : str
        Why the last attempt failed; empty when it did not.
    """

    changed = Signal()
    """Motion, basis or figures are others."""
    added = Signal()
    """Advice, maxima, or what tells the error while a slider is dragged, has come; or work was cancelled."""
    failed = Signal(str)
    """Why a basis cannot be made, in a sentence."""

    def __init__(self, basis: Callable[[], BasisState], tasks: TaskRunner, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._basis, self._tasks = basis, tasks
        self.prepared: PreparedMotion | None = None
        self.analysis: Analysis | None = None
        self._blend: Blend | None = None
        self.extremes: Extremes | None = None
        self.live: LiveAlpha | None = None
        self.advice: Advice | None = None
        self.trouble = ""
        self._asked: InputsKey | None = None
        self._kept: OrderedDict[InputsKey, Analysis] = OrderedDict()
        self._motions: OrderedDict[tuple[str, str, str], PreparedMotion] = OrderedDict()
        self._blends: OrderedDict[tuple[InputsKey, tuple[tuple[str, float], ...]], Blend] = OrderedDict()
        self._prepared_of: tuple[str, str, str] | None = None
        self._of: dict[str, object] = {}
        tasks.changed.connect(self._on_task)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(DELAY_MS)
        self._timer.timeout.connect(self._follow)

    @property
    def blend(self) -> Blend | None:
        """The basis in use with its figures, where they fit the analysis and the present amounts."""
        found, analysis = self._blend, self.analysis
        if found is None or analysis is None or found.key != analysis.key:
            return None
        return found if dict(found.amounts) == dict(self._basis().setup.amounts) else None

    @property
    def shows_motion(self) -> bool:
        """Whether the analysis is of the motion that is there."""
        return self.analysis is not None and self.analysis.key.of_motion == self._prepared_of

    @property
    def is_fresh(self) -> bool:
        """Whether the analysis is that of the present inputs."""
        return self.analysis is not None and self.analysis.key == inputs_key(self._basis())

    @property
    def busy(self) -> bool:
        """Whether an analysis, or the figures of the basis in use, are being worked out."""
        return self._timer.isActive() or self._running(ANALYSIS) or self._running(BLEND)

    def follow(self) -> None:
        """Bring everything up to date, soon."""
        self._timer.start()

    def restart(self) -> None:
        """Try again what failed or was cancelled."""
        self._asked, self.trouble = None, ""
        self._of.clear()
        self._follow()

    def forget(self) -> None:
        """Let go of everything: another project is open."""
        self._timer.stop()
        for kept in (self._kept, self._motions, self._blends):
            kept.clear()
        self._asked, self.trouble = None, ""
        self._clear()
        self.changed.emit()

    def close(self) -> None:
        """Stop the clock; nothing is told any more."""
        self._timer.stop()
        self.blockSignals(True)

    # -- the chain ------------------------------------------------------------------------------------------------

    def _follow(self) -> None:
        self._timer.stop()
        try:
            found = Ingredients.of(self._basis())
        except InputError as error:
            self._fail(str(error))
            return
        if found is None:
            self._asked = None
            self._stop(ANALYSIS, *DEPENDENT)
            self._tell_motion()
            return
        key = found.key
        if key in self._kept:
            self._stop(ANALYSIS)
            self._asked = key
            self._take(self._kept[key])
        elif self._asked != key:
            self._asked, self.trouble = key, ""
            self._stop(*DEPENDENT)
            self._analyse(found)
        elif self.analysis is not None and self.analysis.key == key:
            self._complete()

    def _analyse(self, found: Ingredients) -> None:
        """Prepare the motion, which can be shown, then make the basis."""
        prepared = self._motions.get(found.key.of_motion)
        self._tell_motion(prepared, found.key.of_motion)

        def done(motion: PreparedMotion) -> None:
            _keep(self._motions, found.key.of_motion, motion)
            if self._asked == found.key:
                self._tell_motion(motion, found.key.of_motion)
                self._make(found, motion)

        if prepared is not None:
            self._make(found, prepared)
            return
        title = f"Preparing “{found.motion.name}”"
        self._tasks.submit(title, lambda report: prepare_motion(found, report), done, failed=self._lost, key=ANALYSIS)

    def _make(self, found: Ingredients, motion: PreparedMotion) -> None:
        self._tasks.submit(
            f"Quasi-eigen basis of “{found.motion.name}”",
            lambda progress: analyse(found, motion, progress),
            self._done,
            failed=self._lost,
            key=ANALYSIS,
        )

    def _lost(self, error: BaseException) -> None:
        self._fail(describe(error))

    def _done(self, analysis: Analysis) -> None:
        _keep(self._kept, analysis.key, analysis)
        if self._asked == analysis.key:
            self._take(analysis)

    def _take(self, analysis: Analysis) -> None:
        self.trouble = ""
        self.analysis, self.prepared, self._prepared_of = analysis, analysis.prepared, analysis.key.of_motion
        self._kept.move_to_end(analysis.key)
        self._complete()

    def _complete(self) -> None:
        """Work out what depends on the amounts and the bounds in use."""
        analysis, setup = self.analysis, self._basis().setup
        if analysis is None:
            return
        key = (analysis.key, tuple(sorted(setup.amounts.items())))
        if key in self._blends:
            self._stop(BLEND)
            self._blend = self._blends[key]
        elif not setup.amounts:
            self._stop(BLEND)
            self._blend = blended(analysis, setup)
            _keep(self._blends, key, self._blend)
        elif self._of.get(BLEND) != key or not self._running(BLEND):
            self._mix(analysis, key)
        self._watch(analysis)
        self._advise(analysis)
        self._measure()
        self.changed.emit()

    def _mix(self, analysis: Analysis, key: tuple[InputsKey, tuple[tuple[str, float], ...]]) -> None:
        setup = self._basis().setup

        def done(blend: Blend) -> None:
            _keep(self._blends, key, blend)
            self._blend = blend
            self._measure()
            self.changed.emit()

        self._tasks.submit(
            "Figures of the basis in use",
            lambda progress: blended(analysis, setup, progress),
            done,
            failed=self._lost,
            key=BLEND,
        )
        self._of[BLEND] = key

    def _watch(self, analysis: Analysis) -> None:
        """Make ready what tells the error while a slider is dragged."""
        bounds = self._basis().setup.options.bounds
        if self._of.get(LIVE) == (analysis.key, bounds):
            return
        self.live = None

        def work(progress: Progress) -> LiveAlpha:
            from engine.basis.live import LiveAlpha

            quasi, motion = analysis.result.quasi, analysis.prepared.motion
            hand, ridge = analysis.hand, analysis.options.ridge

            def live(frames: int | None) -> LiveAlpha:
                return LiveAlpha(
                    hand.basis, quasi, motion, BOUNDS[bounds], hand.skin, frames, ridge=ridge, progress=progress
                )

            if motion.kind in ("factored", "driven") and len(motion) <= MOST_EXACT:
                exact, half = live(None), np.full(len(hand.basis), 0.5)
                start = time.perf_counter()
                exact.alpha(half)
                if time.perf_counter() - start <= LIVE_SECONDS:
                    return exact
            return live(LIVE_FRAMES)

        def done(live: LiveAlpha) -> None:
            self.live = live
            self.added.emit()

        self._tasks.submit("Making the slider ready", work, done, failed=_unheard, key=LIVE, quiet=True)
        self._of[LIVE] = analysis.key, bounds

    def _advise(self, analysis: Analysis) -> None:
        """Find out what to sculpt next."""
        bounds = self._basis().setup.options.bounds
        if self._of.get(ADVICE) == (analysis.key, bounds):
            return
        self.advice = None
        weights = analysis.result.comparison.weights["quasi_eigen"][bounds]

        def work(progress: Progress) -> Advice:
            from engine.basis.advice import advise

            hand, quasi = analysis.hand, analysis.result.quasi
            return advise(hand.basis, quasi, analysis.prepared.motion, weights, vertices=hand.skin, progress=progress)

        def done(advice: Advice) -> None:
            self.advice = advice
            self.added.emit()

        self._tasks.submit("Finding advice", work, done, failed=_unheard, key=ADVICE, quiet=True)
        self._of[ADVICE] = analysis.key, bounds

    def _measure(self) -> None:
        """Work out maxima and percentiles of the basis in use, the long part."""
        analysis, blend, setup = self.analysis, self.blend, self._basis().setup
        if analysis is None or blend is None:
            self._stop(EXTREMES)
            self._of.pop(EXTREMES, None)
            self.extremes = None
            return
        bounds = setup.options.bounds
        key = (analysis.key, tuple(sorted(setup.amounts.items())), bounds)
        if key == self._of.get(EXTREMES):
            return
        self.extremes = None
        weights = blend.comparison.weights["quasi_eigen"][bounds]

        def work(progress: Progress) -> Extremes:
            from engine.basis.extremes import error_extremes

            motion, skin = analysis.prepared.motion, analysis.hand.skin
            return error_extremes(blend.basis, motion, weights, vertices=skin, progress=progress)

        def done(found: Extremes) -> None:
            self.extremes = found
            self.added.emit()

        self._tasks.submit("Maxima and percentiles", work, done, key=EXTREMES)
        self._of[EXTREMES] = key

    # -- odds and ends --------------------------------------------------------------------------------------------

    def _tell_motion(
        self, prepared: PreparedMotion | None = None, motion_key: tuple[str, str, str] | None = None
    ) -> None:
        if self._asked is None:
            self._clear()
        elif prepared is not None or motion_key != self._prepared_of:
            self.prepared, self._prepared_of = prepared, None if prepared is None else motion_key
        self.changed.emit()

    def _clear(self) -> None:
        self.prepared = self.analysis = self._blend = self.extremes = self.live = self.advice = None
        self._prepared_of = None
        self._of.clear()

    def _on_task(self, task: Task) -> None:
        """Forget what a task was for that was stopped, cancelled, or failed: it is to be done again."""
        if task.key in DEPENDENT and task.state in (TaskState.CANCELLED, TaskState.FAILED):
            self._of.pop(task.key, None)
        if task.key in (ANALYSIS, BLEND) and task.state is TaskState.CANCELLED:
            self.added.emit()

    def _fail(self, text: str) -> None:
        self.trouble = text
        self.failed.emit(text)
        self.changed.emit()

    def _running(self, key: str) -> bool:
        return any(task.key == key and task.active for task in self._tasks.tasks)

    def _stop(self, *keys: str) -> None:
        for task in [task for task in self._tasks.tasks if task.key in keys and task.active]:
            self._tasks.cancel(task)


def _unheard(_error: BaseException) -> None:
    """Do without what is only a help."""


def _keep(kept: OrderedDict[Any, Any], key: Any, value: Any) -> None:
    kept[key] = value
    kept.move_to_end(key)
    while len(kept) > KEPT:
        kept.popitem(last=False)
