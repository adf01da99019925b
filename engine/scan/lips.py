"""Guides along the lips of an open mouth, so that its border runs along the lips and not across the opening.

A spline through few fiducials spreads each one's pull over its neighbourhood: where the slit opens to many times its
width in the template, the border sags into the mouth between them and the lower lip comes to a point. The guides are
further nodes on both borders of both lips. Their places are linear in the fiducials, so the warp stays one product.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from engine.mesh import FloatArray, IntArray
from engine.scan.template import FaceTemplate, TemplateLayout, lip_fiducials


def lip_guides(template: FaceTemplate, scheme: str, names: tuple[str, ...]) -> tuple[list[int], FloatArray]:
    """Return the guides' vertices and the matrix (guides, fiducials) that places them.

    The inner border is a cubic spline through corners and inner fiducials over the template's own arc length. The outer
    border keeps the template's profile of lip thickness, scaled to the thickness at the mid-line. Without the inner
    fiducials (a closed mouth, or some of them skipped) there are no guides. Ours.
    """
    layout = template.layout(scheme)
    vertices: list[int] = []
    rows: list[FloatArray] = []
    for lip in ("lip_upper", "lip_lower"):
        inner_names = lip_fiducials(lip)
        needed = (*inner_names, lip)
        if not {lip, f"{lip}_inner"} <= set(template.curves) or not set(needed) <= set(names):
            continue
        inner, outer = template.curves[f"{lip}_inner"], template.curves[lip]
        columns = [names.index(name) for name in inner_names]
        along = _arc_length(layout, inner)
        knots = along[[int(np.flatnonzero(inner == layout.fiducials[name])[0]) for name in inner_names]]
        spline = CubicSpline(knots, np.eye(5), bc_type="natural")
        placed = {int(v) for v in (layout.fiducials[name] for name in needed)}
        for vertex, share in zip(inner, along, strict=True):
            if int(vertex) not in placed:
                vertices.append(int(vertex))
                rows.append(_row(len(names), columns, spline(share)))
        middle = names.index(lip)
        thickness = layout.vertices[layout.fiducials[lip], 1] - layout.vertices[layout.fiducials[f"{lip}_inner"], 1]
        for vertex in outer:
            if int(vertex) in placed:
                continue
            x, y = layout.vertices[vertex]
            share = np.interp(x, layout.vertices[inner, 0], along)
            profile = (y - np.interp(x, layout.vertices[inner, 0], layout.vertices[inner, 1])) / thickness
            row = _row(len(names), columns, spline(share))
            row[middle] += profile
            row[names.index(f"{lip}_inner")] -= profile
            vertices.append(int(vertex))
            rows.append(row)
    return vertices, np.array(rows).reshape(len(rows), len(names))


def _arc_length(layout: TemplateLayout, curve: IntArray) -> FloatArray:
    steps = np.linalg.norm(np.diff(layout.vertices[curve], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _row(count: int, columns: list[int], values: FloatArray) -> FloatArray:
    row = np.zeros(count)
    row[columns] = values
    return row
