"""The command line as scripts see it: exit codes, one line for what is wrong, one JSON object, no Qt."""

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

from engine.files.depth_json import write_depth_scan
from engine.files.landmarks_json import write_fiducials
from engine.files.npz import write_npz
from engine.files.ply import write_ply
from engine.scan.range_image import RangeImage
from studio import cli, output
from studio.scan import job

ROOT = Path(__file__).parents[2]
FIT_KEYS = {
    "fiducial_residual_px",
    "median_mm",
    "p95_mm",
    "p99_mm",
    "max_mm",
    "filled_vertices",
    "folded_faces",
    "vertices",
    "faces",
}
Positions = dict[str, tuple[float, float]]


@pytest.fixture
def folder(tmp_path: Path, scan: RangeImage, fiducials: Positions, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with one scan in every form and its fiducials, which is also the working folder."""
    write_depth_scan(tmp_path / "base.json", scan, 0.02)
    write_npz(tmp_path / "base.npz", scan)
    write_ply(tmp_path / "base.ply", scan)
    write_fiducials(tmp_path / "f.json", fiducials, (scan.width, scan.height))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def process(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-m", "studio", *arguments],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
    )


def call(capfd: pytest.CaptureFixture[str], *arguments: str | Path) -> tuple[int, str, str]:
    """Run a command here, with all that any library writes to stdout and stderr."""
    code = cli.main([str(argument) for argument in arguments])
    return code, *capfd.readouterr()


@pytest.mark.parametrize("name", ["base.json", "base.npz", "base.ply"])
def test_info_says_what_a_scan_holds(
    folder: Path, scan: RangeImage, capfd: pytest.CaptureFixture[str], name: str
) -> None:
    code, out, _ = call(capfd, "scan", "info", name, "--json")
    values = json.loads(out)
    assert code == 0 and out.count("\n") == 1
    assert (values["width"], values["height"], values["unit"]) == (scan.width, scan.height, "mm")
    assert values["missing_fraction"] == scan.missing_fraction
    assert values["spikes"] == 1
    points = scan.points[scan.valid]
    np.testing.assert_allclose(values["bounds_mm"], [points.min(axis=0), points.max(axis=0)], atol=0.02)


def test_unit_scales_a_scan_and_is_said(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    _, mm, _ = call(capfd, "scan", "info", "base.npz", "--json")
    code, cm, err = call(capfd, "scan", "info", "base.npz", "--unit", "cm", "--json")
    assert code == 0 and json.loads(cm)["unit"] == "cm"
    np.testing.assert_allclose(np.array(json.loads(cm)["bounds_mm"]), 10 * np.array(json.loads(mm)["bounds_mm"]))
    assert "base.npz" in err  # six and a half metres is an unlikely face, and that is said


@pytest.mark.parametrize("target", ["face.glb", "face.obj"])
def test_fit_writes_the_face_and_prints_one_object(
    folder: Path, capfd: pytest.CaptureFixture[str], target: str
) -> None:
    code, out, err = call(capfd, "scan", "fit", "base.json", "--fiducials", "f.json", "--out", target, "--json")
    values = json.loads(out)
    assert code == 0 and err == "" and out.count("\n") == 1
    assert set(values) >= FIT_KEYS
    assert values["fiducial_residual_px"] < 1e-6 and values["folded_faces"] == 0
    assert (values["faces"], values["spikes"]) == (16 * len(job.template_of().faces), 1)
    assert values["median_mm"] < 0.1
    assert values["files"][0] == target and all((folder / name).stat().st_size > 0 for name in values["files"])
    assert len(values["files"]) == (1 if target == "face.glb" else 3)


def test_a_face_says_how_it_was_made(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    code, *_ = call(capfd, *FIT.format("base.json").split(), "--levels", "1")
    data = (folder / "face.glb").read_bytes()
    text = json.dumps(json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")]))
    assert code == 0
    assert '"levels": 1' in text and '"scheme": "closed"' in text and '"spikes": 1' in text


def test_without_a_display_the_studio_says_what_to_do(
    folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    refused(capfd, ["studio"], "no display")
    refused(capfd, [], "no display")


def test_fit_takes_every_option_of_the_job(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    words = "scan fit base.npz --unit mm --fiducials f.json --out a.obj --levels 0 --spike-mm 50 --no-smooth --json"
    code, out, _ = call(capfd, *words.split())
    values = json.loads(out)
    assert code == 0 and (values["faces"], values["levels"]) == (len(job.template_of().faces), 0)
    assert values["spikes"] == 0
    code, out, _ = call(capfd, *words.replace("50 --no-smooth --json", "4 --no-fill-gaps").split())
    assert code == 0 and re.search(r"^spikes +1$", out, re.M) and re.search(r"^filled_pixels +0$", out, re.M)


def test_copied_command_line_makes_the_same_fit(
    folder: Path, make_project: Callable[..., Any], fiducials: Positions, capfd: pytest.CaptureFixture[str]
) -> None:
    project, scan_id = make_project(fiducials)
    options = job.FitOptions(levels=1, smooth=False, spike_mm=3.5)
    project.change_scan(scan_id, options=options)
    item = project.scan(scan_id)
    line = job.as_command(item, options, "f.json", "my face.glb")
    assert line == (
        "quasiface scan fit base.json --fiducials f.json --levels 1 --spike-mm 3.5 --no-smooth --out 'my face.glb'"
    )
    import shlex

    code, out, _ = call(capfd, *shlex.split(line)[1:], "--json")
    assert code == 0 and json.loads(out)["faces"] == 4 * len(job.template_of().faces)
    assert job.as_command(item, job.FitOptions()) == (
        "quasiface scan fit base.json --fiducials base_fiducials.json --out base.glb"
    )


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


FIT = "scan fit {} --fiducials f.json --out face.glb"
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
    "scan info base.json --unit feet": "--unit",
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


def test_our_own_fault_leaves_a_report(
    folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("planted\nfault")

    monkeypatch.setattr(job, "export_face", fail)
    code, out, err = call(capfd, *FIT.format("base.json").split())
    assert (code, out) == (1, "") and err.count("\n") == 1 and "planted fault" in err
    report = Path(err.strip().rpartition("a report is in ")[2])
    assert "RuntimeError: planted" in report.read_text() and "in fail" in report.read_text()


def test_the_real_command_needs_no_qt(folder: Path) -> None:
    """In processes of their own: no Qt, no 3-D is loaded, and stdout is the JSON object alone."""
    probe = (
        "import sys; from studio.cli import main; code = main(sys.argv[1:]); "
        "loaded = {m.partition('.')[0] for m in sys.modules}; "
        "print(sorted(loaded & {'PySide6', 'shiboken6', 'pyvista', 'pyvistaqt', 'vtkmodules', 'matplotlib'}), "
        "file=sys.stderr); sys.exit(code)"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = (*FIT.format("base.json").split(), "--json")
    done = subprocess.run(
        [sys.executable, "-c", probe, *words], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0 and done.stderr == "[]\n", done.stderr
    assert set(json.loads(done.stdout)) >= FIT_KEYS

    refusing = process(*FIT.format("none.ply").split(), cwd=folder)
    assert (refusing.returncode, refusing.stdout) == (2, "")
    assert refusing.stderr == "none.ply: there is no such file; check the name and the folder\n"


def test_help_and_version_load_no_numpy(folder: Path) -> None:
    probe = (
        "import sys; from studio.cli import main; codes = [main(a.split()) for a in sys.argv[1:]]; "
        "heavy = {'numpy', 'scipy', 'cv2', 'PySide6', 'pyvista', 'matplotlib'} & set(sys.modules); "
        "print(codes, sorted(heavy), file=sys.stderr)"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "100"}
    words = ["--help", "scan --help", "scan info --help", "scan fit --help", "demo --help", "--version"]
    done = subprocess.run(
        [sys.executable, "-c", probe, *words], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.stderr == "[0, 0, 0, 0, 0, 0] []\n", done.stderr
    for word in ("studio", "demo", "info", "--fiducials", "--levels", "--spike-mm", "--unit", "--json", "--out"):
        assert word in done.stdout
    assert re.search(r"^\d+\.\d+\.\d+", done.stdout.splitlines()[-1])


def test_all_bad_files_together_stay_below_a_gigabyte(folder: Path, scan: RangeImage) -> None:
    resource = pytest.importorskip("resource")
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
        "import json, os, resource, sys; from studio.cli import main; codes = set()\n"
        "for place, words in json.loads(sys.argv[1]):\n"
        "    os.chdir(place); codes.add(main(words.split()))\n"
        "print(codes, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    assert resource is not None
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", probe, json.dumps(spoiled)], env=environment, capture_output=True, text=True, timeout=100
    )
    codes, _, kilobytes = done.stdout.strip().rpartition(" ")
    assert codes == "{2}", done.stderr
    assert int(kilobytes) < 1_000_000
    assert len(done.stderr.splitlines()) == len(BAD_FILES)


def test_figures_print_for_people_and_for_scripts(capsys: pytest.CaptureFixture[str]) -> None:
    values = {
        "a": np.float64("nan"),
        "b": np.int64(3),
        "c": [np.float32(0.5), None],
        "d": Path("x"),
        "e": 1e-9,
        "f": True,
    }
    output.print_result(values, True)
    assert json.loads(capsys.readouterr().out) == {"a": None, "b": 3, "c": [0.5, None], "d": "x", "e": 1e-9, "f": True}
    output.print_result(values, False)
    assert " ".join(capsys.readouterr().out.split()) == "a - b 3 c 0.5000 - d x e 1.0e-09 f yes"
    output.print_table(("scan", "mm"), [("base", 0.05), ("a", 12)])
    assert capsys.readouterr().out == "scan      mm\nbase  0.0500\na         12\n"
    assert output.one_line("a\n\tb\x1b[31m") == "a b [31m"
    with pytest.raises(TypeError):
        output.plain(object())
