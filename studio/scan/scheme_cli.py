"""``quasiface scheme ...``, and what ``--scheme`` means everywhere: a shipped scheme's name, or a file. No Qt."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from studio.output import Json, print_result, remark

if TYPE_CHECKING:
    from engine.landmarks import LandmarkScheme


def scheme_from(text: str) -> LandmarkScheme:
    """Return the shipped scheme of a name, or that of a ``.toml`` file.

    Raises
    ------
    InputError
        When it is neither, or the file cannot be read as a scheme.
    """
    from engine.errors import InputError
    from engine.files.scheme import read_scheme
    from studio.scan.job import SCHEMES, scheme_of

    if Path(text).suffix.lower() == ".toml":
        return read_scheme(text)
    if text not in SCHEMES:
        remedy = f"give {', '.join(SCHEMES)} or the .toml file of a scheme"
        raise InputError(f"--scheme {text!r}", "is no scheme", remedy)
    return scheme_of(text)


def scheme_files(text: str) -> tuple[Path, ...]:
    """Return the file that ``scheme_from`` reads; none for a shipped scheme's name."""
    return (Path(text),) if Path(text).suffix else ()


def check(file: Path, /, *, template: Path | None = None, as_json: Json = False) -> int:
    """Say what a fiducial scheme holds and whether it fits the template; remarks tell what is worth knowing.

    Parameters
    ----------
    file : Path
        The scheme (.toml).
    template : Path
        Another template than the one shipped.
    """
    from engine.errors import InputError
    from engine.files.scheme import read_scheme
    from engine.scan.scheme_vertices import check_scheme, with_vertices
    from studio.scan.job import template_of

    scheme, face = read_scheme(file), template_of(template)
    try:
        findings = check_scheme(face, scheme)
    except InputError as error:
        raise InputError(f"{file}, {error.subject}", error.problem, error.remedy) from None
    for finding in findings:
        remark(f"{file}: {finding.text}")
    values = {
        "name": scheme.name,
        "title": scheme.title,
        "layout": scheme.layout,
        "fiducials": len(scheme),
        "groups": list(dict.fromkeys(mark.group for mark in scheme)),
        "vertices": {mark.name: mark.vertex for mark in with_vertices(face, scheme)},
        "remarks": [finding.text for finding in findings],
    }
    print_result(values, as_json)
    return 0
