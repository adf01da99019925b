"""Report and plates say what was measured, read without colour, and need no display."""

from __future__ import annotations

import datetime
import os
import re
import subprocess
import sys
import zlib
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from engine.errors import InputError
from engine.scan.limits import Bounds, RegionLimits
from engine.scan.quality import FitQuality, Limits, measure, measure_regions
from engine.scan.regions import regions_of
from studio.report import drawing, layout
from studio.report.entry import Absent, Origin, ReportEntry
from studio.report.layout import figure
from studio.report.overview import ROWS, overview_pages
from studio.report.pages import write_report
from studio.report.plates import WIDTH_PX, write_plates
from studio.report.scan_page import FacePictures
from tests.widgets.scene import synthetic
from widgets.scene.heatmap import HeatRange


def entry(
    name: str, scheme: str = "closed", quality: FitQuality | None = None, limits: Limits | None = None
) -> ReportEntry:
    fit = synthetic.fit(scheme)
    word, held = ("car", "ar") if scheme == "open" else ("", "")
    regions = measure_regions(fit, regions_of(synthetic.template()), limits)
    origin = Origin((("file", "base.json"),), (("options", "as shipped"),), (("scan key", "0123456789abcdef"),))
    made = synthetic.scan(), synthetic.fiducials(scheme), scheme, fit, quality or measure(fit), regions, origin
    return ReportEntry(name, word, held, *made)


def test_an_entry_is_frozen_and_owns_its_landmarks() -> None:
    landmarks = synthetic.fiducials()
    made = ReportEntry("a", "", "", synthetic.scan(), landmarks, "closed", synthetic.fit(), measure(synthetic.fit()))
    landmarks.clear()
    assert len(made.landmarks) == 20
    with pytest.raises(AttributeError):
        made.name = "b"  # type: ignore[misc]
    assert entry("car", "open").title == "car (ar)"
    assert entry("base").title == "base"


@pytest.fixture(scope="module")
def plates(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ...]:
    folder = tmp_path_factory.mktemp("plates")
    return write_plates(folder / "new", [entry("base"), entry("car", "open")], synthetic.template())


def test_four_plates_of_1600_pixels_that_show_something(plates: tuple[Path, ...]) -> None:
    assert [path.name for path in plates] == [f"figure_{k}.png" for k in (1, 2, 3, 4)]
    for path in plates:
        picture = cv2.imread(str(path))
        assert picture.shape[1] == WIDTH_PX
        assert 0.1 < (picture < 245).any(axis=2).mean() < 0.98, path
        assert (picture[:, :6] > 250).all() and (picture[:, -6:] > 250).all(), "nothing is cut at the sides"
        assert (picture[-6:] > 250).all(), "the caption ends above the edge"


def test_the_chosen_points_are_red_in_figures_1_and_4(plates: tuple[Path, ...]) -> None:
    for index in (0, 3):
        blue, green, red = np.moveaxis(cv2.imread(str(plates[index])).astype(int), 2, 0)
        spots, _ = cv2.connectedComponents(((red > 200) & (green < 60) & (blue < 80)).astype(np.uint8))
        assert spots - 1 >= 20, plates[index]


def test_plates_need_a_scan_of_either_scheme(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="open"):
        write_plates(tmp_path, [entry("base")], synthetic.template())
    with pytest.raises(InputError, match="closed"):
        write_plates(tmp_path, [entry("car", "open")], synthetic.template())


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    both = [entry("base"), entry("car", "open")]
    with pytest.raises(InputError, match="cannot be written"):
        write_plates(tmp_path / "file", both, synthetic.template())
    with pytest.raises(InputError, match="cannot be written"):
        write_report(tmp_path / "file" / "r.pdf", both)
    with pytest.raises(InputError, match="no fitted scan"):
        write_report(tmp_path / "r.pdf", [])


def words(pdf: bytes) -> str:
    """Return what a PDF's text operators write; letters outside ASCII are dropped."""
    text = []
    for stream in re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.S):
        try:
            content = zlib.decompress(stream)
        except zlib.error:
            continue
        for block in re.findall(rb"BT(.*?)ET", content, re.S):
            pieces = re.findall(rb"\(((?:\\.|[^\\()])*)\)", block)
            text.append(b"".join(pieces).decode("latin-1").replace("\\", ""))
    return "\n".join(text)


def test_the_report_writes_figures_verdicts_and_parameters_as_text(tmp_path: Path) -> None:
    good = measure(synthetic.fit())
    bad = replace(good, median_mm=0.987, p99_mm=0.45, folded_faces=7)
    limits = Limits(median_mm=0.123).with_region("nose", RegionLimits(Bounds(0.0011, 0.0022)))
    entries = [entry("base", limits=limits), entry("car", "open", bad, limits)]
    sheet = tmp_path / "sheet.png"
    left_out = [Absent("eel", "3 fiducials to place")]
    path = write_report(tmp_path / "sub" / "report.pdf", entries, limits=limits, absent=left_out, sheet=sheet,
                        date=datetime.date(2026, 1, 31))  # fmt: skip
    pdf = path.read_bytes()
    assert pdf.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) == 1 + len(entries), "an overview, and a page for every scan"
    text = words(pdf)
    for word in ("Scans fitted to the template", "0.99", "fail", "warn", "pass", "limit 0.123", "0.0011 | 0.0022"):
        assert word in text, word
    for fact in ("Quasiface Studio", "240", "level 1", "scheme closed, open", "lengths in mm", "2026-01-31"):
        assert fact in text, fact
    for fact in ("eel", "3 fiducials to place", "1 without a fit", "base.json", "0123456789abcdef", "spikes removed"):
        assert fact in text, fact
    for region in entries[0].regions:
        assert region.name in text
        for name in ("median_mm", "p95_mm", "max_mm"):
            assert figure(getattr(region, name)) in text, (region.name, name)
        assert figure(region.filled_fraction, "%") in text
    assert pdf.count(b"/Subtype /Image") >= 2 * (3 + 8), "pictures are embedded"
    picture = cv2.imread(str(sheet))
    assert picture.shape[1] > picture.shape[0] / 3 and 0.2 < (picture < 245).any(axis=2).mean() < 0.9


def test_many_scans_keep_to_their_pages_and_every_verdict_has_a_shape_of_its_own(tmp_path: Path) -> None:
    entries = [entry(f"scan {k}") for k in range(ROWS + 2)]
    found = [FacePictures(dict.fromkeys((("textured", "three_quarter"), ("heat", "front")), synthetic.scan().colour))]
    pages = overview_pages(entries, [], found * len(entries), "many", "", Limits(), HeatRange())
    assert len(pages) == 3, "two tables, the second with the first faces, and one more with the rest"
    for page in pages:
        for text in page.figure.texts:
            x, y = text.get_position()
            assert 0.05 < x < 0.95 and 0.03 < y < 0.97, text.get_text()
    assert len(set(layout.WORDS.values())) == 4 == len(set(layout._MARKS.values()))


def test_the_same_entries_make_the_same_report(tmp_path: Path) -> None:
    first = write_report(tmp_path / "a.pdf", [entry("base")]).read_bytes()
    second = write_report(tmp_path / "b.pdf", [entry("base")]).read_bytes()
    assert first == second


def test_a_crop_keeps_the_face_and_its_aspect() -> None:
    points = synthetic.fit().pixels
    for aspect in (0.6, 1.0, 1.7):
        left, right, bottom, top = drawing.face_box(points, aspect, (240, 240))
        assert (right - left) / (bottom - top) == pytest.approx(aspect)
        assert left >= -0.5 and top >= -0.5 and right <= 239.5 and bottom <= 239.5
        if aspect == 1.0:
            assert left <= points[:, 0].min() and right >= points[:, 0].max()


def test_missing_depth_looks_like_no_depth() -> None:
    scan = synthetic.scan()
    picture = drawing.depth_picture(scan, *drawing.face_depths(synthetic.fit().mesh.vertices))
    grey = (picture[..., 0] == picture[..., 1]) & (picture[..., 1] == picture[..., 2])
    assert (grey == scan.valid).all()
    row = scan.height // 2
    assert picture[row, scan.width // 2, 0] > picture[row, 40, 0], "near is bright"


def test_reports_need_no_display(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path\n"
        "from tests.studio.report.test_report import entry\n"
        "from studio.report.pages import write_report\n"
        "write_report(Path(sys.argv[1]), [entry('base')])\n"
        "assert 'PySide6' not in sys.modules\n"
    )
    bare = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "XAUTHORITY")}
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "r.pdf")], capture_output=True, text=True, env=bare, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "WARN" not in done.stderr and "ERR" not in done.stderr, done.stderr
