"""One face has one verdict, whichever command judges it; what is placed before a mesh is told, whatever was chosen."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from engine.files.limits import write_limits
from engine.scan.limits import Bounds, Limits, RegionLimits
from studio.cli import main

TIGHT = Limits().with_region("nose", RegionLimits(Bounds(0.0, 0.0)))
NOT_JUDGED = {"skipped_fiducials", "unit", "assumed", "files", "name", "state", "seconds"}


def told(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[dict[str, Any], str]:
    assert main([str(word) for word in words]) == 0
    seen = capsys.readouterr()
    return json.loads(seen.out), seen.err


@pytest.mark.parametrize("limits", [None, TIGHT])
def test_fit_and_batch_agree_on_every_figure(
    folder: Path, capsys: pytest.CaptureFixture[str], limits: Limits | None
) -> None:
    more = [] if limits is None else ["--limits", write_limits(folder / "l.toml", limits)]
    words = ["scan", "fit", "base.npz", "--fiducials", "f.json", "--out", "a.glb", "--levels", 1, *more]
    one = told(capsys, *words, "--json")[0]
    item = '[[item]]\nscan = "base.npz"\nfiducials = "f.json"\nout = "b.glb"\n'
    (folder / "jobs.toml").write_text('stage = "scan"\n[options]\nlevels = 1\n' + item)
    many = told(capsys, "batch", "jobs.toml", "--json", *more)[0]["items"][0]
    assert {k: v for k, v in one.items() if k not in NOT_JUDGED} == {
        k: v for k, v in many.items() if k not in NOT_JUDGED
    }
    assert len(one["regions"]) > 5 and (one["worst_region"] == "nose") == (limits is not None)
    assert limits is None or one["verdict"] == "fail"
    assert main([str(word) for word in words]) == 0
    assert "worst_region" in (shown := capsys.readouterr().out) and "regions" not in shown


def test_limits_are_read_before_anything_is_fitted_and_never_replaced(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["scan", "fit", "base.npz", "--fiducials", "f.json"]
    (folder / "l.toml").write_text("[face]\nmedian_mm = -1\n")
    assert main([*words, "--out", "a.glb", "--limits", "l.toml"]) == 2
    assert "median_mm" in capsys.readouterr().err and not (folder / "a.glb").exists()
    write_limits(folder / "l.toml", TIGHT).rename(folder / "l.glb")
    before = (folder / "l.glb").read_bytes()
    assert main([*words, "--out", "l.glb", "--limits", "l.glb"]) == 2
    assert (folder / "l.glb").read_bytes() == before


def test_what_was_placed_automatically_is_told_beside_what_was_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = [f"v {x} {y} {(x * x + y * y) / -200}" for y in range(-50, 60, 10) for x in range(-50, 60, 10)]
    for row in range(10):
        for column in range(1, 11):
            a = 11 * row + column
            lines += [f"f {a} {a + 1} {a + 12}", f"f {a} {a + 12} {a + 11}"]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    words = ["scan", "info", tmp_path / "a.obj", "--unit", "mm", "--json"]
    alone = told(capsys, *words)[1]
    reason = next(line for line in alone.splitlines() if "confidence" in line)
    asked = told(capsys, *words, "--distance-mm", 900)
    assert f"{reason}; distance mm as asked" in asked[1] and asked[0]["view"]["distance_mm"] == 900
    whole = ["--turn", 0, "--tilt", 0, "--roll", 0, "--look-at", 0, 0, 0, "--distance-mm", 900, "--fov", 20]
    assert "confidence" not in told(capsys, *words, *whole)[1], "nothing was placed"
