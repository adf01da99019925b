"""The shapes of the hand-made rig: found, renamed, reordered, mirrored, split, combined, mapped."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget

from widgets.basis.shapes_table import ShapeRow

EDITS = ("mirror", "split", "combine", "duplicate", "remove")
"""What ``edit_requested`` may ask for."""
MAPPINGS = ("arkit", "facs")
"""What ``mapping_requested`` may ask for."""


class ShapesPanel(QWidget):
    """Find field, table and tools.

    Signals
    -------
    selected(str)
        The shape that is looked at.
    selection_changed(object)
        Tuple of the names of all shapes that are marked, in the order of the table.
    rename_requested(str, str)
        Name, and the new one.
    reorder_requested(object)
        Tuple of all names in the order wanted.
    edit_requested(str, object)
        One of ``EDITS``, and the tuple of the names of the shapes meant.
    mapping_requested(str)
        One of ``MAPPINGS``.
    add_requested()
        A rig is to be opened from a file.
    """

    selected = Signal(str)
    selection_changed = Signal(object)
    rename_requested = Signal(str, str)
    reorder_requested = Signal(object)
    edit_requested = Signal(str, object)
    mapping_requested = Signal(str)
    add_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows: tuple[ShapeRow, ...] = ()
        self._current: str | None = None
        self._reasons: dict[str, str] = {}

    @property
    def rows(self) -> tuple[ShapeRow, ...]:
        """What is listed."""
        return self._rows

    @property
    def current(self) -> str | None:
        """Name of the shape that is looked at."""
        return self._current

    @property
    def note(self) -> str:
        """What stands beside the dock's name: how many there are."""
        return str(len(self._rows)) if self._rows else ""

    @property
    def selection(self) -> tuple[str, ...]:
        """Names of all shapes that are marked, in the order of the table."""
        return ()

    def set_shapes(self, rows: Sequence[ShapeRow]) -> None:
        """List shapes; marks stay where their shapes are still there."""
        self._rows = tuple(rows)

    def set_cosine_limit(self, limit: float) -> None:
        """Warn at shapes whose cosine to their hand shape lies below ``limit``."""

    def set_current(self, name: str | None) -> None:
        """Mark the shape that is looked at without telling anybody."""
        self._current = name

    def set_edit_available(self, kind: str, available: bool, reason: str = "") -> None:
        """Allow an edit, or say why not."""
        self._reasons[kind] = "" if available else reason

    def edit_name(self, name: str) -> None:
        """Let the user type another name for a shape."""

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(232, 420)
