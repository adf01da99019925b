"""Limits come back from TOML as they were; what is wrong in a file is named."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.limits import LimitsModel, limits_toml, read_limits, write_limits
from engine.scan.limits import REGIONS, Bounds, Limits, RegionLimits

LENGTH = st.floats(0, 500, allow_nan=False)
BOUNDS = st.tuples(LENGTH, LENGTH).map(lambda pair: Bounds(min(pair), max(pair)))
SHARES = st.tuples(st.floats(0, 1), st.floats(0, 1)).map(lambda pair: Bounds(min(pair), max(pair)))
REGION = st.builds(RegionLimits, BOUNDS, BOUNDS, BOUNDS, SHARES.map(lambda b: b))
LIMITS = st.builds(
    lambda m, p, f, t, r: Limits(median_mm=m, p99_mm=p, folded_faces=f, tolerance=t, regions={**REGIONS, **r}),
    LENGTH, LENGTH, st.integers(0, 1000), st.floats(1, 50),
    st.dictionaries(st.from_regex(r"[a-z][a-z0-9_ ]{0,20}", fullmatch=True), REGION, max_size=4),
)  # fmt: skip


@given(LIMITS)
def test_every_limits_come_back_from_their_text(limits: Limits) -> None:
    import tomllib

    assert LimitsModel.model_validate(tomllib.loads(limits_toml(limits))).limits() == limits


def test_what_a_file_leaves_out_is_as_shipped(tmp_path: Path) -> None:
    path = tmp_path / "l.toml"
    path.write_text("[regions.nose]\nmedian_mm = { warn = 0.5, fail = 0.6 }\n")
    found = read_limits(path)
    assert found.region("nose").median_mm == Bounds(0.5, 0.6)
    assert found.region("nose").p95_mm == Limits().region("nose").p95_mm
    assert found.region("lips") == Limits().region("lips") and found.median_mm == Limits().median_mm
    assert read_limits(write_limits(path, found)) == found


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("face = 3", "face"),
        ("[face]\nmedian_mm = -1", "face.median_mm"),
        ("[face]\nmedian = 1", "face.median"),
        ("[face]\ntolerance = 0.5", "face.tolerance"),
        ("[face]\nmedian_mm = nan", "face.median_mm"),
        ("[regions.nose]\nmedian_mm = { warn = 2, fail = 1 }", "fail 1 is below warn 2"),
        ("[regions.nose]\nmedian_mm = { warn = 2 }", "regions.nose.median_mm.fail"),
        ("[regions.Nose]\n", "regions.Nose"),
        ("[regions.nose]\nears_mm = { warn = 1, fail = 2 }", "ears_mm"),
        ("[face\n", "as TOML"),
        ("x = " + "[" * 5000, "as TOML"),
    ],
)
def test_a_wrong_file_is_told_by_its_field(tmp_path: Path, text: str, named: str) -> None:
    path = tmp_path / "l.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_limits(path)
    assert str(path) in str(caught.value) and named in str(caught.value) and "\n" not in str(caught.value)
