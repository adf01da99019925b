"""Offers the work of sessions that ended without saying so, at the start."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from engine.errors import InputError
from studio.recovery_keeper import RecoveryKeeper
from studio.tasks import describe
from studio.waiting import waiting
from widgets import theme
from widgets.window.lost_sessions import HEIGHT, WIDTH, LostRow, LostSessionsPanel

if TYPE_CHECKING:
    from studio.main_window import MainWindow
    from studio.project.lost import LostSession


class RestoreDialog(QDialog):
    """The panel over what a keeper finds: every row is restored, kept or discarded.

    Parameters
    ----------
    keeper : RecoveryKeeper
        Restores and discards.
    lost : list of LostSession
        What there is, the newest first.
    may_replace : callable
        Asks about unsaved steps of the project that is open; False keeps it.
    restored : callable
        Is told what could not be found again, after one was restored.
    """

    def __init__(
        self,
        keeper: RecoveryKeeper,
        lost: list[LostSession],
        may_replace: Callable[[], bool],
        restored: Callable[[tuple[str, ...]], None],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("restore")
        self.setWindowTitle("Restore unsaved work")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self._keeper, self._lost = keeper, list(lost)
        self._may_replace, self._restored = may_replace, restored
        self.panel = LostSessionsPanel(self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        self.panel.restore_requested.connect(self._restore)
        self.panel.discard_requested.connect(self._discard)
        self.panel.later_requested.connect(self.reject)
        self._show()
        room = self.screen().availableSize()
        height = HEIGHT if len(lost) > 2 else HEIGHT - 100 * (3 - len(lost))
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(height), room.height() - 80))
        self.panel.list.setFocus()

    def _show(self) -> None:
        now = time.time()
        self.panel.show_rows([row_of(lost, now) for lost in self._lost])

    def _restore(self, index: int) -> None:
        if not self._may_replace():
            return
        try:
            with waiting():
                missing = self._keeper.restore(self._lost[index].files)
        except (InputError, OSError) as error:
            self.panel.tell(describe(error))
            return
        self.accept()
        self._restored(missing)

    def _discard(self, index: int) -> None:
        self._keeper.discard(self._lost.pop(index).files)
        if self._lost:
            self._show()
        else:
            self.reject()


def row_of(lost: LostSession, now: float) -> LostRow:
    """Return a session as it is listed; ``now`` is the time, seconds since 1970."""
    return LostRow(
        lost.name,
        "never saved to a file" if lost.path is None else str(lost.path.parent),
        f"Last step {ago(now - lost.time)}, {clock(lost.time, now)}",
        _held(lost) + _count(lost.steps, "step") + (" since it was saved" if lost.path is not None else ""),
        lost.picture,
        lost.damage,
        not lost.damage or lost.scans + lost.rigs + lost.motions > 0,
    )


def _held(lost: LostSession) -> str:
    """Return what a session holds, in words that end with a comma."""
    parts = []
    if lost.scans or not (lost.rigs or lost.motions):
        parts += [_count(lost.scans, "scan"), f"{_count(lost.placed, 'fiducial')} placed"]
    if lost.rigs or lost.motions:
        parts += [_count(lost.rigs, "rig"), _count(lost.motions, "performance")]
    return "".join(f"{part}, " for part in parts)


def ago(seconds: float) -> str:
    """Return a span of time in the words that people use."""
    for length, name in ((86400.0, "day"), (3600.0, "hour"), (60.0, "minute")):
        if seconds >= length:
            return f"{_count(int(seconds // length), name)} ago"
    return "less than a minute ago"


def clock(moment: float, now: float) -> str:
    """Return the time of day, with the date where that is another day."""
    then = time.localtime(moment)
    today = time.localtime(now)[:3] == then[:3]
    return time.strftime("%H:%M" if today else "%d %b %Y, %H:%M", then)


def offer_lost(window: MainWindow) -> RestoreDialog | None:
    """Show the dialog over a window when there is something to restore, and return at once."""
    from studio.project.lost import describe_lost

    found = [describe_lost(files) for files in window.recovery.abandoned()]
    if not found:
        return None

    def restored(missing: tuple[str, ...]) -> None:
        window.guard.adopt_autosave()
        window.guard.offer_autosave()
        if missing:
            window.message.tell("error", f"Restored, but without {'; '.join(missing)}")
        else:
            window.message.tell(
                "info", f"Restored {window.session.name} as it was at its last step; it is not saved yet"
            )

    dialog = RestoreDialog(
        window.recovery, sorted(found, key=lambda lost: -lost.time), window.files.may_discard, restored, window
    )
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
    return dialog


def _count(number: int, name: str) -> str:
    return f"{number} {name}" + ("" if number == 1 else "s")
