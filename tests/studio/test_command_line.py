"""The command line as scripts see it: figures, one JSON object, help, no Qt."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

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


FIT = "scan fit {} --fiducials f.json --out face.glb"


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
