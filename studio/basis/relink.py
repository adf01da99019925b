"""Finds the files of rigs and performances whose content is missing, and says where one holds something else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from engine.progress import Progress, part
from studio import dialogs
from studio.basis.commands import SetMotion, SetRig
from studio.basis.loading import LoadedMotion, LoadedRig, load_motion, load_rig
from studio.project.basis_items import MotionItem, RigItem
from studio.tasks import describe

if TYPE_CHECKING:
    from studio.basis.context import BasisContext
    from studio.main_window import MainWindow

RIG_FILTER = "Rigs (*.glb *.npz *.obj);;All files (*)"
MOTION_FILTER = "Performances (*.c3d *.trc *.csv *.tsv *.txt *.pc2 *.npz *.glb);;All files (*)"
_KINDS = {"markers": "markers", "weights": "curves", "dense": "vertices"}


class MissingFiles:
    """Asks where a missing file lies; one of other content takes its place only once that was agreed to."""

    def __init__(self, window: MainWindow, context: BasisContext) -> None:
        self._window, self._context = window, context

    def reason(self) -> str:
        """Return why there is nothing to ask about; empty where a file is missing."""
        return "" if self._context.basis.missing else "no file is missing"

    def ask(self) -> None:
        """Ask where the file of the first rig or performance lies whose content is missing."""
        missing = self._context.basis.missing
        if not missing:
            return
        item = missing[0]
        kinds = RIG_FILTER if isinstance(item, RigItem) else MOTION_FILTER
        path = dialogs.open_file(self._window, self._window.settings, f"Where is {item.name}?", kinds)
        if path is not None:
            self.read(item, path)

    def read(self, item: RigItem | MotionItem, path: Path) -> None:
        """Read a file beside the window in the place of an item's content."""

        def work(progress: Progress) -> LoadedRig | LoadedMotion:
            if isinstance(item, MotionItem):
                return load_motion(path, item.options, progress)
            loaded = load_rig(path, part(progress, 0.0, 0.5))
            if loaded.item.content == item.content or loaded.item.unit == item.unit:
                return loaded
            again = load_rig(path, part(progress, 0.5, 1.0), item.unit)  # it may have been read so at first
            return again if again.item.content == item.content else loaded

        self._context.session.tasks.submit(
            f"Reading {path.name}",
            work,
            lambda loaded: self._take(item.id, path, loaded),
            failed=lambda error: self._window.message.tell("error", describe(error)),
            key=f"reading {item.id}",
        )

    def _take(self, item_id: str, path: Path, loaded: LoadedRig | LoadedMotion) -> None:
        basis = self._context.basis
        old: RigItem | MotionItem | None = basis.rigs.get(item_id) or basis.motions.get(item_id)
        if old is None:
            return
        if loaded.item.content == old.content:
            self._push(item_id, loaded)
            return
        text = f"{path.name} is not the file of {old.name} that was lost: {difference(old, loaded)}"
        self._window.message.tell("info", text, [("Use it all the same", lambda: self._push(item_id, loaded))])

    def _push(self, item_id: str, loaded: LoadedRig | LoadedMotion) -> None:
        project = self._context.project

        def push() -> None:
            command: SetRig | SetMotion
            if isinstance(loaded, LoadedRig):
                rig = project.basis.rigs[item_id]
                item = replace(loaded.item, id=rig.id, name=rig.name, edits=rig.edits)
                command = SetRig(project, item, loaded.content)
            else:
                motion = project.basis.motions[item_id]
                command = SetMotion(project, replace(loaded.item, id=motion.id, name=motion.name), loaded.data)
            self._context.session.stack.push(command)

        if item_id in project.basis.rigs or item_id in project.basis.motions:
            self._window.attempt(push)


def difference(old: RigItem | MotionItem, loaded: LoadedRig | LoadedMotion) -> str:
    """Return in words what a file has that an item did not have."""
    if isinstance(loaded, LoadedRig) or isinstance(old, RigItem):
        rig = loaded.content.rig if isinstance(loaded, LoadedRig) else None
        count = "" if rig is None else f"{len(rig.basis)} shapes of {len(rig.mesh.vertices)} vertices, "
        return f"it has {count}which are not those that were stored"
    new = loaded.item
    found = []
    if new.kind != old.kind or new.count != old.count:
        found.append(f"{new.count} {_KINDS[new.kind]} instead of {old.count} {_KINDS[old.kind]}")
    if new.frames != old.frames:
        found.append(f"{new.frames} frames instead of {old.frames}")
    if new.fps != old.fps:
        found.append(f"{new.fps:g} frames a second instead of {old.fps:g}")
    return f"it has {', '.join(found) if found else 'as many frames, but other values in them'}"
