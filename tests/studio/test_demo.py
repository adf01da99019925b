"""The demo goes the whole way in a process without Qt and without a display."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from engine.errors import InputError
from engine.files.images import image_size
from studio import demo
from studio.basis.results import Ingredients, analyse
from studio.project import store
from studio.scan.job import template_of

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.timeout(400)
NAMES = ["base", "car", "man", "she", "eel", "too"]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, dict[str, Any], str]]:
    """The folder of one run, the JSON object that it printed, and what it said on stderr."""
    out = tmp_path_factory.mktemp("demo") / "out"
    probe = (
        "import sys; from studio.cli import main; code = main(sys.argv[1:]); "
        "assert not {'PySide6', 'shiboken6', 'pyvistaqt'} & set(sys.modules), 'Qt was loaded'; sys.exit(code)"
    )
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run(
        [sys.executable, "-c", probe, "demo", "--out", str(out), "--json"],
        env={**environment, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=380,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("\n") == 1
    yield out, json.loads(done.stdout), done.stderr


def test_every_scan_has_its_figures_and_faces(ran: tuple[Path, dict[str, Any], str]) -> None:
    out, printed, told = ran
    assert [row["name"] for row in printed["scans"]] == NAMES
    for row in printed["scans"]:
        assert row["fiducial_residual_px"] < 1e-6
        assert row["median_mm"] <= 0.07 and row["faces"] == 16 * len(template_of().faces)
    for name in NAMES:
        for suffix in (".glb", ".obj", ".mtl", "_texture.png"):
            assert (out / "faces" / f"{name}{suffix}").stat().st_size > 0
    assert sorted(printed["faces"]) == sorted(str(path) for path in (out / "faces").iterdir())
    assert "100%" in told and "fitting too" in told


def test_the_project_opens_fresh_with_the_same_figures(ran: tuple[Path, dict[str, Any], str]) -> None:
    _, printed, _ = ran
    project = store.load(Path(printed["project"]))
    assert [item.name for item in project.scans] == NAMES
    assert all(project.state(item.id).kind == "fresh" for item in project.scans)
    assert all(bool(item.held) == (item.name != "base") for item in project.scans)
    for item, row in zip(project.scans, printed["scans"], strict=True):
        fit = project.fit(item.id)
        assert len(fit.mesh.faces) == row["faces"] and int(fit.filled.sum()) == row["filled_vertices"]


def test_report_and_plates_are_there(ran: tuple[Path, dict[str, Any], str]) -> None:
    out, printed, _ = ran
    assert Path(printed["report"]).read_bytes().startswith(b"%PDF-")
    assert sorted(printed["plates"]) == sorted(str(path) for path in (out / "plates").iterdir())
    figures = [f"{stage}figure_{number}" for stage in ("basis_", "") for number in range(1, 5)]
    assert sorted(Path(path).stem for path in printed["plates"]) == ["basis_alpha", *figures]
    assert all(image_size(path)[0] == 1600 for path in printed["plates"])


def test_both_bases_are_there_with_the_figures_that_the_project_gives(ran: tuple[Path, dict[str, Any], str]) -> None:
    out, printed, _ = ran
    assert sorted(printed["basis_files"]) == sorted(str(path) for path in (out / "basis").iterdir())
    assert all(check["passes"] for check in printed["basis_checks"]) and len(printed["basis_checks"]) == 5
    own, other = printed["bases"]
    assert own["hand -1..2"] / own["quasi_eigen -1..2"] > 3.5 and own["median_cosine"] > 0.85 > other["median_cosine"]
    assert "no longer look like themselves" in other["warnings"][0]
    basis = store.load(Path(printed["project"])).basis
    assert len(basis.rigs) == 2 and basis.hand is not None and basis.hand.name.startswith("animator")
    ingredients = Ingredients.of(basis)
    assert ingredients is not None
    again = analyse(ingredients).result.comparison.errors["quasi_eigen"]["-1..2"]
    assert again.alpha_mean == pytest.approx(own["quasi_eigen -1..2"], rel=1e-9)


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="--out"):
        demo.run(tmp_path / "file" / "below")
    with pytest.raises(InputError, match="file"):
        demo.run(tmp_path / "file")
