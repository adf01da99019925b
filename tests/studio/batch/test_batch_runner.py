"""Workers may die whenever they like, memory is counted as the system can give it, and a report loses no figures."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from engine.scan.limits import Limits
from studio.batch import runner
from studio.batch.job import ItemResult
from studio.batch.options import read_jobs
from studio.batch.runner import WORKER_BYTES, free_bytes, run_items, workers_for
from studio.cli import main
from studio.project import store
from studio.project.document import Project

Make = Callable[..., tuple[Project, str]]
ITEM = '[[item]]\nscan = "base.npz"\nfiducials = "f.json"\nout = "{out}"\n'


def jobs(folder: Path, *outs: str) -> Path:
    path = folder / "jobs.toml"
    path.write_text('stage = "scan"\n[options]\nlevels = 0\n' + "".join(ITEM.format(out=out) for out in outs))
    return path


def test_workers_that_die_between_items_cost_no_item(folder: Path) -> None:
    asked = read_jobs(jobs(folder, *(f"{k}.glb" for k in range(5))))
    told: list[str] = []

    def kill(_number: int, result: ItemResult) -> None:
        told.append(result.name)
        if len(told) == 1:
            for process in multiprocessing.active_children():
                os.kill(process.pid or 0, signal.SIGKILL)
            time.sleep(0.5)  # the pool sees it before anything else is handed out

    results = run_items(asked.items, Limits(), workers=2, told=kill)
    assert [result.state for result in results] == ["done"] * 5 and sorted(told) == list("01234")
    assert sorted(path.name for path in folder.glob("*.glb")) == [f"{k}.glb" for k in range(5)]
    assert not multiprocessing.active_children()


@pytest.mark.skipif(not Path("/proc/meminfo").is_file(), reason="the system does not say what is free")
def test_memory_that_only_caches_files_is_free() -> None:
    free = free_bytes()
    assert free is not None
    unused = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    cached = next(line for line in Path("/proc/meminfo").read_text().splitlines() if line.startswith("Cached:"))
    assert unused - (256 << 20) < free <= os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    assert free > unused or int(cached.split()[1]) < 512 << 10


def test_fewer_workers_than_asked_are_told(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runner, "free_bytes", lambda: WORKER_BYTES + 1)
    assert workers_for(4, 9) == 1
    assert main(["batch", str(jobs(folder, "a.glb", "b.glb")), "--workers", "2", "--json"]) == 0
    seen = capsys.readouterr()
    assert json.loads(seen.out)["workers"] == 1 and "1 of 2 workers: free memory" in seen.err
    monkeypatch.setattr(runner, "free_bytes", lambda: 99 * WORKER_BYTES)
    assert main(["batch", str(jobs(folder, "a.glb")), "--workers", "2"]) == 0
    assert "1 of 2 workers: there is 1 item" in capsys.readouterr().err
    monkeypatch.setattr(runner, "free_bytes", lambda: None)
    assert workers_for(4, 9) == 4


def test_options_of_the_other_kind_are_refused(folder: Path, saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = jobs(folder, "a.glb")
    for words in (["--pattern", "{name}"], ["--format", "obj"], ["--out", "x"], ["--report", "r.pdf"]):
        assert main(["batch", str(path), *words]) == 2
        assert f"{words[0]}: is for projects" in capsys.readouterr().err
    assert main(["batch", str(saved), "--out", str(folder / "faces"), "--resume"]) == 2
    assert "--resume: is for jobs files" in capsys.readouterr().err
    assert not list(folder.glob("**/*.glb"))


def two_scans(make_project: Make, fiducials: dict[str, tuple[float, float]], folder: Path) -> Path:
    """Return a project with a scan that can be fitted, and one whose fiducials lie outside its picture."""
    from dataclasses import replace

    from engine.landmarks import LandmarkSet
    from studio.scan.options import FitOptions

    project, scan_id = make_project(fiducials)
    project.change_scan(scan_id, options=FitOptions(levels=0))
    one = project.scan(scan_id)
    bad = LandmarkSet.placed(dict.fromkeys(fiducials, (5.0, 5.0)))
    project.insert_scan(1, replace(one, id="bad", name="bad", landmarks=bad))
    return store.save(project, folder / "two.qface")


@pytest.mark.parametrize("workers", [1, 2])
def test_the_report_takes_the_fits_of_the_batch(
    make_project: Make,
    fiducials: dict[str, tuple[float, float]],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    workers: int,
) -> None:
    from studio.report import job

    def again(*_words: Any) -> None:
        raise AssertionError("fitted twice")

    monkeypatch.setattr(job, "fit_scan", again)
    place, out = two_scans(make_project, fiducials, tmp_path), tmp_path / "new" / "r.pdf"
    words = ["batch", str(place), "--out", str(tmp_path / "faces"), "--report", str(out), "--workers", str(workers)]
    assert main([*words, "--json"]) == 2, "one scan failed"
    found = json.loads(capsys.readouterr().out)
    assert found["report"] == [str(out), str(tmp_path / "new" / "r_sheet.png")] and "report_error" not in found
    assert [item["state"] for item in found["items"]] == ["done", "failed"]
    assert out.read_bytes().startswith(b"%PDF")


def test_a_report_that_cannot_be_is_told_before_the_work(
    saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_bytes(b"x")
    (tmp_path / "folder.pdf").mkdir()
    for name, problem in (("r.txt", "end it in .pdf"), ("file/r.pdf", "folder"), ("folder.pdf", "is a folder")):
        code = main(["batch", str(saved), "--out", str(tmp_path / "faces"), "--report", str(tmp_path / name)])
        assert code == 2 and problem in capsys.readouterr().err
    assert not (tmp_path / "faces").exists()


def test_a_report_that_fails_leaves_the_figures(
    saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from engine.errors import InputError
    from studio.report import job

    def fails(error: Exception) -> Callable[..., None]:
        def run(*_words: Any, **_more: Any) -> None:
            raise error

        return run

    words = ["batch", str(saved), "--out", str(tmp_path / "faces"), "--report", str(tmp_path / "r.pdf")]
    for error, code in ((InputError("r.pdf", "disk full", "make room"), 2), (ZeroDivisionError("none"), 1)):
        monkeypatch.setattr(job, "run", fails(error))
        assert main([*words, "--json"]) == code
        found = json.loads(capsys.readouterr().out)
        assert found["items"][0]["state"] == "done" and str(error) in found["report_error"] and found["report"] == []
        assert main(words) == code
        seen = capsys.readouterr()
        assert "median_mm" in seen.out and str(error) in seen.err
