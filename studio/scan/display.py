"""From project and selection to the widgets of the scan stage; the only place that fills them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from engine.errors import InputError
from engine.landmarks import LandmarkScheme, LandmarkSet
from engine.mesh import BoolArray, FloatArray
from studio.project.document import needs
from studio.scan import edits
from studio.scan.context import ScanContext
from studio.scan.follower import ShownFit
from studio.scan.job import SCHEMES, item_scheme, scheme_of, template_for, template_of
from studio.scan.options import FitOptions
from studio.scan.rows import Thumbnails, scan_row
from studio.scan.workspace import ScanWorkspace
from widgets.scan.source_panel import SourceView

if TYPE_CHECKING:
    from engine.scan.range_image import RangeImage
    from engine.scan.warp import TemplateWarp


class ScanDisplay(QObject):
    """Fills the widgets; asks the project, never changes it."""

    def __init__(self, context: ScanContext, workspace: ScanWorkspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._context = context
        self._work = workspace
        self._thumbnails = Thumbnails()
        self._diagram: LandmarkScheme | None = None
        self._edges = template_of().edges
        self._wired = False
        self._depth: tuple[RangeImage, FloatArray] | None = None
        self.warp: TemplateWarp | None = None
        self.trouble = ""
        self.verdict_of: Callable[[str], str] = lambda _scan_id: ""
        """Says what is beyond its limits on a scan's face."""
        self.show_schemes()
        workspace.inputs.source_panel.set_options(FitOptions().model_dump())
        template = template_of()
        workspace.template_title.set_note(f"{len(template.mirror)} vertices, {len(template.faces)} triangles")

    def show_scan(self) -> None:
        """Show another scan, or that there is none."""
        item, image, work = self._context.item, self._context.image, self._work
        if item is None or image is None:
            work.canvas_panel.set_scan("", None, None)
            work.inputs.source_panel.set_source(None)
        else:
            depth = self._depth_of(image)
            work.canvas_panel.set_scan(item.name, image.colour, depth, image.valid)
        self.show_source()
        self.show_scheme()
        self.show_options()
        self.show_list()
        sources = self.carry_sources()
        work.inputs.source_panel.set_carry_sources(sources, sources[0][0] if sources else None)
        work.canvas_panel.canvas.frame_unless_moved()

    def show_source(self) -> None:
        """Show where the scan in view comes from."""
        item, image = self._context.item, self._context.image
        if item is None or image is None:
            return
        source = item.source
        name = Path(source.depth_file.replace("\\", "/")).name or "made in the studio"
        stated = not source.assumed or source.assumed.endswith("in the file")
        said = source.assumed if source.assumed.startswith(source.unit) else f"{source.unit}, {source.assumed}"
        unit = f"{source.unit}, as in file" if stated else said
        depth = self._depth_of(image)
        view = SourceView(
            item.name, name, image.width, image.height, unit, image.missing_fraction, source.spikes, depth,
            source.unit if source.unit_open else "", source.assumed, source.view is not None,
        )  # fmt: skip
        self._work.inputs.source_panel.set_source(view)

    def _depth_of(self, image: RangeImage) -> FloatArray:
        """Return the depth (H, W) of the scan in view, mm; the same array for the same scan."""
        if self._depth is None or self._depth[0] is not image:
            self._depth = image, -image.points[..., 2]
        return self._depth[1]

    def show_spikes(self, spikes: BoolArray) -> None:
        """Mark the spikes that were found in the scan in view."""
        image = self._context.image
        if image is not None:
            self._work.canvas_panel.canvas.set_missing(image.valid, spikes)

    def show_schemes(self) -> None:
        """Offer the schemes that are shipped and those of the project."""
        schemes = [*map(scheme_of, SCHEMES), *self._context.project.schemes.values()]
        panel = self._work.inputs.source_panel
        panel.set_schemes([(scheme.name, f"{scheme.name}, {len(scheme)} points") for scheme in schemes])
        if self._context.item is not None:
            panel.set_scheme(self._context.item.scheme)

    def show_scheme(self) -> None:
        """Show the scheme of the scan in view: names, diagram, fiducials."""
        scheme, work = self._context.scheme, self._work
        work.canvas_panel.canvas.set_scheme(scheme)
        work.template_panel.set_scheme(scheme)
        work.fiducials.set_scheme(scheme)
        shown = scheme_of("closed") if scheme is None else scheme
        work.inputs.source_panel.set_scheme(shown.name)
        if shown != self._diagram:
            self._diagram = shown
            layout = template_for(None, shown).layout(shown.name)
            work.template_panel.set_template(self._edges, layout.vertices, layout.fiducials)
            work.fiducials.set_vertices(layout.fiducials)
        self.show_landmarks()
        self.show_current()

    def show_landmarks(self) -> None:
        """Show the fiducials of the scan in view, and the template warped onto them."""
        landmarks, work = self._context.landmarks, self._work
        work.canvas_panel.canvas.set_landmarks(landmarks)
        work.template_panel.set_landmarks(landmarks)
        work.fiducials.set_landmarks(landmarks)
        self._warp(landmarks)

    def show_drag(self, landmarks: LandmarkSet) -> None:
        """Show where everything would be if the hand let go now."""
        self._work.canvas_panel.canvas.set_landmarks(landmarks)
        self._warp(landmarks)

    def show_current(self) -> None:
        """Mark the fiducial that a click would place."""
        name, work = self._context.fiducial, self._work
        work.canvas_panel.canvas.set_current(name)
        work.template_panel.set_current(name)
        work.fiducials.set_current(name)

    def show_options(self) -> None:
        """Show the options of the fit of the scan in view."""
        item = self._context.item
        if item is not None:
            self._work.inputs.source_panel.set_options(item.options.model_dump())
            self._work.fit.set_level(item.options.levels)

    def show_list(self) -> None:
        """Show all scans and which can be carried from."""
        project, panel = self._context.project, self._work.inputs
        rows = [scan_row(project, item, self._thumbnails, self.verdict_of(item.id)) for item in project.scans]
        panel.scan_list.set_scans(rows)
        panel.scan_list.set_current(self._context.scan_id)
        sources = self.carry_sources()
        panel.source_panel.set_carry_sources(sources)
        self._work.fiducials.set_carry_available(bool(sources), "No other scan has fiducials yet")

    def carry_sources(self) -> list[tuple[str, str]]:
        """Return (id, name) of the other scans that have fiducials, the previous one first."""
        scans, current = list(self._context.project.scans), self._context.scan_id
        ids = [item.id for item in scans]
        if current not in ids:
            return []
        at = ids.index(current)
        nearest_first = [*reversed(scans[:at]), *scans[at + 1 :]]
        return [(s.id, s.name) for s in nearest_first if edits.placed(s.landmarks, item_scheme(s))]

    def show_fit(self, shown: ShownFit | None) -> None:
        """Show a face in 3-D with its figures, or that there is none yet."""
        item, image, work = self._context.item, self._context.image, self._work
        fit = None if shown is None else shown.fit
        marks = {} if fit is None or item is None else self._marks(fit.scheme, item_scheme(item))
        work.views.set_fit(fit, image, fiducials=marks)
        work.views.set_preview_note("")
        work.fit.set_checks(None if shown is None else shown.checks)
        needed = "Add a scan first" if item is None else needs(item)
        work.fit.set_fit_available(not needed, needed)
        ready = item is not None and self._context.project.state(item.id).kind == "fresh"
        work.fit.set_export_available(ready, needed or "Fit the face first")

    @staticmethod
    def _marks(name: str, present: LandmarkScheme) -> dict[str, int]:
        """Return the vertices of the fiducials of a fit, whose scheme ``name`` may have gone since."""
        scheme = present if name == present.name else scheme_of(name) if name in SCHEMES else None
        return {} if scheme is None else dict(template_for(None, scheme).layout(name).fiducials)

    def _warp(self, landmarks: LandmarkSet) -> None:
        item, canvas = self._context.item, self._work.canvas_panel.canvas
        self.warp, self.trouble = None, ""
        if item is None:
            canvas.set_template_vertices(None)
            canvas.set_folded(None)
            return
        positions = edits.located(landmarks, item_scheme(item))
        template = template_for(None, item_scheme(item))
        if len(positions) >= 3:
            from engine.scan.warp import warp_template  # with scipy, which the first paint need not wait for

            try:
                self.warp = warp_template(template, item.scheme, positions)
            except InputError as error:
                self.trouble = str(error)
        if self.warp is None:
            canvas.set_template_vertices(None)
            canvas.set_folded(None)
            return
        if not self._wired:
            self._wired = True
            canvas.set_template(self._edges, None)
        canvas.set_template_vertices(self.warp.vertices)
        folded = self.warp.folded
        canvas.set_folded(template.faces[folded] if len(folded) else None)
