"""Makes every picture of README and docs from the real window: ``make screenshots`` (needs a display, or Xvfb).

The window is driven through its own actions; nothing is painted over. Pictures go to ``docs/images``; with
``--out FOLDER`` they go there, in three window sizes, to be looked at.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from PySide6.QtTest import QTest

from engine.landmarks import LandmarkSet, LandmarkState
from studio.app import application, make_window
from studio.main_window import MainWindow
from studio.scan.commands import SetLandmarks
from studio.settings import Settings
from studio.theme import wear

IMAGES = Path(__file__).resolve().parent / "images"
PATIENCE = 120.0
SIZES = {"": (1440, 900)}
MORE_SIZES = {"-small": (1280, 800), "-large": (2560, 1440)}


def wait(condition: Callable[[], bool], what: str) -> None:
    """Run the event loop until ``condition`` holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(what)
        QTest.qWait(20)


class Photographer:
    """Brings one window into states worth showing and takes its picture."""

    def __init__(self, folder: Path, out: Path) -> None:
        self._folder, self._out = folder, out
        self.window: MainWindow = make_window(Settings(folder / "studio.ini"))
        self.window.move(0, 0)
        self.window.resize(1440, 900)
        self.window.show()
        wait(lambda: self.stage.centre.views.scene is not None, "3-D did not start")
        self.rest()

    @property
    def stage(self) -> Any:
        """The scan stage of the window."""
        return self.window.stage

    def rest(self) -> None:
        """Wait until every task is done and everything is painted."""
        wait(lambda: not self.window.session.tasks.busy, "a task did not end")
        QTest.qWait(600)

    def take(self, name: str, size: tuple[int, int] = (1440, 900)) -> None:
        """Save what the screen shows of the window."""
        self.window.resize(*size)
        self.rest()
        for action in ("view.frame", "view.three_quarter"):
            if self.window.actions_[action].isEnabled():
                self.window.actions_[action].trigger()
        self.rest()
        path = self._out / f"{name}.png"
        if not self.window.screen().grabWindow(self.window.winId()).save(str(path)):
            raise OSError(f"{path} could not be written")
        print(f"{path.name}  {size[0]} x {size[1]}")

    def choose(self, name: str) -> None:
        """Bring the scan of this name into view."""
        (scan_id,) = [item.id for item in self.window.session.project.scans if item.name == name]
        self.stage.context.select_scan(scan_id)
        self.rest()

    def change(self, change: Callable[[LandmarkSet], LandmarkSet], text: str) -> None:
        """Change the fiducials of the scan in view as one step."""
        context = self.stage.context
        old = context.landmarks
        command = SetLandmarks(self.window.session.project, context.scan_id, old, change(old), text)
        self.window.session.stack.push(command)
        self.rest()

    def fill(self) -> None:
        """Open the sample, fit it, move a point of "she", leave three proposals and three locks on "too"."""
        self.window.actions_["scan.sample"].trigger()
        self.rest()
        self.window.actions_["scan.fit_all"].trigger()
        self.rest()
        self.window.session.save(self._folder / "anna.qface")
        self.choose("she")
        # A preview that follows a nudge is dropped by going on, so the older fit is shown as stale.
        self.stage.editor.nudge("chin", 0.6, 0.0)
        self.stage.context.select_scan(self.window.session.project.scans[-1].id)
        self.rest()
        self.change(_partly_proposed, "Propose the mouth again")
        self.stage.context.select_fiducial("mouth_right")
        self.rest()

    def fill_basis(self) -> None:
        """Open the sample of the basis stage, and go to a smile and to the worst frame by hand."""
        self.window.show_stage("basis")
        self.window.actions_["basis.sample"].trigger()
        wait(lambda: self.stage.centre.views.scene is not None, "3-D did not start")
        wait(lambda: not self.stage.exports.reason(), "the basis was not made")
        self.rest()
        self.stage.context.select_shape("mouthSmileLeft")
        self.window.message.clear()
        self.stage.go_to_frame(1653)
        self.rest()

    def close(self) -> None:
        """Close the window without a question."""
        self.window.session.stack.setClean()
        self.window.close()


def _partly_proposed(landmarks: LandmarkSet) -> LandmarkSet:
    proposed = ("mouth_right", "lip_upper", "lip_lower")
    locked = ("nose_bridge", "eye_left_inner", "eye_right_inner")
    changes = {name: replace(landmarks[name], state=LandmarkState.PROPOSED) for name in proposed}
    changes |= {name: replace(landmarks[name], locked=True) for name in locked}
    return landmarks.with_points(changes)


def main() -> int:
    """Make all pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="another folder than docs/images, for all window sizes")
    out: Path | None = parser.parse_args().out
    sizes = SIZES if out is None else SIZES | MORE_SIZES
    (out or IMAGES).mkdir(parents=True, exist_ok=True)
    app = application()
    with tempfile.TemporaryDirectory() as folder:
        photographer = Photographer(Path(folder), out or IMAGES)
        window = photographer.window
        photographer.take("start-dark")
        photographer.fill()
        for look in ("dark", "light"):
            wear(app, window.settings, look)
            for suffix, size in sizes.items():
                photographer.take(f"scan-{look}{suffix}", size)
        wear(app, window.settings, "dark")
        window.actions_["scan.confirm_all"].trigger()
        photographer.rest()
        photographer.stage.centre.canvas_panel.set_view("missing")
        photographer.stage.centre.views.set_mode("shaded")
        window.show_dock("history")
        photographer.take("scan-missing-shaded")
        photographer.fill_basis()
        for look in ("dark", "light"):
            wear(app, window.settings, look)
            for suffix, size in sizes.items():
                photographer.take(f"basis-{look}{suffix}", size)
        photographer.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
