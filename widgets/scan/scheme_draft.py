"""A scheme while it is edited: every edit is a function from one draft to the next, so that undo is a list. No Qt."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from engine.landmarks import LandmarkDefinition, LandmarkScheme, Side
from engine.scan.scheme_vertices import resolved_vertex, scheme_findings, side_of_vertex, with_vertices
from engine.scan.template import FaceTemplate
from engine.scheme_checks import Finding

_SIDES = {"left": "right", "right": "left"}


@dataclass(frozen=True)
class DraftRow:
    """One fiducial of a draft; ``origin`` is the name it had when editing began, empty for a new one."""

    mark: LandmarkDefinition
    origin: str = ""


@dataclass(frozen=True)
class SchemeDraft:
    """A scheme that need not be right yet."""

    name: str
    title: str
    layout: str
    rows: tuple[DraftRow, ...]

    @classmethod
    def of(cls, scheme: LandmarkScheme, template: FaceTemplate) -> SchemeDraft:
        """Return the draft of a scheme, with the vertex number of every fiducial."""
        rows = tuple(DraftRow(mark, mark.name) for mark in with_vertices(template, scheme))
        return cls(scheme.name, scheme.title, scheme.layout, rows)

    @property
    def marks(self) -> tuple[LandmarkDefinition, ...]:
        """The fiducials in clicking order."""
        return tuple(row.mark for row in self.rows)

    @property
    def renames(self) -> dict[str, str]:
        """The new names of fiducials by those they had when editing began."""
        return {row.origin: row.mark.name for row in self.rows if row.origin and row.origin != row.mark.name}

    def scheme(self) -> LandmarkScheme:
        """Return the scheme; ``InputError`` when something is wrong with it."""
        return LandmarkScheme(self.name, self.title, self.marks, self.layout)

    def findings(self, template: FaceTemplate) -> tuple[Finding, ...]:
        """Return what is wrong with it or worth knowing, errors first."""
        return scheme_findings(template, self.name, self.title, self.layout, self.marks)

    def vertex(self, row: int, template: FaceTemplate) -> int | None:
        """Return the vertex of a row that is on the template."""
        vertex = resolved_vertex(template, self.layout, self.rows[row].mark)
        return vertex if vertex is not None and 0 <= vertex < len(template.mirror) else None

    def row_of(self, name: str) -> int | None:
        """Return the first row of a name."""
        return next((row for row, mark in enumerate(self.marks) if mark.name == name), None)

    def row_at(self, vertex: int, template: FaceTemplate) -> int | None:
        """Return the row that a vertex carries."""
        return next((row for row in range(len(self.rows)) if self.vertex(row, template) == vertex), None)

    # -- edits --------------------------------------------------------------------------------------------------------

    def changed(self, row: int, **fields: object) -> SchemeDraft:
        """Return the draft with some fields of one fiducial replaced, and nothing else."""
        mark = replace(self.rows[row].mark, **fields)  # type: ignore[arg-type]
        rows = (*self.rows[:row], replace(self.rows[row], mark=mark), *self.rows[row + 1 :])
        return replace(self, rows=rows)

    def renamed(self, row: int, name: str) -> SchemeDraft:
        """Return the draft with another name; mirrors that meant the old one follow."""
        old = self.rows[row].mark.name
        partner = self._partner(row)
        draft = self.changed(row, name=name)
        if self.rows[row].mark.mirror == old:
            draft = draft.changed(row, mirror=name)
        return draft if partner is None or partner == row else draft.changed(partner, mirror=name)

    def mirrored_with(self, row: int, name: str) -> SchemeDraft:
        """Return the draft in which the fiducial's mirror is ``name``, both ways; empty: it has none."""
        draft, partner = self, self._partner(row)
        if partner is not None and partner != row:
            draft = draft.changed(partner, mirror="")
        draft = draft.changed(row, mirror=name)
        other = draft.row_of(name) if name else None
        if other is None:
            return draft
        former = draft._partner(other)
        if former is not None and former not in (other, row):
            draft = draft.changed(former, mirror="")
        return draft.changed(other, mirror=draft.rows[row].mark.name)

    def placed(self, row: int, vertex: int, template: FaceTemplate) -> SchemeDraft:
        """Return the draft with a fiducial on another vertex; its side follows, and its partner goes to the mirror."""
        side = Side(side_of_vertex(template, vertex))
        draft = self.changed(row, vertex=vertex, side=side)
        mark, partner = draft.rows[row].mark, draft._partner(row)
        if side is Side.MIDDLE:
            if partner is not None and partner != row:
                draft = draft.changed(partner, mirror="")
            return draft.changed(row, mirror=mark.name)
        if partner == row:
            return draft.changed(row, mirror="")
        if partner is None:
            return draft
        return draft.changed(partner, vertex=int(template.mirror[vertex]), side=Side(_SIDES[side]))

    def added(self, after: int) -> SchemeDraft:
        """Return the draft with a new fiducial behind a row; it waits for its vertex."""
        group = self.rows[after].mark.group if self.rows else "face"
        mark = LandmarkDefinition(self.free_name("point"), group, Side.MIDDLE, "", "")
        return self._inserted(after + 1, DraftRow(mark))

    def duplicated(self, row: int) -> SchemeDraft:
        """Return the draft with a copy of a fiducial behind it; the copy waits for a vertex of its own."""
        mark = self.rows[row].mark
        return self._inserted(row + 1, DraftRow(replace(mark, name=self.free_name(mark.name), mirror="", vertex=None)))

    def deleted(self, row: int) -> SchemeDraft:
        """Return the draft without a fiducial; its partner has none then."""
        partner = self._partner(row)
        draft = self if partner in (None, row) else self.changed(int(partner or 0), mirror="")
        return replace(draft, rows=(*draft.rows[:row], *draft.rows[row + 1 :]))

    def moved(self, row: int, to: int) -> SchemeDraft:
        """Return the draft with a row at another place of the order."""
        rest = (*self.rows[:row], *self.rows[row + 1 :])
        return replace(self, rows=(*rest[:to], self.rows[row], *rest[to:]))

    def with_partner(self, row: int, template: FaceTemplate) -> SchemeDraft:
        """Return the draft with the fiducial's partner on the other side, made where there is none.

        Raises
        ------
        ValueError
            When the fiducial has no vertex yet, or lies in the middle.
        """
        vertex, mark = self.vertex(row, template), self.rows[row].mark
        if vertex is None:
            raise ValueError("it has no vertex yet")
        there = int(template.mirror[vertex])
        if there == vertex:
            raise ValueError("it lies in the middle")
        draft = self.changed(row, side=Side(side_of_vertex(template, vertex)))
        side = Side(_SIDES[draft.rows[row].mark.side])
        partner = self._partner(row)
        if partner is None or partner == row:
            partner = self.row_at(there, template)
        if partner is None:
            name = other_side(mark.name)
            known = self.row_of(name) if name != mark.name else None
            if known is not None and not self.rows[known].mark.mirror:
                partner = known
            else:
                name = self.free_name(name if name != mark.name else f"{mark.name}_{side}")
                new = replace(mark, name=name, side=side, mirror="", hint=other_side(mark.hint))
                draft, partner = draft._inserted(row + 1, DraftRow(new)), row + 1
        draft = draft.mirrored_with(row, draft.rows[partner].mark.name)
        return draft.changed(partner, vertex=there, side=side)

    def free_name(self, wanted: str) -> str:
        """Return ``wanted``, with a number behind it where it is taken."""
        taken = {mark.name for mark in self.marks}
        name, number = wanted, 2
        while name in taken:
            name, number = f"{wanted}_{number}", number + 1
        return name

    def _inserted(self, row: int, new: DraftRow) -> SchemeDraft:
        return replace(self, rows=(*self.rows[:row], new, *self.rows[row:]))

    def _partner(self, row: int) -> int | None:
        """Return the row that this one and its mirror agree on."""
        mark = self.rows[row].mark
        other = self.row_of(mark.mirror) if mark.mirror else None
        return other if other is not None and self.rows[other].mark.mirror == mark.name else None


def other_side(text: str) -> str:
    """Return a name or a sentence with left and right exchanged."""
    return re.sub("left|right", lambda found: _SIDES[found.group()], text)


class DraftHistory:
    """The drafts of one editing; edits of one field that follow each other are one step."""

    def __init__(self, draft: SchemeDraft) -> None:
        self._drafts, self._at, self._field = [draft], 0, ""

    @property
    def draft(self) -> SchemeDraft:
        """The present draft."""
        return self._drafts[self._at]

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to take back."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether a step was taken back."""
        return self._at + 1 < len(self._drafts)

    def push(self, draft: SchemeDraft, field: str = "") -> None:
        """Go on with another draft; ``field`` names what is being typed."""
        if draft == self.draft:
            return
        keep = self._at if field and field == self._field and self._at else self._at + 1
        self._drafts[keep:] = [draft]
        self._at, self._field = len(self._drafts) - 1, field

    def undo(self) -> None:
        """Take the last step back."""
        self._at, self._field = max(self._at - 1, 0), ""

    def redo(self) -> None:
        """Do it again."""
        self._at, self._field = min(self._at + 1, len(self._drafts) - 1), ""
