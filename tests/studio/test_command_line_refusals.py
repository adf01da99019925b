"""Whatever is wrong with files and arguments: exit code 2, one line that says what to do, no harm done."""

from __future__ import annotations

import json
import os
import pickle
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.scan.range_image import RangeImage
from studio import cli

ROOT = Path(__file__).parents[2]
FIT = "scan fit {} --fiducials f.json --out face.glb"


def call(capfd: pytest.CaptureFixture[str], *arguments: str | Path) -> tuple[int, str, str]:
    """Run a command here, with all that any library writes to stdout and stderr."""
    code = cli.main([str(argument) for argument in arguments])
    return code, *capfd.readouterr()


def edit_json(path: Path, **fields: Any) -> None:
    path.write_text(json.dumps({**json.loads(path.read_text()), **fields}))


def edit_points(path: Path, edit: Callable[[dict[str, Any]], object]) -> None:
    value = json.loads(path.read_text())
    edit(value["points"])
    path.write_text(json.dumps(value))


def cut(path: Path, share: float = 0.5) -> None:
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])


def pickled_npz(path: Path) -> None:
    class Harm:
        def __reduce__(self) -> Any:
            return (Path.touch, (path.parent / "harmed",))

    header = b"\x93NUMPY\x01\x00v\x00" + b"{'descr': '|O', 'fortran_order': False, 'shape': (1,), }".ljust(117) + b"\n"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("points.npy", header + pickle.dumps([Harm()]))


def absurd_npz(path: Path) -> None:
    text = b"{'descr': '<f8', 'fortran_order': False, 'shape': (9999999, 9999999, 3), }"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("points.npy", b"\x93NUMPY\x01\x00v\x00" + text.ljust(117) + b"\n" + bytes(64))


def absurd_ply(path: Path) -> None:
    path.write_text(
        "ply\nformat ascii 1.0\nobj_info num_cols 2000000000\nobj_info num_rows 2000000000\n"
        "element vertex 999999999999\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"
    )


def absurd_png(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[16:24] = (2**31 - 1).to_bytes(4, "big") * 2
    path.write_bytes(data)


def empty_depth(folder: Path, scan: RangeImage) -> None:
    import cv2

    name = json.loads((folder / "base.json").read_text())["depth"]
    cv2.imwrite(str(folder / name), np.zeros((scan.height, scan.width), np.uint16))


def small_colour(folder: Path) -> None:
    import cv2

    name = json.loads((folder / "base.json").read_text())["colour"]
    cv2.imwrite(str(folder / name), np.zeros((5, 7, 3), np.uint8))


def depth_of(folder: Path) -> Path:
    return folder / json.loads((folder / "base.json").read_text())["depth"]


def collinear(points: dict[str, Any]) -> None:
    for number, name in enumerate(points):
        points[name] = [10.0 + 5 * number, 20.0 + 4 * number]


BAD_FILES: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "truncated depth image": (FIT.format("base.json"), lambda f: cut(depth_of(f)), "base_depth"),
    "truncated in its header": (FIT.format("base.json"), lambda f: cut(depth_of(f), 0.001), "base_depth"),
    "truncated npz": (FIT.format("base.npz"), lambda f: cut(f / "base.npz"), "base.npz"),
    "truncated ply": (FIT.format("base.ply"), lambda f: cut(f / "base.ply"), "base.ply"),
    "truncated json": (FIT.format("base.json"), lambda f: cut(f / "base.json"), "base.json"),
    "empty json": (FIT.format("base.json"), lambda f: (f / "base.json").write_bytes(b""), "is empty"),
    "empty npz": (FIT.format("base.npz"), lambda f: (f / "base.npz").write_bytes(b""), "is empty"),
    "empty ply": ("scan info base.ply", lambda f: (f / "base.ply").write_bytes(b""), "is empty"),
    "wrong magic png": ("scan info base.json", lambda f: depth_of(f).write_bytes(b"GARBAGE" * 99), "base_depth"),
    "wrong magic npz": ("scan info base.npz", lambda f: (f / "base.npz").write_bytes(b"GARBAGE" * 99), "base.npz"),
    "wrong magic ply": ("scan info base.ply", lambda f: (f / "base.ply").write_bytes(b"GARBAGE" * 99), "base.ply"),
    "wrong kind": ("scan info f.txt", lambda f: (f / "f.txt").write_text("hello"), "is not a scan"),
    "absurd png": ("scan info base.json", lambda f: absurd_png(depth_of(f)), "base_depth"),
    "absurd npz": ("scan info base.npz", lambda f: absurd_npz(f / "base.npz"), "base.npz"),
    "absurd ply": ("scan info base.ply", lambda f: absurd_ply(f / "base.ply"), "base.ply"),
    "pickle in an npz": ("scan info base.npz", lambda f: pickled_npz(f / "base.npz"), "base.npz"),
    "colour of another size": ("scan info base.json", small_colour, "colour"),
    "path out of the folder": ("scan info base.json", lambda f: edit_json(f / "base.json", depth="../d.png"), "depth"),
    "no focal length": ("scan info base.json", lambda f: edit_json(f / "base.json", fx=0), "fx"),
    "unknown unit": (FIT.format("base.json"), lambda f: edit_json(f / "base.json", unit_mm="x"), "unit_mm"),
    "no scan": (FIT.format("none.json"), lambda f: None, "none.json: there is no such file"),
    "a folder": (FIT.format("."), lambda f: None, "is a folder"),
    "fiducials missing": (
        FIT.format("base.json"),
        lambda f: edit_points(f / "f.json", lambda p: p.pop("chin")),
        "chin",
    ),
    "fiducials empty": (FIT.format("base.json"), lambda f: edit_points(f / "f.json", lambda p: p.clear()), "forehead"),
    "fiducial twice": (
        FIT.format("base.json"),
        lambda f: (f / "f.json").write_text((f / "f.json").read_text().replace('"chin"', '"chin": [1, 2],\n  "chin"')),
        "'chin' twice",
    ),
    "fiducials at one place": (
        FIT.format("base.json"),
        lambda f: edit_points(f / "f.json", lambda p: p.update(chin=p["nose_tip"])),
        "f.json",
    ),
    "fiducials collinear": (FIT.format("base.json"), lambda f: edit_points(f / "f.json", collinear), "line"),
    "fiducial outside": (
        FIT.format("base.json"),
        lambda f: edit_points(f / "f.json", lambda p: p.update(chin=[1e4, 5])),
        "chin",
    ),
    "fiducial not a number": (
        FIT.format("base.json"),
        lambda f: (f / "f.json").write_text(re.sub(r'"chin": \[[^]]*', '"chin": [NaN, 1', (f / "f.json").read_text())),
        "chin",
    ),
    "fiducials of another picture": (
        FIT.format("base.json"),
        lambda f: edit_json(f / "f.json", image_size=[640, 480]),
        "image_size",
    ),
    "other scheme": (FIT.format("base.json") + " --scheme open", lambda f: None, "lip_upper_inner"),
    "no fiducial file": (FIT.format("base.json"), lambda f: (f / "f.json").unlink(), "f.json: there is no such file"),
    "no template": (FIT.format("base.json") + " --template t.json", lambda f: None, "t.json"),
    "broken template": (
        FIT.format("base.json") + " --template t.json",
        lambda f: (f / "t.json").write_text('{"name": 3}'),
        "t.json",
    ),
    "ending of the output": ("scan fit base.json --fiducials f.json --out face.fbx", lambda f: None, ".glb or .obj"),
    "folder of the output": ("scan fit base.json --fiducials f.json --out no/face.glb", lambda f: None, "folder"),
}
BAD_ARGUMENTS = {
    "": "",
    "scan fit": "see quasiface scan fit --help",
    "scan fit base.json": "--fiducials",
    "scan fit base.json --fiducials f.json": "--out",
    FIT.format("base.json") + " --levels many": "--levels 'many'",
    FIT.format("base.json") + " --levels 7": "--levels '7': input should be less than or equal to 4",
    FIT.format("base.json") + " --spike-mm nan": "--spike-mm",
    FIT.format("base.json") + " --scheme ajar": "--scheme",
    FIT.format("base.json") + " --nonsense 1": "--nonsense",
    FIT.format("base.json") + " more": "more",
    "scan info base.json --unit feet": "unit",
    "scan": "",
    "scan bake": "bake",
    "bake": "bake",
    "--nonsense": "--nonsense",
    "studio none.qface": "none.qface: there is no such file",
    "demo --out": "--out",
}


@pytest.mark.parametrize("kind", BAD_FILES)
def test_bad_files_end_in_exit_code_2_and_one_line(
    folder: Path, scan: RangeImage, capfd: pytest.CaptureFixture[str], kind: str
) -> None:
    words, spoil, named = BAD_FILES[kind]
    spoil(folder)
    refused(capfd, words.split(), named)
    assert not (folder / "face.glb").exists() and not (folder / "harmed").exists()


def test_a_scan_without_a_valid_pixel_is_refused(
    folder: Path, scan: RangeImage, capfd: pytest.CaptureFixture[str]
) -> None:
    empty_depth(folder, scan)
    refused(capfd, ["scan", "info", "base.json"], "no valid pixel")
    np.savez(folder / "base.npz", points=np.full((4, 5, 3), np.nan))
    refused(capfd, ["scan", "info", "base.npz", "--json"], "no valid pixel")


@pytest.mark.parametrize("words", [words for words, named in BAD_ARGUMENTS.items() if named])
def test_bad_arguments_end_in_exit_code_2_and_one_line(
    folder: Path, capfd: pytest.CaptureFixture[str], words: str
) -> None:
    refused(capfd, words.split(), BAD_ARGUMENTS[words])


def refused(capfd: pytest.CaptureFixture[str], words: list[str], named: str) -> None:
    code, out, err = call(capfd, *words)
    assert (code, out) == (2, ""), err
    assert err.count("\n") == 1 and err.endswith("\n") and named in err, err
    assert "Traceback" not in err and all(c.isprintable() or c == "\n" for c in err)


def test_without_a_display_the_studio_says_what_to_do(
    folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    refused(capfd, ["studio"], "no display")
    refused(capfd, [], "no display")


def test_all_bad_files_together_stay_below_a_gigabyte(folder: Path, scan: RangeImage) -> None:
    if not Path("/proc/self/status").exists():
        pytest.skip("memory is measured on Linux only")
    spoiled = []
    for number, (words, spoil, _) in enumerate(BAD_FILES.values()):
        place = folder / str(number)
        place.mkdir()
        for name in ("base.json", "base.npz", "base.ply", "f.json", "base_depth.png", "base_colour.png"):
            if (folder / name).exists():
                (place / name).write_bytes((folder / name).read_bytes())
        spoil(place)
        spoiled.append([str(place), words])
    probe = (
        "import json, os, re, sys; from studio.cli import main; codes = set()\n"
        "for place, words in json.loads(sys.argv[1]):\n"
        "    os.chdir(place); codes.add(main(words.split()))\n"
        # Not ru_maxrss: that one begins with the size of the process that started this one.
        "print(codes, re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read())[1])"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", probe, json.dumps(spoiled)], env=environment, capture_output=True, text=True, timeout=100
    )
    codes, _, kilobytes = done.stdout.strip().rpartition(" ")
    assert codes == "{2}", done.stderr
    assert int(kilobytes) < 1_000_000
    assert len(done.stderr.splitlines()) == len(BAD_FILES)
