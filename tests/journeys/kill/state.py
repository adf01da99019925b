"""What a project is, in one line, for both sides of the kill test."""

from __future__ import annotations

import hashlib

from studio.project import header as h
from studio.project.document import Project


def digest(project: Project) -> str:
    """Return a digest of all that edits can change; the range images count by their content."""
    parts = [h.SharedHeader.of(project).model_dump_json()]
    parts += [h.ItemHeader.of(item).model_dump_json() for item in project.scans]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:20]
