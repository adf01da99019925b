from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

import resources
from engine.errors import Cancelled, InputError
from engine.files.scheme import read_scheme
from engine.files.template import read_template
from engine.geometry.normals import face_normals
from engine.scan.fit import fit_template
from engine.scan.quality import Verdict, measure, verdicts
from engine.scan.range_image import Camera, RangeImage
from engine.scan.repair import repair
from engine.scan.warp import mirror_proposals, propose_fiducials, warp_template

TEMPLATE = read_template(resources.template_path())
CAMERA = Camera(1200.0, 1200.0, 319.5, 239.5)


def true_depth(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 650 - 80 * np.sqrt(np.clip(1 - ((x - 320) / 200) ** 2 - ((y - 240) / 250) ** 2, 0, 1))


def clicks(scheme: str = "closed", turn: float = 0.06) -> dict[str, tuple[float, float]]:
    layout = TEMPLATE.layout(scheme)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    places = (layout.vertices - [0, 240]) @ rotation.T * 1.3 + [320, 240]
    return {name: tuple(places[vertex]) for name, vertex in layout.fiducials.items()}


def egg(noise: float = 0.15) -> RangeImage:
    y, x = np.mgrid[:480, :640].astype(float)
    depth = true_depth(x, y)
    depth[depth > 649.9] = np.nan
    rng = np.random.default_rng(2)
    depth += rng.normal(0, noise, depth.shape)
    depth[215:223, 240:270] = np.nan
    return RangeImage(CAMERA.points(depth), np.full((480, 640, 3), 150, np.uint8), CAMERA)


@pytest.mark.parametrize("scheme", ["closed", "open"])
def test_fiducials_are_met_exactly(scheme: str) -> None:
    rng = np.random.default_rng(0)
    places = {n: (x + rng.normal(0, 3), y + rng.normal(0, 3)) for n, (x, y) in clicks(scheme).items()}
    warp = warp_template(TEMPLATE, scheme, places)
    fiducials = TEMPLATE.layout(scheme).fiducials
    for name, place in places.items():
        np.testing.assert_allclose(warp.vertices[fiducials[name]], place, atol=1e-6)
    assert warp.residual_px < 1e-6


def test_a_turned_face_is_the_turned_template() -> None:
    warp = warp_template(TEMPLATE, "closed", clicks())
    rotation = np.array([[np.cos(0.06), -np.sin(0.06)], [np.sin(0.06), np.cos(0.06)]])
    expected = (TEMPLATE.layout("closed").vertices - [0, 240]) @ rotation.T * 1.3 + [320, 240]
    np.testing.assert_allclose(warp.vertices, expected, atol=1e-8)
    assert not len(warp.folded)
    assert warp.suspects == ()


def test_a_fold_names_its_fiducial() -> None:
    places = clicks()
    x, y = places["eye_left_inner"]
    warp = warp_template(TEMPLATE, "closed", places | {"eye_left_inner": (x + 75, y)})
    assert len(warp.folded)
    assert warp.suspects[0] == "eye_left_inner"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"nose": (3, 3)}, "fiducial nose: is not in the closed scheme"),
        ({"nose_tip": (319.0, 400.0), "chin": (319.0, 400.0)}, "nose_tip and chin: lie at one place"),
        ({"nose_tip": (float("nan"), 4.0)}, "nose_tip: is not a finite"),
    ],
)
def test_wrong_fiducials_are_named(change: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        warp_template(TEMPLATE, "closed", clicks() | change)


def test_points_on_a_line_too_few_or_outside_are_errors() -> None:
    with pytest.raises(InputError, match="on one line"):
        warp_template(TEMPLATE, "closed", {n: (10.0 * k, 5.0 * k) for k, n in enumerate(clicks())})
    with pytest.raises(InputError, match="place at least 3"):
        warp_template(TEMPLATE, "closed", dict(itertools.islice(clicks().items(), 2)))
    with pytest.raises(InputError, match=r"chin: .* lies outside the 640 x 480 picture"):
        fit_template(egg(), clicks() | {"chin": (320.0, 1e4)}, TEMPLATE)
    with pytest.raises(InputError, match="has no layout 'wide'"):
        warp_template(TEMPLATE, "wide", clicks())


def test_proposals_find_the_rest_of_a_known_face_from_five_points() -> None:
    places = clicks()
    first = dict(itertools.islice(places.items(), 5))
    proposed = propose_fiducials(TEMPLATE, "closed", first)
    assert set(proposed) == set(places) - set(first)
    for name, place in proposed.items():
        np.testing.assert_allclose(place, places[name], atol=1e-6)
    with pytest.raises(InputError, match="place 5 before"):
        propose_fiducials(TEMPLATE, "closed", dict(itertools.islice(places.items(), 4)))


def test_proposals_stay_calm_when_the_clicks_are_not() -> None:
    places, rng = clicks(), np.random.default_rng(3)
    first = {n: (x + rng.normal(0, 2), y + rng.normal(0, 2)) for n, (x, y) in itertools.islice(places.items(), 5)}
    proposed = propose_fiducials(TEMPLATE, "closed", first)
    assert max(np.hypot(*np.subtract(proposed[name], places[name])) for name in proposed) < 15


def test_mirrored_points_land_on_the_other_side() -> None:
    scheme, places = read_scheme(resources.scheme_path("closed")), clicks()
    half = {name: place for name, place in places.items() if "right" not in name}
    for name, place in mirror_proposals(scheme, half).items():
        np.testing.assert_allclose(place, places[name], atol=1e-6)
    with pytest.raises(InputError, match="mid-line"):
        mirror_proposals(scheme, {"eye_left_outer": (3, 3)})


def test_the_fit_lies_on_the_surface_and_says_what_it_filled() -> None:
    fit = fit_template(egg(), clicks(), TEMPLATE, levels=2)
    assert len(fit.mesh.vertices) == 6588
    truth = true_depth(*fit.pixels.T)
    error = np.abs(-fit.mesh.vertices[:, 2] - truth)[truth < 640]
    filled = fit.filled[truth < 640]
    assert np.median(error[~filled]) < 0.05
    assert error[filled].max() < 0.5
    assert 20 < filled.sum() < 300
    np.testing.assert_allclose(CAMERA.project(fit.mesh.vertices), fit.pixels, atol=0.02)
    np.testing.assert_allclose(fit.mesh.uv, (fit.pixels + 0.5) / [640, 480])
    assert (face_normals(fit.mesh.vertices, fit.mesh.faces)[:, 2] > 0).mean() > 0.99, "faces look at the scanner"
    assert np.isnan(fit.deviation_mm[fit.filled]).all()
    assert fit.repair.noise_mm == pytest.approx(0.15, rel=0.1)


def test_a_refit_of_a_repaired_scan_is_the_same_fit() -> None:
    scan, places = egg(), clicks()
    once, twice = fit_template(scan, places, TEMPLATE), fit_template(repair(scan), places, TEMPLATE)
    np.testing.assert_array_equal(once.mesh.vertices, twice.mesh.vertices)


def test_an_outline_over_the_wall_behind_does_not_reach_for_it() -> None:
    scan = egg()
    depth = -scan.points[..., 2]
    behind = RangeImage(CAMERA.points(np.where(np.isnan(depth), 1900.0, depth)), camera=CAMERA)
    wide = {n: ((x - 320) * 1.18 + 320, y) for n, (x, y) in clicks(turn=0).items()}
    wide = {n: p for n, p in wide.items() if not n.startswith("jaw")}
    fit = fit_template(behind, wide, TEMPLATE)
    assert (-fit.mesh.vertices[:, 2]).max() < 700


def test_quality_tells_good_from_bad() -> None:
    good = {check.name: check for check in verdicts(measure(fit_template(egg(), clicks(), TEMPLATE)))}
    assert good["median"].verdict is Verdict.OK
    assert good["scan noise"].verdict is Verdict.OK
    assert good["folded triangles"].verdict is Verdict.OK
    noisy = {check.name: check for check in verdicts(measure(fit_template(egg(1.5), clicks(), TEMPLATE)))}
    assert noisy["median"].verdict is Verdict.FAIL
    assert noisy["scan noise"].verdict is Verdict.FAIL
    x, y = clicks()["nose_tip"]
    folded = measure(fit_template(egg(), clicks() | {"nose_tip": (x + 90, y)}, TEMPLATE))
    assert folded.folded_faces > 0
    assert {c.name: c for c in verdicts(folded)}["folded triangles"].verdict is Verdict.FAIL


def test_a_fiducial_on_the_very_border_of_the_picture_is_inside() -> None:
    for border in ((639.5, 300.0), (300.0, 479.5), (-0.5, -0.5)):
        fit_template(egg(), clicks() | {"jaw_left": border}, TEMPLATE)


def test_a_template_whose_lips_do_not_follow_their_curve_is_refused() -> None:
    layout = TEMPLATE.layout("open")
    wrong = dict(layout.fiducials) | {"lip_upper_inner_left": layout.fiducials["chin"]}
    with pytest.raises(InputError, match="layout open: the fiducials of lip_upper do not follow"):
        replace(TEMPLATE, layouts={"open": replace(layout, fiducials=wrong)})


def test_an_open_mouth_has_its_border_on_the_lips() -> None:
    """Between few fiducials a bare spline sags into the opening; the guides keep the border a smooth curve."""
    places = clicks("open", 0.0)
    x0, y0 = np.mean([places["mouth_left"], places["mouth_right"]], axis=0)
    half = places["mouth_left"][0] - x0
    for name, (x, y) in dict(places).items():
        if name.startswith("lip") and "_inner" in name:
            y = y0 + (-30 if "upper" in name else 30) * (1 - ((x - x0) / half) ** 2)
        elif name in ("lip_upper", "lip_lower", "chin"):
            y += -17 if name == "lip_upper" else 17
        places[name] = (x, y)
    warp = warp_template(TEMPLATE, "open", places)
    assert not len(warp.folded)
    for lip, height in (("lip_upper_inner", -30), ("lip_lower_inner", 30)):
        curve = warp.vertices[TEMPLATE.curves[lip]] - [x0, y0]
        assert np.abs(curve[:, 1] - height * (1 - (curve[:, 0] / half) ** 2)).max() < 1.0


def test_cancelling_stops_the_fit() -> None:
    def stop(fraction: float, text: str) -> None:
        if fraction > 0.5:
            raise Cancelled(text)

    with pytest.raises(Cancelled):
        fit_template(egg(), clicks(), TEMPLATE, progress=stop)


def test_a_face_on_nothing_is_an_error() -> None:
    scan = egg()
    points = np.array(scan.points)
    points[:, 200:450] = np.nan
    with pytest.raises(InputError, match="most of the face"):
        fit_template(replace(scan, points=points), clicks(), TEMPLATE)
