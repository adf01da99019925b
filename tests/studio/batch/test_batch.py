"""A batch does every item it can, says what failed, leaves whole files only, and goes on where it was stopped."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from engine.errors import Cancelled, InputError
from engine.scan.limits import Bounds, Limits, RegionLimits
from studio.batch.options import read_jobs
from studio.batch.project import face_names, project_items
from studio.batch.runner import run_items, workers_for
from studio.cli import main
from studio.project import store
from studio.project.document import Project

ITEM = '[[item]]\nscan = "{scan}"\nfiducials = "f.json"\nout = "{out}"\n'


def jobs(folder: Path, *outs: str, scan: str = "base.npz", head: str = "[options]\nlevels = 1\n") -> Path:
    path = folder / "jobs.toml"
    path.write_text('stage = "scan"\n' + head + "".join(ITEM.format(scan=scan, out=out) for out in outs))
    return path


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, dict[str, Any], str]:
    code = main([str(word) for word in words])
    seen = capsys.readouterr()
    assert len(seen.out.strip().splitlines()) <= 1, "exactly one JSON object"
    return code, json.loads(seen.out) if seen.out.strip() else {}, seen.err


def test_one_bad_item_stops_nothing_and_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = jobs(folder, "faces/a.glb", "faces/b.obj")
    with path.open("a") as text:
        text.write(ITEM.format(scan="gone.npz", out="faces/c.glb"))
    code, found, told = run(capsys, "batch", path, "--json")
    assert code == 2 and (found["done"], found["failed"]) == (2, 1)
    assert [item["name"] for item in found["items"]] == ["a", "b", "c"]
    assert "gone.npz" in found["items"][2]["error"] and "no such file" in found["items"][2]["error"]
    first = found["items"][0]
    assert first["verdict"] in ("ok", "warn", "fail") and first["levels"] == 1
    assert {region["name"] for region in first["regions"]} >= {"brows", "lids", "nose", "lips", "cheeks", "jaw"}
    names = sorted(entry.name for entry in (folder / "faces").iterdir())
    assert names == ["a.glb", "b.mtl", "b.obj", "b_texture.png"]
    assert "3/3" in told


def test_two_workers_find_what_one_finds(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = run(capsys, "batch", jobs(folder, "a.glb", "b.glb"), "--json")
    faces = [(folder / name).read_bytes() for name in ("a.glb", "b.glb")]
    two = run(capsys, "batch", jobs(folder, "a.glb", "b.glb"), "--workers", 2, "--json")
    assert one[0] == two[0] == 0
    for before, after in zip(one[1]["items"], two[1]["items"], strict=True):
        for item in (before, after):
            item.pop("seconds")
        assert before == after
    assert [(folder / name).read_bytes() for name in ("a.glb", "b.glb")] == faces


def test_resume_leaves_out_what_is_done_and_nothing_else(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = jobs(folder, "a.glb", "b.glb", "c.glb")
    code, first, _ = run(capsys, "batch", path, "--json")
    assert code == 0
    (folder / "b.glb").write_bytes(b"something else")
    (folder / "c.glb").unlink()
    code, again, _ = run(capsys, "batch", path, "--resume", "--json")
    assert code == 0 and [item["state"] for item in again["items"]] == ["skipped", "done", "done"]
    assert again["items"][0]["median_mm"] == first["items"][0]["median_mm"]
    jobs(folder, "a.glb", "b.glb", "c.glb", head="[options]\nlevels = 0\n")
    _, other, _ = run(capsys, "batch", path, "--resume", "--json")
    assert [item["state"] for item in other["items"]] == ["done"] * 3, "other options make another face"
    assert [i["state"] for i in run(capsys, "batch", path, "--json")[1]["items"]] == ["done"] * 3, "asked for anew"
    (folder / "jobs.done.json").write_text("{broken")
    _, lost, _ = run(capsys, "batch", path, "--resume", "--json")
    assert [item["state"] for item in lost["items"]] == ["done"] * 3, "a record that cannot be read counts as none"


@pytest.mark.parametrize("workers", [1, 2])
def test_a_batch_that_is_killed_leaves_whole_files_only(folder: Path, workers: int) -> None:
    path = jobs(folder, *(f"faces/{k}.glb" for k in range(30)))
    command = [sys.executable, "-m", "studio", "batch", str(path), "--workers", str(workers)]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    process = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    faces = folder / "faces"
    until = time.monotonic() + 60
    while time.monotonic() < until and len(list(faces.glob("*.glb")) if faces.is_dir() else []) < 2:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    time.sleep(0.5)  # workers see that their parent is gone
    written = sorted(faces.glob("[0-9]*.glb"))
    assert 2 <= len(written) < 30
    sizes = set()
    for face in written:
        data = face.read_bytes()
        assert data[:4] == b"glTF" and int.from_bytes(data[8:12], "little") == len(data), face
        sizes.add(len(data))
    assert len(sizes) == 1, "the same scan makes the same face"


def test_cancelling_stops_between_steps_and_keeps_what_is_written(folder: Path) -> None:
    asked = read_jobs(jobs(folder, "a.glb", "b.glb", "c.glb"))
    seen: list[str] = []

    def progress(fraction: float, text: str) -> None:
        if len(seen) == 1 and text.startswith("b: sampling"):
            raise Cancelled

    with pytest.raises(Cancelled):
        run_items(asked.items, Limits(), told=lambda _n, result: seen.append(result.name), progress=progress)
    assert seen == ["a"] and [p.name for p in sorted(folder.glob("*.glb"))] == ["a.glb"]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "stage"),
        ('stage = "viseme"\n[[item]]\nscan="a"\nfiducials="b"\nout="c.glb"', "stage"),
        ('stage = "scan"\n', "item"),
        ('stage = "scan"\nitem = []\n', "item"),
        (
            'stage = "scan"\n[options]\nlevels = 9\n' + ITEM.format(scan="base.npz", out="a.glb"),
            "item.0.options, levels",
        ),
        ('stage = "scan"\n' + ITEM.format(scan="../base.npz", out="a.glb"), "item.0.scan"),
        ('stage = "scan"\n' + ITEM.format(scan="base.npz", out="/tmp/a.glb"), "item.0.out"),
        ('stage = "scan"\n' + ITEM.format(scan="base.npz", out="a.stl"), "ending"),
        ('stage = "scan"\n' + 2 * ITEM.format(scan="base.npz", out="a.glb"), "also written by item.0"),
        ('stage = "scan"\n' + ITEM.format(scan="base.glb", out="base.glb"), "would replace an input"),
        ('stage = "scan"\nlimits = "../l.toml"\n' + ITEM.format(scan="base.npz", out="a.glb"), "limits"),
        ('stage = "scan"\n[[item]]\nscan="a"\nfiducials="b"\nout="c.glb"\nscheme="shut"', "item.0.scheme"),
        ("stage = ", "jobs.toml"),
    ],
)
def test_a_wrong_jobs_file_is_told_by_its_field(folder: Path, text: str, named: str) -> None:
    path = folder / "jobs.toml"
    path.write_text(text or "\n")
    with pytest.raises(InputError) as caught:
        read_jobs(path)
    assert named in str(caught.value) and str(path) in str(caught.value)


def test_a_link_out_of_the_folder_is_refused(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    outside = tmp_path_factory.mktemp("outside")
    (folder / "link").symlink_to(outside)
    with pytest.raises(InputError, match="leads out"):
        read_jobs(jobs(folder, "link/a.glb"))


def test_the_scans_of_a_project(saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found, _ = run(capsys, "batch", saved, "--out", tmp_path / "f", "--pattern", "{number}_{name}", "--json")
    assert code == 0 and found["items"][0]["state"] == "done"
    assert (tmp_path / "f" / "01_base.glb").is_file()
    tight = store.load(saved)
    tight.set_limits(Limits().with_region("nose", RegionLimits(Bounds(0.0, 0.0))))
    store.save(tight, saved)
    found = run(capsys, "batch", saved, "--out", tmp_path / "f", "--json")[1]
    assert (found["items"][0]["verdict"], found["items"][0]["worst_region"]) == ("fail", "nose"), "the project's limits"
    assert run(capsys, "batch", saved, "--json")[0] == 2, "--out is missing"


def test_a_scan_that_lacks_fiducials_is_named(make_project: Callable[..., tuple[Project, str]], tmp_path: Path) -> None:
    project, _ = make_project({}, "bare")
    items, left_out = project_items(project, tmp_path)
    assert not items and "no fiducials" in left_out[0].error and "bare" in left_out[0].error


def test_names_of_faces_are_file_names_and_never_the_same(make_project: Callable[..., tuple[Project, str]]) -> None:
    project, scan_id = make_project({}, 'a/b:"c"')
    assert face_names(project.scans, "{name}") == {scan_id: "a_b__c_"}
    assert face_names(project.scans, "x{number}") == {scan_id: "x01"}
    for pattern, problem in (("{ears}", "not known"), ("{", "cannot be read"), ("{held}", "no name")):
        with pytest.raises(InputError, match=problem):
            face_names(project.scans, pattern)
    item = project.scan(scan_id)
    from dataclasses import replace

    project.insert_scan(1, replace(item, id="other", name="d"))
    with pytest.raises(InputError, match="two scans"):
        face_names(project.scans, "face")


def test_there_are_never_more_workers_than_items_or_fewer_than_one() -> None:
    assert workers_for(8, 3) <= 3 and workers_for(1, 0) == 1 == workers_for(1, 9)
