"""Which scan and which fiducial the scan stage is at: the only state it keeps beside the project."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from engine.landmarks import LandmarkScheme, LandmarkSet
from engine.scan.range_image import RangeImage
from studio.project.document import Project, ScanItem
from studio.scan.job import item_scheme
from studio.scan.next_step import first_unfinished
from studio.session import Session


class ScanContext(QObject):
    """The selection, and what is selected, read from the project anew each time."""

    scan_changed = Signal()
    """Another scan is in view, or none."""
    fiducial_changed = Signal()
    """A click would place another fiducial, or none."""

    def __init__(self, session: Session, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.scan_id: str | None = None
        self.fiducial: str | None = None
        self.doubtful: dict[str, frozenset[str]] = {}
        """By scan, the proposals that were carried there and deserve a look."""

    @property
    def project(self) -> Project:
        """The open project."""
        return self.session.project

    @property
    def item(self) -> ScanItem | None:
        """The scan in view."""
        if self.scan_id is None or self.scan_id not in self.project:
            return None
        return self.project.scan(self.scan_id)

    def name(self) -> str:
        """Return the name of the scan in view; empty without one."""
        item = self.item
        return "" if item is None else item.name

    @property
    def image(self) -> RangeImage | None:
        """Its range image."""
        item = self.item
        return None if item is None else self.project.range_image(item.id)

    @property
    def scheme(self) -> LandmarkScheme | None:
        """Its fiducial scheme."""
        item = self.item
        return None if item is None else item_scheme(item)

    @property
    def landmarks(self) -> LandmarkSet:
        """Its fiducials; none without a scan."""
        item = self.item
        return LandmarkSet({}) if item is None else item.landmarks

    def select_scan(self, scan_id: str | None) -> None:
        """Bring a scan into view, at its first unfinished fiducial."""
        if scan_id is not None and scan_id not in self.project:
            scan_id = None
        if scan_id == self.scan_id:
            return
        self.scan_id = scan_id
        self.fiducial = (
            None
            if scan_id is None
            else first_unfinished(self.project, scan_id, doubtful=self.doubtful.get(scan_id, ()))
        )
        self.scan_changed.emit()

    def select_fiducial(self, name: str | None) -> None:
        """Make a fiducial the current one."""
        scheme = self.scheme
        if name is not None and (scheme is None or name not in scheme):
            name = None
        if name != self.fiducial:
            self.fiducial = name
            self.fiducial_changed.emit()

    def advance(self) -> None:
        """Go on to the next unfinished fiducial after the current one; stay when all are done."""
        if self.scan_id is not None:
            following = first_unfinished(self.project, self.scan_id, self.fiducial, self.doubtful.get(self.scan_id, ()))
            if following is not None:
                self.select_fiducial(following)

    def follow(self) -> None:
        """Keep the selection valid after scans came or went, or the scheme changed."""
        ids = [item.id for item in self.project.scans]
        if self.scan_id not in ids:
            self.scan_id = None
            self.select_scan(ids[0] if ids else None)
            if not ids:
                self.fiducial = None
                self.scan_changed.emit()
        scheme = self.scheme
        if self.fiducial is not None and (scheme is None or self.fiducial not in scheme):
            self.select_fiducial(None)
            self.advance()
