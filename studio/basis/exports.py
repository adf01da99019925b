"""What leaves the basis stage: the basis in use, its curves over the performance, the report, the command line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from engine.errors import InputError
from engine.progress import Progress
from studio import dialogs
from studio.basis.job import BasisInputs, as_command, check_out
from studio.basis.results import Analysis, Blend

if TYPE_CHECKING:
    from engine.mesh import FloatArray
    from engine.motion import WeightCurves
    from studio.basis.controller import BasisStage
    from studio.basis.job import BasisResult

BASIS_FILTER = "glTF binary (*.glb);;NumPy archive (*.npz)"
GLB_FILTER = "glTF binary (*.glb)"
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

    def export_animated(self) -> None:
        """Ask for a GLB and write the basis in use with the weights that reproduce the performance."""
        analysis, blend = self._ready()
        path = self._ask("Export basis and performance", f"{self._name()}_performance.glb", GLB_FILTER)
        if path is not None:
            self.write_basis(path, analysis, blend, animated=True)

    def export_objects(self) -> None:
        """Ask for a folder and write the basis in use into one of its own there, an OBJ a shape."""
        analysis, blend = self._ready()
        window = self._stage.window
        folder = dialogs.open_folder(window, window.settings, "Folder that the shapes' folder is made in")
        if folder is None:
            return
        path = folder / f"{self._name()}_quasi_eigen"
        if not path.exists() or dialogs.ask_replace(window, path):
            self.write_basis(path, analysis, blend)

    def write_basis(self, path: Path, analysis: Analysis, blend: Blend, *, animated: bool = False) -> None:
        """Write the basis in use beside the window."""
        item = self._stage.context.hand
        content = None if item is None else self._stage.context.basis.rig_content(item.content)
        texture = None if content is None or path.suffix.lower() == ".npz" else content.texture
        made = analysis.hand.with_basis(blend.basis)
        curves = self._curves(analysis, blend) if animated else None

        def write(_progress: Progress) -> tuple[Path, ...]:
            from engine.files.rig_out import write_rig

            return write_rig(path, made, name="quasi-eigen", texture=texture, curves=curves)

        self._write(path, write)

    def _curves(self, analysis: Analysis, blend: Blend) -> WeightCurves:
        """Return the weights of the basis in use under the bounds in use."""
        from engine.motion import WeightCurves

        weights = blend.comparison.weights["quasi_eigen"][self._stage.context.setup.options.bounds]
        return WeightCurves(blend.basis.names, weights, analysis.prepared.motion.fps)

    def export_curves(self) -> None:
        """Ask for a file and write the weights of the basis in use under the bounds in use."""
        analysis, blend = self._ready()
        path = self._ask("Export weights", f"{self._name()}_weights.csv", CURVES_FILTER)
        if path is None:
            return
        curves = self._curves(analysis, blend)

        def write(_progress: Progress) -> tuple[Path, ...]:
            from engine.files.weights_csv import write_weights

            write_weights(path, curves)
            return (path,)

        self._write(path, write)

    def export_report(self) -> None:
        """Ask for a file and write the report of the basis in use, in a process of its own."""
        analysis, blend = self._ready()
        path = self._ask("Report", f"{self._name()}.pdf", REPORT_FILTER)
        if path is None:
            return
        files = {role: Path(source) for role, source in self._sources().items()}
        item = self._stage.context.hand
        content = None if item is None else self._stage.context.basis.rig_content(item.content)
        setup = self._stage.context.setup
        amounts = analysis.amounts(setup)

        def write(progress: Progress) -> tuple[Path, ...]:
            from studio.report.basis_entry import entry_of
            from studio.report.basis_job import write_apart

            inputs = BasisInputs(analysis.hand, analysis.prepared.motion)
            result = in_use(analysis, blend, amounts)
            texture = None if content is None else content.texture
            entry = entry_of(inputs, setup.options, result, files=files, texture=texture)
            return write_apart(entry, path, progress)

        self._write(path, write)

    def command(self) -> str:
        """Return the command line that makes the same basis of the same files.

        Raises
        ------
        InputError
            When a rig or a performance is not chosen.
        """
        context, sources = self._stage.context, self._sources()
        motion, analysis = context.motion, self._stage.follower.analysis
        if "hand" not in sources or motion is None:
            raise InputError("command", "needs a rig and a performance", "open both first")
        options, out = context.setup.options, f"{self._name()}_quasi_eigen.glb"
        if options.train is not None and analysis is not None and self._stage.follower.is_fresh:
            # A command counts the frames of the recording, the window those it shows.
            options = options.model_copy(update={"train": analysis.prepared.recorded(options.train)})
        return as_command(
            sources["hand"], sources["motion"], options, motion.options, out, sources.get("rig"), self._pairs_file()
        )

    def not_in_command(self) -> tuple[str, ...]:
        """Return what the project holds that a command line does not say, in words."""
        context = self._stage.context
        hand, motion, driver = context.hand, context.motion, context.basis.driver
        found = []
        if motion is not None and motion.options.pairs is not None and self._pairs_file() is None:
            found.append("pairs of markers")
        if any(rig is not None and rig.edits for rig in (hand, driver)):
            found.append("edits of shapes")
        if context.setup.amounts:
            found.append("amounts below 1")
        if any(item is not None and not item.source for item in (hand, motion, driver)):
            found.append("content without a file")
        return tuple(found)

    def _pairs_file(self) -> str | None:
        """Return the file that the pairs stand in, where it is known: that of the sample."""
        from studio.basis.sample import CLIP, PAIRS, sample_path

        motion = self._stage.context.motion
        if motion is None or motion.options.pairs is None or Path(motion.source) != sample_path(CLIP):
            return None
        from engine.files.marker_pairs import read_marker_pairs

        known = {pair.label: pair.target for pair in read_marker_pairs(sample_path(PAIRS))}
        return str(sample_path(PAIRS)) if known == motion.options.pairs else None

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

    def _write(self, path: Path, write: Callable[[Progress], tuple[Path, ...]]) -> None:
        check_out(path, tuple(Path(source) for source in self._sources().values()))

        def work(progress: Progress) -> tuple[Path, ...]:
            progress(0.0, f"writing {path.name}")
            return write(progress)

        def done(files: tuple[Path, ...]) -> None:
            more = f" and {len(files) - 1} more files" if len(files) > 1 else ""
            self._stage.window.message.tell("info", f"Wrote {files[0]}{more}")

        self._stage.window.session.tasks.submit(f"Writing {path.name}", work, done)


def in_use(analysis: Analysis, blend: Blend, amounts: FloatArray) -> BasisResult:
    """Return the result with the shapes between hand (0) and quasi-eigen (1) in the place of the quasi-eigen ones."""
    result = analysis.result
    if (amounts == 1.0).all():
        return result
    quasi = replace(
        result.quasi,
        basis=blend.basis,
        cosine=analysis.measures.cosine(amounts),
        residual_mm=amounts * result.quasi.residual_mm,
        residual_fraction=amounts * result.quasi.residual_fraction,
    )
    return replace(result, quasi=quasi, comparison=blend.comparison)
