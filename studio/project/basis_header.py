"""Rigs, performances and the basis setup as the project file's header and the journal hold them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from engine.errors import InputError
from engine.name_text import LONGEST_NAME
from studio.basis.options import BasisOptions, MotionOptions
from studio.project.basis_items import MOST_EDITS, MOST_ITEMS, BasisSetup, MotionItem, RigItem
from studio.project.basis_state import BasisState
from studio.project.checks import check_name
from studio.project.linked import LinkedFile, place_of, relative_to
from studio.project.path_text import escaped, plain
from studio.project.shape_edit_text import edits_from, edits_text

Id = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
ArrayKey = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
Text = Annotated[
    str, Field(max_length=20_000), BeforeValidator(lambda value: escaped(value) if isinstance(value, str) else value)
]
Name = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]
Unit = Annotated[str, Field(max_length=16)]
Count = Annotated[int, Field(ge=0, le=1 << 40)]
MOST_NAMES = 10_000


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class LinkHeader(_Model):
    """``linked.LinkedFile``: where it is seen from the project, where it was, and how it is known again."""

    relative: Text = ""
    path: Text
    size: Count
    time_ns: int = Field(ge=-(1 << 62), le=1 << 62)
    digest: ArrayKey

    @classmethod
    def of(cls, link: LinkedFile, folder: Path | None) -> LinkHeader:
        """Return the header of a link; ``folder`` is that of the project, where it has one."""
        relative = "" if folder is None else relative_to(link.path, folder)
        return cls(relative=relative, path=str(link.path), size=link.size, time_ns=link.time_ns, digest=link.digest)

    def link(self, folder: Path | None) -> LinkedFile:
        """Return the link of the header; where the project lies decides where it is looked for first."""
        place = place_of(plain(self.relative), plain(self.path), folder)
        return LinkedFile(place, self.size, self.time_ns, self.digest)


class RigHeader(_Model):
    """``basis_items.RigItem``."""

    id: Id
    name: Name
    content: ArrayKey
    source: Text = ""
    unit: Unit = "mm"
    assumed: Text = ""
    format: Annotated[str, Field(max_length=40)] = ""
    edits: list[dict[str, Any]] = Field(default_factory=list, max_length=MOST_EDITS)

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_name(self.name)
        edits_from(self.edits)
        return self

    @classmethod
    def of(cls, item: RigItem) -> RigHeader:
        """Return the header of a rig."""
        return cls(**{**vars(item), "edits": edits_text(item.edits)})

    def item(self) -> RigItem:
        """Return the rig of the header."""
        values = {name: getattr(self, name) for name in ("id", "name", "content", "unit", "format")}
        texts = {"source": plain(self.source), "assumed": plain(self.assumed)}
        return RigItem(**values, **texts, edits=edits_from(self.edits))


class MotionHeader(_Model):
    """``basis_items.MotionItem``."""

    id: Id
    name: Name
    kind: Literal["markers", "weights", "dense"]
    content: ArrayKey
    source: Text = ""
    unit: Unit = "mm"
    assumed: Text = ""
    frames: Count = 0
    count: Count = 0
    fps: float = Field(default=0.0, ge=0.0, le=1e5)
    options: MotionOptions = Field(default_factory=MotionOptions)
    link: LinkHeader | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_name(self.name)
        return self

    @classmethod
    def of(cls, item: MotionItem, folder: Path | None) -> MotionHeader:
        """Return the header of a performance; ``folder`` is that of the project, where it has one."""
        return cls(**{**vars(item), "link": None if item.link is None else LinkHeader.of(item.link, folder)})

    def item(self, folder: Path | None) -> MotionItem:
        """Return the performance of the header."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        texts = {"source": plain(self.source), "assumed": plain(self.assumed)}
        return MotionItem(**{**values, **texts, "link": None if self.link is None else self.link.link(folder)})


class SetupHeader(_Model):
    """``basis_items.BasisSetup``."""

    hand: Id | None = None
    motion: Id | None = None
    driver: Id | None = None
    options: BasisOptions = Field(default_factory=BasisOptions)
    amounts: dict[Name, Annotated[float, Field(ge=0.0, le=1.0)]] = Field(default_factory=dict, max_length=MOST_NAMES)

    @classmethod
    def of(cls, setup: BasisSetup) -> SetupHeader:
        """Return the header of a setup."""
        return cls(**{**vars(setup), "amounts": dict(setup.amounts)})

    def setup(self) -> BasisSetup:
        """Return the setup of the header."""
        return BasisSetup(**{name: getattr(self, name) for name in type(self).model_fields})


class BasisHeader(_Model):
    """All of the basis stage that edits can change: what the file and the journal hold alike."""

    rigs: list[RigHeader] = Field(default_factory=list, max_length=MOST_ITEMS)
    motions: list[MotionHeader] = Field(default_factory=list, max_length=MOST_ITEMS)
    setup: SetupHeader = Field(default_factory=SetupHeader)

    @model_validator(mode="after")
    def _check(self) -> Self:
        for word, items in (("rig", self.rigs), ("performance", self.motions)):
            for values in ([item.id for item in items], [item.name for item in items]):
                double = sorted({value for value in values if values.count(value) > 1})
                if double:
                    raise InputError(f"{word} {double[0]!r}", "is there twice", "open an older copy of the project")
        return self

    @classmethod
    def of(cls, state: BasisState, folder: Path | None) -> BasisHeader | None:
        """Return the header of what a project has for the basis stage; None where it has nothing."""
        if state.is_empty:
            return None
        return cls(
            rigs=[RigHeader.of(item) for item in state.rigs],
            motions=[MotionHeader.of(item, folder) for item in state.motions],
            setup=SetupHeader.of(state.setup),
        )

    def give(self, state: BasisState, folder: Path | None) -> None:
        """Set it in a project that has none of it; contents follow."""
        for rig in self.rigs:
            state.rigs.insert(len(state.rigs), rig.item())
        for motion in self.motions:
            state.motions.insert(len(state.motions), motion.item(folder))
        state.set_setup(self.setup.setup())


class RigDataHeader(_Model):
    """The arrays of a ``basis_items.RigContent`` by key, and the names they go with."""

    vertices: ArrayKey
    faces: ArrayKey
    uv: ArrayKey | None = None
    uv_faces: ArrayKey | None = None
    parts: dict[Name, ArrayKey] = Field(default_factory=dict, max_length=1_000)
    names: list[Name] = Field(max_length=MOST_NAMES)
    displacements: ArrayKey
    mean: ArrayKey | None = None
    texture: ArrayKey | None = None


class MotionDataHeader(_Model):
    """Marker positions, weights, or positions of a mesh by key, and the names they go with."""

    kind: Literal["markers", "weights", "dense"]
    names: list[Name] = Field(default_factory=list, max_length=MOST_NAMES)
    fps: float = Field(gt=0, le=1e5)
    values: ArrayKey
    scale: float = Field(default=1.0, gt=0, le=1e6)
    axes: ArrayKey | None = None


class ContentsHeader(_Model):
    """What the items of a project stand for, by their content key; linked performances are not among them."""

    rigs: dict[ArrayKey, RigDataHeader] = Field(default_factory=dict, max_length=MOST_ITEMS)
    motions: dict[ArrayKey, MotionDataHeader] = Field(default_factory=dict, max_length=MOST_ITEMS)
