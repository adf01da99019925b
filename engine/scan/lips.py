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
    border keeps the template's profile of lip thickness, scaled to the thickness at the mid-line; where further
    fiducials lie on it, what they differ from that is shared out between them. Without the inner fiducials (a closed
    mouth, a scheme that has not all of them, or some of them skipped) a lip has no guides. Ours.
    """
    layout = template.layout(scheme)
    carried = {layout.fiducials[name]: column for column, name in enumerate(names)}
    vertices: list[int] = []
    rows: list[FloatArray] = []
    for lip in ("lip_upper", "lip_lower"):
        if not {lip, f"{lip}_inner"} <= set(template.curves) or not {*lip_fiducials(lip), lip} <= set(names):
            continue
        inner, outer = template.curves[f"{lip}_inner"], template.curves[lip]
        along = _arc_length(layout, inner)
        knots = [k for k, vertex in enumerate(inner) if int(vertex) in carried]
        columns = [carried[int(inner[k])] for k in knots]
        spline = CubicSpline(along[knots], np.eye(len(knots)), bc_type="natural")
        for vertex, share in zip(inner, along, strict=True):
            if int(vertex) not in carried:
                vertices.append(int(vertex))
                rows.append(_row(len(names), columns, spline(share)))
        middle, inner_middle = names.index(lip), names.index(f"{lip}_inner")
        thickness = layout.vertices[layout.fiducials[lip], 1] - layout.vertices[layout.fiducials[f"{lip}_inner"], 1]
        profile: dict[int, FloatArray] = {}
        for vertex in outer:
            x, y = layout.vertices[vertex]
            share = np.interp(x, layout.vertices[inner, 0], along)
            height = (y - np.interp(x, layout.vertices[inner, 0], layout.vertices[inner, 1])) / thickness
            row = _row(len(names), columns, spline(share))
            row[middle] += height
            row[inner_middle] -= height
            profile[int(vertex)] = row
        fixed = [int(vertex) for vertex in outer if int(vertex) in carried]
        off = np.array([np.eye(len(names))[carried[vertex]] - profile[vertex] for vertex in fixed])
        places = layout.vertices[fixed, 0]
        for vertex in profile:
            if vertex not in carried:
                shares = [np.interp(layout.vertices[vertex, 0], places, unit) for unit in np.eye(len(fixed))]
                vertices.append(vertex)
                rows.append(profile[vertex] + np.array(shares) @ off)
    return vertices, np.array(rows).reshape(len(rows), len(names))


def _arc_length(layout: TemplateLayout, curve: IntArray) -> FloatArray:
    steps = np.linalg.norm(np.diff(layout.vertices[curve], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _row(count: int, columns: list[int], values: FloatArray) -> FloatArray:
    row = np.zeros(count)
    row[columns] = values
    return row
