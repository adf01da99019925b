"""What is still missing, in one sentence, and the key that does it or leads there. No Qt."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from engine.errors import some
from engine.landmarks import LandmarkState
from studio.project.document import Project
from studio.scan.job import item_scheme, missing_fiducials

FEW = 4
"""So many proposals are confirmed one by one."""
MOST_NAMED = 3


@dataclass(frozen=True)
class NextStep:
    """A sentence for the status line and the id of the action that does it or leads there."""

    text: str
    action: str = ""


def next_step(
    project: Project,
    scan_id: str | None,
    current: str | None,
    doubtful: Collection[str] = (),
    failing: Sequence[str] = (),
) -> NextStep:
    """Return the next missing step: of the scan in view first, then of the others.

    Parameters
    ----------
    project : Project
        Read only.
    scan_id : str, optional
        The scan in view.
    current : str, optional
        The fiducial that a click would place.
    doubtful : collection of str
        Proposals on the scan in view that deserve a look.
    failing : sequence of str
        Names of fitted scans that fail their limits.
    """
    if not project.scans or scan_id is None or scan_id not in project:
        return NextStep("add scans or a folder of them, or open the sample", "scan.add")
    item = project.scan(scan_id)
    quoted = f"“{item.name}”"
    unset, proposed = missing_fiducials(item.landmarks, item_scheme(item))
    if unset:
        name = current if current in unset else unset[0]
        total = len(item_scheme(item))
        text = f"click {name} on {quoted}, {total - len(unset)} of {total} done"
        return NextStep(text, "" if current in unset else "scan.next")
    if proposed:
        if len(proposed) > FEW:
            return NextStep(
                f"look over {len(proposed)} proposed fiducials on {quoted}, then confirm all", "scan.confirm_all"
            )
        plural = "fiducial" if len(proposed) == 1 else "fiducials"
        return NextStep(f"confirm {len(proposed)} proposed {plural} on {quoted}", "scan.next")
    state = project.state(scan_id)
    if state.kind != "fresh":
        why = f" ({state.reason})" if state.kind == "stale" or state.reason != "no fit yet" else ""
        return NextStep(f"fit {quoted}{why}", "scan.fit")
    blank = [other for other in project.scans if not other.landmarks.points]
    if blank:
        what = f"“{blank[0].name}”" if len(blank) == 1 else f"{len(blank)} other scans"
        return NextStep(f"carry the fiducials of {quoted} to {what}", "scan.carry_to_all")
    for other in project.scans:
        if project.state(other.id).kind != "fresh":
            return NextStep(f"go on with “{other.name}”: {project.state(other.id).reason}", "scan.next")
    bad = f", but {some(failing, MOST_NAMED)} {'fails' if len(failing) == 1 else 'fail'} the limits" if failing else ""
    if not project.path:
        return NextStep(f"every scan is fitted{bad}: save the project", "file.save")
    return NextStep(f"every scan is fitted{bad}: export the faces", "scan.export_face")


def next_scan(project: Project, after: str | None) -> str | None:
    """Return the first scan after ``after`` that is not fresh, going round once; None when all are."""
    ids = [item.id for item in project.scans]
    start = ids.index(after) + 1 if after in ids else 0
    for scan_id in ids[start:] + ids[:start]:
        if project.state(scan_id).kind != "fresh":
            return scan_id
    return None


def first_unfinished(
    project: Project, scan_id: str, after: str | None = None, doubtful: Collection[str] = ()
) -> str | None:
    """Return the next unset fiducial of a scan after ``after``, else the next proposed one, doubtful ones first."""
    item = project.scan(scan_id)
    names = item_scheme(item).names
    start = names.index(after) + 1 if after in names else 0
    order = names[start:] + names[:start]
    unset = item.landmarks.names(LandmarkState.UNSET, order=order)
    proposed = item.landmarks.names(LandmarkState.PROPOSED, order=order)
    worth = [name for name in proposed if name in doubtful]
    return next(iter((*unset, *worth, *proposed)), None)
