"""The colours by role, dark and light, and how they reach Qt: Fusion, a palette, a small style sheet, pixel fonts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from PySide6.QtCore import QByteArray, QObject, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QFontInfo, QIcon, QPainter, QPalette, QPixmap
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QApplication

import resources
from widgets import text_scale
from widgets.style_sheet import style_sheet
from widgets.text_scale import fix, fix_icon, px

CONTROL_PX, TABLE_PX, AXIS_PX, NAME_PX = 12, 11, 10, 14
__all__ = ["DARK", "LIGHT", "Theme", "apply", "current", "fix", "fix_icon", "font", "icon", "overlay", "px", "signals"]


@dataclass(frozen=True)
class Theme:
    """One set of colour roles, each ``#rrggbb``; overlays over pictures are the same in both themes.

    ``name`` is ``dark`` or ``light``. Roles ending in ``_text`` are for letters.
    """

    name: str
    window: str
    panel: str
    raised: str
    segment_on: str
    segment_off: str
    input: str
    line: str
    text: str
    dim: str
    alternate: str
    selection: str
    accent: str
    on_accent: str
    accent_text: str
    view_top: str
    view_bottom: str
    plate: str
    plate_alpha: float
    timeline: str
    captured: str
    reconstructed: str
    reconstructed_text: str
    left: str
    right: str
    middle: str
    fresh: str
    fresh_text: str
    stale: str
    stale_text: str
    missing: str
    canvas_top: str = "#4a4d52"
    canvas_bottom: str = "#37393d"

    @property
    def is_dark(self) -> bool:
        """Whether letters are lighter than what they stand on."""
        return self.name == "dark"

    def colour(self, role: str, alpha: float = 1.0) -> QColor:
        """Return a role as a colour, ``alpha`` 0..1."""
        colour = QColor(str(getattr(self, role)))
        colour.setAlphaF(alpha)
        return colour

    def side(self, side: str) -> QColor:
        """Return the colour of the subject's ``left``, ``right`` or ``middle``."""
        return self.colour({"left": "left", "right": "right"}.get(str(side), "middle"))


DARK = Theme(
    name="dark", window="#1e1f22", panel="#26282b", raised="#303338", segment_on="#3a3d42", segment_off="#1e1f22",
    input="#1e1f22", line="#3a3d42", text="#d7dae0", dim="#979da7", alternate="#292b2f", selection="#3d342a",
    accent="#e8912d", on_accent="#1e1f22", accent_text="#f0a24a", view_top="#212327", view_bottom="#191a1d",
    plate="#191a1d", plate_alpha=0.80, timeline="#17181a", captured="#e5484d", reconstructed="#3b82f6",
    reconstructed_text="#6ba3fa", left="#2fb8a6", right="#9b7cf2", middle="#f0f2f5", fresh="#4fb477",
    fresh_text="#5cc084", stale="#e0a823", stale_text="#e0a823", missing="#6b717a",
)  # fmt: skip

LIGHT = Theme(
    name="light", window="#dcdee2", panel="#eff0f2", raised="#ffffff", segment_on="#ffffff", segment_off="#dfe1e5",
    input="#ffffff", line="#c3c7cd", text="#212429", dim="#5a616b", alternate="#e9eaed", selection="#f8e2c6",
    accent="#e8912d", on_accent="#1e1f22", accent_text="#8f4d06", view_top="#d8dade", view_bottom="#c9ccd1",
    plate="#eff0f2", plate_alpha=0.84, timeline="#dfe1e5", captured="#d13438", reconstructed="#2563eb",
    reconstructed_text="#1d4fc4", left="#0f8f80", right="#6f4fd8", middle="#212429", fresh="#2c8a53",
    fresh_text="#1a6a3b", stale="#b98207", stale_text="#7d5600", missing="#8a9099",
)  # fmt: skip

THEMES = {theme.name: theme for theme in (DARK, LIGHT)}


class _Signals(QObject):
    changed = Signal()


signals = _Signals()
_state = {"theme": DARK}


def current() -> Theme:
    """Return the theme in use."""
    return _state["theme"]


def overlay() -> Theme:
    """Return the theme of everything drawn over pictures: the dark one, whatever the window wears."""
    return DARK


def apply(app: QApplication, theme: Theme, scale: float | None = None) -> None:
    """Dress the application in ``theme`` and tell every widget that paints by itself (``signals.changed``).

    ``scale`` is the text scale, 0.8..2, of everything that is read; left out, it stays.
    """
    _state["theme"] = theme
    if scale is not None:
        text_scale.set_factor(scale)
    if app.style().objectName().lower() != "fusion":
        app.setStyle("Fusion")
    app.setFont(font())
    app.setPalette(palette(theme))
    sheet = style_sheet(theme, str(resources.icon_path("")).replace("\\", "/"))
    app.setStyleSheet(text_scale.scaled_sheet(sheet))
    text_scale.refit()
    signals.changed.emit()


def palette(theme: Theme) -> QPalette:
    """Return the Qt palette of a theme."""
    result = QPalette()
    roles = {
        QPalette.ColorRole.Window: theme.panel,
        QPalette.ColorRole.Base: theme.input,
        QPalette.ColorRole.AlternateBase: theme.alternate,
        QPalette.ColorRole.Button: theme.raised,
        QPalette.ColorRole.Mid: theme.line,
        QPalette.ColorRole.Midlight: theme.line,
        QPalette.ColorRole.Light: theme.line,
        QPalette.ColorRole.Dark: theme.window,
        QPalette.ColorRole.Shadow: theme.window,
        QPalette.ColorRole.Highlight: theme.selection,
        QPalette.ColorRole.HighlightedText: theme.text,
        QPalette.ColorRole.PlaceholderText: theme.dim,
        QPalette.ColorRole.Link: theme.accent_text,
        QPalette.ColorRole.LinkVisited: theme.accent_text,
        QPalette.ColorRole.Accent: theme.accent,
        QPalette.ColorRole.WindowText: theme.text,
        QPalette.ColorRole.Text: theme.text,
        QPalette.ColorRole.ButtonText: theme.text,
        QPalette.ColorRole.BrightText: theme.text,
        QPalette.ColorRole.ToolTipBase: theme.raised,
        QPalette.ColorRole.ToolTipText: theme.text,
    }
    for role, colour in roles.items():
        result.setColor(role, QColor(colour))
    for role in (QPalette.ColorRole.WindowText, QPalette.ColorRole.Text, QPalette.ColorRole.ButtonText):
        result.setColor(QPalette.ColorGroup.Disabled, role, QColor(theme.missing))
    return result


@lru_cache(maxsize=1)
def _family() -> str:
    if "Inter" in QFontDatabase.families():
        return "Inter"
    return QFontInfo(QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)).family()


def font(pixels: int = CONTROL_PX, *, bold: bool = False) -> QFont:
    """Return the interface font, ``pixels`` high at 100 %, with figures of one width; ``bold`` means weight 600."""
    result = QFont(_family())
    result.setPixelSize(px(pixels))
    result.setWeight(QFont.Weight.DemiBold if bold else QFont.Weight.Normal)
    result.setFeature(QFont.Tag("tnum"), 1)
    return result


def icon(name: str, role: str = "text", size: int = 16) -> QIcon:
    """Return a line icon tinted with a colour role of the current theme.

    Parameters
    ----------
    name : str
        One of our own (``resources/icons/<name>.svg``), or a name with a dot, which qtawesome knows.
    role : str
        Colour role; disabled icons take ``missing``.
    size : int
        Edge in pixels of 100 %: 16, 14 in title bars.
    """
    theme = current()
    if "." in name:
        import qtawesome

        return QIcon(qtawesome.icon(name, color=getattr(theme, role), color_disabled=theme.missing))
    return tinted(name, str(getattr(theme, role)), theme.missing, px(size))


@lru_cache(maxsize=512)
def tinted(name: str, colour: str, disabled: str, size: int) -> QIcon:
    """Return our icon ``name`` in two colours (``#rrggbb``), ``size`` pixels, sharp at scales 1, 1.5, 2 and 3."""
    source = resources.icon_path(f"{name}.svg").read_text(encoding="utf-8")
    result = QIcon()
    for mode, tint in ((QIcon.Mode.Normal, colour), (QIcon.Mode.Disabled, disabled)):
        renderer = QSvgRenderer(QByteArray(source.replace("currentColor", tint).encode()))
        for scale in (1, 1.5, 2, 3):
            edge = round(size * scale)
            pixmap = QPixmap(edge, edge)
            pixmap.fill(Qt.GlobalColor.transparent)
            painter = QPainter(pixmap)
            renderer.render(painter, QRectF(0, 0, edge, edge))
            painter.end()
            pixmap.setDevicePixelRatio(scale)
            result.addPixmap(pixmap, mode)
    return result


def contrast(first: str, second: str) -> float:
    """Return the contrast ratio 1..21 of two colours (``#rrggbb``), WCAG 2 relative luminance."""
    lighter, darker = sorted((_luminance(first), _luminance(second)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def _luminance(colour: str) -> float:
    channels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
