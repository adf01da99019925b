"""What panels say: verdicts are not rounded away, the first advice is shown, names and notes can be read."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt

from widgets.basis.advice_panel import AdviceItem, AdvicePanel
from widgets.basis.guide_panel import GuidePanel
from widgets.basis.motion_panel import MotionFacts, MotionPanel
from widgets.basis.shape_panel import ShapeFacts, ShapePanel
from widgets.basis.words import DASH, judged


@pytest.mark.parametrize(
    ("value", "at_least", "text"),
    [(0.8496, True, "0.8496"), (0.847, True, "0.847"), (0.85, True, "0.85"), (0.8504, True, "0.85"),
     (0.84, True, "0.84"), (0.8504, False, "0.8504"), (0.8496, False, "0.85")],
)  # fmt: skip
def test_a_number_is_never_rounded_onto_the_limit_it_misses(value: float, at_least: bool, text: str) -> None:
    assert judged(value, 0.85, at_least) == text
    assert judged(None, 0.85) == judged(float("nan"), 0.85) == DASH


def test_the_first_advice_is_shown_until_the_page_is_turned(qtbot) -> None:  # type: ignore[no-untyped-def]
    panel = AdvicePanel()
    qtbot.addWidget(panel)
    one, two = AdviceItem("one"), AdviceItem("two")
    panel.set_advice([two])
    panel.set_advice([one, two])
    assert panel.text.text() == "one"
    panel.more.click()
    panel.set_advice([AdviceItem("zero"), one, two])
    assert panel.text.text() == "two", "the page that was turned to stays"
    panel.set_advice([one])
    assert panel.text.text() == "one"


def test_the_amount_is_not_a_number_while_there_is_no_quasi_eigen_shape(qtbot) -> None:  # type: ignore[no-untyped-def]
    panel = ShapePanel()
    qtbot.addWidget(panel)
    panel.set_shape(ShapeFacts("smile", 1.0))
    panel.set_available(False, "there is no basis yet")
    assert panel.number.text() == DASH
    panel.set_available(True)
    assert panel.number.text() == "1.00"


@pytest.mark.parametrize("follow", ["mouse", "keys"])
def test_what_was_assumed_leads_to_the_settings(qtbot, follow: str) -> None:  # type: ignore[no-untyped-def]
    panel = MotionPanel()
    qtbot.addWidget(panel)
    panel.set_motion(MotionFacts("clip.c3d", 600, 120.0, notes=("unit mm assumed", "y up assumed")))
    panel.show()
    link = panel.notes_value
    assert link.text == "2 assumed" and link.toolTip() == "unit mm assumed\ny up assumed"
    with qtbot.waitSignal(panel.settings_requested):
        if follow == "mouse":
            qtbot.mouseClick(link, Qt.MouseButton.LeftButton)
        else:
            qtbot.keyClick(link, Qt.Key.Key_Space)


def test_all_missing_names_are_listed_to_be_copied(qtbot) -> None:  # type: ignore[no-untyped-def]
    panel = GuidePanel()
    qtbot.addWidget(panel)
    names = [f"name{k}" for k in range(28)]
    panel.show_missing("ARKit", names)
    assert all(name in panel.names.text() for name in names) and not panel.names.isHidden()
    assert panel.names.textInteractionFlags() & Qt.TextInteractionFlag.TextSelectableByMouse
    panel.show_missing("ARKit", [])
    assert panel.names.isHidden()


def test_progress_moves_nothing_else_in_the_status_line(qtbot) -> None:  # type: ignore[no-untyped-def]
    from studio.status_line import StatusLine
    from studio.tasks import Task

    line = StatusLine()
    qtbot.addWidget(line)
    line.resize(1280, 24)
    line.show()
    places: list[list[tuple[int, int, int, int]]] = []
    parts = (line.task, line.progress, line.percent, line.cancel)
    for fraction, title in ((0.01, "Reading"), (0.55, "Reading"), (1.0, "Maxima and percentiles of a long name")):
        task = Task(title, "", quiet=False)
        task.fraction = fraction
        line._show_task(task, 1)
        qtbot.wait(1)
        places.append([part.geometry().getRect() for part in parts])
    assert places[0] == places[1] == places[2]
