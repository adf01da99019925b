"""The panels of the scan stage: what they show, what they ask for, and that they say nothing by themselves."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QAbstractScrollArea, QApplication, QComboBox, QLineEdit, QWidget

from engine.landmarks import LandmarkSet
from tests.widgets.conftest import LOCKED, PROPOSED, UNSET
from widgets.scan.canvas_panel import CanvasPanel
from widgets.scan.fiducials_panel import FiducialsPanel
from widgets.scan.fit_panel import FitPanel
from widgets.scan.inputs_panel import InputsPanel
from widgets.scan.scan_list import ScanList, ScanRow
from widgets.scan.source_panel import SourcePanel, SourceView
from widgets.scan.template_panel import TemplatePanel

LEFT = Qt.MouseButton.LeftButton
ROWS = [
    ScanRow("1", "base", "closed mouth", "", 20, 20, "fresh"),
    ScanRow("2", "car", "fit fresh", "ar", 20, 20, "stale", np.zeros((48, 64, 3), np.uint8)),
    ScanRow("3", "too", "3 proposed", "oo", 17, 20, "missing"),
]


def listen(widget, *names: str) -> list[tuple]:
    said: list[tuple] = []
    for name in names:
        getattr(widget, name).connect(lambda *values, name=name: said.append((name, *values)))
    return said


def shown(qtbot, widget):
    qtbot.addWidget(widget)
    widget.resize(widget.sizeHint())
    widget.show()
    qtbot.waitExposed(widget)
    QApplication.processEvents()
    return widget


def click(button) -> None:
    QTest.mouseClick(button, LEFT)


# The list of scans ---------------------------------------------------------------------------------------------------


def test_an_empty_list_says_what_belongs_there_and_leaves_the_offer_to_the_welcome_page(qtbot) -> None:
    panel = shown(qtbot, ScanList())
    assert panel.empty.isVisible() and not panel.empty.buttons
    assert not [button for button in panel.findChildren(QAbstractButton) if button.isVisible()]
    panel.set_scans(ROWS)
    assert not panel.empty.isVisible()


def test_choosing_a_scan_is_said_once_and_showing_one_never(qtbot) -> None:
    panel = shown(qtbot, ScanList())
    said = listen(panel, "selected")
    panel.set_scans(ROWS)
    panel.set_current("3")
    panel.set_scans(ROWS)
    assert panel.current == "3"
    assert said == []
    view = panel._view
    QTest.mouseClick(view.viewport(), LEFT, pos=view.visualRect(view.rows.index(1)).center())
    QTest.keyClick(view, Qt.Key.Key_Up)
    assert said == [("selected", "2"), ("selected", "1")]
    assert view.visualRect(view.rows.index(0)).height() == 48


def test_a_scan_is_renamed_and_removed_by_asking(qtbot) -> None:
    panel = shown(qtbot, ScanList())
    panel.set_scans(ROWS)
    panel.set_current("2")
    said = listen(panel, "rename_requested", "remove_requested")
    panel.edit_name("2")
    editor = panel._view.viewport().findChild(QLineEdit)
    editor.selectAll()
    QTest.keyClicks(editor, "cart")
    QTest.keyClick(editor, Qt.Key.Key_Return)
    QApplication.processEvents()
    QTest.keyClick(panel._view, Qt.Key.Key_Delete)
    {action.text().split("\t")[0]: action for action in panel.menu("3").actions()}["Remove"].trigger()
    assert said == [("rename_requested", "2", "cart"), ("remove_requested", "2"), ("remove_requested", "3")]
    assert panel.rows[1].name == "car"


def test_the_letters_that_are_held_are_underlined(qtbot) -> None:
    panel = shown(qtbot, ScanList())
    panel.set_scans([ScanRow("1", "mmm"), ScanRow("2", "mmm", held="mm")])
    panel.resize(panel.sizeHint())
    QApplication.processEvents()
    picture = panel._view.viewport().grab().toImage()

    def run(top: int) -> int:
        return max(
            sum(picture.pixelColor(x, y).lightness() > 150 for x in range(66, 120)) for y in range(top + 23, top + 26)
        )

    assert run(0) == 0
    assert run(48) >= 14


# Source, repair, template --------------------------------------------------------------------------------------------


def test_source_is_shown_with_units_and_options_are_only_said_by_the_hand(qtbot) -> None:
    panel = shown(qtbot, SourcePanel())
    said = listen(panel, "options_changed", "scheme_changed", "carry_requested")
    depth = np.full((48, 64), 600.0)
    panel.set_source(SourceView("too", "too_depth.png", 640, 480, "mm, as in file", 0.0412, 912, depth))
    options = {"remove_spikes": True, "spike_mm": 4.0, "fill_gaps": False, "largest_gap_px": 12, "smooth": True}
    panel.set_options(options)
    panel.set_schemes([("closed", "closed, 20 points"), ("open", "open, 26 points")])
    panel.set_scheme("open")
    panel.set_carry_sources([("1", "base"), ("2", "car")], "2")
    assert said == []
    assert [panel._values[n].text for n in ("Size", "Missing", "Spikes")] == ["640 × 480 px", "4.1 %", "912 px, 0.30 %"]
    assert panel.spike_mm.text() == "4.0 mm"
    assert not panel.largest_gap_px.isEnabled()
    assert "tick the box" in panel.largest_gap_px.toolTip()
    click(panel.fill_gaps)
    panel.spike_mm.setFocus()
    panel.spike_mm.selectAll()
    QTest.keyClicks(panel.spike_mm, "6.5")
    QTest.keyClick(panel.spike_mm, Qt.Key.Key_Return)
    panel.scheme.activated.emit(panel.scheme.currentIndex())
    click(panel.carry_button)
    assert said == [
        ("options_changed", {"fill_gaps": True}), ("options_changed", {"spike_mm": 6.5}), ("scheme_changed", "open"),
        ("carry_requested", "2"),
    ]  # fmt: skip


def test_without_a_scan_the_inputs_say_what_is_needed(qtbot) -> None:
    panel = shown(qtbot, SourcePanel())
    for widget in (panel.remove_spikes, panel.scheme, panel.carry_button):
        assert not widget.isEnabled()
        assert widget.toolTip()


def test_the_left_column_keeps_its_width(qtbot) -> None:
    panel = shown(qtbot, InputsPanel())
    panel.scan_list.set_scans(ROWS)
    panel.source_panel.set_schemes([("closed", "closed, 20 points")])
    assert panel.minimumSizeHint().width() <= 232
    assert panel.source_panel.minimumSizeHint().width() <= 232
    assert panel.sizeHint().width() == 232


# Canvas ---------------------------------------------------------------------------------------------------------------


def test_tools_steer_the_canvas(qtbot, picture, scheme, landmarks) -> None:
    panel = shown(qtbot, CanvasPanel())
    depth = np.tile(np.linspace(500.0, 600.0, 200), (160, 1))
    panel.set_scan("too", picture, depth, np.isfinite(depth))
    panel.canvas.set_scheme(scheme)
    panel.canvas.set_landmarks(landmarks)
    said = listen(panel, "view_changed", "wire_toggled", "fiducials_toggled")
    QTest.mouseClick(panel.views, LEFT, pos=panel.views.box("depth").center().toPoint())
    assert panel.canvas.view == "depth"
    assert panel.depth_bar.isVisible()
    assert panel.plate.accessibleName() == "too depth, 200 × 160"
    for button in (panel.wire_button, panel.fiducial_button):
        click(button)
    assert said == [("view_changed", "depth"), ("wire_toggled", False), ("fiducials_toggled", False)]
    assert not panel.canvas.fiducials.visible
    assert panel.zoom_label.text() == f"{100 * panel.canvas.zoom:.0f} %"


def test_the_depth_bar_sets_the_contrast_and_gives_it_back(qtbot, picture) -> None:
    panel = shown(qtbot, CanvasPanel())
    depth = np.tile(np.linspace(500.0, 600.0, 200), (160, 1))
    panel.set_scan("too", picture, depth, np.isfinite(depth))
    panel.set_view("depth")
    bar = panel.depth_bar
    own = panel.canvas.contrast
    x = round(bar._x(own[1]))
    QTest.mousePress(bar, LEFT, pos=QPoint(x, 12))
    QTest.mouseMove(bar, QPoint(x - 40, 12))
    QApplication.processEvents()
    QTest.mouseRelease(bar, LEFT, pos=QPoint(x - 40, 12))
    assert panel.canvas.contrast[1] < own[1] - 15
    assert bar.range == pytest.approx(panel.canvas.contrast)
    QTest.mouseDClick(bar, LEFT, pos=QPoint(x - 60, 12))
    assert panel.canvas.contrast == own
    assert bar.range == own


def test_a_scan_without_depth_says_so(qtbot, picture) -> None:
    panel = shown(qtbot, CanvasPanel())
    said = listen(panel, "view_changed")
    panel.set_scan("photo", picture, None)
    said.clear()
    QTest.mouseClick(panel.views, LEFT, pos=panel.views.box("depth").center().toPoint())
    assert panel.canvas.view == "colour"
    assert said == []


# Template -------------------------------------------------------------------------------------------------------------


@pytest.fixture
def template_panel(qtbot, scheme, template, landmarks) -> TemplatePanel:
    panel = TemplatePanel()
    layout = template.layouts["closed"]
    panel.set_template(template.edges, layout.vertices, layout.fiducials)
    panel.set_scheme(scheme)
    panel.set_landmarks(landmarks)
    return shown(qtbot, panel)


def test_a_proposed_point_is_confirmed_and_the_next_one_follows(template_panel, landmarks) -> None:
    panel = template_panel
    said = listen(panel, "confirm_requested", "confirm_all_requested", "skip_requested")
    panel.set_current(PROPOSED)
    assert panel.step_label.text() == "Next, 1 of 1 proposed"
    assert panel.name_label.text() == PROPOSED
    assert panel.hint_label.text()
    for button in (panel.confirm_button, panel.confirm_all_button, panel.skip_button):
        assert button.isEnabled()
        click(button)
    assert said == [("confirm_requested", PROPOSED), ("confirm_all_requested",), ("skip_requested", PROPOSED)]
    panel.set_landmarks(landmarks.moved(PROPOSED, 3, 4))
    panel.set_current(UNSET)
    assert panel.step_label.text() == "Next, 18 of 20"
    assert not panel.confirm_button.isEnabled()
    assert "click it in the picture" in panel.confirm_button.toolTip()
    assert not panel.confirm_all_button.isEnabled()


def test_what_cannot_be_done_says_why(template_panel) -> None:
    template_panel.set_current(LOCKED)
    assert not template_panel.skip_button.isEnabled()
    assert template_panel.skip_button.toolTip() == "It is locked"
    template_panel.set_current(None)
    assert "press N" in template_panel.confirm_button.toolTip()


def test_every_fiducial_of_the_diagram_can_be_clicked(template_panel, scheme, template) -> None:
    said = listen(template_panel, "selected")
    diagram = template_panel.diagram
    for name in scheme.names:
        QTest.mouseClick(diagram, LEFT, pos=diagram.place(name).toPoint())
    assert said == [("selected", name) for name in scheme.names]
    left, right = diagram.place("mouth_left").x(), diagram.place("mouth_right").x()
    assert left > right


# Fiducials ------------------------------------------------------------------------------------------------------------


def test_tools_of_the_fiducials_ask_for_the_current_one(qtbot, scheme, landmarks) -> None:
    panel = shown(qtbot, FiducialsPanel())
    panel.set_scheme(scheme)
    panel.set_landmarks(landmarks)
    panel.set_current("nose_tip")
    said = listen(panel, "unset_requested", "lock_requested", "mirror_requested", "carry_requested", "selected")
    for button in (panel.lock_button, panel.delete_button, panel.mirror_button, panel.carry_button):
        click(button)
    panel.set_current(LOCKED)
    assert not panel.delete_button.isEnabled()
    assert "locked" in panel.delete_button.toolTip()
    click(panel.lock_button)
    assert said == [
        ("lock_requested", "nose_tip", True), ("unset_requested", "nose_tip"), ("mirror_requested",),
        ("carry_requested",), ("lock_requested", LOCKED, False),
    ]  # fmt: skip
    assert panel.note == "17 / 20"


def test_the_filter_counts_what_is_proposed(qtbot, scheme, landmarks) -> None:
    panel = shown(qtbot, FiducialsPanel())
    panel.set_scheme(scheme)
    panel.set_landmarks(landmarks)
    assert dict(panel.filter._items)["proposed"] == "Proposed 1"
    QTest.mouseClick(panel.filter, LEFT, pos=panel.filter.box("proposed").center().toPoint())
    assert panel.table.model().names == (PROPOSED,)
    assert panel.tools.minimumSizeHint().width() <= 296


def test_import_and_export_are_in_the_menu(qtbot, scheme, landmarks) -> None:
    panel = shown(qtbot, FiducialsPanel())
    assert not panel.import_action.isEnabled()
    panel.set_scheme(scheme)
    assert panel.import_action.isEnabled()
    assert not panel.export_action.isEnabled()
    panel.set_landmarks(landmarks)
    said = listen(panel, "import_requested", "export_requested")
    panel.import_action.trigger()
    panel.export_action.trigger()
    assert said == [("import_requested",), ("export_requested",)]
    panel.set_landmarks(LandmarkSet({}))
    assert not panel.export_action.isEnabled()
    assert panel.export_action.toolTip()


# Fit ------------------------------------------------------------------------------------------------------------------


def figure(name, value, unit, limit=None, verdict=None):
    return SimpleNamespace(name=name, value=value, unit=unit, limit=limit, verdict=verdict)


def test_figures_stand_with_limit_and_verdict(qtbot) -> None:
    panel = shown(qtbot, FitPanel())
    assert not panel.to_scan.isVisible()
    assert panel.empty_label.isVisible()
    panel.set_checks(
        [
            figure("median", 0.0512, "mm", 0.07, "ok"),
            figure("95th percentile", float("nan"), "mm"),
            figure("vertices", 6588, "count"),
            figure("filled vertices", 3.21, "%", 10.0, "ok"),
        ]
    )
    first, second = panel.to_scan.rows
    assert (first.name, first.value, first.limit, first.verdict) == ("median", "0.05", "0.07", "ok")
    assert (second.value, second.limit, second.verdict) == ("–", "", "")
    assert [(r.name, r.value, r.limit) for r in panel.mesh.rows] == [
        ("vertices", "6\u00a0588", ""),
        ("filled vertices, %", "3.2", "10.0"),
    ]
    panel.set_checks(None)
    assert not panel.mesh.isVisible()


def test_level_and_buttons_ask(qtbot) -> None:
    panel = shown(qtbot, FitPanel())
    said = listen(panel, "level_changed", "fit_requested", "export_requested")
    panel.set_level(2)
    assert said == []
    QTest.mouseClick(panel.levels, LEFT, pos=panel.levels.box("3").center().toPoint())
    panel.set_fit_available(False, "Place 3 more fiducials")
    click(panel.fit_button)
    assert panel.fit_button.toolTip() == "Place 3 more fiducials"
    panel.set_fit_available(True)
    click(panel.fit_button)
    click(panel.export_button)
    assert said == [("level_changed", 3), ("fit_requested",), ("export_requested",)]


@pytest.mark.parametrize("make", [ScanList, SourcePanel, CanvasPanel, TemplatePanel, FiducialsPanel, FitPanel])
def test_everything_that_takes_the_keys_has_a_name(qtbot, make) -> None:
    panel = shown(qtbot, make())
    nameless = [
        type(widget).__name__
        for widget in panel.findChildren(QWidget)
        if widget.focusPolicy() & Qt.FocusPolicy.TabFocus
        and not (widget.accessibleName() or getattr(widget, "text", lambda: "")())
        and widget.objectName() != "qt_spinbox_lineedit"
        and not any(area.viewport() is widget for area in panel.findChildren(QAbstractScrollArea))
        and not any(box.view() is widget for box in panel.findChildren(QComboBox))
    ]
    assert nameless == []


def test_the_vertex_of_a_fiducial_is_told_and_copied(template_panel, scheme, template, qtbot) -> None:
    vertices = template.layouts["closed"].fiducials
    for name in ("chin", "jaw_left"):
        template_panel.set_current(name)
        assert template_panel.vertex_button.text() == f"vertex {vertices[name]}"
        QTest.mouseClick(template_panel.vertex_button, Qt.MouseButton.LeftButton)
        assert QApplication.clipboard().text() == str(vertices[name])
    template_panel.set_current(None)
    assert template_panel.vertex_button.isHidden()
    panel = FiducialsPanel()
    qtbot.addWidget(panel)
    panel.set_scheme(scheme)
    panel.set_vertices(vertices)
    tip = panel.table.model().index(scheme.names.index("chin"), 1).data(Qt.ItemDataRole.ToolTipRole)
    assert tip.startswith(f"chin, unset, vertex {vertices['chin']}\n")
