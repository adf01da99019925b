"""The project while it is open: scans, fiducials, options and the results made from them. No Qt.

Only commands (``studio.scan.commands``) change a project; everybody else reads it and subscribes to its changes.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

from engine.errors import InputError
from engine.landmarks import LandmarkScheme, LandmarkSet
from engine.scan.limits import Limits
from studio.project.basis_state import BasisKind, BasisState
from studio.project.keys import array_key as array_key
from studio.project.keys import content_key as content_key
from studio.project.keys import new_id as new_id
from studio.project.schemes import resolved
from studio.scan.job import changes, input_key, item_scheme, missing_fiducials, usable_fiducials
from studio.scan.options import FitOptions

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from engine.scan.mesh_view import MeshView
    from engine.scan.range_image import RangeImage

ScanKind = Literal["added", "removed", "name", "landmarks", "scheme", "options", "source", "fit"]
ChangeKind = Literal["project", "schemes", "limits"] | ScanKind | BasisKind
StateKind = Literal["missing", "stale", "fresh"]

SUFFIX = ".qface"
"""Ending of a project's file."""

FEWEST_FIDUCIALS = 4
"""Below this many placed points no fit is offered (three always lie on some plane map, without any bending)."""


@dataclass(frozen=True)
class Change:
    """What has changed: the kind, and the id of the item (empty for the project itself)."""

    kind: ChangeKind
    id: str = ""


@dataclass(frozen=True)
class ItemState:
    """Whether there is a result and whether it belongs to the present inputs; ``reason`` says why not, in words."""

    kind: StateKind
    reason: str = ""


@dataclass(frozen=True)
class SourceInfo:
    """Where a scan came from and what was found in it.

    ``depth_file`` is the path it was read from, ``unit`` the unit of the file, ``assumed`` what the reader had to
    assume (empty when nothing), ``missing_fraction`` the share of pixels without a point, ``spikes`` their count.
    ``view`` is where the camera stood before a mesh (None for a range image), ``view_asked`` whether the user put it
    there.
    """

    depth_file: str = ""
    unit: str = "mm"
    assumed: str = ""
    width: int = 0
    height: int = 0
    missing_fraction: float = 0.0
    spikes: int = 0
    view: MeshView | None = None
    view_asked: bool = False

    @property
    def unit_asked(self) -> bool:
        """Whether the user chose the unit."""
        return self.assumed.startswith(f"{self.unit}, as asked")

    @property
    def unit_open(self) -> bool:
        """Whether the unit was assumed or chosen, so that another may be meant; else the file states it."""
        return self.unit_asked or self.assumed.startswith(f"{self.unit} assumed")


@dataclass(frozen=True)
class ScanItem:
    """One scan of a project; a change makes a new item.

    ``word`` is the word that was spoken and ``held`` its letters that were held, both empty for the base face.
    ``image_key`` names the scan's content (``content_key``). ``scheme`` names a shipped scheme or one of the project's
    own; that one the project hands to the item as ``custom``.
    """

    id: str
    name: str
    image_key: str
    word: str = ""
    held: str = ""
    source: SourceInfo = field(default_factory=SourceInfo)
    scheme: str = "closed"
    landmarks: LandmarkSet = field(default_factory=lambda: LandmarkSet({}))
    options: FitOptions = field(default_factory=lambda: FitOptions())
    custom: LandmarkScheme | None = None


_ASPECTS: tuple[tuple[ChangeKind, Callable[[ScanItem], object]], ...] = (
    ("name", lambda item: (item.name, item.word, item.held)),
    ("source", lambda item: (item.source, item.image_key)),
    ("scheme", lambda item: (item.scheme, item.custom)),
    ("landmarks", lambda item: item.landmarks),
    ("options", lambda item: item.options),
)


class Project:
    """The scans of one project, their pictures and their fits; ``basis`` holds its rigs and performances.

    Scans and fits are kept by content key beside the undo stack: the range image of a removed scan stays as long as the
    project is open, and of the fits the ones made last, up to ``keep_fits`` and ``keep_bytes`` (but always the last one
    of every scan). So undo back to old inputs finds their fit again and is fresh at once.
    """

    def __init__(
        self,
        name: str = "Untitled",
        path: Path | None = None,
        keep_fits: int = 64,
        keep_bytes: int = 256 * 1024 * 1024,
    ) -> None:
        self._name = name
        self._path = path
        self._keep_fits, self._keep_bytes = keep_fits, keep_bytes
        self._scans: tuple[ScanItem, ...] = ()
        self._schemes: dict[str, LandmarkScheme] = {}
        self._images: dict[str, RangeImage] = {}
        self._fits: OrderedDict[str, FaceFit] = OrderedDict()
        self._last: dict[str, str] = {}
        self._limits = Limits()
        self._callbacks: list[Callable[[Change], None]] = []
        self.basis = BasisState(self._tell)

    # -- reading ------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """What the project is called: its file's name, or "Untitled"."""
        return self._name

    @property
    def path(self) -> Path | None:
        """The file it was last saved to or opened from."""
        return self._path

    @property
    def scans(self) -> tuple[ScanItem, ...]:
        """All scans, in the order of the list."""
        return self._scans

    @property
    def limits(self) -> Limits:
        """What fits are judged by."""
        return self._limits

    @property
    def schemes(self) -> Mapping[str, LandmarkScheme]:
        """Its own fiducial schemes by name, beside those that are shipped."""
        return MappingProxyType(self._schemes)

    def scan(self, scan_id: str) -> ScanItem:
        """Return one scan; KeyError when there is none of this id."""
        for item in self._scans:
            if item.id == scan_id:
                return item
        raise KeyError(scan_id)

    def __contains__(self, scan_id: object) -> bool:
        return any(item.id == scan_id for item in self._scans)

    def index(self, scan_id: str) -> int:
        """Return the place of a scan in the list; KeyError when there is none of this id."""
        return self._scans.index(self.scan(scan_id))

    def range_image(self, scan_id: str) -> RangeImage:
        """Return the scan itself."""
        return self._images[self.scan(scan_id).image_key]

    def image(self, image_key: str) -> RangeImage | None:
        """Return the scan of a content key, if the project holds it."""
        return self._images.get(image_key)

    def fit(self, scan_id: str) -> FaceFit | None:
        """Return the fit of the present inputs where there is one, else the last that was made, else None."""
        key = self.fit_key(scan_id)
        return None if key is None else self._fits[key]

    def fit_key(self, scan_id: str) -> str | None:
        """Return the input key of what ``fit`` returns."""
        present = input_key(self.scan(scan_id))
        if present in self._fits:
            return present
        last = self._last.get(scan_id)
        return last if last in self._fits else None

    def last_key(self, scan_id: str) -> str | None:
        """Return the input key of the result that was put last, whether it is still kept or not."""
        return self._last.get(scan_id)

    def has_fit(self, key: str) -> bool:
        """Whether the fit of an input key is kept."""
        return key in self._fits

    def kept_fit(self, key: str) -> FaceFit | None:
        """Return the fit of an input key, if it is kept."""
        return self._fits.get(key)

    def state(self, scan_id: str) -> ItemState:
        """Derive a scan's state: missing (what is needed), stale (what changed) or fresh."""
        item = self.scan(scan_id)
        needed = needs(item)
        if needed:
            return ItemState("missing", needed)
        key = self.fit_key(scan_id)
        if key is None:
            return ItemState("missing", "no fit yet")
        differs = changes(key, input_key(item))
        return ItemState("stale", ", ".join(differs)) if differs else ItemState("fresh")

    def summary(self) -> ItemState:
        """Derive the state of the whole stage: that of its first scan that is not fresh, named."""
        for kind in ("missing", "stale"):
            for item in self._scans:
                state = self.state(item.id)
                if state.kind == kind:
                    return ItemState(state.kind, f"{item.name}: {state.reason}")
        return ItemState("fresh") if self._scans else ItemState("missing", "no scans")

    def unique_name(self, wanted: str, besides: str | None = None) -> str:
        """Return ``wanted``, with a number behind it where another scan than ``besides`` has that name."""
        taken = {item.name for item in self._scans if item.id != besides}
        name, number = wanted, 2
        while name in taken:
            name, number = f"{wanted} {number}", number + 1
        return name

    # -- listening ----------------------------------------------------------------------------------------------

    def subscribe(self, callback: Callable[[Change], None]) -> Callable[[], None]:
        """Call ``callback`` after every change; returns what ends it."""
        self._callbacks.append(callback)

        def unsubscribe() -> None:
            if callback in self._callbacks:
                self._callbacks.remove(callback)

        return unsubscribe

    def _tell(self, kind: ChangeKind, scan_id: str = "") -> None:
        for callback in tuple(self._callbacks):
            callback(Change(kind, scan_id))

    def _tell_aspects(self, old: ScanItem, new: ScanItem) -> None:
        for kind, aspect in _ASPECTS:
            if aspect(old) != aspect(new):
                self._tell(kind, new.id)

    # -- changing (for commands and the store) ---------------------------------------------------------------------

    def set_path(self, path: Path) -> None:
        """Say where the project is stored; it is named after its file."""
        path = Path(path)
        if path != self._path:
            self._path, self._name = path, path.stem
            self._tell("project")

    def set_limits(self, limits: Limits) -> None:
        """Judge fits by other limits; no fit becomes stale by it."""
        if limits != self._limits:
            self._limits = limits
            self._tell("limits")

    def add_image(self, scan: RangeImage) -> str:
        """Keep a scan beside the undo stack and return its content key; changes nothing that is seen."""
        key = content_key(scan)
        self._images.setdefault(key, scan)
        return key

    def insert_scan(self, index: int, item: ScanItem, scan: RangeImage | None = None) -> None:
        """Put a scan into the list; its range image is only needed when the project does not hold it yet.

        Raises
        ------
        InputError
            When the id is already there, or the range image or the scheme is not.
        """
        if item.id in self:
            raise InputError(f"scan {item.name}", "is already in the project", "add it once")
        if scan is not None:
            self._images.setdefault(item.image_key, scan)
        if item.image_key not in self._images:
            raise InputError(f"scan {item.name}", "comes without its range image", "add it from its file again")
        index, item = max(0, min(index, len(self._scans))), resolved(self._schemes, item)
        self._scans = (*self._scans[:index], item, *self._scans[index:])
        self._tell("added", item.id)

    def remove_scan(self, scan_id: str) -> ScanItem:
        """Take a scan out of the list; its range image and fits stay for undo."""
        item = self.scan(scan_id)
        self._scans = tuple(other for other in self._scans if other.id != scan_id)
        self._tell("removed", scan_id)
        return item

    def replace_scan(self, item: ScanItem) -> None:
        """Put a changed item in the place of the one with its id, and tell which sides of it changed."""
        index, item = self.index(item.id), resolved(self._schemes, item)
        old = self._scans[index]
        if item.image_key not in self._images:
            raise InputError(f"scan {item.name}", "comes without its range image", "add it from its file again")
        self._scans = (*self._scans[:index], item, *self._scans[index + 1 :])
        self._tell_aspects(old, item)

    def change_scan(self, scan_id: str, **fields: Any) -> None:
        """Replace some fields of a scan."""
        self.replace_scan(replace(self.scan(scan_id), **fields))

    def set_schemes(self, schemes: Mapping[str, LandmarkScheme], changed: Iterable[ScanItem] = ()) -> None:
        """Set the project's own schemes, and with them the scans that they change; each still finds its scheme."""
        before = {item.id: item for item in self._scans}
        after = before | {item.id: item for item in changed}
        self._scans = tuple(resolved(schemes, item) for item in after.values())
        self._schemes = dict(schemes)
        self._tell("schemes")
        for item in self._scans:
            self._tell_aspects(before[item.id], item)

    def put_fit(self, scan_id: str, key: str, fit: FaceFit) -> None:
        """Keep a result under the key of the inputs it was made from, as the last one of the scan.

        This is not an edit: it may happen at any time, also between undo and redo, and loses no step of theirs.
        A scan that has been removed meanwhile keeps its result for undo.
        """
        self.keep_fit(key, fit)
        self.set_last(scan_id, key)

    def keep_fit(self, key: str, fit: FaceFit) -> None:
        """Keep a result by its key only; the oldest beyond the limits are dropped, but never the last of a scan."""
        self._fits[key] = fit
        self._fits.move_to_end(key)
        held = set(self._last.values()) | {input_key(item) for item in self._scans} | {key}
        size = sum(map(_bytes, self._fits.values()))
        for old in [k for k in self._fits if k not in held]:
            if len(self._fits) <= self._keep_fits and size <= self._keep_bytes:
                break
            size -= _bytes(self._fits.pop(old))

    def set_last(self, scan_id: str, key: str | None) -> None:
        """Say which result is the last one of a scan; None: it has none."""
        if key is None:
            self._last.pop(scan_id, None)
        else:
            self._last[scan_id] = key
        self._tell("fit", scan_id)


def needs(item: ScanItem) -> str:
    """Return what a scan needs before it can be fitted, in words; empty when it can be."""
    scheme = item_scheme(item)
    unset, proposed = missing_fiducials(item.landmarks, scheme)
    placed = usable_fiducials(item.landmarks, scheme)
    if not placed and not proposed:
        return "no fiducials"
    parts = []
    if unset:
        parts.append(f"{_count(len(unset))} to place")
    if proposed:
        parts.append(f"{len(proposed)} to confirm" if parts else f"{_count(len(proposed))} to confirm")
    if not parts and len(placed) < FEWEST_FIDUCIALS:
        return f"{FEWEST_FIDUCIALS - len(placed)} more to place (too many are skipped)"
    return ", ".join(parts)


def _bytes(fit: FaceFit) -> int:
    mesh = fit.mesh
    arrays = (mesh.vertices, mesh.faces, mesh.uv, fit.normals, fit.pixels, fit.filled, fit.deviation_mm)
    return sum(array.nbytes for array in arrays if array is not None)


def _count(number: int) -> str:
    return f"{number} fiducial" + ("" if number == 1 else "s")
