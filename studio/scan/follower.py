"""The 3-D face follows the fiducials: a refit after every step, beside the window, of which the latest wins."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from engine.errors import InputError
from engine.progress import Progress, part, silent
from engine.scan.limits import Limits
from engine.scan.range_image import RangeImage
from studio.project.document import FEWEST_FIDUCIALS, Project, ScanItem, needs
from studio.scan import edits
from studio.scan.job import FitInputs, input_key, item_scheme, repair_options, run
from studio.scan.options import FitOptions
from studio.tasks import TaskRunner, describe

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from engine.scan.quality import Check
    from engine.scan.repair import RepairedScan

PREVIEW_LEVELS = 2
"""A preview is not finer than this, so that it comes before the hand has moved on."""


@dataclass(frozen=True)
class ShownFit:
    """A face that can be shown: the fit, its figures, and whether it is only a preview.

    ``count`` of ``total`` fiducials were placed; the others were proposals.
    """

    fit: FaceFit
    checks: tuple[Check, ...]
    preview: bool
    count: int
    total: int

    @property
    def median_mm(self) -> float:
        """Median distance of visible vertices to the scan, mm."""
        return next((check.value for check in self.checks if check.name == "median"), float("nan"))


class RepairCache:
    """Repaired scans, the ones used last; safe to use from several threads."""

    def __init__(self, keep: int = 3) -> None:
        self._keep = keep
        self._lock = threading.Lock()
        self._scans: OrderedDict[tuple[str, Any], RepairedScan] = OrderedDict()

    def get(self, image_key: str, scan: RangeImage, options: FitOptions, progress: Progress = silent) -> RepairedScan:
        """Return the repaired scan, made now when it is not kept."""
        from engine.scan.repair import repair as repair_scan

        wanted = repair_options(options)
        key = (image_key, wanted)
        with self._lock:
            if key in self._scans:
                self._scans.move_to_end(key)
                return self._scans[key]
        progress(0.0, "repairing the scan")
        repaired = repair_scan(scan, wanted)
        with self._lock:
            self._scans[key] = repaired
            while len(self._scans) > self._keep:
                self._scans.popitem(last=False)
        return repaired


def figures(fit: FaceFit, limits: Limits) -> tuple[Check, ...]:
    """Return the figures of a fit with limits and verdicts."""
    from engine.scan.quality import measure, verdicts

    return tuple(verdicts(measure(fit), limits))


class FitFollower(QObject):
    """Keeps the face of the scan in view up to date.

    A scan whose fiducials are all decided gets its result, as the job makes it; one with proposals left gets a preview
    that is shown but not kept.
    """

    shown = Signal(str, object)
    """Scan id and its `ShownFit`, or None where there is none."""
    failed = Signal(str, str)
    """Scan id and why no face can be made of its fiducials."""

    def __init__(self, project: Callable[[], Project], tasks: TaskRunner, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._project = project
        self._tasks = tasks
        self.repaired = RepairCache()
        self._asked: tuple[str, str] | None = None
        self._figures: OrderedDict[str, tuple[FaceFit, tuple[Check, ...]]] = OrderedDict()

    def judge_anew(self) -> None:
        """Forget what was judged by other limits."""
        self._figures.clear()
        self.forget()

    def forget(self) -> None:
        """Take the next request for a new one, whatever it asks."""
        self._asked = None

    def follow(self, item: ScanItem) -> None:
        """Show the face of a scan as it is now; refit it when that is needed and possible."""
        project, scheme = self._project(), item_scheme(item)
        positions = edits.located(item.landmarks, scheme)
        whole = not needs(item)
        key = input_key(item) if whole else f"{item.id} {sorted(positions.items())} {hash(scheme)} {item.options}"
        if self._asked == (item.id, key):
            return
        self._asked = (item.id, key)
        unset = [n for n in scheme.names if n not in positions and item.landmarks[n].state != "skipped"]
        if whole and project.has_fit(key):
            fit = project.kept_fit(key)
            assert fit is not None
            self._stop()
            self.shown.emit(item.id, self._described(key, fit, item))
        elif unset or len(positions) < FEWEST_FIDUCIALS:
            self._stop()
            self._show_last(item)
        else:
            self._refit(item, positions, whole, key)

    def _refit(self, item: ScanItem, positions: edits.Positions, whole: bool, key: str) -> None:
        project = self._project()
        scan, scheme = project.range_image(item.id), item_scheme(item)
        levels = item.options.levels if whole else min(item.options.levels, PREVIEW_LEVELS)
        options = item.options.model_copy(update={"levels": levels})
        limits = project.limits

        def work(progress: Progress) -> tuple[FaceFit, tuple[Check, ...]]:
            repaired = self.repaired.get(item.image_key, scan, options, part(progress, 0.0, 0.5))
            fit = run(FitInputs(repaired, dict(positions), scheme), options, part(progress, 0.5, 0.9))
            return fit, figures(fit, limits)

        def done(result: tuple[FaceFit, tuple[Check, ...]]) -> None:
            fit, checks = result
            if whole:
                self._remember(key, fit, checks)
                project.put_fit(item.id, key, fit)
            self.shown.emit(item.id, self._shown_fit(item, fit, checks, preview=not whole))

        def failed(error: BaseException) -> None:
            self._asked = None if not isinstance(error, InputError) else self._asked
            self.failed.emit(item.id, describe(error))

        self._tasks.submit(f"Fitting “{item.name}”", work, done, failed=failed, key="follow", quiet=True)

    def _show_last(self, item: ScanItem) -> None:
        project = self._project()
        fit, key = project.fit(item.id), project.fit_key(item.id)
        self.shown.emit(item.id, None if fit is None or key is None else self._described(key, fit, item))

    def _described(self, key: str, fit: FaceFit, item: ScanItem) -> ShownFit:
        if key not in self._figures or self._figures[key][0] is not fit:
            self._remember(key, fit, figures(fit, self._project().limits))
        return self._shown_fit(item, fit, self._figures[key][1], preview=False)

    def _remember(self, key: str, fit: FaceFit, checks: tuple[Check, ...]) -> None:
        self._figures[key] = (fit, checks)
        while len(self._figures) > 64:
            self._figures.popitem(last=False)

    @staticmethod
    def _shown_fit(item: ScanItem, fit: FaceFit, checks: tuple[Check, ...], *, preview: bool) -> ShownFit:
        scheme = item_scheme(item)
        return ShownFit(fit, checks, preview, len(edits.placed(item.landmarks, scheme)), len(scheme))

    def _stop(self) -> None:
        for task in [task for task in self._tasks.tasks if task.key == "follow" and task.active]:
            self._tasks.cancel(task)
