"""Custom schemes stood on the template: planted warps, the sample's fit, and what must not be accepted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.errors import InputError
from engine.landmarks import LandmarkDefinition, LandmarkScheme, Side
from engine.mesh import FloatArray
from engine.scan.fit import fit_template
from engine.scan.lips import lip_guides
from engine.scan.quality import measure
from engine.scan.repair import repair
from engine.scan.scheme_vertices import check_scheme, side_of_vertex, with_vertices
from engine.scan.warp import mirror_proposals, propose_fiducials, warp_template
from tests.engine.scan.truth import bundled_scan
from tests.engine.schemes import CHEEKS, TEMPLATE, changed, quick, shipped, thorough

LAYOUT = TEMPLATE.layout("closed")


def planted(vertices: FloatArray) -> FloatArray:
    """A smooth map of the flat template to pixels that is bent more than a few points can say."""
    x, y = vertices.T / 100.0
    bent = np.stack([x + 0.06 * np.sin(3.0 * y) * x, y + 0.05 * np.cos(2.5 * x + 1.0) + 0.04 * x * x], axis=1)
    return 150.0 * bent + [320.0, -60.0]


def clicks(scheme: LandmarkScheme) -> dict[str, tuple[float, float]]:
    """Return the places of a scheme's fiducials under the planted map."""
    found = with_vertices(TEMPLATE, scheme)
    places = planted(LAYOUT.vertices)
    return {mark.name: (float(places[mark.vertex, 0]), float(places[mark.vertex, 1])) for mark in found}


def miss_px(scheme: LandmarkScheme) -> float:
    warp = warp_template(TEMPLATE.with_scheme(scheme), scheme.name, clicks(scheme))
    assert warp.residual_px < 1e-6 and len(warp.folded) == 0
    return float(np.sqrt(np.mean((warp.vertices - planted(LAYOUT.vertices)) ** 2)))


def test_more_fiducials_find_a_planted_warp_better() -> None:
    few, usual, many = miss_px(quick()), miss_px(shipped("closed")), miss_px(thorough())
    assert many < 0.75 * usual and usual < 0.75 * few


def test_a_scheme_of_the_same_vertices_is_the_same_warp() -> None:
    own = replace(shipped("closed"), name="own", title="")
    places = clicks(own)
    mine = warp_template(TEMPLATE.with_scheme(own), "own", places).vertices
    np.testing.assert_allclose(mine, warp_template(TEMPLATE, "closed", places).vertices, rtol=0, atol=1e-9)


@pytest.mark.parametrize("count", [12, 30])
def test_custom_schemes_fit_the_sample(count: int) -> None:
    scan, places = bundled_scan("base")
    repaired = repair(scan)
    usual = fit_template(repaired, places, TEMPLATE, "closed", levels=2)
    scheme = quick() if count == 12 else thorough()
    assert len(scheme) == count
    # Where the ten further points are on the picture, the usual warp says; a picture by hand says little else.
    flat = warp_template(TEMPLATE, "closed", places).vertices
    where = {mark.name: places.get(mark.name, tuple(flat[mark.vertex])) for mark in scheme if mark.vertex is not None}
    face = fit_template(repaired, where, TEMPLATE.with_scheme(scheme), scheme.name, levels=2)
    mine, theirs = measure(face), measure(usual)
    assert face.scheme == scheme.name and face.fiducial_residual_px < 1e-6 and len(face.folded_faces) == 0
    assert mine.median_mm <= theirs.median_mm * (1.02 if count == 30 else 1.15)
    assert mine.p99_mm <= theirs.p99_mm * (1.05 if count == 30 else 1.5)


def test_proposals_and_mirrors_know_the_points_of_a_custom_scheme() -> None:
    scheme, places = thorough(), clicks(thorough())
    known = {name: places[name] for name in shipped("closed").names}
    proposed = propose_fiducials(TEMPLATE.with_scheme(scheme), scheme.name, known)
    assert set(proposed) == set(scheme.names) - set(known)
    assert max(np.hypot(*np.subtract(proposed[name], places[name])) for name in proposed) < 8.0
    lefts = {name: places[name] for name in places if not name.endswith("right") and "right" not in name}
    assert {f"{name}_right" for name in CHEEKS} <= set(mirror_proposals(scheme, lefts))


def test_a_fiducial_without_partner_takes_no_part_in_mirroring() -> None:
    mole = LandmarkDefinition("mole", "marks", Side.LEFT, "", "The mole.", 140)
    scheme = LandmarkScheme("own", "", (*quick().landmarks, mole))
    places = {name: place for name, place in clicks(scheme).items() if name in ("lip_upper", "chin", "mole")}
    assert mirror_proposals(scheme, places) == {}
    assert check_scheme(TEMPLATE, scheme) == ()


def test_the_side_of_a_vertex_is_the_subjects() -> None:
    for mark in shipped("open"):
        assert mark.vertex is not None and side_of_vertex(TEMPLATE, mark.vertex) == mark.side


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"vertex": 441}, "mouth_left, vertex: vertex 441 is not one of 0 to 440"),
        ({"vertex": 10**9}, "mouth_left, vertex: vertex 1000000000 is not one of"),
        ({"vertex": 268}, "mouth_left, side: is on the side left, but vertex 268 lies on the side right"),
        ({"vertex": 40}, "mouth_right, vertex: vertex 267 is not the mirror of mouth_left's vertex 40"),
    ],
)
def test_a_vertex_that_does_not_fit_is_named(fields: dict[str, int], words: str) -> None:
    wrong = LandmarkScheme("own", "", changed(quick(), "mouth_left", **fields))
    with pytest.raises(InputError, match=words):
        TEMPLATE.with_scheme(wrong)


def test_a_fiducial_that_nobody_placed_on_the_template_is_named() -> None:
    ear = LandmarkDefinition("ear", "ears", Side.LEFT, "", "The ear.")
    with pytest.raises(InputError, match=r"own, ear, vertex: has no vertex.*click its place"):
        TEMPLATE.with_scheme(LandmarkScheme("own", "", (*quick().landmarks, ear)))


def test_a_number_that_the_layout_gives_to_another_is_named() -> None:
    marks = (*(replace(mark, vertex=None) for mark in quick()), LandmarkDefinition("x", "x", Side.MIDDLE, "x", "", 26))
    with pytest.raises(InputError, match="own, x, vertex: vertex 26 carries chin already"):
        TEMPLATE.with_scheme(LandmarkScheme("own", "", marks))


def test_points_on_one_line_are_no_scheme() -> None:
    middle = [int(v) for v in np.flatnonzero(TEMPLATE.mirror == np.arange(len(TEMPLATE.mirror)))[:6]]
    marks = tuple(LandmarkDefinition(f"p{v}", "middle", Side.MIDDLE, f"p{v}", "", v) for v in middle)
    with pytest.raises(InputError, match="all fiducials lie on one line"):
        TEMPLATE.with_scheme(LandmarkScheme("own", "", marks))


def test_an_open_scheme_without_inner_lip_points_is_told_so_and_has_no_guides() -> None:
    all_of_it = replace(shipped("open"), name="own")
    assert check_scheme(TEMPLATE, all_of_it) == ()
    missing = "lip_upper_inner_left"
    marks = tuple(
        replace(mark, mirror="") if mark.mirror == missing else mark for mark in all_of_it if mark.name != missing
    )
    scheme = replace(all_of_it, landmarks=marks)
    (remark,) = check_scheme(TEMPLATE, scheme)
    assert not remark.is_error and "lip_upper" in remark.problem and missing in remark.problem
    template = TEMPLATE.with_scheme(scheme)
    guided, _ = lip_guides(template, "own", scheme.names)
    upper, lower = (set(TEMPLATE.curves[f"{lip}_inner"].tolist()) for lip in ("lip_upper", "lip_lower"))
    assert not upper & set(guided) - lower and lower & set(guided)
    none = LandmarkScheme("own", "", quick().landmarks, "open")
    assert len(check_scheme(TEMPLATE, none)) == 2
    assert lip_guides(TEMPLATE.with_scheme(none), "own", none.names)[0] == []


def test_lip_points_in_the_wrong_order_are_no_scheme() -> None:
    # Left and right of the inner lip have changed places; as a pair they still mirror each other.
    there = {"lip_upper_inner_left": (271, Side.RIGHT), "lip_upper_inner_right": (43, Side.LEFT)}
    marks = tuple(
        replace(mark, vertex=there[mark.name][0], side=there[mark.name][1]) if mark.name in there else mark
        for mark in shipped("open")
    )
    with pytest.raises(InputError, match=r"lip_upper_inner, vertex.*from corner to corner"):
        TEMPLATE.with_scheme(LandmarkScheme("own", "", marks, "open"))


def test_further_points_on_a_lip_are_met_and_its_border_stays_smooth() -> None:
    """A point on the outer border, and one on the inner, are nodes of their own beside the guides."""
    inner = [
        LandmarkDefinition("in_left", "lips", Side.LEFT, "in_right", "", 41),
        LandmarkDefinition("in_right", "lips", Side.RIGHT, "in_left", "", int(TEMPLATE.mirror[41])),
    ]
    scheme = replace(thorough("open"), landmarks=(*thorough("open").landmarks, *inner))
    template, layout = TEMPLATE.with_scheme(scheme), TEMPLATE.layout("open")
    names, places = scheme.names, 2.0 * layout.vertices + 40.0
    vertices, rows = lip_guides(template, scheme.name, names)
    assert not set(vertices) & {mark.vertex for mark in scheme} and len(set(vertices)) == len(vertices)
    # On the template itself the guides miss its own border by what the splines smooth away, and no more than before.
    where = places[[mark.vertex for mark in scheme]]
    usual, before = lip_guides(TEMPLATE, "open", shipped("open").names)
    missed = np.abs(before @ places[[mark.vertex for mark in shipped("open")]] - places[usual]).max()
    assert np.abs(rows @ where - places[vertices]).max() <= missed
    assert warp_template(template, scheme.name, dict(zip(names, map(tuple, where), strict=True))).residual_px < 1e-6
    moved = where.copy()
    moved[names.index("lip_outer_left"), 1] -= 3.0
    beside = vertices.index(111)
    assert -3.0 < (rows @ moved - rows @ where)[beside, 1] < -0.5
