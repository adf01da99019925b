"""Schemes as TOML: what is written is read again, and what is wrong is named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import resources
from engine.errors import InputError
from engine.files.scheme import read_scheme, write_scheme
from engine.landmarks import LandmarkDefinition, LandmarkScheme, Side
from tests.engine.schemes import quick, shipped, thorough

texts = st.text(st.sampled_from("aB \"\\'#=[]{}äß漢字😀\u0301"), max_size=40)
groups = texts.map(lambda text: f"g{text}"[:40])
names = st.from_regex(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,20}", fullmatch=True)


@st.composite
def schemes(draw: st.DrawFn) -> LandmarkScheme:
    chosen = draw(st.lists(names, min_size=4, max_size=12, unique=True))
    vertices = draw(st.lists(st.integers(0, 440), min_size=len(chosen), max_size=len(chosen), unique=True))
    pairs = draw(st.integers(0, len(chosen) // 2))
    marks = []
    for k, (name, vertex) in enumerate(zip(chosen, vertices, strict=True)):
        side, mirror = Side.MIDDLE, draw(st.sampled_from([name, ""]))
        if k < 2 * pairs:
            side, mirror = (Side.LEFT, chosen[k + 1]) if k % 2 == 0 else (Side.RIGHT, chosen[k - 1])
        group, hint = draw(texts.filter(lambda text: len(text.strip()) > 0 and len(text) <= 40)), draw(texts)
        marks.append(LandmarkDefinition(name, group, side, mirror, hint, draw(st.sampled_from([vertex, None]))))
    return LandmarkScheme(f"{draw(names)}_x", draw(texts), tuple(marks), draw(st.sampled_from(["closed", "open"])))


@settings(deadline=None, max_examples=40)
@given(scheme=schemes())
def test_what_is_written_is_read_again(tmp_path_factory: pytest.TempPathFactory, scheme: LandmarkScheme) -> None:
    path = tmp_path_factory.getbasetemp() / "own.toml"
    write_scheme(path, scheme)
    assert read_scheme(path) == scheme


@pytest.mark.parametrize("scheme", [shipped("closed"), shipped("open"), quick(), thorough()], ids=lambda s: s.name)
def test_real_schemes_go_round(tmp_path: Path, scheme: LandmarkScheme) -> None:
    write_scheme(tmp_path / "own.toml", scheme)
    assert read_scheme(tmp_path / "own.toml") == scheme


def test_the_layout_may_be_left_out_where_the_name_tells_it(tmp_path: Path) -> None:
    text = resources.scheme_path("open").read_text().replace('layout = "open"\n', "")
    (tmp_path / "old.toml").write_text(text)
    assert read_scheme(tmp_path / "old.toml").layout == "open"


def _without(line: str) -> Callable[[str], str]:
    return lambda text: text.replace(line, "", 1)


def _instead(old: str, new: str) -> Callable[[str], str]:
    return lambda text: text.replace(old, new, 1)


SPOILT: dict[str, tuple[Callable[[str], str], str]] = {
    "no TOML": (lambda text: text[:200] + "=", "cannot be read as TOML"),
    "deep": (lambda text: "a = " + "[" * 100_000, "cannot be read as TOML"),
    "name missing": (_without('name = "eye_left_outer"\n'), r"landmark\.0\.name"),
    "unknown field": (_instead("group =", "grupe ="), r"landmark\.0"),
    "side": (_instead('side = "left"', 'side = "up"'), r"landmark\.0\.side"),
    "layout": (_instead('layout = "closed"', 'layout = "ajar"'), "layout"),
    "vertex is text": (_instead("vertex = 78", 'vertex = "78"'), r"landmark\.0\.vertex"),
    "vertex is negative": (_instead("vertex = 78", "vertex = -78"), r"landmark\.0\.vertex"),
    "vertex is enormous": (_instead("vertex = 78", "vertex = 99999999999999999999"), r"landmark\.0\.vertex"),
    "vertex is half": (_instead("vertex = 78", "vertex = 7.5"), r"landmark\.0\.vertex"),
    "vertex used twice": (_instead("vertex = 78", "vertex = 70"), "eye_left_inner: vertex 70 carries eye_left_outer"),
    "two of a name": (_instead('name = "eye_left_inner"', 'name = "eye_left_outer"'), "eye_left_outer.*occurs twice"),
    "mirror does not point back": (
        _instead('mirror = "eye_right_outer"', 'mirror = "eye_right_inner"'),
        "eye_left_outer: its mirror 'eye_right_inner' does not point back",
    ),
    "mirror on the same side": (_instead('side = "left"', 'side = "right"'), "eye_left_outer: lies on the same side"),
    "own mirror off the middle": (_instead('side = "middle"', 'side = "left"'), "nose_tip: is its own mirror"),
    "name of signs": (_instead('name = "chin"', 'name = "the/chin"'), "the/chin: the name has other signs"),
    "name ends in a line": (_instead('name = "chin"', 'name = "chin\\n"'), r"chin.*other signs"),
    "scheme without name": (_instead('name = "quick"', 'name = ""'), "name: is empty"),
    "two lines": (_instead('title = "', 'title = "one\\ntwo'), "title.*more than one line"),
    "too few": (lambda text: text[: text.index("[[", text.index("[[") + 2)], "1 fiducials are too few"),
}


@pytest.mark.parametrize("kind", SPOILT)
def test_what_is_wrong_is_named(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "own.toml"
    write_scheme(path, quick())
    spoil, words = SPOILT[kind]
    before = path.read_text()
    path.write_text(spoil(before))
    assert path.read_text() != before
    with pytest.raises(InputError, match=words) as caught:
        read_scheme(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_a_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_scheme(tmp_path / "no" / "own.toml", quick())
