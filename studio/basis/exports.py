"""What leaves the basis stage: the basis in use, its curves over the performance, the report, the command line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject

from engine.errors import InputError
from engine.progress import Progress
from studio import dialogs
from studio.basis.job import BasisInputs, as_command, check_out
from studio.basis.results import Analysis, Blend

if TYPE_CHECKING:
    from studio.basis.controller import BasisStage

BASIS_FILTER = "glTF binary (*.glb);;NumPy archive (*.npz)"
CURVES_FILTER = "Weights (*.csv)"
REPORT_FILTER = "PDF (*.pdf)"


class BasisExports(QObject):
    """Asks where to, and writes beside the window."""

    def __init__(self, stage: BasisStage) -> None:
        super().__init__(stage)
        self._stage = stage

    def reason(self) -> str:
        """Say why nothing can be written now; empty when it can."""
        follower = self._stage.follower
        if follower.analysis is None:
            return self._stage.teller.state.reason or "there is no basis yet"
        if not follower.is_fresh:
            return "the basis is being made anew"
        return "" if follower.blend is not None else "its figures are being worked out"

    def export_basis(self) -> None:
        """Ask for a file and write the basis in use, names and displacements as they are shown."""
        analysis, blend = self._ready()
        path = self._ask("Export basis", f"{self._name()}_quasi_eigen.glb", BASIS_FILTER)
        if path is not None:
            self.write_basis(path, analysis, blend)

    def write_basis(self, path: Path, analysis: Analysis, blend: Blend) -> None:
        """Write the basis in use beside the window."""
        item = self._stage.context.hand
        content = None if item is None else self._stage.context.basis.rig_content(item.content)
        texture = None if content is None or path.suffix.lower() == ".npz" else content.texture
        made = analysis.hand.with_basis(blend.basis)

        def write() -> tuple[Path, ...]:
            from engine.files.rig_out import write_rig

            return write_rig(path, made, name="quasi-eigen", texture=texture)

        self._write(path, write)

    def export_curves(self) -> None:
        """Ask for a file and write the weights of the basis in use under the bounds in use."""
        analysis, blend = self._ready()
        path = self._ask("Export weights", f"{self._name()}_weights.csv", CURVES_FILTER)
        if path is None:
            return
        bounds = self._stage.context.setup.options.bounds
        weights = blend.comparison.weights["quasi_eigen"][bounds]
        fps = analysis.prepared.motion.fps

        def write() -> tuple[Path, ...]:
            from engine.files.weights_csv import write_weights
            from engine.motion import WeightCurves

            write_weights(path, WeightCurves(blend.basis.names, weights, fps))
            return (path,)

        self._write(path, write)

    def export_report(self) -> None:
        """Ask for a file and write the report of the quasi-eigen basis."""
        analysis, _blend = self._ready()
        path = self._ask("Report", f"{self._name()}.pdf", REPORT_FILTER)
        if path is None:
            return
        inputs = BasisInputs(analysis.hand, analysis.prepared.motion)
        files = {role: Path(source) for role, source in self._sources().items()}

        def write() -> tuple[Path, ...]:
            from studio.report.basis_job import write_basis_report

            found: Any = write_basis_report(path, inputs, analysis.options, analysis.result, files=files)
            return tuple(found)

        self._write(path, write)

    def command(self) -> str:
        """Return the command line that makes the same basis of the same files.

        Raises
        ------
        InputError
            When a rig or a performance is not chosen.
        """
        context, sources = self._stage.context, self._sources()
        motion = context.motion
        if "hand" not in sources or motion is None:
            raise InputError("command", "needs a rig and a performance", "open both first")
        options, out = context.setup.options, f"{self._name()}_quasi_eigen.glb"
        return as_command(sources["hand"], sources["motion"], options, motion.options, out, sources.get("rig"))

    def _sources(self) -> dict[str, str]:
        context = self._stage.context
        hand, motion, driver = context.hand, context.motion, context.basis.driver
        found = {} if hand is None else {"hand": hand.source or f"{hand.name}.npz"}
        if motion is not None:
            found["motion"] = motion.source or f"{motion.name}.npz"
        if driver is not None and hand is not None and driver is not hand:
            found["rig"] = driver.source or f"{driver.name}.npz"
        return found

    def _ready(self) -> tuple[Analysis, Blend]:
        analysis, blend, why = self._stage.follower.analysis, self._stage.follower.blend, self.reason()
        if why or analysis is None or blend is None:
            raise InputError("basis", why or "is not there", "wait until it is made")
        return analysis, blend

    def _name(self) -> str:
        hand = self._stage.context.hand
        return "basis" if hand is None else hand.name

    def _ask(self, title: str, name: str, wanted: str) -> Path | None:
        window = self._stage.window
        return dialogs.save_file(window, window.settings, title, name, wanted)

    def _write(self, path: Path, write: Callable[[], tuple[Path, ...]]) -> None:
        check_out(path, tuple(Path(source) for source in self._sources().values()))

        def work(progress: Progress) -> tuple[Path, ...]:
            progress(0.0, f"writing {path.name}")
            return write()

        def done(files: tuple[Path, ...]) -> None:
            self._stage.window.message.tell("info", f"Wrote {', '.join(file.name for file in files[:3])}")

        self._stage.window.session.tasks.submit(f"Writing {path.name}", work, done)
