"""What an artist may do next, as the advice panel shows it: a sentence and what its buttons do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from engine.mesh import FloatArray
from widgets.basis.advice_panel import AdviceItem
from widgets.basis.words import count

if TYPE_CHECKING:
    from engine.basis.advice import Advice
    from studio.basis.results import Analysis

MOST_DRIFTS = 3


def advice_items(
    analysis: Analysis, amounts: FloatArray, advice: Advice | None, shape: str | None = None
) -> list[AdviceItem]:
    """Return advice, that on the shape in view first, then the weightiest.

    The keys of actions: ``keep|NAME|AMOUNT``, ``shape|NAME``, ``axis|NUMBER``, ``frame|NUMBER``, numbers from 0.
    """
    items: list[AdviceItem] = []
    named = dict(zip(analysis.names, amounts, strict=True))
    if advice is not None:
        drifting = [drift for drift in advice.drifting if named[drift.name] > drift.amount + 1e-9]
        drifting.sort(key=lambda drift: drift.name != shape)
        for drift in drifting[:MOST_DRIFTS]:
            rest = round(100 * (1 - drift.amount))
            text = f"{drift.name} drifts from its hand shape"
            tip = f"Cosine {drift.cosine:.2f}; with {rest} % of the hand shape it is recognisable again"
            keep = (f"keep|{drift.name}|{drift.amount:.4f}", f"Keep {rest} % of hand")
            items.append(AdviceItem(text, "warn", (keep, (f"shape|{drift.name}", "Show")), tip))
        if len(drifting) > MOST_DRIFTS:
            more = len(drifting) - MOST_DRIFTS
            items.append(AdviceItem(f"{more} more shapes drift", "warn", (("keep_all", "Keep all recognisable"),)))
    for axis in analysis.result.quasi.missing:
        text = f"No shape touches axis {axis + 1}"
        tip = "Add it as a shape and make it recognisable, or sculpt one that does what it does"
        items.append(AdviceItem(text, "warn", ((f"axis|{axis}", f"Show axis {axis + 1}"),), tip))
    for warning in analysis.result.quasi.warnings:
        text, _, names = warning.partition(": ")
        items.append(AdviceItem(text, "warn", (), names))
    if advice is not None:
        for found in advice.uncovered:
            frame = found.frames[0]
            text = f"{100 * found.share:.0f} % of the remaining error is one motion at the {found.region}"
            tip = f"{found.rms_mm:.2f} mm RMS; {found.nearest[0][0]} comes nearest: sculpt or change a shape for it"
            items.append(AdviceItem(text, "info", ((f"frame|{frame}", f"Show frame {count(frame + 1)}"),), tip))
    return sorted(items, key=lambda item: not item.actions)  # what can be done at a click goes first
