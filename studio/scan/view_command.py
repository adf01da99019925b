"""The undoable edit that puts the virtual camera before a mesh elsewhere."""

from __future__ import annotations

from PySide6.QtGui import QUndoCommand

from engine.errors import InputError
from engine.landmarks import LandmarkSet
from engine.scan.range_image import RangeImage
from studio.project.checks import check_landmark
from studio.project.document import Project, SourceInfo


class SetView(QUndoCommand):
    """Look at a scan's mesh from elsewhere: another range image, with the fiducials where they are in it."""

    def __init__(
        self,
        project: Project,
        scan_id: str,
        source: SourceInfo,
        scan: RangeImage,
        landmarks: LandmarkSet,
        text: str = "",
    ) -> None:
        if scan_id not in project:
            raise InputError("scan", "is not in the project any more", "choose another")
        item = project.scan(scan_id)
        for name, point in landmarks.points.items():
            check_landmark(name, point, scan.width, scan.height, project.schemes.values())
        super().__init__(text or f"Place the camera of {item.name}")
        self._project, self._id = project, scan_id
        self._old = (item.source, item.image_key, item.landmarks)
        self._new = (source, project.add_image(scan), landmarks)

    def redo(self) -> None:
        """Take the new view."""
        self._set(self._new)

    def undo(self) -> None:
        """Take the old view."""
        self._set(self._old)

    def _set(self, seen: tuple[SourceInfo, str, LandmarkSet]) -> None:
        self._project.change_scan(self._id, source=seen[0], image_key=seen[1], landmarks=seen[2])
