"""Names of shapes: every usual spelling of all 52, halves, aliases, action units, sides."""

from __future__ import annotations

import pytest

from engine.shape_name_tables import ACTION_UNITS, ARKIT
from engine.shape_names import action_unit, arkit_mapping, facs_mapping, partner, side, words


def base(name: str) -> str:
    return name.removesuffix("Left").removesuffix("Right")


def letter(name: str) -> str:
    return {"Left": "L", "Right": "R"}.get(name[len(base(name)) :], "")


SPELLINGS = {
    "as it is": lambda n: n,
    "capital": lambda n: n[0].upper() + n[1:],
    "letter": lambda n: base(n) + (f"_{letter(n)}" if letter(n) else ""),
    "capital and letter": lambda n: base(n)[0].upper() + base(n)[1:] + (f"_{letter(n)}" if letter(n) else ""),
    "letter in front": lambda n: (f"{letter(n)}_" if letter(n) else "") + "_".join(words(base(n))),
    "dots": lambda n: base(n) + (f".{letter(n)}" if letter(n) else ""),
    "lower case": lambda n: n.lower(),
    "upper words": lambda n: "_".join(words(n)).upper(),
    "spaces": lambda n: " ".join(words(n)),
    "side in front": lambda n: " ".join([*words(n[len(base(n)) :]), *words(base(n))]).title(),
    "node": lambda n: f"blendShape1.{n}",
    "prefix": lambda n: f"head_v2_{n}",
}


@pytest.mark.parametrize("spelling", sorted(SPELLINGS))
def test_all_52_are_known_in_every_spelling(spelling: str) -> None:
    spell = SPELLINGS[spelling]
    names = [spell(name) for name in ARKIT]
    found = arkit_mapping(names)
    assert len(ARKIT) == len(set(ARKIT)) == len(set(names)) == 52
    assert dict(found.found) == {name: (spell(name),) for name in ARKIT}
    assert (found.missing, dict(found.double), found.unknown) == ((), {}, ())
    assert dict(found.names) == {spell(name): name for name in ARKIT}


def test_what_is_missing_twice_in_halves_or_unknown() -> None:
    names = ("eyeBlink_L", "EyeBlinkLeft", "browInnerUp_L", "browInnerUp_R", "earWiggle", "jawOpen", "smile")
    found = arkit_mapping(names)
    assert found.found["browInnerUp"] == ("browInnerUp_L", "browInnerUp_R")
    assert dict(found.double) == {"eyeBlinkLeft": ("eyeBlink_L", "EyeBlinkLeft")}
    assert found.unknown == ("earWiggle",)
    assert found.found["mouthSmileLeft"] == found.found["mouthSmileRight"] == ("smile",)
    assert set(found.missing) == set(ARKIT) - {
        "eyeBlinkLeft", "browInnerUp", "jawOpen", "mouthSmileLeft", "mouthSmileRight",
    }  # fmt: skip
    assert dict(found.names) == {
        "browInnerUp_L": "browInnerUp_L",
        "browInnerUp_R": "browInnerUp_R",
        "jawOpen": "jawOpen",
    }
    assert arkit_mapping(("cheekPuff", "cheekPuff_L")).double == {"cheekPuff": ("cheekPuff", "cheekPuff_L")}


def test_the_real_name_wins_over_another_word_for_it() -> None:
    found = arkit_mapping(("cheekRaiser_L", "cheekSquint_L", "JawDrop", "lips funnel"))
    assert found.found["cheekSquintLeft"] == ("cheekSquint_L",) and found.unknown == ("cheekRaiser_L",)
    assert found.found["jawOpen"] == ("JawDrop",) and found.found["mouthFunnel"] == ("lips funnel",)


def test_action_units_by_number_by_name_and_by_what_they_show() -> None:
    found = facs_mapping(("AU01", "au_12_L", "AU12_R", "head_AU4", "Chin Raiser", "jawOpen", "mouthRollLower", "AU99"))
    assert dict(found.found) == {
        "AU1": ("AU01",), "AU4": ("head_AU4",), "AU12": ("au_12_L", "AU12_R"), "AU17": ("Chin Raiser",),
        "AU26": ("jawOpen",), "AU28": ("mouthRollLower",),
    }  # fmt: skip
    assert found.unknown == ("AU99",) and not found.double
    assert found.names["au_12_L"] == "AU12_L" and found.names["jawOpen"] == "AU26"
    arkit = facs_mapping(ARKIT)
    assert set(arkit.missing) == {"AU11", "AU13", "AU23", "AU25", "AU27"}
    assert arkit.found["AU61"] == ("eyeLookInRight", "eyeLookOutLeft")
    assert arkit.names["mouthSmileLeft"] == "AU12_L"
    assert facs_mapping(("AU12", "AU12_L")).double == {"AU12": ("AU12", "AU12_L")}


def test_the_tables_are_whole() -> None:
    shown = {shape for unit in ACTION_UNITS for shape in unit.arkit}
    assert shown <= set(ARKIT)
    assert set(ARKIT) - shown == {"mouthClose", "mouthLeft", "mouthRight", "mouthShrugUpper"}
    assert len({unit.number for unit in ACTION_UNITS}) == len(ACTION_UNITS)
    assert action_unit("AU12").name == "Lip corner puller" and action_unit("AU99") is None


@pytest.mark.parametrize(
    ("name", "other", "where"),
    [
        ("eyeBlinkLeft", "eyeBlinkRight", "L"),
        ("eyeBlink_R", "eyeBlink_L", "R"),
        ("L_eye_blink", "R_eye_blink", "L"),
        ("smile.l", "smile.r", "L"),
        ("LEFT_SMILE", "RIGHT_SMILE", "L"),
        ("BrowLft", "BrowRgt", "L"),
        ("eyeLookLeft_R", "eyeLookLeft_L", "R"),
        ("jawOpen", None, ""),
        ("bright", None, ""),
        ("lower", None, ""),
    ],
)
def test_the_other_side_is_spelled_alike(name: str, other: str | None, where: str) -> None:
    assert (partner(name), side(name)) == (other, where)
    if other is not None:
        assert partner(other) == name
