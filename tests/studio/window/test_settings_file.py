"""The settings file: limits, the signal, and what happens to a file that cannot be read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from studio.settings import SETTINGS, VERSION, Settings, declared

NUMBERS = [setting for setting in SETTINGS if setting.type in (int, float) and setting.maximum is not None]


@pytest.mark.parametrize("setting", NUMBERS, ids=lambda setting: setting.key)
def test_a_number_beyond_its_limits_is_refused_and_read_as_the_default(setting: Any, tmp_path: Path) -> None:
    kept = Settings(tmp_path / "s.ini")
    for value in (setting.minimum - 1, setting.maximum + 1, float("nan")):
        with pytest.raises(ValueError, match=setting.key):
            kept[setting.key] = value
    section, name = setting.key.split("/")
    (tmp_path / "t.ini").write_text(f"[{section}]\n{name}={setting.maximum + 1}\n")
    assert Settings(tmp_path / "t.ini")[setting.key] == setting.default
    kept[setting.key] = setting.type(setting.maximum)
    assert kept[setting.key] == setting.maximum


def test_a_choice_that_is_none_of_them_reads_as_the_default(tmp_path: Path) -> None:
    (tmp_path / "s.ini").write_text("[look]\ntheme=pink\n")
    kept = Settings(tmp_path / "s.ini")
    assert kept["look/theme"] == declared("look/theme").default
    with pytest.raises(ValueError, match="pink"):
        kept["look/theme"] = "pink"


def test_a_switch_that_is_off_is_off_in_the_next_session(tmp_path: Path) -> None:
    key = next(setting.key for setting in SETTINGS if setting.type is bool and setting.default)
    first = Settings(tmp_path / "s.ini")
    first[key] = False
    first.save()
    assert Settings(tmp_path / "s.ini")[key] is False


def test_changed_tells_the_key_once_and_only_when_the_value_is_another(tmp_path: Path) -> None:
    kept, told = Settings(tmp_path / "s.ini"), []
    kept.changed.connect(told.append)
    kept["look/theme"] = "light"
    kept["look/theme"] = "light"
    kept.remove("look/theme")
    kept.remove("look/theme")
    assert told == ["look/theme", "look/theme"]


def test_the_ends_of_a_range_do_not_pass_each_other(tmp_path: Path) -> None:
    kept = Settings(tmp_path / "s.ini")
    assert "below Heatmap to" in kept.conflict("view/low", kept["view/high"])
    assert "above Heatmap from" in kept.conflict("view/high", kept["view/low"])
    assert not kept.conflict("view/low", kept["view/high"] / 2)


def test_every_setting_that_is_shown_can_be_shown_and_its_default_is_allowed() -> None:
    assert len({setting.key for setting in SETTINGS}) == len(SETTINGS)
    for setting in SETTINGS:
        assert setting.text.endswith(".") and setting.allows(setting.default)
        assert isinstance(setting.default, setting.type)
        assert not setting.labels or len(setting.labels) == len(setting.choices)
        if setting.section:
            assert setting.title and setting.type in (bool, int, float, str)
            assert not setting.below or declared(setting.below)


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"\xff\xfe\x00[look]", "damaged"),
        (b"[look]\ntheme=light\nwhat is this\n", "damaged"),
        (b"[look]\ntheme=li\x00ght\n", "damaged"),
        (f"[file]\nversion={VERSION + 1}\n[look]\ntheme=light\n".encode(), "another version"),
        (b"[file]\nversion=new\n", "another version"),
        (b"a=" + b"x" * 5_000_000, "larger"),
    ],
)
def test_a_file_that_cannot_be_read_is_put_aside_whole_and_told_once(content: bytes, word: str, tmp_path: Path) -> None:
    path = tmp_path / "s.ini"
    path.write_bytes(content)
    kept = Settings(path)
    assert word in kept.notice and "s.ini.bak" in kept.notice
    assert (tmp_path / "s.ini.bak").read_bytes() == content
    assert all(kept[setting.key] == setting.default for setting in SETTINGS)
    kept["look/theme"] = "light"
    kept.save()
    again = Settings(path)
    assert not again.notice and again["look/theme"] == "light"


def test_a_file_without_a_version_is_read(tmp_path: Path) -> None:
    (tmp_path / "s.ini").write_text("[look]\ntheme=light\n")
    kept = Settings(tmp_path / "s.ini")
    assert not kept.notice and kept["look/theme"] == "light"


@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=st.binary(max_size=300) | st.text(max_size=200).map(lambda text: text.encode("utf-8", "replace")))
def test_whatever_a_file_holds_every_value_is_allowed(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "s.ini"
    path.write_bytes(content)
    kept = Settings(path)
    for setting in SETTINGS:
        value = kept[setting.key]
        assert isinstance(value, setting.type) and setting.allows(value)
