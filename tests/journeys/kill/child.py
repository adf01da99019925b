"""A studio that is used by a restless hand until it is killed.

``python -m tests.journeys.kill.child SEED FOLDER [cold]``.

The real window, without its 3-D, gets seeded random clicks, drags, keys and actions. After every step it writes one
line to stdout: the time (monotonic, seconds) and the digest of the project; other lines say what is about to happen, so
that the killer can strike in the middle of it.
"""

from __future__ import annotations

import json
import random
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt, QTimer

from engine.errors import InputError
from engine.files.landmarks_json import read_fiducials
from engine.files.scan import read_scan
from engine.landmarks import LandmarkSet
from studio import dialogs
from studio.app import application, make_window
from studio.project import store
from studio.settings import Settings
from tests.journeys.driver import Hand
from tests.journeys.kill.state import digest
from widgets.viewers.mesh_viewer import MeshViewer

KEYS = (
    (Qt.Key.Key_Return, Qt.KeyboardModifier.NoModifier),
    (Qt.Key.Key_Left, Qt.KeyboardModifier.NoModifier),
    (Qt.Key.Key_Up, Qt.KeyboardModifier.ShiftModifier),
    (Qt.Key.Key_Down, Qt.KeyboardModifier.NoModifier),
)


def tell(**values: Any) -> None:
    """Write one line, at once."""
    sys.stdout.write(json.dumps({"t": time.monotonic(), **values}) + "\n")
    sys.stdout.flush()


class RestlessHand:
    """Does one random thing after another to a window."""

    def __init__(self, seed: int, folder: Path) -> None:
        self._random = random.Random(seed)
        self._folder = folder
        self._truth = read_fiducials(folder / "face_fiducials.json").positions
        self._scans = sorted((folder / "scans").glob("*.json"))
        self.window = make_window(Settings())
        self._hand = Hand(self.window, None, None)
        self._deeds: dict[Callable[[], object], int] = {
            self.place: 12, self.drag: 4, self.key: 5, self.undo: 3, self.redo: 2, self.add: 2, self.remove: 1,
            self.rename: 1, self.option: 2, self.scheme: 1, self.take: 1, self.save: 2, self.fit: 1,
            self.action: 3, self.other_scan: 2,
        }  # fmt: skip

    def start(self) -> None:
        """Show the window and begin."""
        window = self.window
        window.resize(1280, 800)
        window.show()
        window.session.stack.indexChanged.connect(lambda _index: self.report("step"))
        window.session.saved.connect(lambda: self.report("saved"))
        window.session.saving.connect(lambda _path: tell(about="save"))
        window.session.tasks.changed.connect(self._on_task)
        self.report("ready")
        self.add()
        self._timer = QTimer()
        self._timer.timeout.connect(self.step)
        self._timer.start(30)

    def report(self, what: str) -> None:
        """Say what the project is now."""
        tell(what=what, digest=digest(self.window.session.project), path=str(self.window.session.project.path or ""))

    def step(self) -> None:
        """Do one thing; what cannot be done is refused in words, and nothing has changed."""
        tell(about="life")
        deed = self._random.choices(list(self._deeds), list(self._deeds.values()))[0]
        self._timer.setInterval(self._random.choice((5, 20, 40, 120)))
        if self._stage.context.item is None and deed not in (self.add, self.undo, self.redo, self.save):
            return
        try:
            deed()
        except InputError:
            return

    def place(self) -> None:
        """Click near where the current fiducial belongs."""
        name = self._stage.context.fiducial
        if name in self._truth:
            self._click(self._near(name))

    def drag(self) -> None:
        """Drag a placed fiducial."""
        placed = [n for n, p in self._hand.landmarks.points.items() if p.is_set and n in self._truth and not p.locked]
        if placed:
            name = self._random.choice(placed)
            start, end = self._hand.landmarks[name], self._near(name)
            if self._in_sight((start.x, start.y)) and self._in_sight(end):
                self._hand.press_move((start.x, start.y), end, steps=3)
                self._hand.release(end)

    def key(self) -> None:
        """Press a key over the picture."""
        self._hand.key(*self._random.choice(KEYS))

    def undo(self) -> None:
        """Take some steps back."""
        for _ in range(self._random.randint(1, 4)):
            self.window.actions_["edit.undo"].trigger()

    def redo(self) -> None:
        """Do some again."""
        for _ in range(self._random.randint(1, 3)):
            self.window.actions_["edit.redo"].trigger()

    def add(self) -> None:
        """Add a scan from its file."""
        if len(self.window.session.project.scans) < 5:
            self._stage.files.drop([self._random.choice(self._scans)])

    def remove(self) -> None:
        """Remove the scan in view, when there is another."""
        if len(self.window.session.project.scans) > 2:
            self.window.actions_["scan.remove"].trigger()

    def rename(self) -> None:
        """Give the scan in view another name."""
        if self._stage.context.scan_id is not None:
            self._stage.rename(self._stage.context.scan_id, f"scan {self._random.randint(1, 999)}")

    def option(self) -> None:
        """Change an option of the fit."""
        changes = ({"levels": self._random.randint(0, 1)}, {"spike_mm": self._random.randint(5, 90) / 10})
        self._stage.editor.set_options(self._random.choice(changes))

    def scheme(self) -> None:
        """Choose the other scheme."""
        if self._stage.context.item is not None:
            self._stage.editor.set_scheme(self._random.choice(("closed", "open")))

    def take(self) -> None:
        """Take all fiducials from a file."""
        self._stage.editor.take(self._truth, "file")

    def save(self) -> None:
        """Save, at first under a name."""
        if self.window.session.is_dirty:
            self.window.files.save()

    def fit(self) -> None:
        """Fit the scan in view, where that is possible."""
        self.window.actions_["scan.fit"].trigger()

    def action(self) -> None:
        """Use one of the actions on fiducials, when it can be used."""
        name = self._random.choice(("scan.skip", "scan.unset", "scan.lock", "scan.mirror", "scan.confirm_all"))
        self.window.actions_.refresh()
        self.window.actions_[name].trigger()

    def other_scan(self) -> None:
        """Look at another scan."""
        scans = self.window.session.project.scans
        if scans:
            self._stage.context.select_scan(self._random.choice(scans).id)

    @property
    def _stage(self) -> Any:
        return self.window.stage

    def _near(self, name: str) -> tuple[float, float]:
        x, y = self._truth[name]
        return x + self._random.uniform(-2.0, 2.0), y + self._random.uniform(-2.0, 2.0)

    def _in_sight(self, place: tuple[float, float]) -> bool:
        return self._hand.canvas.viewport().rect().contains(self._hand.at(*place))

    def _click(self, place: tuple[float, float]) -> None:
        if self._in_sight(place):
            self._hand.click(*place)

    def _on_task(self, task: Any) -> None:
        if task.title.startswith("Fitting") and task.state == "running":
            tell(about="fit")


def load_all(folder: Path) -> None:
    """Load what the window loads while its user looks around: the first step is not to wait for it."""
    import engine.scan.fit
    import studio.project.recovery
    from studio.project.thumbnail import draw
    from studio.scan.job import template_of

    template_of().refine(1)
    scan = read_scan(min((folder / "scans").glob("*.json"))).scan
    draw(scan, LandmarkSet({}))
    assert engine.scan.fit and studio.project.recovery


def main(seed: int, folder: Path, cold: bool = False) -> int:
    """Run until killed, or for a minute; ``cold`` without loading anything beforehand."""
    MeshViewer.start = lambda _self: None  # type: ignore[method-assign]
    dialogs.save_file = lambda *_values: folder / "work" / "face.qface"  # type: ignore[assignment]
    real = store.save

    def save(*values: Any, **more: Any) -> Path:
        if values[1] is not None and values[1].name.startswith(("image-", "fit-")):
            tell(about="piece")
        return real(*values, **more)

    store.save = save
    app = application()
    if not cold:
        load_all(folder)
    hand = RestlessHand(seed, folder)
    QTimer.singleShot(0, hand.start)
    QTimer.singleShot(60_000, app.quit)
    return app.exec()


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:] == ["cold"]))
