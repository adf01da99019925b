"""A project becomes a report: the job that window and command line run alike. No Qt."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import InputError
from engine.files.atomic import check_writable
from engine.files.source import kind_of
from engine.landmarks import LandmarkState
from engine.progress import Progress, part, silent
from engine.scan.limits import Limits
from studio.report.options import ReportOptions
from studio.scan.job import METHOD, input_key, inputs_of, item_scheme, template_of
from studio.scan.job import run as fit_scan
from studio.scan.judged_figures import region_figures
from studio.scan.options import FitOptions

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from engine.scan.range_image import RangeImage
    from studio.project.document import Project, ScanItem, SourceInfo
    from studio.report.entry import Absent, Origin, ReportEntry

_SHARE_OF_FITS = 0.5


@dataclass(frozen=True, eq=False)
class ReportScan:
    """A scan as it is when a report is asked for.

    Parameters
    ----------
    item : ScanItem
    scan : RangeImage
    fit : FaceFit or None
        Its last fit.
    stale : str
        Why that fit does not belong to the present inputs, in words; empty where it does.
    needs : str
        What a fit would need first, in words; empty where it can be made.
    """

    item: ScanItem
    scan: RangeImage
    fit: FaceFit | None
    stale: str = ""
    needs: str = ""


@dataclass(frozen=True, eq=False)
class ReportResult:
    """What was written and found.

    ``files`` are the report and, where asked for, the contact sheet; ``names`` the scans that have a page; ``fits`` the
    fits by scan id that had to be made, each with its input key.
    """

    files: tuple[Path, ...]
    entries: tuple[ReportEntry, ...]
    absent: tuple[Absent, ...]
    fits: dict[str, tuple[str, FaceFit]] = field(default_factory=dict)
    names: tuple[str, ...] = ()

    def without_entries(self) -> ReportResult:
        """Return the result without what the pages were made of, to be sent to another process."""
        return replace(self, entries=())


def scans_of(project: Project) -> tuple[ReportScan, ...]:
    """Return the scans of a project as a report needs them; the project is not touched afterwards."""
    from studio.project.document import needs

    result = []
    for item in project.scans:
        state, fit = project.state(item.id), project.fit(item.id)
        # What lacks a fiducial may still have a fit from before: old, but there.
        stale = "" if state.kind == "fresh" else state.reason
        result.append(ReportScan(item, project.range_image(item.id), fit, stale if fit else "", needs(item)))
    return tuple(result)


def sheet_path(report: Path) -> Path:
    """Return where the contact sheet of a report goes."""
    return report.with_name(f"{report.stem}_sheet.png")


def check_out(out: Path) -> None:
    """Raise an InputError where a report clearly cannot be written to ``out``: its ending, its folder."""
    if out.suffix.lower() != ".pdf":
        raise InputError(str(out), "has no ending of a report", "end it in .pdf")
    for file in (out, sheet_path(out)):
        if kind_of(file.parent) is not None:
            check_writable(file)
    above = next((folder for folder in out.parent.parents if kind_of(folder) is not None), None)
    if kind_of(out.parent) is None and (above is None or kind_of(above) != "folder"):
        raise InputError(str(out), "its folder cannot be made", "choose another place")


def run(
    scans: Sequence[ReportScan],
    limits: Limits,
    options: ReportOptions,
    out: Path,
    progress: Progress = silent,
    *,
    title: str = "Scans fitted to the template",
    date: datetime.date | None = None,
) -> ReportResult:
    """Fit what is missing, where that is asked for, and write the report.

    Raises
    ------
    InputError
        When no scan has a fit, or a file cannot be written.
    Cancelled
        From ``progress``; no file is then changed.
    """
    from engine.scan.quality import measure_regions
    from engine.scan.regions import regions_of
    from studio.report.entry import Absent
    from studio.report.pages import write_report
    from widgets.scene.heatmap import HeatRange

    out = Path(out)
    check_out(out)
    regions = regions_of(template_of())
    entries, absent, made = [], [], {}
    for number, one in enumerate(scans):
        share = part(progress, _SHARE_OF_FITS * number / len(scans), _SHARE_OF_FITS * (number + 1) / len(scans))
        fit, note = one.fit, f"stale: {one.stale}" if one.stale else ""
        if (fit is None or one.stale) and not one.needs and options.fit_missing:
            share(0.0, f"fitting {one.item.name}")
            try:
                fit, note = fit_scan(inputs_of(one.item, one.scan), one.item.options, share), ""
            except InputError as error:
                fit = None
                absent.append(Absent(one.item.name, str(error)))
                continue
            made[one.item.id] = (input_key(one.item), fit)
        if fit is None:
            absent.append(Absent(one.item.name, one.needs or "not fitted yet"))
            continue
        entries.append(entry_of(one, fit, measure_regions(fit, regions, limits), note))
    if not entries:
        why = f" ({absent[0].name}: {absent[0].reason})" if absent else ""
        raise InputError("report", f"no scan has a fit{why}", "fit one first")
    sheet = sheet_path(out) if options.contact_sheet else None
    write_report(
        out,
        entries,
        title=title,
        limits=limits,
        heat=HeatRange(0.0, options.heat_mm),
        absent=absent,
        regions=regions,
        date=date,
        sheet=sheet,
        progress=part(progress, _SHARE_OF_FITS, 1.0),
    )
    return ReportResult(
        (out,) if sheet is None else (out, sheet),
        tuple(entries),
        tuple(absent),
        made,
        tuple(entry.name for entry in entries),
    )


def entry_of(one: ReportScan, fit: FaceFit, regions: Sequence[Any], note: str = "") -> ReportEntry:
    """Return a scan with its fit as the report's pages need it."""
    from engine.scan.quality import measure
    from studio.report.entry import ReportEntry

    item = one.item
    placed = inputs_of(item, one.scan).fiducials
    return ReportEntry(
        item.name, item.word, item.held, one.scan, placed, item.scheme, fit, measure(fit), tuple(regions),
        origin_of(item), note,
    )  # fmt: skip


def origin_of(item: ScanItem) -> Origin:
    """Return what a report says about where a scan's fit comes from."""
    from studio.report.entry import Origin

    source, order = item.source, item_scheme(item).names
    skipped = item.landmarks.names(LandmarkState.SKIPPED, order=order)
    placed = item.landmarks.names(LandmarkState.PLACED, order=order)
    name = Path(source.depth_file.replace("\\", "/")).name
    shown = ", ".join(skipped) if len(skipped) <= 2 else f"{len(skipped)}: {skipped[0]} ..."
    inputs = [
        ("file", _short(name) if name else "made in the studio"),
        ("unit", _unit(source)),
        ("scheme", f"{item.scheme}, {len(placed)} of {len(order)} placed"),
        ("skipped", shown or "none"),
    ]
    view = source.view
    if view is not None:
        inputs.append(("view", f"{view.width} x {view.height} px from {view.distance_mm:.0f} mm"))
    defaults = FitOptions()
    changed = [
        (entry.title or field_name, _shown(getattr(item.options, field_name)))
        for field_name, entry in FitOptions.model_fields.items()
        if getattr(item.options, field_name) != getattr(defaults, field_name)
    ]
    _method, scan, _scheme, fiducials, options = input_key(item).split("-")[:5]
    proof = [("method", f"{METHOD}"), ("scan key", scan[:16]), ("fiducials key", fiducials), ("options key", options)]
    return Origin(tuple(inputs), tuple(changed[:4]) or (("options", "as shipped"),), tuple(proof))


def _shown(value: object) -> str:
    return (
        ("on" if value else "off")
        if isinstance(value, bool)
        else f"{value:g}"
        if isinstance(value, float)
        else str(value)
    )


def _unit(source: SourceInfo) -> str:
    return source.assumed if source.assumed.startswith(source.unit) else f"{source.unit} {source.assumed}".strip()


def _short(text: str, most: int = 30) -> str:
    return text if len(text) <= most else f"{text[: most // 2 - 1]}...{text[-most // 2 + 2 :]}"


def figures(result: ReportResult, limits: Limits) -> dict[str, Any]:
    """Return the figures of a report under the names that scripts rely on."""
    from engine.scan.quality import verdicts
    from studio.report.overview import worst_region
    from studio.report.scan_page import entry_verdict

    rows = []
    for entry in result.entries:
        worst = worst_region(entry)
        rows.append(
            {
                "name": entry.name,
                "verdict": str(entry_verdict(entry, limits)),
                "stale": entry.note.removeprefix("stale: ") if entry.note else None,
                "worst_region": None if worst is None else worst.name,
                "checks": {c.name: str(c.verdict) for c in verdicts(entry.quality, limits) if c.verdict is not None},
                "regions": [region_figures(region) for region in entry.regions],
            }
        )
    absent = [{"name": scan.name, "reason": scan.reason} for scan in result.absent]
    return {"files": result.files, "scans": rows, "without_fit": absent, "fitted": len(result.fits)}
