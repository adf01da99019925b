"""How bases, bounds and numbers are called and coloured in every panel of the stage."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPen

from widgets import theme

BASES = {"hand": "hand", "quasi_eigen": "quasi-eigen", "pca": "PCA"}
"""Key of a basis -> what is read."""
BOUNDS = {"0..1": "0 to 1", "-1..2": "−1 to 2", "free": "free"}
"""Key of the bounds of weights -> what is read."""
ROLES = {"hand": "text", "quasi_eigen": "reconstructed_text", "pca": "dim"}
"""Key of a basis -> colour role."""
DASH = "–"


def colour_of(basis: str) -> QColor:
    """Return the colour that a basis has in every plot and table."""
    return theme.current().colour(ROLES.get(basis, "dim"))


def pen_of(basis: str, width: float = 1.0) -> QPen:
    """Return the pen of a basis' curves; the reference, PCA, is dashed."""
    pen = QPen(colour_of(basis), width)
    if basis == "pca":
        pen.setStyle(Qt.PenStyle.CustomDashLine)
        pen.setDashPattern([3.0, 2.0])
    return pen


def count(value: int) -> str:
    """Return a whole number in groups of three."""
    return f"{value:,}".replace(",", "\u00a0")


def judged(value: float | None, limit: float, at_least: bool = True) -> str:
    """Return a number with two digits, with more where it would be rounded onto the limit that it misses."""
    misses = value is not None and (value < limit if at_least else value > limit)
    digits = next((d for d in (2, 3, 4) if figure(value, d) != figure(limit, d)), 5) if misses else 2
    return figure(value, digits)


def figure(value: float | None, digits: int = 2) -> str:
    """Return a number, or a dash for what is not known or not finite."""
    if value is None or value != value or value in (float("inf"), float("-inf")):
        return DASH
    return f"{value:.{digits}f}".replace("-", "−") if abs(value) < 1e6 else f"{value:.2e}".replace("-", "−")
