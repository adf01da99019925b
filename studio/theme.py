"""Which theme the window wears, remembered between sessions."""

from __future__ import annotations

from PySide6.QtWidgets import QApplication

from studio.settings import Settings
from widgets import theme


def wear(app: QApplication, settings: Settings, name: str | None = None) -> theme.Theme:
    """Dress the application in the theme ``name`` (``dark`` or ``light``; the remembered one) at its text scale."""
    chosen = theme.THEMES.get(name or settings["look/theme"], theme.DARK)
    settings["look/theme"] = chosen.name
    theme.apply(app, chosen, settings["look/text_scale"] / 100)
    return chosen
