"""A project becomes a report: what is stale or missing is fitted or said, limits come from the project or a file."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from engine.errors import Cancelled, InputError
from engine.files.limits import write_limits
from engine.landmarks import LandmarkSet
from engine.scan.fit import FaceFit
from engine.scan.limits import Bounds, Limits, RegionLimits
from studio.cli import main
from studio.project import store
from studio.project.document import Project
from studio.report.job import run, scans_of
from studio.report.options import ReportOptions
from studio.report.process import run_apart
from studio.scan.job import input_key
from studio.scan.limit_commands import SetLimits
from tests.studio.report.test_report import words

Make = Callable[..., tuple[Project, str]]
TIGHT = Limits().with_region("nose", RegionLimits(Bounds(0.0, 0.0)))


@pytest.fixture
def fitted(make_project: Make, fiducials: dict[str, Any], face: FaceFit) -> Project:
    """A project with a fresh fit and a scan without fiducials."""
    project, scan_id = make_project(fiducials)
    project.put_fit(scan_id, input_key(project.scan(scan_id)), face)
    project.insert_scan(1, replace(project.scan(scan_id), id="bare", name="bare", landmarks=LandmarkSet({})))
    return project


def test_setting_limits_is_a_step_that_makes_no_fit_stale(fitted: Project, tmp_path: Path) -> None:
    told = []
    fitted.subscribe(lambda change: told.append(change.kind))
    step = SetLimits(fitted, TIGHT)
    step.redo()
    assert fitted.limits == TIGHT and told == ["limits"]
    assert fitted.state(fitted.scans[0].id).kind == "fresh"
    again = store.load(store.save(fitted, tmp_path / "a.qface"))
    assert again.limits == TIGHT and again.state(again.scans[0].id).kind == "fresh"
    step.undo()
    assert fitted.limits == Limits()
    assert store.load(store.save(fitted, tmp_path / "b.qface")).limits == Limits()


def test_a_report_from_the_command_line(fitted: Project, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = store.save(fitted, tmp_path / "p.qface")
    before = place.read_bytes()
    limits = write_limits(tmp_path / "l.toml", TIGHT)
    out = tmp_path / "r.pdf"
    assert main(["report", str(place), "--out", str(out), "--limits", str(limits), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["files"] == [str(out), str(tmp_path / "r_sheet.png")]
    assert [(s["name"], s["verdict"], s["worst_region"]) for s in found["scans"]] == [("base", "fail", "nose")]
    assert found["without_fit"] == [{"name": "bare", "reason": "no fiducials"}] and found["fitted"] == 0
    text = words(out.read_bytes())
    assert "nose" in text and "1 without a fit" in text and "base.json" in text and "0 | 0" in text
    assert place.read_bytes() == before, "the project is not changed"
    assert main(["report", str(place), "--out", str(tmp_path / "r.txt")]) == 2
    assert "end it in .pdf" in capsys.readouterr().err


def test_a_stale_fit_is_made_anew_or_said(fitted: Project, tmp_path: Path) -> None:
    scan_id = fitted.scans[0].id
    options = fitted.scan(scan_id).options.model_copy(update={"levels": 0})
    fitted.change_scan(scan_id, options=options)
    plain = ReportOptions(contact_sheet=False, fit_missing=False)
    said = run(scans_of(fitted), Limits(), plain, tmp_path / "a.pdf")
    assert said.entries[0].note == "stale: options changed" and not said.fits
    assert "stale: options changed" in words((tmp_path / "a.pdf").read_bytes())
    made = run(scans_of(fitted), Limits(), ReportOptions(contact_sheet=False), tmp_path / "b.pdf")
    assert made.entries[0].note == "" and made.entries[0].fit.levels == 0
    assert made.fits[scan_id][0] == input_key(fitted.scan(scan_id))


def test_without_any_fit_there_is_no_report(make_project: Make, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no scan has a fit"):
        run(scans_of(make_project()[0]), Limits(), ReportOptions(), tmp_path / "r.pdf")


def test_the_same_in_a_process_of_its_own_which_can_be_stopped(fitted: Project, tmp_path: Path) -> None:
    options, seen = ReportOptions(contact_sheet=False), []

    def stop(fraction: float, text: str) -> None:
        seen.append(text)
        if text.startswith("picturing"):
            raise Cancelled

    with pytest.raises(Cancelled):
        run_apart(scans_of(fitted), Limits(), options, tmp_path / "a.pdf", stop, title="t")
    assert not (tmp_path / "a.pdf").exists() and "starting" in seen
    with pytest.raises(InputError, match="end it in"):
        run_apart(scans_of(fitted), Limits(), options, tmp_path / "a.txt", lambda f, t: None, title="t")
    result = run_apart(scans_of(fitted), Limits(), options, tmp_path / "b.pdf", lambda f, t: None, title="t")
    assert result.names == ("base",) and (tmp_path / "b.pdf").read_bytes().startswith(b"%PDF")
