"""A scheme stood on a template: which vertex carries each fiducial, and what does not fit together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from engine.errors import InputError
from engine.landmarks import LandmarkDefinition, LandmarkScheme
from engine.scan.template import FaceTemplate, TemplateLayout, check_lips, lip_fiducials
from engine.scheme_checks import Finding, check_fiducials, check_head


def resolved_vertex(template: FaceTemplate, layout: str, landmark: LandmarkDefinition) -> int | None:
    """Return the vertex of a fiducial: its own, else that of the template's layout under the same name, else None."""
    if landmark.vertex is not None:
        return landmark.vertex
    return template.layout(layout).fiducials.get(landmark.name)


def with_vertices(template: FaceTemplate, scheme: LandmarkScheme) -> LandmarkScheme:
    """Return the scheme with the vertex number of every fiducial that has one on the template."""
    found = (replace(mark, vertex=resolved_vertex(template, scheme.layout, mark)) for mark in scheme)
    return replace(scheme, landmarks=tuple(found))


def side_of_vertex(template: FaceTemplate, vertex: int) -> str:
    """Return the subject's side that a vertex lies on: ``left``, ``right`` or ``middle`` (its own mirror)."""
    if int(template.mirror[vertex]) == vertex:
        return "middle"
    across = next(iter(template.layouts.values())).vertices[:, 0]
    return "left" if across[vertex] > across[template.mirror[vertex]] else "right"


def check_on_template(
    template: FaceTemplate, layout: str, landmarks: Sequence[LandmarkDefinition]
) -> Iterator[Finding]:
    """Yield what does not fit a template: vertices that are not there or taken, pairs and sides that it has otherwise.

    A lip of whose fiducials (``lip_fiducials`` and the outer middle) some are missing can be used, but then nothing
    guides its border between the points; an ``open`` scheme is told so by a finding that is no error.
    """
    ground = template.layouts.get(layout)
    if ground is None:
        yield Finding(None, "layout", f"the template has no layout {layout[:40]!r}", "choose another template")
        return
    count = len(template.mirror)
    vertices = [resolved_vertex(template, layout, landmark) for landmark in landmarks]
    owner: dict[int, int] = {}
    for row, (landmark, vertex) in enumerate(zip(landmarks, vertices, strict=True)):
        if vertex is None:
            yield Finding(row, "vertex", "has no vertex", "click its place on the template, or give its number")
        elif not 0 <= vertex < count:
            yield Finding(
                row, "vertex", f"vertex {vertex} is not one of 0 to {count - 1}", "choose one of the template"
            )
        elif vertex in owner:
            if None in (
                landmark.vertex,
                landmarks[owner[vertex]].vertex,
            ):  # two numbers are compared without a template
                problem = f"vertex {vertex} carries {landmarks[owner[vertex]].name} already"
                yield Finding(row, "vertex", problem, "choose another vertex")
        else:
            owner[vertex] = row
            yield from _check_side(template, row, landmark, vertex)
    rows = {landmark.name: row for row, landmark in enumerate(landmarks)}
    for row, landmark in enumerate(landmarks):
        other = rows.get(landmark.mirror)
        if other is not None and other > row and row in owner.values() and other in owner.values():
            here, there = vertices[row], vertices[other]
            assert here is not None
            partner = int(template.mirror[here])
            if partner != here and partner != there:
                problem = f"vertex {there} is not the mirror of {landmark.name}'s vertex {here}, which is {partner}"
                yield Finding(other, "vertex", problem, f"give it vertex {partner}")
    if len(owner) >= 3:
        yield from _check_line(ground, list(owner))
    fiducials = {landmarks[row].name: vertex for vertex, row in owner.items()}
    yield from _check_lips(template, layout, fiducials, rows)


def scheme_findings(
    template: FaceTemplate, name: str, title: str, layout: str, landmarks: Sequence[LandmarkDefinition]
) -> tuple[Finding, ...]:
    """Return everything that is wrong with a scheme, or worth knowing, in the order of its rows, errors first."""
    found = [
        *check_head(name, title, layout),
        *check_fiducials(landmarks),
        *check_on_template(template, layout, landmarks),
    ]
    return tuple(sorted(found, key=lambda f: (not f.is_error, -1 if f.row is None else f.row)))


def check_scheme(template: FaceTemplate, scheme: LandmarkScheme) -> tuple[Finding, ...]:
    """Return what is worth knowing of a scheme that can be used with a template.

    Raises
    ------
    InputError
        Naming scheme, fiducial and field, when it cannot be used.
    """
    findings = tuple(check_on_template(template, scheme.layout, scheme.landmarks))
    for finding in findings:
        if finding.is_error:
            mark = None if finding.row is None else scheme.landmarks[finding.row].name
            subject = f"scheme {scheme.name}, " + (finding.field if mark is None else f"{mark}, {finding.field}")
            raise InputError(subject, finding.problem, finding.remedy)
    return findings


@lru_cache(maxsize=8)
def template_with(template: FaceTemplate, scheme: LandmarkScheme) -> FaceTemplate:
    """Return what ``FaceTemplate.with_scheme`` returns; kept for the next call, so that a drag finds it warm."""
    check_scheme(template, scheme)
    fiducials = {mark.name: resolved_vertex(template, scheme.layout, mark) for mark in scheme}
    layout = TemplateLayout(
        template.layout(scheme.layout).vertices, {name: v for name, v in fiducials.items() if v is not None}
    )
    return replace(template, layouts={**template.layouts, scheme.name: layout})


def _check_side(template: FaceTemplate, row: int, landmark: LandmarkDefinition, vertex: int) -> Iterator[Finding]:
    there = side_of_vertex(template, vertex)
    if landmark.mirror and there != landmark.side:
        problem = f"is on the side {landmark.side!s}, but vertex {vertex} lies on the side {there}"
        yield Finding(row, "side", problem, "correct side or vertex")


def _check_line(layout: TemplateLayout, vertices: list[int]) -> Iterator[Finding]:
    places = layout.vertices[vertices]
    spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    if spread[-1] <= 1e-3 * spread[0]:
        yield Finding(None, "name", "all fiducials lie on one line of the template", "add some on both sides")


def _check_lips(
    template: FaceTemplate, layout: str, fiducials: dict[str, int], rows: dict[str, int]
) -> Iterator[Finding]:
    for lip in ("lip_upper", "lip_lower"):
        needed = (*lip_fiducials(lip), lip)
        missing = [name for name in needed if name not in fiducials]
        if missing:
            if layout == "open":
                problem = f"nothing guides the border of {lip} on an open mouth without {', '.join(missing)}"
                yield Finding(None, "layout", problem, "add what is missing, or accept a coarser lip", is_error=False)
            continue
        try:
            own = TemplateLayout(template.layout(layout).vertices, {name: fiducials[name] for name in needed})
            check_lips(template.name, layout, own, template.curves)
        except InputError as error:
            yield Finding(rows[f"{lip}_inner"], "vertex", error.problem, "put them back on the lip's border, in order")
