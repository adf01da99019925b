"""Regions cover the face once, mirrored, at every level; what is planted in one is seen there and only there."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import resources
from engine.errors import InputError
from engine.files.template import read_template
from engine.geometry.subdivide import unique_edges
from engine.scan.fit import FaceFit, fit_template
from engine.scan.limits import FIGURES, REGIONS, Bounds, Limits, RegionLimits, Verdict, worst
from engine.scan.quality import measure, measure_regions, overall, verdicts
from engine.scan.range_image import Camera, RangeImage
from engine.scan.regions import OTHER, FaceRegions, border, regions_of

TEMPLATE = read_template(resources.template_path())
FACE = regions_of(TEMPLATE)
CAMERA = Camera(760.0, 760.0, 119.5, 119.5)


def clicks() -> dict[str, tuple[float, float]]:
    layout = TEMPLATE.layout("closed")
    low, high = layout.vertices.min(axis=0), layout.vertices.max(axis=0)
    flat = (layout.vertices - (low + high) / 2) * (180 / (high - low)[1]) + 120
    return {name: (float(flat[k, 0]), float(flat[k, 1])) for name, k in layout.fiducials.items()}


def dome(extra: np.ndarray | float = 0.0) -> RangeImage:
    rows, columns = np.indices((240, 240))
    x, y = (columns - 119.5) / 240, (rows - 119.5) / 240
    noise = np.random.default_rng(0).normal(0.0, 0.05, x.shape)
    return RangeImage(CAMERA.points(650.0 + 160.0 * x**2 + 120.0 * y**2 + noise + extra))


def fitted(extra: np.ndarray | float = 0.0) -> FaceFit:
    return fit_template(dome(extra), clicks(), TEMPLATE, levels=2)


def test_every_vertex_has_one_region_and_its_mirror_the_same() -> None:
    assert set(FACE.names) == set(REGIONS) and not FACE.assumed
    assert sorted(np.concatenate(list(TEMPLATE.regions.values()))) == list(range(len(TEMPLATE.faces)))
    base = FACE.vertices(0)
    assert (base[TEMPLATE.mirror] == base).all()
    for level in range(5):
        found = FACE.vertices(level)
        places = TEMPLATE.refine(level).apply(TEMPLATE.layout("open").vertices)
        tree = cKDTree(places)
        distance, other = tree.query(places * [-1, 1])
        assert distance.max() < 0.05, "the subdivided template is symmetrical"
        assert (found == found[other]).all()
        assert set(np.unique(found)) == set(range(len(FACE.names)))


def test_fiducials_lie_in_the_region_they_are_named_after() -> None:
    layout, found = TEMPLATE.layout("open"), FACE.vertices(0)
    for name, vertex in layout.fiducials.items():
        region = FACE.names[found[vertex]]
        expected = {"brow": {"brows"}, "nose": {"nose"}, "lip": {"lips", "mouth"}, "jaw": {"jaw"}, "chin": {"jaw"},
                    "eye": {"lids", "eyes", "nose"}, "mouth": {"lips", "mouth"}, "forehead": {"forehead"}}  # fmt: skip
        assert region in expected[name.split("_")[0]], (name, region)


def test_lids_surround_the_eyes_and_the_lips_end_at_their_drawn_border() -> None:
    faces, names = FACE.faces, FACE.names
    _edges, side = unique_edges(TEMPLATE.faces)
    of_edge: dict[int, set[int]] = {}
    for edge, region in zip(side.ravel().tolist(), np.repeat(faces, 3).tolist(), strict=True):
        of_edge.setdefault(edge, set()).add(region)
    around = {names[k] for pair in of_edge.values() if names.index("eyes") in pair for k in pair}
    assert around == {"eyes", "lids"}, "nothing but lid touches what shows between the lids"
    lips = {tuple(sorted(edge)) for edge in border(FACE, "lips").tolist()}
    for curve in ("lip_upper", "lip_lower"):
        line = TEMPLATE.curves[curve][1:-1]
        assert all(tuple(sorted(pair)) in lips for pair in zip(line[:-1].tolist(), line[1:].tolist(), strict=True))
    with pytest.raises(InputError, match="not on this template"):
        border(FACE, "ears")


@pytest.mark.parametrize("region", ["forehead", "nose", "cheeks"])
def test_a_planted_deviation_is_seen_in_its_region_only(region: str) -> None:
    clean = fitted()
    tree = cKDTree(clean.pixels)
    rows, columns = np.indices((240, 240))
    pixels = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    distance, nearest = tree.query(pixels)
    mine = ((FACE.vertices(2)[nearest] == FACE.names.index(region)) & (distance < 8)).reshape(240, 240)
    ripple = np.where(mine, np.random.default_rng(1).normal(0.0, 0.8, mine.shape), 0.0)
    before = {r.name: r for r in measure_regions(clean, FACE)}
    after = {r.name: r for r in measure_regions(fitted(ripple), FACE)}
    assert after[region].median_mm > 5 * before[region].median_mm
    assert after[region].verdict is not Verdict.OK
    for name, found in after.items():
        if name != region:
            assert found.median_mm < 1.5 * before[name].median_mm, (name, "is not touched")
    assert max(after.values(), key=lambda r: r.rank).name == region


def test_figures_are_those_of_the_regions_vertices() -> None:
    face = fitted()
    for found in measure_regions(face, FACE):
        mine = FACE.mask(found.name, 2)
        distance = face.deviation_mm[mine & ~np.isnan(face.deviation_mm)]
        assert found.vertices == mine.sum()
        assert found.median_mm == pytest.approx(np.median(distance))
        assert found.max_mm == distance.max() and found.filled_fraction == face.filled[mine].mean()


def test_verdicts_turn_exactly_at_their_limits() -> None:
    bounds = Bounds(0.1, 0.2)
    judged = [bounds.judge(v) for v in (0.0, 0.1, np.nextafter(0.1, 1), 0.2, np.nextafter(0.2, 1), np.nan, np.inf)]
    assert [str(v) for v in judged] == ["ok", "ok", "warn", "warn", "fail", "fail", "fail"]
    assert worst([Verdict.WARN, Verdict.FAIL, Verdict.OK]) is Verdict.FAIL and worst([]) is Verdict.OK
    face = fitted()
    plain = {r.name: r for r in measure_regions(face, FACE)}
    for figure in FIGURES:
        value = getattr(plain["nose"], figure)
        wide = RegionLimits(*[Bounds(900.0, 900.0)] * 4)
        exact = Limits().with_region("nose", replace(wide, **{figure: Bounds(value, value)}))
        assert {r.name: r for r in measure_regions(face, FACE, exact)}["nose"].verdict is Verdict.OK
        if value > 0:
            low = Bounds(np.nextafter(value, 0), 900.0)
            judged_low = exact.with_region("nose", replace(wide, **{figure: low}))
            found = {r.name: r for r in measure_regions(face, FACE, judged_low)}
            assert found["nose"].verdict is Verdict.WARN and found["nose"].figure == figure
    bad = Limits().with_region("nose", RegionLimits(median_mm=Bounds(0.0, 0.0)))
    regions = measure_regions(face, FACE, bad)
    assert overall(verdicts(measure(face), bad), regions) is Verdict.FAIL


def test_a_region_of_filled_vertices_alone_has_no_distance_and_is_judged_by_its_share() -> None:
    face = fitted()
    hidden = FACE.mask("jaw", 2)
    hollow = replace(face, filled=face.filled | hidden, deviation_mm=np.where(hidden, np.nan, face.deviation_mm))
    jaw = {r.name: r for r in measure_regions(hollow, FACE)}["jaw"]
    assert np.isnan(jaw.median_mm) and jaw.filled_fraction == 1.0
    assert jaw.verdict is Verdict.FAIL and jaw.figure == "filled_fraction"


@pytest.mark.parametrize(("warn", "fail"), [(-0.1, 1), (0.2, 0.1), (float("nan"), 1), (0, float("inf")), (0, 1e9)])
def test_bounds_that_make_no_sense_are_refused(warn: float, fail: float) -> None:
    with pytest.raises(InputError):
        Bounds(warn, fail)


def test_a_share_above_one_is_no_limit() -> None:
    """A project could not be read again with it: files hold shares to 0..1."""
    assert Limits(filled_fraction=1.0).filled_fraction == 1.0
    with pytest.raises(InputError, match="filled_fraction"):
        Limits(filled_fraction=1.01)


def test_limits_reach_another_process_as_they_are() -> None:
    limits = Limits(p99_mm=0.5).with_region("nose", RegionLimits(Bounds(0.1, 0.3)))
    assert pickle.loads(pickle.dumps(limits)) == limits and hash(limits) == hash(pickle.loads(pickle.dumps(limits)))


def test_a_template_without_regions_gets_them_by_its_fiducials_and_says_so() -> None:
    bare = regions_of(replace(TEMPLATE, regions={}))
    assert "nearest" in bare.assumed
    assert set(bare.names) == {"brows", "lids", "nose", "lips", "cheeks", "jaw", "forehead"}
    agreed = np.array([bare.names[k] for k in bare.faces]) == np.array([FACE.names[k] for k in FACE.faces])
    known = ~np.isin(np.array(FACE.names)[FACE.faces], ["mouth", "eyes"])
    assert agreed[known].mean() > 0.6, "roughly the same parts of the face"
    part = regions_of(replace(TEMPLATE, regions={"nose": TEMPLATE.regions["nose"]}))
    assert part.names == ("nose", OTHER)


def test_regions_of_a_template_are_checked() -> None:
    for regions, problem in (
        ({"nose": [0, 1], "lips": [1]}, "in them twice"),
        ({"nose": [9999]}, "does not exist"),
        ({"nose": []}, "has no face"),
    ):
        with pytest.raises(InputError, match=problem):
            replace(TEMPLATE, regions={name: np.array(faces, dtype=np.int64) for name, faces in regions.items()})
    with pytest.raises(InputError, match="take those of the template"):
        measure_regions(fit_template(dome(), clicks(), TEMPLATE, levels=0), with_one_vertex_more())


def with_one_vertex_more() -> FaceRegions:
    layouts = {
        name: replace(layout, vertices=np.vstack([layout.vertices, [[0.0, 0.0]]]))
        for name, layout in TEMPLATE.layouts.items()
    }
    mirror = np.append(TEMPLATE.mirror, len(TEMPLATE.mirror))
    return regions_of(replace(TEMPLATE, mirror=mirror, layouts=layouts))
