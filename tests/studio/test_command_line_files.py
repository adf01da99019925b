"""What a command may not touch, whom it blames, and what it says when it cannot print."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import resources
from engine.scan.range_image import RangeImage
from studio import cli

ROOT = Path(__file__).parents[2]
FIT = ("scan", "fit", "base.json", "--fiducials", "f.json", "--levels", "0", "--out")


def call(capfd: pytest.CaptureFixture[str], *arguments: str | Path) -> tuple[int, str, str]:
    """Run a command here, with all that any library writes to stdout and stderr."""
    code = cli.main([str(argument) for argument in arguments])
    return code, *capfd.readouterr()


def refused(capfd: pytest.CaptureFixture[str], *words: str | Path) -> str:
    code, out, err = call(capfd, *words)
    assert (code, out) == (2, ""), err
    assert err.count("\n") == 1 and err.endswith("\n") and not err.rstrip().endswith((";", "of"))
    return err


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def rename_depth(folder: Path, name: str) -> None:
    fields = json.loads((folder / "base.json").read_text())
    (folder / fields["depth"]).rename(folder / name)
    (folder / "base.json").write_text(json.dumps({**fields, "depth": name}))


def template(folder: Path, edit: Callable[[dict[str, Any]], object]) -> None:
    value = json.loads(resources.template_path().read_text(encoding="utf-8"))
    edit(value)
    (folder / "t.json").write_text(json.dumps(value))


def test_the_texture_of_an_obj_leaves_a_depth_image_of_its_name_alone(
    folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    rename_depth(folder, "d.png")
    before = contents(folder)
    code, out, _ = call(capfd, *FIT, "d.obj", "--json")
    after = contents(folder)
    assert code == 0 and json.loads(out)["files"] == ["d.obj", "d.mtl", "d_texture.png"]
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {"d.obj", "d.mtl", "d_texture.png"}


@pytest.mark.parametrize("target", ["d.obj", "sub/../d.obj"])
def test_no_file_of_the_scan_is_replaced(folder: Path, capfd: pytest.CaptureFixture[str], target: str) -> None:
    (folder / "sub").mkdir()
    rename_depth(folder, "d_texture.png")
    before = contents(folder)
    assert "d_texture.png: would be replaced" in refused(capfd, *FIT, target)
    assert contents(folder) == before


def test_nor_through_a_link_nor_when_the_scan_is_called_a_face(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (folder / "base.ply").rename(folder / "scan.glb")
    (folder / "link.obj").symlink_to(folder / "scan.glb")
    before = contents(folder)
    words = ("scan", "fit", "scan.glb", "--fiducials", "f.json", "--levels", "0", "--out")
    assert "scan.glb: would be replaced" in refused(capfd, *words, "scan.glb")
    assert "link.obj: would be replaced" in refused(capfd, *words, "link.obj")
    (folder / "f.glb").write_bytes((folder / "f.json").read_bytes())
    assert "f.glb: would be replaced" in refused(
        capfd, *words[:2], "base.npz", "--fiducials", "f.glb", "--out", "f.glb"
    )
    (folder / "f.glb").unlink()
    assert contents(folder) == before


TEMPLATES: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "no chin": (
        lambda t: t["layouts"]["closed"]["fiducials"].pop("chin"),
        "t.json, layout closed, fiducials: the template has no vertex for chin; ",
    ),
    "no layout": (lambda t: t.update(layouts={}), "t.json, template "),
    "other layout": (lambda t: t["layouts"].pop("closed"), "choose the scheme open, or another template"),
    "two fiducials at one place": (
        lambda t: t["layouts"]["closed"]["vertices"].__setitem__(
            t["layouts"]["closed"]["fiducials"]["chin"],
            t["layouts"]["closed"]["vertices"][t["layouts"]["closed"]["fiducials"]["nose_tip"]],
        ),
        "t.json, ",
    ),
    "vertices of another count": (lambda t: t["layouts"]["closed"]["vertices"].pop(), "t.json, template "),
}


@pytest.mark.parametrize("kind", TEMPLATES)
def test_a_bad_template_is_blamed_itself(folder: Path, capfd: pytest.CaptureFixture[str], kind: str) -> None:
    edit, named = TEMPLATES[kind]
    template(folder, edit)
    told = refused(capfd, *FIT, "face.glb", "--template", "t.json")
    assert named in told and told.startswith("t.json") and "f.json" not in told


def test_a_template_that_never_ends_is_refused(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(folder / "pipe")
    for path in ("/dev/zero", "pipe"):
        assert f"{path}: is not a regular file" in refused(capfd, *FIT, "face.glb", "--template", path)


def test_a_bad_scan_is_blamed_itself(
    folder: Path, scan: RangeImage, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from engine.errors import InputError
    from studio.scan import job

    def alone(*_: object) -> None:
        raise InputError("range image", "every pixel stands alone", "check the unit")

    monkeypatch.setattr(job, "run", alone)
    told = refused(capfd, *FIT, "face.glb")
    assert told == "base.json, range image: every pixel stands alone; check the unit\n"


def test_absurd_sizes_are_refused_with_the_file(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    fields = json.loads((folder / "base.json").read_text())
    for change in ({"unit_mm": 1e4}, {"fx": 1e-300}):
        (folder / "base.json").write_text(json.dumps({**fields, **change}))
        assert refused(capfd, *FIT, "face.glb").startswith("base.json, ")


LONG = "x" * 300


@pytest.mark.parametrize(
    "words",
    [
        (*FIT, f"{LONG}.glb"),
        (*FIT, f"{LONG}.obj"),
        (*FIT, f"{LONG}/face.glb"),
        (*FIT, "x" * 250 + ".obj"),
        (*FIT, "face.glb", "--template", LONG),
        ("scan", "info", LONG),
        ("scan", "fit", "base.json", "--fiducials", LONG, "--out", "face.glb"),
        ("studio", LONG),
        ("demo", "--out", LONG),
    ],
    ids=lambda words: " ".join(words).replace(LONG, "LONG")[:60],
)
def test_names_too_long_are_refused(folder: Path, capfd: pytest.CaptureFixture[str], words: tuple[str, ...]) -> None:
    before = contents(folder)
    assert "too long" in refused(capfd, *words)
    assert contents(folder) == before


def test_the_studio_takes_json_and_says_what_it_opened(
    folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    app = pytest.importorskip("studio.app")
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    monkeypatch.setattr(app, "run", lambda project: 0)
    (folder / "a.qface").write_bytes(b"x")
    for words, project in ((["studio", "a.qface"], "a.qface"), (["studio"], None), ([], None)):
        code, out, err = call(capfd, *words, "--json")
        assert (code, err) == (0, "") and json.loads(out) == {"project": project, "exit_code": 0}
        assert call(capfd, *words) == (0, "", "")
    assert "there is no such file" in refused(capfd, "studio", "none.qface", "--json")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full is Linux's")
@pytest.mark.parametrize("words", ["scan info base.npz", "scan info base.npz --json", "--help", "--version"])
def test_a_full_disk_behind_the_output_is_said_in_one_line(folder: Path, words: str) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_STATE_HOME": str(folder / "state")}
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "studio", *words.split()],
            cwd=folder, env=environment, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and "cannot be written (No space left on device)" in done.stderr
    assert not (folder / "state").exists()
