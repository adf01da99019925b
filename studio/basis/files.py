"""Files of the basis stage: rigs and performances come in, bases and curves go out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from engine.errors import InputError
from engine.progress import Progress, part
from studio import dialogs
from studio.basis.commands import AddMotion, AddRig, ChooseInput, SetMotion
from studio.basis.context import BasisContext
from studio.basis.dropped import DroppedFiles, sort_dropped
from studio.basis.loading import LoadedMotion, LoadedRig, load_motion, load_rig
from studio.basis.options import MotionOptions
from studio.basis.relink import MOTION_FILTER, RIG_FILTER, MissingFiles
from studio.project.basis_items import MotionItem
from studio.tasks import describe

if TYPE_CHECKING:
    from studio.main_window import MainWindow

PAIRS_FILTER = "Marker pairs (*.json)"
MOST_REMARKS = 4

Loaded = LoadedRig | LoadedMotion


class BasisFiles(QObject):
    """Asks for files, reads them beside the window, and pushes what came of it.

    Attributes
    ----------
    missing : MissingFiles
        Finds files that are not where they were.
    """

    told = Signal(str, str)
    """A message: kind and text."""

    def __init__(self, window: MainWindow, context: BasisContext) -> None:
        super().__init__(window)
        self._window, self._context = window, context
        self.missing = MissingFiles(window, context)

    # -- in ---------------------------------------------------------------------------------------------------

    def add_rig(self) -> None:
        """Ask for a rig and make it the hand-sculpted one."""
        path = dialogs.open_file(self._window, self._window.settings, "Open rig", RIG_FILTER)
        if path is not None:
            self.read((path,), ())

    def add_motion(self) -> None:
        """Ask for a performance."""
        path = dialogs.open_file(self._window, self._window.settings, "Open performance", MOTION_FILTER)
        if path is not None:
            self.read((), (path,))

    def drop(self, paths: Sequence[Path]) -> None:
        """Take in what was dropped: rigs, performances, pairs of markers.

        Raises
        ------
        InputError
            When nothing of it can be used.
        """
        found = sort_dropped(paths)
        if found.left_out and not (found.rigs or found.motions or found.pairs):
            raise InputError(found.left_out[0].split(":")[0], "is neither a rig nor a performance", "drop one of these")
        if found.rigs or found.motions:
            self.read(found.rigs, found.motions, found)
        elif found.pairs:
            self.read_pairs(found.pairs[0])

    def read(self, rigs: Sequence[Path], motions: Sequence[Path], dropped: DroppedFiles | None = None) -> None:
        """Read files beside the window and add them as one step."""
        pairs = dropped.pairs[0] if dropped is not None and dropped.pairs else None
        loads: list[Callable[[Progress], Loaded]] = [partial(load_rig, path) for path in rigs]
        loads += [partial(_load_bound, path, pairs) for path in motions]
        names = [path.name for path in (*rigs, *motions)]

        def work(progress: Progress) -> tuple[list[Loaded], list[str]]:
            loaded, failures = [], []
            for k, load in enumerate(loads):
                try:
                    loaded.append(load(part(progress, k / len(loads), (k + 1) / len(loads))))
                except InputError as error:
                    failures.append(str(error))
            return loaded, failures

        def done(result: tuple[list[Loaded], list[str]]) -> None:
            loaded, failures = result
            if loaded:
                self._window.attempt(self._add, loaded)
            if failures:
                self.told.emit("error", ". ".join(failures[:2]))

        title = f"Reading {names[0]}" if len(names) == 1 else f"Reading {len(names)} files"
        self._context.session.tasks.submit(title, work, done)

    def open_sample(self) -> None:
        """Add the rig and the performance that come with the program, as one step."""
        from studio.basis.sample import load_sample

        def done(loaded: tuple[LoadedRig, LoadedMotion]) -> None:
            self._window.attempt(self._add, list(loaded), "Open sample")

        self._context.session.tasks.submit("Reading the sample", load_sample, done)

    def _add(self, loaded: Sequence[Loaded], text: str = "") -> None:
        project, stack = self._context.project, self._context.session.stack
        names = ", ".join(entry.item.name for entry in loaded)
        stack.beginMacro(text or f"Open {names}")
        try:
            for entry in loaded:
                if isinstance(entry, LoadedRig):
                    rig = replace(entry.item, name=project.basis.rigs.unique_name(entry.item.name))
                    stack.push(AddRig(project, rig, entry.content))
                    stack.push(ChooseInput(project, self._role(entry), rig.id))
                else:
                    item = replace(entry.item, name=project.basis.motions.unique_name(entry.item.name))
                    stack.push(AddMotion(project, item, entry.data))
                    stack.push(ChooseInput(project, "motion", item.id))
        finally:
            stack.endMacro()
        if text:  # the sample needs no remarks
            return
        remarks = [f"{entry.item.name}: {remark}" for entry in loaded for remark in _remarks(entry)]
        if remarks:
            more = f" and {len(remarks) - MOST_REMARKS} more" if len(remarks) > MOST_REMARKS else ""
            self.told.emit("info", ". ".join(remarks[:MOST_REMARKS]) + more)

    def _role(self, loaded: LoadedRig) -> Any:
        """Return what a rig is opened for: to be driven where the curves know its shapes and not the hand's."""
        from engine.motion import WeightCurves

        motion = self._context.motion
        data = None if motion is None else self._context.basis.motion_data(motion.content)
        if self._context.hand is None or not isinstance(data, WeightCurves):
            return "hand"
        curves = {_plain(name) for name in data.names}
        knows_hand = any(_plain(name) in curves for name in self._context.names)
        knows_new = any(_plain(name) in curves for name in loaded.content.rig.basis.names)
        return "driver" if knows_new and not knows_hand else "hand"

    # -- again ------------------------------------------------------------------------------------------------

    def read_again(self, item: MotionItem, options: MotionOptions) -> None:
        """Set a performance up otherwise; where unit, axes or rate are others, it is read again beside."""
        project, stack = self._context.project, self._context.session.stack
        old = item.options.model_dump(include={"unit", "up", "forward", "fps"})
        same_reading = old == options.model_dump(include={"unit", "up", "forward", "fps"})
        if same_reading and project.basis.motion_data(item.content) is not None:
            stack.push(SetMotion(project, replace(item, options=options)))
            return
        source = item.link.path if item.link is not None else Path(item.source)

        def done(loaded: LoadedMotion) -> None:
            if item.id not in project.basis.motions:
                return
            new = replace(loaded.item, id=item.id, name=project.basis.motions[item.id].name)
            self._window.attempt(lambda: stack.push(SetMotion(project, new, loaded.data)))

        self._context.session.tasks.submit(
            f"Reading {source.name}",
            lambda progress: load_motion(source, options, progress),
            done,
            failed=lambda error: self.told.emit("error", describe(error)),
            key=f"reading {item.id}",
        )

    def read_pairs(self, path: Path) -> None:
        """Bind the markers of the performance in use by the pairs of a file.

        Raises
        ------
        InputError
            When there is no such performance, or the pairs cannot be read.
        """
        motion = self._context.motion
        if motion is None or motion.kind != "markers":
            raise InputError(path.name, "binds markers, but no recorded markers are open", "open them first")
        options = _with_pairs(path, motion.options)
        self._context.session.stack.push(
            SetMotion(self._context.project, replace(motion, options=options), text=f"Bind markers by {path.name}")
        )


def _load_bound(path: Path, pairs: Path | None, progress: Progress) -> LoadedMotion:
    return load_motion(path, _with_pairs(pairs), progress)


def _with_pairs(path: Path | None, options: MotionOptions | None = None) -> MotionOptions:
    options = options or MotionOptions()
    if path is None:
        return options
    from engine.files.marker_pairs import read_marker_pairs

    pairs = {pair.label: pair.target for pair in read_marker_pairs(path)}
    return MotionOptions.checked(**{**options.model_dump(), "pairs": pairs})


def _remarks(entry: Loaded) -> tuple[str, ...]:
    told = [clause for clause in entry.item.assumed.split("; ") if "assumed" in clause]
    return (*told, *entry.remarks)


def _plain(name: str) -> str:
    return name.lower().replace("_", "").replace("-", "").replace(" ", "")
