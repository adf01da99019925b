"""A supervisor points at regions, tightens a limit, takes it back, and fits everything in one go."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from engine.scan.limits import Limits
from studio.scan.limits_dialog import LimitsDialog
from tests.journeys.driver import LEFT, NO_KEY, Hand


def row(hand: Hand, name: str) -> QPoint:
    """Return the middle of a region's row."""
    table = hand.stage.centre.fit.regions
    names = [region.name for region in table.rows]
    return QPoint(30, 22 + 20 * names.index(name) + 10)


def test_regions_limits_and_a_batch(hand: Hand, tmp_path: Path) -> None:
    hand.act("scan.sample")
    hand.rest()
    stage, project = hand.stage, hand.window.session.project
    panel = stage.centre.fit
    assert [r.name for r in panel.regions.rows][:2] == ["brows", "lids"]
    before = hand.picture().astype(int)
    QTest.mouseClick(panel.regions, LEFT, NO_KEY, row(hand, "lids"))
    hand.rest()
    assert panel.regions.chosen == "lids" and stage.quality.marker.shown > 20
    assert (np.abs(hand.picture().astype(int) - before).max(axis=2) > 40).sum() > 200, "its border is on the face"
    QTest.keyClick(panel.regions, Qt.Key.Key_Escape)
    assert stage.quality.marker.shown == 0

    hand.act("scan.limits")
    dialog = hand.window.findChild(LimitsDialog)
    cells = dialog.panel.table
    lids = next(k for k in range(cells.rowCount()) if cells.item(k, 0).text() == "lids")
    cells.item(lids, 1).setText("0.5")
    assert "below warn" in dialog.panel.trouble.text() and not dialog.panel.apply_button.isEnabled()
    cells.item(lids, 1).setText("0.001")
    cells.item(lids, 2).setText("0.002")
    assert cells.item(lids, cells.columnCount() - 1).text() == "fail", "seen before it is applied"
    assert project.limits == Limits()
    QTest.mouseClick(dialog.panel.apply_button, LEFT)
    hand.rest()
    assert project.limits.region("lids").median_mm.fail == 0.002
    assert {str(r.verdict) for r in panel.regions.rows if r.name == "lids"} == {"fail"}
    assert project.state(stage.context.scan_id).kind == "fresh"
    hand.act("edit.undo")
    hand.rest()
    assert project.limits == Limits()
    assert "fail" not in {str(r.verdict) for r in panel.regions.rows}

    hand.act("scan.batch")
    batch = stage.quality._batch
    batch.panel.folder.field.setText(str(tmp_path / "faces"))
    batch.panel.level.setCurrentIndex(batch.panel.level.findData(1))
    assert "save the project first" in batch.panel.command.field.placeholderText()
    QTest.mouseClick(batch.panel.start_button, LEFT)
    assert batch.running and batch.panel.cancel_button.isVisible()
    hand.rest()
    ready = batch.panel.chosen()
    assert len(ready) == len(list((tmp_path / "faces").glob("*.glb"))) > 0
    assert all(project.state(scan_id).kind == "fresh" for scan_id in ready)
    assert all(project.scan(scan_id).options.levels == 1 for scan_id in ready)
    hand.act("edit.undo")
    assert all(project.scan(scan_id).options.levels == 2 for scan_id in ready), "one step for all"
    batch.panel.level.setCurrentIndex(0)
    QTest.mouseClick(batch.panel.start_button, LEFT)
    QTest.mouseClick(batch.panel.cancel_button, LEFT)
    hand.rest()
    assert not batch.running and batch.panel.start_button.isVisible()
    QTest.keyClick(batch, Qt.Key.Key_Escape)
    QTest.qWait(50)
