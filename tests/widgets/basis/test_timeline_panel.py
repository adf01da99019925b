"""The timeline panel scrubs, plays, steps and marks; in a dock its buttons stand in the title bar."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow

from widgets import theme
from widgets.basis.timeline_panel import TimelinePanel
from widgets.parts.picture import PictureOptions, offer_of
from widgets.parts.titles import DockTitle

LEFT = Qt.MouseButton.LeftButton
ROOT = Path(__file__).parents[3]


@pytest.fixture
def panel(qtbot) -> TimelinePanel:
    made = TimelinePanel()
    qtbot.addWidget(made)
    made.resize(1200, 200)
    frames = np.arange(600)
    curve = 1 + np.sin(frames / 40.0)
    made.set_clip(600, 120.0)
    made.set_curves({"pca": curve / 5, "hand": curve, "quasi_eigen": curve / 4}, {"hand": curve * 2})
    made.set_worst([300, 63])
    made.show()
    qtbot.waitExposed(made)
    yield made
    made.close_playback()


def test_curves_stand_in_one_order_with_their_units(panel: TimelinePanel) -> None:
    alpha, rms = panel.canvas.tracks
    assert [c.name for c in alpha.curves] == ["hand", "quasi-eigen", "PCA"] and alpha.unit == "%"
    assert [c.dashed for c in alpha.curves] == [False, False, True] and rms.unit == "mm"
    panel.set_curves({}, {})
    assert panel.canvas.tracks == ()
    panel.grab()


def test_every_way_to_a_frame_tells_it_once_and_shows_it_everywhere(panel: TimelinePanel) -> None:
    told: list[int] = []
    panel.frame_changed.connect(told.append)
    press = panel.transport.buttons
    QTest.mouseClick(press["next"], LEFT)
    QTest.mouseClick(press["last"], LEFT)
    QTest.mouseClick(press["previous"], LEFT)
    QTest.mouseClick(press["first"], LEFT)
    panel.transport.field.selectAll()
    QTest.keyClicks(panel.transport.field, "43")
    QTest.keyClick(panel.transport.field, Qt.Key.Key_Return)
    QTest.mouseClick(panel.transport.chips, LEFT, pos=panel.transport.chips.box(1).center().toPoint())
    x = round(panel.canvas.x_of(400))
    QTest.mouseClick(panel.canvas, LEFT, pos=QPoint(x, 80))
    assert told[:-1] == [1, 599, 598, 0, 42, 63] and told[-1] == panel.frame == panel.playback.frame
    assert panel.transport.field.value() == panel.frame + 1
    panel.set_frame(300)
    assert len(told) == 7 and panel.frame == 300
    assert "of 600, 2.500 s, 120 fps" in panel.transport.rest.text()


def test_it_plays_by_the_clock_and_a_scrub_goes_on_from_there(panel: TimelinePanel) -> None:
    now = [0.0]
    panel.playback._clock = lambda: now[0]
    told, playing = [], []
    panel.frame_changed.connect(told.append)
    panel.playing_changed.connect(playing.append)
    QTest.mouseClick(panel.transport.buttons["play"], LEFT)
    now[0] = 0.5
    panel.playback.tick()
    panel.canvas.frame_changed.emit(200)
    now[0] = 1.0
    panel.playback.tick()
    assert told[0] == 60 and told[-1] == 260 and panel.canvas.frame == 260 and panel.is_playing
    panel.toggle_play()
    assert playing == [True, False]
    panel.set_loop(True)
    panel.play()
    now[0] += 5.0
    panel.playback.tick()
    assert panel.is_playing and panel.frame == (260 + 600) % 600
    panel.step(3)
    assert not panel.is_playing and panel.frame == 263


def test_a_shorter_clip_keeps_the_playhead_inside(panel: TimelinePanel) -> None:
    panel.set_frame(599)
    panel.set_clip(10, 60.0)
    assert panel.frame == 9
    panel.set_clip(0)
    assert panel.frame == 0 and not panel.transport.buttons["play"].isEnabled()
    assert offer_of(panel.canvas).ready()


def test_in_a_dock_the_buttons_stand_in_the_title_bar(qtbot, panel: TimelinePanel) -> None:
    window, dock = QMainWindow(), QDockWidget("Performance error")
    qtbot.addWidget(window)
    dock.setWidget(panel)
    title = DockTitle("Performance error", "", dock)
    window.addDockWidget(Qt.DockWidgetArea.BottomDockWidgetArea, dock)
    window.resize(1280, 240)
    window.show()
    qtbot.waitExposed(window)
    QApplication.processEvents()
    assert panel.transport.parent() is title and panel.transport.isVisible()
    assert panel.transport.x() == 232 and title.height() == 28
    assert panel.canvas.y() == 0
    buttons = [title.buttons["float"], title.buttons["close"]]
    assert panel.transport.geometry().right() < min(b.x() for b in buttons)
    dock.setWidget(None)
    panel.setParent(None)


def test_nothing_is_cut_at_large_text(qtbot, qapp, panel: TimelinePanel) -> None:
    try:
        theme.apply(qapp, theme.LIGHT, 1.5)
        QApplication.processEvents()
        rows = theme.px(16) * 4
        assert panel.canvas.minimumSizeHint().height() >= theme.px(20) + rows + theme.px(16) * 2
        panel.resize(1200, panel.minimumSizeHint().height())
        panel.grab()
    finally:
        theme.apply(qapp, theme.DARK, 1.0)


def test_the_picture_and_the_table_of_the_curves(panel: TimelinePanel) -> None:
    made = offer_of(panel.canvas)
    assert made is not None and made.ready() == ""
    image = made.take(PictureOptions(scale=2))
    assert image.width() == 2 * panel.canvas.width()
    rows = made.table()
    assert rows[0] == ["frame", "α hand %", "α quasi-eigen %", "α PCA %", "RMS hand mm"] and len(rows) == 601


def test_the_docks_load_neither_pyqtgraph_nor_3d() -> None:
    modules = ("inputs_panel", "shape_panel", "error_panel", "projection_panel", "advice_panel", "eigen_panel",
               "cloud_panel", "timeline_panel")  # fmt: skip
    code = f"import sys, {', '.join('widgets.basis.' + m for m in modules)}\n"
    code += "print([m for m in ('pyqtgraph', 'vtkmodules', 'pyvista', 'matplotlib', 'scipy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
