"""The fiducial schemes of a project: finding them by name, and what scans keep when one changes. No Qt."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from engine.errors import InputError
from engine.landmarks import Landmark, LandmarkScheme, LandmarkSet
from studio.project.checks import known_landmarks
from studio.scan.job import SCHEMES, check_custom, scheme_of

if TYPE_CHECKING:
    from studio.project.document import Project, ScanItem

MOST = 100
"""How many schemes a project may have."""

Schemes = Mapping[str, LandmarkScheme]


def find_scheme(schemes: Schemes, name: str) -> LandmarkScheme:
    """Return the scheme ``name``, one of ``schemes`` or one that is shipped.

    Raises
    ------
    InputError
        When there is no such scheme.
    """
    return schemes[name] if name in schemes else scheme_of(name)


def resolved(schemes: Schemes, item: ScanItem) -> ScanItem:
    """Return the item carrying the scheme that its name stands for; InputError when there is none of this name."""
    custom = None if item.scheme in SCHEMES else find_scheme(schemes, item.scheme)
    return item if item.custom == custom else replace(item, custom=custom)


def checked(schemes: Iterable[LandmarkScheme]) -> dict[str, LandmarkScheme]:
    """Return schemes by name once each of them can be used with the template that is shipped.

    Raises
    ------
    InputError
        On a name that is taken, too many schemes, or one that does not fit the template.
    """
    found: dict[str, LandmarkScheme] = {}
    for scheme in schemes:
        check_custom(scheme)
        if scheme.name in found:
            raise InputError(f"scheme {scheme.name}", "belongs to two schemes", "give one another name")
        found[scheme.name] = scheme
    if len(found) > MOST:
        raise InputError("schemes", f"are {len(found)}", f"keep {MOST} at most")
    return found


@dataclass(frozen=True)
class SchemeEdit:
    """Schemes, and what the scans they concern have: (name of the scheme, fiducials) by scan id."""

    schemes: Schemes
    scans: Mapping[str, tuple[str, LandmarkSet]]

    def apply(self, project: Project) -> None:
        """Set all of it at once."""
        changed = [
            replace(project.scan(scan_id), scheme=name, landmarks=landmarks)
            for scan_id, (name, landmarks) in self.scans.items()
        ]
        project.set_schemes(self.schemes, changed)


def present(project: Project, scan_ids: Iterable[str]) -> SchemeEdit:
    """Return what a project has now: its schemes, and what the scans of ``scan_ids`` have."""
    items = (project.scan(scan_id) for scan_id in scan_ids)
    return SchemeEdit(dict(project.schemes), {item.id: (item.scheme, item.landmarks) for item in items})


def put(project: Project, scheme: LandmarkScheme, replaces: str | None, renames: Mapping[str, str]) -> SchemeEdit:
    """Return what a project has after ``scheme`` was added, or took the place of its scheme ``replaces``.

    ``renames`` tells the new names of fiducials by their old ones: points go along on every scan that uses the scheme.
    Points whose name is in no scheme any more are taken off.

    Raises
    ------
    InputError
        When the scheme cannot be used, its name is taken, or what it replaces is not there.
    """
    if replaces is not None and replaces not in project.schemes:
        raise InputError(f"scheme {replaces}", "is not in the project", "add it as a new one")
    if scheme.name != replaces and scheme.name in project.schemes:
        raise InputError(f"scheme {scheme.name}", "is in the project already", "give it another name")
    wrong = [f"{old} to {new}" for old, new in renames.items() if new not in scheme]
    if wrong:
        raise InputError(f"scheme {scheme.name}", f"has no fiducial to rename {wrong[0]}", "rename to one it has")
    kept = [scheme if name == replaces else other for name, other in project.schemes.items()]
    schemes = checked(kept if replaces is not None else [*kept, scheme])
    return _edit(project, schemes, scheme.name, replaces, renames)


def remove(project: Project, name: str) -> SchemeEdit:
    """Return what a project has without its scheme ``name``; points that are in no scheme any more are taken off.

    Raises
    ------
    InputError
        When there is no such scheme, it is one that is shipped, or a scan uses it.
    """
    if name in SCHEMES:
        raise InputError(f"scheme {name}", "comes with the program", "leave it, or duplicate it to change it")
    if name not in project.schemes:
        raise InputError(f"scheme {name}", "is not in the project", "choose one of its schemes")
    users = users_of(project, name)
    if users:
        raise InputError(f"scheme {name}", f"is used by {', '.join(users[:5])}", "choose another scheme there first")
    return _edit(project, {key: value for key, value in project.schemes.items() if key != name}, name, None, {})


def users_of(project: Project, name: str) -> list[str]:
    """Return the names of the scans that use a scheme."""
    return [item.name for item in project.scans if item.scheme == name]


def _edit(
    project: Project, schemes: Schemes, name: str, replaces: str | None, renames: Mapping[str, str]
) -> SchemeEdit:
    known = known_landmarks(schemes.values())
    scans: dict[str, tuple[str, LandmarkSet]] = {}
    for item in project.scans:
        uses = item.scheme == replaces
        points: dict[str, Landmark] = {}
        moved: dict[str, Landmark] = {}
        for old, point in item.landmarks.points.items():
            if old in renames and (uses or old not in known):
                moved[renames[old]] = point
            elif old in known:
                points[old] = point
        # On a scan of another scheme, what is there under the new name is that scheme's own.
        landmarks = LandmarkSet({**points, **moved} if uses else {**moved, **points})
        after = (name if uses else item.scheme, landmarks)
        if after != (item.scheme, item.landmarks):
            scans[item.id] = after
    return SchemeEdit(dict(schemes), scans)
