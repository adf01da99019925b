"""What is noted about a batch is a file like any other: judged anew, believed only where it agrees with the jobs."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from engine.files.limits import write_limits
from engine.scan.limits import Bounds, Limits, RegionLimits
from studio.cli import main

TIGHT = Limits().with_region("nose", RegionLimits(Bounds(0.0, 0.0)))


@pytest.fixture
def jobs(folder: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """A jobs file whose only item is done, with a textured OBJ."""
    path = folder / "jobs.toml"
    item = '[[item]]\nscan = "base.json"\nfiducials = "f.json"\nout = "a.obj"\n'
    path.write_text('stage = "scan"\n[options]\nlevels = 0\n' + item)
    assert main(["batch", str(path), "--json"]) == 0
    capsys.readouterr()
    return path


def again(capsys: pytest.CaptureFixture[str], jobs: Path, *words: object) -> dict[str, Any]:
    assert main([str(word) for word in ("batch", jobs, "--resume", "--json", *words)]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)["items"][0]
    return found


def edit(jobs: Path, **values: object) -> None:
    """Put values into what is noted about the item."""
    record = jobs.with_name("jobs.done.json")
    noted = json.loads(record.read_text())
    noted["done"]["a.obj"] |= values
    record.write_text(json.dumps(noted))


def noted(jobs: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(jobs.with_name("jobs.done.json").read_text())["done"]["a.obj"]
    return found


def test_other_limits_judge_what_is_done(jobs: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    first = again(capsys, jobs)
    assert first["state"] == "skipped" and first["worst_region"] != "nose"
    assert not {"verdict", "worst_region"} & noted(jobs)["figures"].keys()
    limits = write_limits(tmp_path / "l.toml", TIGHT)
    strict = again(capsys, jobs, "--limits", limits)
    assert (strict["state"], strict["verdict"], strict["worst_region"]) == ("skipped", "fail", "nose")
    anew = main(["batch", str(jobs), "--json", "--limits", str(limits)]), json.loads(capsys.readouterr().out)
    fresh = anew[1]["items"][0]
    assert {k: v for k, v in fresh.items() if k not in ("state", "seconds")} == {
        k: v for k, v in strict.items() if k not in ("state", "seconds")
    }, "judged from the record as from the face"
    jobs.write_text(jobs.read_text().replace('"scan"\n', '"scan"\nlimits = "l.toml"\n', 1))
    assert again(capsys, jobs)["worst_region"] == "nose", "also where the jobs file names them"


def test_figures_of_a_record_replace_nothing_else(jobs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    figures = noted(jobs)["figures"]
    edit(jobs, figures=figures | {"error": "x", "state": "failed", "files": ["/etc/passwd"], "verdict": "superb"})
    found = again(capsys, jobs)
    assert found["state"] == "skipped" and "error" not in found and found["verdict"] in ("ok", "warn", "fail")
    assert [Path(name).name for name in found["files"]] == ["a.obj", "a.mtl", "a_texture.png"]
    for broken in ({}, figures | {"median_mm": "0"}, figures | {"regions": [{}]}, figures | {"regions": 3}):
        edit(jobs, figures=broken)
        assert again(capsys, jobs)["state"] == "done"


@pytest.mark.parametrize("place", ["/dev/zero", "../elsewhere", "pipe", "device", "gone"])
def test_sources_of_a_record_stay_in_the_folder(
    jobs: Path, capsys: pytest.CaptureFixture[str], place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    os.mkfifo(jobs.parent / "pipe")
    (jobs.parent / "device").symlink_to("/dev/zero")
    opened: list[str] = []
    plain = Path.open
    monkeypatch.setattr(Path, "open", lambda self, *a, **k: (opened.append(self.name), plain(self, *a, **k))[1])
    edit(jobs, sources=[*noted(jobs)["sources"], place])
    assert again(capsys, jobs)["state"] == "done"
    assert not {"zero", "pipe", "device"} & set(opened)
    edit(jobs, sources=[])
    assert again(capsys, jobs)["state"] == "done", "fewer sources have another key"
    assert again(capsys, jobs)["state"] == "skipped"


def test_files_of_a_record_are_those_of_the_face(jobs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = noted(jobs)["files"]
    for other in ({}, {name: stamp for name, stamp in files.items() if name != "a.obj"}, files | {"f.json": {}}):
        status = (jobs.parent / "f.json").stat()
        stamps = {
            name: stamp or {"size": status.st_size, "mtime_ns": status.st_mtime_ns} for name, stamp in other.items()
        }
        edit(jobs, files=stamps)
        assert again(capsys, jobs)["state"] == "done"


def test_what_changes_while_it_is_read_is_done_again(
    jobs: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A picture that is replaced once it was read: the face was made from the old one."""
    from engine.files import scan as readers

    picture, plain = jobs.parent / "base_colour.png", readers.read_scan

    def late(*words: Any) -> Any:
        read = plain(*words)
        picture.write_bytes(picture.read_bytes() + b"\0")
        return read

    with monkeypatch.context() as patch:
        patch.setattr(readers, "read_scan", late)
        assert main(["batch", str(jobs)]) == 0
    capsys.readouterr()
    assert again(capsys, jobs)["state"] == "done"
    assert again(capsys, jobs)["state"] == "skipped"
