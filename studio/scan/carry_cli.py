"""``quasiface fiducials carry``: the fiducials of one scan proposed on others, by what their pictures show. No Qt."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from engine.errors import InputError
from studio.output import Json, print_result, print_table


def carry(
    source: Path,
    targets: list[Path],
    /,
    *,
    fiducials: Path,
    out: Path,
    unit: str | None = None,
    replace: bool = False,
    as_json: Json = False,
) -> int:
    """Write where the fiducials of one scan lie on others, as proposals to look over.

    Parameters
    ----------
    source : Path
        The scan whose fiducials are known.
    targets : list of Path
        Other scans of the same face, from about the same side.
    fiducials : Path
        The fiducials of the source: .json, .pts, .ljson or .csv.
    out : Path
        Folder for one <scan>_fiducials.json per target; made when it is not there.
    unit : str
        What the numbers of the scans' files mean: mm, cm, m; for meshes also the millimetres of one, as "85.3 mm".
    replace : bool
        Write over files of fiducials that are there.
    """
    from engine.files.landmarks_json import write_fiducials
    from engine.files.scan import read_scan
    from engine.landmarks import inside
    from engine.scan.carry import carry_fiducials
    from studio.scan.fiducial_files import fiducials_from
    from studio.scan.job import check_overwrites

    if not targets:
        raise InputError("targets", "none was given", "name the scans to carry the fiducials to")
    first = read_scan(source, unit)
    known = first.scan
    size = known.width, known.height
    positions, _ = fiducials_from(fiducials, "open", size, known, view=first.view, unit=first.unit)
    files = [out / f"{target.name.split('.')[0]}_fiducials.json" for target in targets]
    if len(set(files)) < len(files):
        raise InputError(str(out), "two scans have the same name", "carry them into different folders")
    check_overwrites(files, (fiducials, source, *targets))
    there = [file for file in files if file.exists()]
    if there and not replace:
        also = f"and {len(there) - 1} more are" if len(there) > 1 else "is"
        raise InputError(str(there[0]), f"{also} there already", "choose another folder, or say --replace")
    scans = [read_scan(target, unit).scan for target in targets]
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(str(out), f"cannot be made ({error.strerror})", "choose another folder") from error
    results: list[dict[str, Any]] = []
    for target, scan, file in zip(targets, scans, files, strict=True):
        found = carry_fiducials(known, positions, scan)
        within = {name: p for name, p in found.positions.items() if inside(*p, scan.width, scan.height)}
        write_fiducials(file, within, (scan.width, scan.height))
        results.append(
            {
                "scan": target,
                "file": file,
                "scheme": "closed" if found.opening is None else "open",
                "fiducials": len(within),
                "certain": sorted(found.certain & within.keys()),
                "doubtful": sorted(within.keys() - found.certain),
            }
        )
    if as_json:
        print_result({"carried": results}, True)
    else:
        rows = [[r["file"], r["fiducials"], len(r["doubtful"]), r["scheme"]] for r in results]
        print_table(("file", "fiducials", "doubtful", "mouth"), rows)
    return 0
