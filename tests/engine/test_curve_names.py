"""Curves find their shapes however either is spelled."""

from __future__ import annotations

import pytest

from engine.curve_names import match_curves
from engine.shape_name_tables import ARKIT

SHORT = {"Left": "_L", "Right": "_R"}


def shortened(name: str) -> str:
    for long, short in SHORT.items():
        if name.endswith(long):
            return name.removesuffix(long) + short
    return name


@pytest.mark.parametrize("spell", [str, str.lower, lambda name: name[0].upper() + name[1:], shortened])
def test_all_of_arkit_is_found_in_any_order(spell) -> None:
    shapes = tuple(reversed(ARKIT))
    found = match_curves([spell(name) for name in ARKIT], shapes)
    assert [ARKIT[source[0]] for source in found] == list(shapes)


def test_one_curve_drives_both_halves_and_a_whole_follows_both_curves() -> None:
    assert match_curves(("BrowInnerUp",), ("browInnerUp_L", "browInnerUp_R")) == ((0,), (0,))
    assert match_curves(("browDownLeft", "browDownRight"), ("browDown",)) == ((0, 1),)


def test_a_side_is_never_taken_for_the_other_and_what_has_no_curve_rests() -> None:
    assert match_curves(("eyeBlinkLeft",), ("eyeBlink_R", "eyeBlink_L", "nose")) == ((), (0,), ())
    assert match_curves(("jawLeft", "jawOpen"), ("jawRight", "jaw_left")) == ((), (0,))


def test_its_own_name_counts_more_than_any_other() -> None:
    assert match_curves(("smile_l", "smile_L"), ("smile_L", "smile_l", "SmileLeft")) == ((1,), (0,), (0,))


def test_letters_of_any_script_count_and_numbers_alone_do_not() -> None:
    assert match_curves(("嘴", "眼"), ("嘴", "口", "眼2")) == ((0,), (), ())
    assert match_curves(("Lächeln_L", "Lcheln_L", "Рот"), ("lächelnLeft", "РОТ")) == ((0,), (2,))
    assert match_curves(("!!", "??", "1", "嘴1"), ("##", "01", "口1", "!!")) == ((), (), (), (0,))


def test_halves_and_wholes_without_arkit_names() -> None:
    assert match_curves(("AU12_L", "AU12_R"), ("AU12", "AU1", "AU2")) == ((0, 1), (), ())
    assert match_curves(("sneer", "AU9"), ("sneer_L", "AU9_R", "AU10_R")) == ((0,), (1,), ())
    assert match_curves(("tongueLeft", "tongueRight", "jaw"), ("tongue", "jawLeft")) == ((), ())
