"""One scan and its fiducials become a fitted face: the job that window, command line and demo run alike."""

from __future__ import annotations

import hashlib
import json
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import InputError, some
from engine.landmarks import LandmarkScheme, LandmarkSet, LandmarkState
from engine.progress import Progress, silent
from studio.scan.options import FitOptions
from studio.scan.view_options import ViewOptions

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from engine.scan.range_image import RangeImage
    from engine.scan.repair import RepairedScan, RepairOptions
    from engine.scan.template import FaceTemplate
    from studio.project.document import ScanItem

SCHEMES = ("closed", "open")
"""Names of the fiducial schemes that are shipped."""

METHOD = 1
"""Version of the fitting method; raised whenever the same inputs begin to give another face."""


@dataclass(frozen=True)
class FitInputs:
    """What a fit is made of.

    Parameters
    ----------
    scan : RangeImage or RepairedScan
        The scan as it was read, mm; or repaired with the same options before, which makes a refit take milliseconds.
    fiducials : mapping of str to (x, y)
        Pixel positions; every name of the scheme but the skipped ones.
    scheme : {"closed", "open"} or LandmarkScheme
        Which set of fiducials, and with it which layout of the template.
    template : Path, optional
        Another template than the one shipped.
    """

    scan: RangeImage | RepairedScan
    fiducials: Mapping[str, tuple[float, float]]
    scheme: str | LandmarkScheme = "closed"
    template: Path | None = None


def scheme_of(scheme: str | LandmarkScheme) -> LandmarkScheme:
    """Return the shipped scheme of a name; a scheme itself comes back as it is.

    Raises
    ------
    InputError
        When there is no such scheme.
    """
    if not isinstance(scheme, str):
        return scheme
    if scheme not in SCHEMES:
        raise InputError(f"scheme {scheme!r}", "is not known", f"use one of {', '.join(SCHEMES)}")
    return _shipped_scheme(scheme)


@lru_cache(maxsize=len(SCHEMES))
def _shipped_scheme(name: str) -> LandmarkScheme:
    import resources
    from engine.files.scheme import read_scheme

    return read_scheme(resources.scheme_path(name))


def item_scheme(item: ScanItem) -> LandmarkScheme:
    """Return the scheme of a scan: the project's own that it carries, or the shipped one that it names."""
    return item.custom or scheme_of(item.scheme)


def is_shipped(scheme: LandmarkScheme) -> bool:
    """Return whether a scheme is one of those that come with the program, unchanged."""
    return scheme.name in SCHEMES and scheme == scheme_of(scheme.name)


def check_custom(scheme: LandmarkScheme) -> None:
    """Raise an InputError unless a scheme can be one of a project: a name of its own, vertices of our template."""
    if scheme.name in SCHEMES:
        raise InputError(f"scheme {scheme.name}", "has the name of one that comes with the program", "rename it")
    template_of().with_scheme(scheme)


def template_of(path: Path | None = None) -> FaceTemplate:
    """Return the template of ``path``, read anew, or the one shipped."""
    from engine.files.template import read_template

    return _shipped_template() if path is None else read_template(path)


@lru_cache(maxsize=1)
def _shipped_template() -> FaceTemplate:
    import resources
    from engine.files.template import read_template

    return read_template(resources.template_path())


def template_for(path: Path | None, scheme: str | LandmarkScheme) -> FaceTemplate:
    """Return the template of ``path``, or the one shipped, with a layout of the scheme's name and all its fiducials.

    Raises
    ------
    InputError
        Naming the template's file, when it has no layout for the scheme or the layout lacks a fiducial; naming the
        scheme's fiducial, when its vertex does not fit.
    """
    import resources

    template, definition = template_of(path), scheme_of(scheme)
    subject = str(resources.template_path() if path is None else path)
    try:
        if not is_shipped(definition):
            return template.with_scheme(definition)
        layout = template.layout(definition.name)
    except InputError as error:
        raise InputError(f"{subject}, {error.subject}", error.problem, error.remedy) from None
    missing = [name for name in definition.names if name not in layout.fiducials]
    if missing:
        problem = f"the template has no vertex for {some(missing)}"
        raise InputError(f"{subject}, layout {definition.name}, fiducials", problem, "name the vertex in the template")
    return template


def usable_fiducials(landmarks: LandmarkSet, scheme: str | LandmarkScheme) -> dict[str, tuple[float, float]]:
    """Return the placed positions, in pixels, of those names that are in ``scheme``, in its order."""
    names = landmarks.names(LandmarkState.PLACED, order=scheme_of(scheme).names)
    return {name: (landmarks[name].x, landmarks[name].y) for name in names}


def missing_fiducials(landmarks: LandmarkSet, scheme: str | LandmarkScheme) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names that still have to be (placed, confirmed) before a fit can be made."""
    names = scheme_of(scheme).names
    return (
        landmarks.names(LandmarkState.UNSET, order=names),
        landmarks.names(LandmarkState.PROPOSED, order=names),
    )


def repair_options(options: FitOptions) -> RepairOptions:
    """Return the engine's repair options."""
    from engine.scan.repair import RepairOptions

    return RepairOptions(**options.model_dump(exclude={"levels"}))


def run(inputs: FitInputs, options: FitOptions, progress: Progress = silent) -> FaceFit:
    """Repair the scan, warp the template onto its fiducials and sample the face.

    Raises
    ------
    InputError
        On fiducials that are duplicate, collinear, too few or outside the picture, and a template that lacks them.
    Cancelled
        From ``progress``.
    """
    from engine.scan.fit import fit_template, warp_template

    template, name = template_for(inputs.template, inputs.scheme), scheme_of(inputs.scheme).name
    # Says what is wrong with the fiducials before the long part begins.
    warp_template(template, name, inputs.fiducials)
    return fit_template(
        inputs.scan,
        inputs.fiducials,
        template,
        name,
        levels=options.levels,
        repair=repair_options(options),
        progress=progress,
    )


def inputs_of(item: ScanItem, scan: RangeImage) -> FitInputs:
    """Return what the fit of a project's scan is made of."""
    scheme = item_scheme(item)
    return FitInputs(scan, usable_fiducials(item.landmarks, scheme), scheme)


def _digest(value: object) -> str:
    text = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def input_key(item: ScanItem) -> str:
    """Return the key of everything that the fit of ``item`` depends on.

    The key has one part each for method, scan, scheme, fiducials and options, so that two keys also tell *what*
    differs (``changes``). Points that are not placed, or not in the scheme, have no part in it; nor has a lock. Of a
    scheme of the project's own, layout, names and vertices count, not its texts or its order.
    """
    scheme = item_scheme(item)
    fiducials = usable_fiducials(item.landmarks, scheme)
    content = [scheme.layout, sorted([mark.name, mark.vertex] for mark in scheme)]
    parts = (
        f"m{METHOD}",
        item.image_key[:32],
        item.scheme if item.custom is None else _digest(content),
        _digest({name: [x.hex(), y.hex()] for name, (x, y) in fiducials.items()}),
        _digest(item.options.model_dump()),
    )
    return "-".join(parts)


_REASONS = ("made by another version", "scan replaced", "scheme changed", "fiducials moved", "options changed")


def changes(old: str, new: str) -> tuple[str, ...]:
    """Return what differs between two input keys, in words; a change of scheme covers that of its fiducials."""
    found = [why for why, a, b in zip(_REASONS, old.split("-"), new.split("-"), strict=False) if a != b]
    if "scheme changed" in found and "fiducials moved" in found:
        found.remove("fiducials moved")
    return tuple(found)


def as_command(item: ScanItem, options: FitOptions, fiducials: str = "", out: str = "") -> str:
    """Return the command line that makes the same fit; only options that differ from their default are written.

    ``fiducials`` and ``out`` name the two files; left out, they are called after the scan.
    """
    source = item.source.depth_file or f"{item.name}.npz"
    words = ["quasiface", "scan", "fit", source]
    words += ["--fiducials", fiducials or f"{item.name}_fiducials.json"]
    if item.scheme != "closed":
        words += ["--scheme", item.scheme if item.custom is None else f"{item.scheme}.toml"]
    for name in item.landmarks.names(LandmarkState.SKIPPED, order=item_scheme(item).names):
        words += ["--skip", name]
    if item.source.unit_asked:  # else the file states it, or it is assumed there as well
        words += ["--unit", item.source.unit]
    if item.source.view is not None and item.source.view_asked:
        words += ViewOptions.of(item.source.view).words()
    for name, value in options.model_dump().items():
        if value == FitOptions.model_fields[name].default:
            continue
        flag = name.replace("_", "-")
        words += [f"--{flag}" if value else f"--no-{flag}"] if isinstance(value, bool) else [f"--{flag}", f"{value:g}"]
    words += ["--out", out or f"{item.name}.glb"]
    return shlex.join(words)


def figures(fit: FaceFit) -> dict[str, Any]:
    """Return the figures of a face under the names that scripts rely on, with the worst verdict on them."""
    from engine.scan.quality import Verdict, measure, verdicts

    quality = measure(fit)
    found = {check.verdict for check in verdicts(quality)}
    return {
        **asdict(quality),
        "verdict": next(str(v) for v in (Verdict.FAIL, Verdict.WARN, Verdict.OK) if v in found),
        "folded_fiducials": list(fit.folded_fiducials),
        "levels": fit.levels,
        "scheme": fit.scheme,
        **asdict(fit.repair),
    }


def provenance(fit: FaceFit) -> dict[str, Any]:
    """Return what a face's file says about how it was made, as plain values."""
    return {
        "scheme": fit.scheme,
        "levels": fit.levels,
        "fiducial_residual_px": fit.fiducial_residual_px,
        "filled_vertices": int(fit.filled.sum()),
        "folded_faces": len(fit.folded_faces),
        "repair": asdict(fit.repair),
    }


def face_files(path: Path, textured: bool) -> tuple[Path, ...]:
    """Return the files that a face exported to ``path`` makes or replaces; the suffix chooses the format.

    Raises
    ------
    InputError
        On another suffix than ``.glb`` and ``.obj``, and where one of the files clearly cannot be written.
    """
    from engine.files.atomic import check_writable
    from engine.files.obj import obj_files

    suffix = path.suffix.lower()
    if suffix not in (".glb", ".obj"):
        raise InputError(str(path), "has no ending that tells the format", "end it in .glb or .obj")
    files = (path,) if suffix == ".glb" else obj_files(path, textured)
    for file in files:
        check_writable(file)
    return files


def check_overwrites(files: Iterable[Path], sources: Iterable[Path]) -> None:
    """Raise an InputError when one of ``files``, which are to be written, is one of ``sources``, links followed."""
    kept = {source.resolve() for source in sources}
    for file in files:
        if file.resolve() in kept:
            raise InputError(str(file), "would be replaced, but the face is made from it", "choose another name")


def export_face(
    fit: FaceFit, scan: RangeImage, path: Path, progress: Progress = silent, *, sources: Iterable[Path] = ()
) -> tuple[Path, ...]:
    """Write a fitted face with the scan's colour picture as its texture; the suffix chooses the format.

    Parameters
    ----------
    fit : FaceFit
        The face, mm.
    scan : RangeImage
        The scan it was fitted to; its colour picture becomes the texture.
    path : Path
        ``.glb`` (metres, as the format wants it) or ``.obj`` (mm, with ``.mtl`` and ``_texture.png`` beside it).
    sources : iterable of Path
        Files that the face was made from; none of them is replaced.

    Returns
    -------
    tuple of Path
        The files that were written.

    Raises
    ------
    InputError
        On another suffix, a folder that cannot be written to, or a file that would replace one of ``sources``.
    """
    path = Path(path)
    check_overwrites(face_files(path, scan.colour is not None), sources)
    progress(0.0, f"Writing {path.name}")
    if path.suffix.lower() == ".glb":
        from engine.files.glb import write_glb

        write_glb(path, fit.mesh, normals=fit.normals, texture=scan.colour, name=path.stem, extras=provenance(fit))
        written: tuple[Path, ...] = (path,)
    else:
        from engine.files.obj import write_obj

        written = write_obj(path, fit.mesh, normals=fit.normals, texture=scan.colour, name=path.stem)
    progress(1.0, f"Wrote {path.name}")
    return written
