"""Rigs and performances after a crash or in a damaged file: found in pieces, in the saved project, or in their files.

An item whose content is nowhere stays in its list and asks for its file (`BasisState.lacks`). No Qt.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

from engine.errors import InputError
from studio.project import basis_store, store
from studio.project.basis_header import ContentsHeader
from studio.project.basis_items import MotionItem, RigContent, RigItem, motion_key
from studio.project.basis_state import BasisState
from studio.project.document import Project
from studio.project.recovery_files import RecoveryFiles

Other = Callable[[], BasisState | None]
"""Returns the basis of the saved project, if there is one that can be read."""


def basis_pieces(project: Project, files: RecoveryFiles) -> dict[Path, Callable[[], object]]:
    """Return where the piece of every rig and every performance lies and what writes it; linked ones have none."""
    found: dict[Path, Callable[[], object]] = {}
    for item in project.basis.rigs:
        if project.basis.rig_content(item.content) is not None:
            path = files.rig(item.content)
            found[path] = _writer(project.basis, item, path)
    for motion in project.basis.motions:
        if motion.link is None and project.basis.motion_data(motion.content) is not None:
            path = files.motion(motion.content)
            found[path] = _writer(project.basis, motion, path)
    return found


def _writer(state: BasisState, item: RigItem | MotionItem, path: Path) -> Callable[[], object]:
    piece = Project()
    _share(state, piece.basis, item)
    if isinstance(item, RigItem):
        piece.basis.rigs.insert(0, item)
    else:
        piece.basis.motions.insert(0, item)
    return lambda: store.save(piece, path)


def _share(state: BasisState, other: BasisState, item: RigItem | MotionItem) -> bool:
    """Let another project have the content of an item; returns whether it was there."""
    content = state.rig_content(item.content) if isinstance(item, RigItem) else None
    if content is not None:
        other.keep_rig(content, item.content)
        return True
    data = state.motion_data(item.content) if isinstance(item, MotionItem) else None
    if data is not None:
        other.keep_motion(item.content, data)
    return data is not None


def restore_contents(project: Project, files: RecoveryFiles, other: Other) -> list[str]:
    """Find what the items of a journal stand for, and return what is nowhere, in words."""
    lost: list[str] = []
    for item in (*project.basis.rigs, *project.basis.motions):
        if isinstance(item, MotionItem) and item.link is not None:
            continue
        path = files.rig(item.content) if isinstance(item, RigItem) else files.motion(item.content)
        if _from(_piece(path), item, project.basis) or _from(other(), item, project.basis):
            continue
        if not from_source(project.basis, item):
            lost.append(_told(item))
    return lost


def items_of_pieces(project: Project, files: RecoveryFiles) -> None:
    """Put the items of all pieces into a project whose journal is lost, as they were when they were added."""
    for kind in ("rig", "motion"):
        for path in files.pieces(kind):
            piece = _piece(path)
            if piece is None:
                continue
            for rig in piece.rigs:
                if rig.id not in project.basis.rigs:
                    project.basis.rigs.insert(len(project.basis.rigs), rig)
                    _share(piece, project.basis, rig)
            for motion in piece.motions:
                if motion.id not in project.basis.motions:
                    project.basis.motions.insert(len(project.basis.motions), motion)
                    _share(piece, project.basis, motion)


def _piece(path: Path) -> BasisState | None:
    if not path.is_file():
        return None
    try:
        return store.load(path).basis
    except (InputError, OSError):
        return None


def _from(state: BasisState | None, item: RigItem | MotionItem, target: BasisState) -> bool:
    return state is not None and _share(state, target, item)


def from_source(state: BasisState, item: RigItem | MotionItem) -> bool:
    """Read what an item stands for from the file it came from, if that still has exactly this content."""
    if not item.source:
        return False
    try:
        if isinstance(item, RigItem):
            from engine.files.rig import read_rig

            file = read_rig(Path(item.source), item.unit or None)
            content = RigContent(file.rig, file.texture)
            if content.key != item.content:
                return False
            state.keep_rig(content, item.content)
        else:
            from studio.basis.loading import motion_of

            data = motion_of(Path(item.source), item.options).data
            if motion_key(data) != item.content:
                return False
            state.keep_motion(item.content, data)
    except (InputError, OSError, ValueError):  # gone, or of a name that this machine does not take
        return False
    return True


def salvage_contents(
    project: Project, header: ContentsHeader | None, connection: sqlite3.Connection, lost: list[str]
) -> int:
    """Read what can be read of a damaged file, and return how many rigs and performances are whole."""
    whole = sum(item.link is not None for item in project.basis.motions)
    items = (*project.basis.rigs, *(item for item in project.basis.motions if item.link is None))
    readings = basis_store.readings(project.basis, header, connection, "")
    for item, (_text, _stored, read) in zip(items, readings, strict=True):
        try:
            read()
        except (InputError, sqlite3.Error):
            if not from_source(project.basis, item):
                lost.append(_told(item))
                continue
        whole += 1
    return whole


def _told(item: RigItem | MotionItem) -> str:
    return f"the {'shapes' if isinstance(item, RigItem) else 'motion'} of {item.name[:40]}, whose place is kept"
