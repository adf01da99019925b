"""What is still to be done for the basis, in one sentence, and the action that does it or leads there. No Qt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from studio.project.document import ItemState, Project


@dataclass(frozen=True)
class BasisStep:
    """A sentence for the status line, and the id of the action that does it or leads there."""

    text: str
    action: str = ""


def next_basis_step(project: Project, state: ItemState, weak: Sequence[str], limit: float, busy: bool) -> BasisStep:
    """Return the next step.

    Parameters
    ----------
    project : Project
        Read only.
    state : ItemState
        How far the basis is.
    weak : sequence of str
        Shapes in use whose cosine to their hand shape lies below ``limit``, the lowest first.
    limit : float
        What a cosine must reach.
    busy : bool
        Whether the basis is being made just now.
    """
    basis = project.basis
    if basis.hand is None:
        if basis.rigs.all:
            return BasisStep("choose the hand-sculpted rig", "basis.choose_hand")
        return BasisStep("open a hand-sculpted rig, or the sample", "basis.add_rig")
    if basis.missing:
        return BasisStep(basis.lacks(basis.missing[0]), "basis.relink")
    if basis.motion is None:
        return BasisStep("open a performance of that face", "basis.add_motion")
    if busy:
        return BasisStep(f"the basis of “{basis.motion.name}” is being made")
    if state.kind != "fresh":
        why = f" ({state.reason})" if state.reason and state.reason != "no basis yet" else ""
        return BasisStep(f"make the basis{why}", "basis.analyse")
    if weak:
        many = f"{len(weak)} shapes" if len(weak) > 1 else "a shape"
        first = f", first {weak[0]}" if len(weak) > 1 else f": {weak[0]}"
        return BasisStep(f"look at {many} below cosine {limit:.2f}{first}", "basis.next")
    if not project.path:
        return BasisStep("the basis is made: save the project", "file.save")
    return BasisStep("the basis is made: export it", "basis.export")
