"""The whole way on the bundled sample, without a display: scans become faces, a rig and a performance a basis."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from engine.errors import InputError
from engine.files.landmarks_json import check_fiducials, read_fiducials
from engine.files.scan import read_scan
from engine.landmarks import LandmarkSet
from engine.progress import Progress, part
from engine.scan.quality import measure_regions
from engine.scan.regions import regions_of
from studio.basis.demo import run as run_basis
from studio.output import print_result, print_table, progress_lines
from studio.project import store
from studio.project.document import SUFFIX, Project, ScanItem, SourceInfo
from studio.report.entry import ReportEntry
from studio.report.job import ReportScan, entry_of, sheet_path
from studio.scan.dropped import ScanToRead
from studio.scan.job import export_face, figures, input_key, inputs_of, template_of
from studio.scan.job import run as fit_scan
from studio.scan.options import FitOptions
from studio.scan.sample import sample_scans

_FIGURES = (
    "fiducial_residual_px",
    "median_mm",
    "p95_mm",
    "p99_mm",
    "max_mm",
    "filled_vertices",
    "folded_faces",
    "vertices",
    "faces",
    "verdict",
)
_SHARE_OF_FITS, _SHARE_OF_SCANS = 0.25, 0.5


@dataclass(frozen=True)
class DemoFiles:
    """Where everything is: faces (GLB and OBJ with their companions), project, report and plates."""

    faces: tuple[Path, ...]
    project: Path
    report: Path
    plates: tuple[Path, ...]


def run(out: Path, as_json: bool = False) -> int:
    """Do all of it, print figures and places, and return the exit code.

    Raises
    ------
    InputError
        When ``out`` cannot be written to.
    """
    started = time.monotonic()
    progress = progress_lines()
    make_folders(out)
    scans, report = part(progress, 0.0, _SHARE_OF_FITS), part(progress, _SHARE_OF_FITS, _SHARE_OF_SCANS)
    entries, project, faces = fit_sample(sample_scans(), out / "faces", scans)
    files = write_results(out, entries, project, faces, report)
    bases = run_basis(out / "basis", out / "plates", project, part(progress, _SHARE_OF_SCANS, 1.0))
    store.save(project, files.project)
    seconds = time.monotonic() - started
    rows = [{"name": entry.name, **figures(entry.fit)} for entry in entries]
    if as_json:
        made = {"bases": bases.rows, "basis_checks": bases.checks, "basis_files": bases.files}
        plates = (*files.plates, *bases.plates)
        found = {"out": out, "scans": rows, **vars(files), **made, "plates": plates, "seconds": round(seconds, 3)}
        print_result(found, True)
        return 0
    print_table(("scan", *_FIGURES), [(row["name"], *(row[name] for name in _FIGURES)) for row in rows])
    print()
    columns = [name for name in bases.rows[0] if name != "warnings"]
    print_table(columns, [[row[name] for name in columns] for row in bases.rows])
    for row in bases.rows:
        for warning in row["warnings"]:
            print(f"{row['basis']}: {warning}")
    print()
    places = {
        "faces": out / "faces",
        "basis": out / "basis",
        "project": files.project,
        "report": files.report,
        "plates": out / "plates",
    }
    print_result({**places, "seconds": f"{seconds:.1f}"}, False)
    return 0


def make_folders(out: Path) -> None:
    """Make the demo's folders; InputError where that is not possible."""
    for folder in (out, out / "faces", out / "basis", out / "plates"):
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            problem = f"the folder cannot be made ({error.strerror or error})"
            raise InputError(str(folder), problem, "choose another place with --out") from None


def fit_sample(
    scans: Sequence[ScanToRead], faces: Path, progress: Progress
) -> tuple[list[ReportEntry], Project, tuple[Path, ...]]:
    """Fit every scan and write its face as GLB and OBJ into the folder ``faces``.

    Returns
    -------
    entries, project, files
        What the report is made of, a project with all scans and their fits, and the files that were written.
    """
    project = Project("demo")
    entries: list[ReportEntry] = []
    files: list[Path] = []
    for number, sample in enumerate(scans):
        share = part(progress, number / len(scans), (number + 1) / len(scans))
        share(0.0, f"fitting {sample.name}")
        entry = _fit(sample, project)
        entries.append(entry)
        for suffix in (".glb", ".obj"):
            files += export_face(entry.fit, entry.scan, faces / f"{sample.name}{suffix}")
    return entries, project, tuple(files)


def write_results(
    out: Path, entries: Sequence[ReportEntry], project: Project, faces: tuple[Path, ...], progress: Progress
) -> DemoFiles:
    """Write project, report and plates into the folder ``out``."""
    from studio.report.pages import write_report
    from studio.report.plates import write_plates

    progress(0.0, "saving the project")
    place = store.save(project, out / f"demo{SUFFIX}")
    progress(0.1, "writing the report")
    report = out / "report.pdf"
    write_report(report, entries, title="The bundled sample", limits=project.limits, sheet=sheet_path(report))
    progress(0.5, "drawing the plates")
    plates = write_plates(out / "plates", entries, template_of())
    progress(1.0, "done")
    return DemoFiles(faces, place, report, tuple(plates))


def _fit(sample: ScanToRead, project: Project) -> ReportEntry:
    """Read and fit one scan, and put both into the project."""
    file = read_scan(sample.path)
    scan = file.scan
    if sample.fiducials is None:
        raise InputError(str(sample.path), "comes without fiducials", "install the sample again")
    placed = read_fiducials(sample.fiducials)
    options = FitOptions()
    item = ScanItem(
        f"sample-{sample.name}",
        sample.name,
        project.add_image(scan),
        sample.word,
        sample.held,
        scheme=sample.scheme,
        landmarks=LandmarkSet.placed(placed.positions),
        options=options,
    )
    inputs = inputs_of(item, scan)
    check_fiducials(placed, inputs.fiducials, (scan.width, scan.height), str(sample.fiducials))
    fit = fit_scan(inputs, options)
    source = SourceInfo(
        str(sample.path), file.unit, file.assumed, scan.width, scan.height, scan.missing_fraction, fit.repair.spikes
    )
    project.insert_scan(len(project.scans), item)
    project.change_scan(item.id, source=source)
    project.put_fit(item.id, input_key(item), fit)
    found = measure_regions(fit, regions_of(template_of()), project.limits)
    return entry_of(ReportScan(project.scan(item.id), scan, fit), fit, found)
