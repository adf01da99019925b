"""What views offer: pictures drawn anew at every scale, PNG that says its size and origin, tables for spreadsheets."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image
from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QGuiApplication, QImage, QPainter
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMenu, QWidget

from widgets.parts import picture
from widgets.parts.landmark_table import LandmarkTable
from widgets.parts.picture import PictureOptions
from widgets.parts.tables import CheckRow, CheckTable
from widgets.scan.canvas_panel import CanvasPanel


class Striped(QWidget):
    """Paints upright stripes, each half a pixel of the layout wide: only a finer picture can show them."""

    def paintEvent(self, _event) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), Qt.GlobalColor.white)
        painter.scale(0.5, 1.0)
        for x in range(0, 2 * self.width(), 2):
            painter.fillRect(QRect(x, 0, 1, self.height()), Qt.GlobalColor.black)


def grey(image: QImage) -> np.ndarray:
    plain = image.convertToFormat(QImage.Format.Format_Grayscale8)
    return (
        np.frombuffer(plain.constBits(), np.uint8)
        .reshape(plain.height(), plain.bytesPerLine())[:, : plain.width()]
        .copy()
    )


def test_a_larger_scale_shows_more_and_is_not_enlarged(qtbot) -> None:
    view = Striped()
    qtbot.addWidget(view)
    view.resize(40, 10)
    made = picture.offer(view, "stripes", "stripes")
    assert grey(made.take(PictureOptions())).shape == (10, 40)
    fine = grey(made.take(PictureOptions(scale=2)))
    assert fine.shape == (20, 80)
    assert (fine[:, 0::2] == 0).all() and (fine[:, 1::2] == 255).all()
    assert picture.offer_of(QWidget(view)) is made, "a child's picture is its parent's"


def test_png_says_how_large_it_is_and_where_it_is_from(qapp) -> None:
    image = QImage(30, 20, QImage.Format.Format_ARGB32)
    image.fill(Qt.GlobalColor.transparent)
    data = picture.png(image, 2, {"Project": "anna.qface", "Scan": "too", "View": "3-D view", "Empty": ""})
    read = Image.open(io.BytesIO(data))
    assert read.format == "PNG" and read.size == (30, 20) and read.mode == "RGBA"
    assert np.asarray(read)[..., 3].max() == 0
    assert read.info["dpi"] == (192, 192) or abs(read.info["dpi"][0] - 192) < 0.1
    assert (read.info["Project"], read.info["Scan"], read.info["View"]) == ("anna.qface", "too", "3-D view")
    assert "Empty" not in read.info


def test_tables_go_to_a_spreadsheet(qtbot, scheme, landmarks) -> None:
    table = CheckTable("to scan", "mm")
    qtbot.addWidget(table)
    table.set_rows([CheckRow("median", "0.04", "0.07", "ok"), CheckRow("a\tname", "1")])
    made = picture.offer_of(table)
    assert made is not None and made.table is not None
    text = picture.tab_separated(made.table())
    assert text == "to scan\tmm\tlimit\tverdict\nmedian\t0.04\t0.07\tok\na name\t1\t\t\n"
    heard: list[str] = []
    picture.requests.asked.connect(lambda _offer, wanted: heard.append(wanted))
    menu = QMenu()
    picture.fill_menu(menu, made)
    for action in menu.actions():
        action.trigger()
    assert heard == ["table", "copy", "save"]
    rows = LandmarkTable()
    qtbot.addWidget(rows)
    rows.set_scheme(scheme)
    rows.set_landmarks(landmarks)
    QTest.keyClick(rows, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    lines = QGuiApplication.clipboard().text().splitlines()
    assert len(lines) == len(scheme) + 1
    cells = {line.split("\t")[0]: line.split("\t")[1:] for line in lines}
    assert float(cells["nose_tip"][0]) == round(landmarks["nose_tip"].x, 1)
    assert cells["chin"][:2] == ["", ""]


def test_the_canvas_is_pictured_with_and_without_what_lies_over_it(qtbot, scheme, landmarks) -> None:
    panel = CanvasPanel()
    qtbot.addWidget(panel)
    panel.resize(300, 300)
    made = picture.offer_of(panel.canvas)
    assert made is not None and made.ready()
    colour = np.full((160, 200, 3), 90, dtype=np.uint8)
    panel.set_scan("too", colour, None)
    panel.canvas.set_scheme(scheme)
    panel.canvas.set_landmarks(landmarks)
    panel.show()
    qtbot.waitExposed(panel)
    panel.canvas.fit_view()
    assert not made.ready()
    bare = grey(made.take(PictureOptions(scale=2, overlays=False)))
    full = grey(made.take(PictureOptions(scale=2)))
    assert bare.shape == full.shape == (2 * panel.canvas.height(), 2 * panel.canvas.width())
    assert (bare == bare[bare.shape[0] // 2, bare.shape[1] // 2]).mean() > 0.5
    assert len(np.unique(bare)) < 40 and (full.astype(int) - bare > 60).any(), "fiducials are there only with overlays"
    assert panel.canvas.fiducials.visible, "and afterwards all is as before"
