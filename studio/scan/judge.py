"""What the limits make of every face of the project, judged beside the window and kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from engine.errors import some
from engine.progress import Progress
from engine.scan.limits import Limits, Verdict
from studio.project.document import Change
from studio.scan.context import ScanContext
from studio.scan.job import template_of

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit

_MOST_NAMED = 2
_KEPT = 4096

Words = str
"""Empty for a face within its limits, else ``fails: lips, jaw`` or ``warns: brows``."""


class Judge(QObject):
    """Knows the verdict on every fresh face, in words; asks for none twice."""

    changed = Signal()
    """More verdicts are known."""

    def __init__(self, context: ScanContext, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._context = context
        self._known: dict[tuple[str, Limits], Words] = {}
        context.session.changed.connect(self._on_change)
        context.session.replaced.connect(self._look)

    def words(self, scan_id: str) -> Words:
        """Return what the limits make of a scan's fresh face; empty also while it is not known yet."""
        project = self._context.project
        key = project.fit_key(scan_id)
        return "" if key is None else self._known.get((key, project.limits), "")

    def _on_change(self, change: Change) -> None:
        if change.kind in ("fit", "limits", "added"):
            self._look()

    def _look(self) -> None:
        project = self._context.project
        limits, wanted = project.limits, {}
        for item in project.scans:
            key, fit = project.fit_key(item.id), project.fit(item.id)
            if key is not None and fit is not None and (key, limits) not in self._known:
                wanted[key] = fit
        if not wanted:
            return

        def work(progress: Progress) -> dict[str, Words]:
            found = {}
            for number, (key, fit) in enumerate(wanted.items()):
                progress(number / len(wanted), "")
                found[key] = in_words(fit, limits)
            return found

        def done(found: dict[str, Words]) -> None:
            if len(self._known) > _KEPT:
                self._known.clear()
            self._known |= {(key, limits): words for key, words in found.items()}
            self.changed.emit()

        self._context.session.tasks.submit("Judging faces", work, done, key="judge", quiet=True)


def in_words(fit: FaceFit, limits: Limits) -> Words:
    """Return which regions, or figures of the whole face, are beyond their limits, the worst kind alone."""
    from engine.scan.quality import measure, measure_regions, overall, verdicts
    from engine.scan.regions import regions_of

    checks, regions = verdicts(measure(fit), limits), measure_regions(fit, regions_of(template_of()), limits)
    worst = overall(checks, regions)
    if worst is Verdict.OK:
        return ""
    named = [region.name for region in regions if region.verdict is worst]
    named += [check.name.lower() for check in checks if check.verdict is worst]
    return f"{'fails' if worst is Verdict.FAIL else 'warns'}: {some(named, _MOST_NAMED)}"
