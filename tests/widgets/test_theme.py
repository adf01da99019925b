"""Colours can be read, in both themes, and reach widgets that paint by themselves."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QApplication

import resources
from widgets import theme
from widgets.parts.buttons import IconButton

TEXT_ON = {
    "text": ("window", "panel", "raised", "segment_on", "input", "alternate", "selection"),
    "dim": ("window", "panel", "segment_off", "alternate"),
    "accent_text": ("window", "panel", "alternate"),
    "on_accent": ("accent",),
    "fresh_text": ("panel", "alternate"),
    "stale_text": ("window", "panel", "alternate"),
    "reconstructed_text": ("panel",),
}


@pytest.mark.parametrize("name", ["dark", "light"])
@pytest.mark.parametrize(("ink", "ground"), [(i, g) for i, grounds in TEXT_ON.items() for g in grounds])
def test_text_has_at_least_four_and_a_half_to_one(name: str, ink: str, ground: str) -> None:
    colours = theme.THEMES[name]
    assert theme.contrast(getattr(colours, ink), getattr(colours, ground)) >= 4.5


def test_text_over_the_brightest_picture_can_be_read() -> None:
    palette = theme.overlay()
    plate = QColor(palette.plate)
    mixed = [round(palette.plate_alpha * c + (1 - palette.plate_alpha) * 255) for c in plate.getRgb()[:3]]
    assert theme.contrast(palette.text, "#{:02x}{:02x}{:02x}".format(*mixed)) >= 4.5


@pytest.mark.parametrize(
    ("first", "second", "ratio"),
    [("#000000", "#ffffff", 21.0), ("#777777", "#ffffff", 4.478), ("#123456", "#123456", 1)],
)
def test_contrast_agrees_with_published_values(first: str, second: str, ratio: float) -> None:
    assert theme.contrast(first, second) == pytest.approx(ratio, abs=5e-4)
    assert theme.contrast(second, first) == theme.contrast(first, second)


def test_every_role_is_a_colour_in_both_themes() -> None:
    for colours in theme.THEMES.values():
        for entry in fields(colours):
            value = getattr(colours, entry.name)
            if entry.name not in ("name", "plate_alpha"):
                assert re.fullmatch(r"#[0-9a-f]{6}", value), entry.name


def test_applying_a_theme_reaches_palette_icons_and_those_who_listen(qapp: QApplication, qtbot) -> None:
    button = IconButton("plus", "Add (A)")
    qtbot.addWidget(button)
    before = button.icon().pixmap(16).toImage()
    with qtbot.waitSignal(theme.signals.changed):
        theme.apply(qapp, theme.LIGHT)
    try:
        assert theme.current() is theme.LIGHT
        assert qapp.palette().color(QPalette.ColorRole.Window) == QColor(theme.LIGHT.panel)
        after = button.icon().pixmap(16).toImage()
        assert before != after
        assert _ink(after) == QColor(theme.LIGHT.dim)
    finally:
        theme.apply(qapp, theme.DARK)
    assert _ink(button.icon().pixmap(16).toImage()) == QColor(theme.DARK.dim)


def _ink(image) -> QColor:
    pixels = [image.pixelColor(x, y) for x in range(image.width()) for y in range(image.height())]
    return QColor(max(pixels, key=lambda c: c.alpha()).rgb())


ICONS = sorted(path.stem for path in Path(resources.icon_path("")).glob("*.svg"))


@pytest.mark.parametrize("name", ICONS)
def test_every_icon_draws_something(qapp: QApplication, name: str) -> None:
    image = theme.icon(name, "text").pixmap(16).toImage()
    inked = sum(image.pixelColor(x, y).alpha() > 128 for x in range(16) for y in range(16))
    assert 3 <= inked <= 200


def test_figures_have_one_width(qapp: QApplication) -> None:
    from PySide6.QtGui import QFontMetricsF

    metrics = QFontMetricsF(theme.font(theme.TABLE_PX))
    assert len({round(metrics.horizontalAdvance(digit), 3) for digit in "0123456789"}) == 1
