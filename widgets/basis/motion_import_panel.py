"""How a performance is read: unit, axes, frame rate, head markers and rest frame, with a preview of it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QSlider,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from engine.errors import InputError
from engine.files.mesh_unit import mm_per_unit, scaled_unit
from engine.files.motion_axes import AXES
from engine.motion import MarkerClip, WeightCurves
from widgets import theme
from widgets.basis.motion_import_values import MotionChoice, MotionImportFacts, points_at, rows_of
from widgets.basis.motion_preview import MotionPreview
from widgets.basis.tracks_table import TracksTable
from widgets.parts.buttons import KeyButton
from widgets.parts.frame_field import FrameField
from widgets.parts.section import DimLabel

WIDTH, HEIGHT, SIDE = 1120, 680, 392
_FASTEST = 100_000.0


class MotionImportPanel(QWidget):
    """Facts in, a choice out: the owner reads the file again under each choice and shows the new facts.

    Signals
    -------
    changed(MotionChoice)
        The user wants it read otherwise. Unit and axes are previewed before the answer comes.
    pairs_requested(), pairs_dropped()
        Choose a pairs file; do without it.
    accepted(MotionChoice), rejected()
        Import as shown; think better of it.
    """

    changed = Signal(object)
    pairs_requested = Signal()
    pairs_dropped = Signal()
    accepted = Signal(object)
    rejected = Signal()

    def __init__(self, verb: str = "Import performance", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._facts: MotionImportFacts | None = None
        self._choice = MotionChoice()
        self._head: tuple[str, ...] = ()
        self._showing = False
        self.preview = MotionPreview()
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setAccessibleName("Frame")
        self.slider.setPageStep(100)
        self.frame = FrameField("Frame number", "The frame that is shown")
        self.use_rest = QPushButton("Use as &rest frame")
        self.use_rest.setAutoDefault(False)
        self.use_rest.setToolTip("This frame shows the neutral face")
        self.unit = _list(("mm", "cm", "m"), "What one unit of the file is: mm, cm, m, or millimetres, as 85.3 mm")
        self.unit.setEditable(True)
        self.up = _list(AXES, "The file's axis that points up")
        self.forward = _list(AXES, "The file's axis that points out of the face")
        self.fps = QDoubleSpinBox()
        self.fps.setRange(0.001, _FASTEST)
        self.fps.setDecimals(3)
        self.fps.setKeyboardTracking(False)
        self.fps.setToolTip("Frames a second")
        self.rest = QSpinBox()
        self.rest.setKeyboardTracking(False)
        self.rest.setToolTip("The frame that shows the neutral face")
        self.pairs = QPushButton("&Pairs...")
        self.pairs.setAutoDefault(False)
        self.pairs.setToolTip("A file that says which marker sits where on the face (.json)")
        self.drop_pairs = QPushButton("Nearest")
        self.drop_pairs.setAutoDefault(False)
        self.drop_pairs.setToolTip("Leave the pairs and bind each marker to the nearest place on the face")
        self.marks: dict[str, DimLabel] = {
            key: DimLabel("", theme.TABLE_PX) for key in ("unit", "up", "forward", "fps")
        }
        self.scale = QCheckBox("Fit the performer's si&ze")
        self.scale.setToolTip("Scale the markers as well as turning and moving them onto the face")
        self.pairs_note = DimLabel("", theme.TABLE_PX)
        self.table = TracksTable()
        self.table_note = DimLabel("", theme.TABLE_PX)
        self.as_head, self.as_face = QPushButton("Ma&ke head"), QPushButton("Make &face")
        self.propose = QPushButton("Propose &head")
        for button, tip in (
            (self.as_head, "The selected markers move with the skull alone"),
            (self.as_face, "The selected markers move with the face"),
            (self.propose, "Find the markers that move rigidly together"),
        ):
            button.setAutoDefault(False)
            button.setToolTip(tip)
        self.note = DimLabel("", theme.TABLE_PX)
        self.alarm = DimLabel("", theme.TABLE_PX, role="stale_text")
        for label in (self.note, self.alarm):
            label.setWordWrap(True)
        self.cancel = KeyButton("Cancel", "Esc")
        self.accept = KeyButton(verb, primary=True)
        self.accept.setDefault(True)
        self._lay_out()
        self._connect()
        theme.signals.changed.connect(self._dress)
        self._dress()

    @property
    def choice(self) -> MotionChoice:
        """What is chosen now."""
        return self._choice

    def show_facts(self, facts: MotionImportFacts, choice: MotionChoice | None = None) -> None:
        """Show a performance as it was read; ``choice`` is what it was read under, as before where left out."""
        self._showing = True
        self._facts = facts
        self._choice = self._choice if choice is None else choice
        self._head = self._choice.head if self._choice.head is not None else facts.head
        clip, curves = isinstance(facts.data, MarkerClip), isinstance(facts.data, WeightCurves)
        self.unit.setCurrentText(self._choice.unit or facts.unit)
        self.up.setCurrentText(self._choice.up or facts.up)
        self.forward.setCurrentText(self._choice.forward or facts.forward)
        self.fps.setValue(self._choice.fps or facts.data.fps)
        length = len(facts.data)
        bound_rest = 0 if facts.bound is None else facts.bound.rest_frame
        rest = bound_rest if self._choice.rest_frame is None else self._choice.rest_frame
        self.slider.setRange(0, length - 1)
        self.frame.setRange(1, length)
        self.frame.fit(max(length, 1000))
        self.rest.setRange(1, length)
        self.rest.setValue(rest + 1)
        for key, label in self.marks.items():
            label.set_role("stale_text")
            label.setText("assumed" if key in facts.guessed else "")
        for name, shown in (("space", not curves), ("rest", clip), ("markers", clip)):
            for widget in self._groups[name]:
                widget.setVisible(shown)
        self.scale.setChecked(self._choice.scale)
        self.drop_pairs.setVisible(clip and facts.pairs > 0)
        self.pairs_note.setText(f"{facts.pairs} paired" if facts.pairs else "nearest place on the face")
        self.note.setText(facts.assumed)
        self.alarm.set_role("captured" if facts.problem else "stale_text")
        self.alarm.setText(facts.problem or "\n".join(facts.warnings))
        self.alarm.setVisible(bool(self.alarm.text()))
        self.accept.set_available(not facts.problem, facts.problem)
        self.preview.set_pending(False)
        self.preview.show_mesh(facts.mesh)
        self.preview.show_note(_curves_note(facts) if curves else "")
        self._showing = False
        self._show_rows()
        self._show_frame()

    def show_pending(self, text: str, busy: bool = False) -> None:
        """Say that the file is being read again (``busy``) or cannot be; empty once it has been."""
        self.preview.set_pending(bool(text))
        self.accept.set_available(not text, "the file is being read under this choice" if busy else text)
        self.alarm.set_role("dim")
        self.alarm.setText(text)
        self.alarm.setVisible(bool(text))

    # Inside -------------------------------------------------------------------------------------------------------

    def _change(self, **values: object) -> None:
        if self._showing or self._facts is None:
            return
        choice = replace(self._choice, **values)  # type: ignore[arg-type]
        if choice != self._choice:
            self._choice = choice
            for key in self.marks:
                if getattr(choice, key) is not None:
                    self.marks[key].setText("")
            self._show_frame()
            self.changed.emit(choice)

    def _choose_unit(self) -> None:
        if self._facts is None or self._showing:
            return
        typed = self.unit.currentText().strip()
        try:
            unit = scaled_unit(mm_per_unit(f"{typed} mm" if typed.replace(".", "", 1).isdigit() else typed))
        except InputError as error:
            self.alarm.set_role("captured")
            self.alarm.setText(str(error))
            self.alarm.show()
            return
        self.unit.setCurrentText(unit)
        if unit != (self._choice.unit or self._facts.unit):
            self._change(unit=unit)

    def _choose_axis(self, key: str, name: str) -> None:
        facts = self._facts
        if facts is None or self._showing:
            return
        axes = {"up": self._choice.up or facts.up, "forward": self._choice.forward or facts.forward, key: name}
        other = "forward" if key == "up" else "up"
        if axes["up"][-1] == axes["forward"][-1]:
            # The other one must leave its line: a choice that cannot be is never sent.
            axes[other] = next(axis for axis in ("z", "-y") if axis[-1] != name[-1])
        self._showing = True
        self.up.setCurrentText(axes["up"])
        self.forward.setCurrentText(axes["forward"])
        self._showing = False
        self._change(up=axes["up"], forward=axes["forward"])

    def _set_role(self, rows: tuple[int, ...], head: bool | None) -> None:
        """Make rows head or face; None turns each over."""
        if self._facts is None or not rows:
            return
        listed = self.table.tracks.rows
        chosen = set(self._head)
        for row in rows:
            label = listed[row].label
            wanted = label not in chosen if head is None else head
            chosen = chosen | {label} if wanted else chosen - {label}
        self._head = tuple(row.label for row in listed if row.label in chosen)
        self._show_rows()
        self._change(head=self._head)

    def _show_rows(self) -> None:
        if self._facts is None:
            return
        rows = rows_of(self._facts, self._head)
        self.table.show_rows(rows)
        count = sum(row.role == "face" for row in rows)
        self.table_note.setText(f"{count} on the face, {len(self._head)} on the head")

    def _show_frame(self) -> None:
        facts = self._facts
        if facts is None:
            return
        index = self.slider.value()
        self.frame.show_value(index + 1)
        points = points_at(facts, self._choice, index)
        rows = self.table.tracks.rows if isinstance(facts.data, MarkerClip) else ()
        roles = [row.role for row in rows] if len(rows) == len(points) else []
        self.preview.show_points(points, [row.label for row in rows], roles)
        if isinstance(facts.data, MarkerClip):
            empty = not np.isfinite(points).any()
            self.preview.show_note("This frame shows no marker" if empty else "")

    def _lay_out(self) -> None:
        form = QGridLayout()
        form.setHorizontalSpacing(8)
        form.setVerticalSpacing(8)
        form.setColumnStretch(2, 1)
        self._groups: dict[str, list[QWidget]] = {"space": [], "rest": [], "markers": []}
        lines: tuple[tuple[str, str, QWidget, QWidget | None], ...] = (
            ("&Unit", "space", self.unit, self.marks["unit"]),
            ("U&p axis", "space", self.up, self.marks["up"]),
            ("For&ward axis", "space", self.forward, self.marks["forward"]),
            ("Frame r&ate", "", self.fps, self.marks["fps"]),
            ("Rest fra&me", "rest", self.rest, None),
            ("Binding", "markers", self.pairs, self.pairs_note),
        )
        for row, (text, group, field, mark) in enumerate(lines):
            label = QLabel(text)
            label.setBuddy(field)
            field.setAccessibleName(text.replace("&", ""))
            form.addWidget(label, row, 0)
            form.addWidget(field, row, 1, Qt.AlignmentFlag.AlignLeft)
            if mark is not None:
                form.addWidget(mark, row, 2)
            if group:
                self._groups[group] += [label, field, *([mark] if mark is not None else [])]
        form.addWidget(self.drop_pairs, len(lines) - 1, 3)
        form.addWidget(self.scale, len(lines), 1, 1, 3)
        self._groups["markers"].append(self.scale)
        roles = QHBoxLayout()
        roles.setSpacing(8)
        for button in (self.as_head, self.as_face, self.propose):
            roles.addWidget(button)
        roles.addStretch(1)
        self._groups["markers"] += [self.table, self.table_note, self.as_head, self.as_face, self.propose]
        self._groups["rest"] += [self.use_rest]
        side = QVBoxLayout()
        side.setContentsMargins(0, 0, 0, 0)
        side.setSpacing(8)
        side.addLayout(form)
        side.addWidget(self.table, 1)
        side.addWidget(self.table_note)
        side.addLayout(roles)
        side.addWidget(self.note)
        side.addWidget(self.alarm)
        side.addStretch(0)
        self._side = QWidget()
        self._side.setLayout(side)
        scrub = QHBoxLayout()
        scrub.setSpacing(8)
        scrub.addWidget(self.slider, 1)
        scrub.addWidget(self.frame)
        scrub.addWidget(self.use_rest)
        left = QVBoxLayout()
        left.setSpacing(8)
        left.addWidget(self.preview, 1)
        left.addLayout(scrub)
        middle = QHBoxLayout()
        middle.setSpacing(16)
        middle.addLayout(left, 1)
        middle.addWidget(self._side)
        foot = QHBoxLayout()
        foot.setSpacing(8)
        foot.addStretch(1)
        foot.addWidget(self.cancel)
        foot.addWidget(self.accept)
        box = QVBoxLayout(self)
        box.setContentsMargins(16, 16, 16, 16)
        box.setSpacing(16)
        box.addLayout(middle, 1)
        box.addLayout(foot)
        order = (
            self.unit, self.up, self.forward, self.fps, self.rest, self.pairs, self.drop_pairs, self.scale,
            self.table, self.as_head, self.as_face, self.propose, self.slider, self.frame, self.use_rest,
            self.cancel, self.accept,
        )  # fmt: skip
        for first, second in pairwise(order):
            QWidget.setTabOrder(first, second)

    def _connect(self) -> None:
        self.unit.activated.connect(lambda _row: self._choose_unit())
        line = self.unit.lineEdit()
        assert line is not None
        line.editingFinished.connect(self._choose_unit)
        self.up.activated.connect(lambda row: self._choose_axis("up", self.up.itemText(row)))
        self.forward.activated.connect(lambda row: self._choose_axis("forward", self.forward.itemText(row)))
        self.fps.valueChanged.connect(lambda value: self._change(fps=value))
        self.rest.valueChanged.connect(lambda value: self._change(rest_frame=value - 1))
        self.use_rest.clicked.connect(lambda: self.rest.setValue(self.slider.value() + 1))
        self.slider.valueChanged.connect(lambda _value: self._show_frame())
        self.frame.valueChanged.connect(lambda value: self.slider.setValue(value - 1))
        self.scale.toggled.connect(lambda on: self._change(scale=on))
        self.pairs.clicked.connect(self.pairs_requested)
        self.drop_pairs.clicked.connect(self.pairs_dropped)
        self.table.toggled.connect(lambda rows: self._set_role(rows, None))
        self.table.chosen.connect(self.preview.show_selected)
        self.preview.picked.connect(self.table.select)
        self.as_head.clicked.connect(lambda: self._set_role(self.table.selected(), True))
        self.as_face.clicked.connect(lambda: self._set_role(self.table.selected(), False))
        self.propose.clicked.connect(self._propose)
        self.cancel.clicked.connect(self.rejected)
        self.accept.clicked.connect(lambda: self.accepted.emit(self._choice))

    def _propose(self) -> None:
        from engine.basis.head import propose_head

        if self._facts is not None and isinstance(self._facts.data, MarkerClip):
            found = propose_head(self._facts.data)
            self._head = found
            self._show_rows()
            self._change(head=found)
            if not found:
                self.table_note.setText("no three markers move rigidly together")

    def _dress(self) -> None:
        self._side.setFixedWidth(theme.px(SIDE))
        for field in (self.unit, self.up, self.forward, self.fps, self.rest):
            theme.fix(field, width=112)


def _list(texts: tuple[str, ...], tip: str) -> QComboBox:
    box = QComboBox()
    box.addItems(list(texts))
    box.setToolTip(tip)
    box.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
    return box


def _curves_note(facts: MotionImportFacts) -> str:
    curves = facts.data
    assert isinstance(curves, WeightCurves)
    return f"{len(curves.names)} curves of {len(curves)} frames\ndrive the shapes of a rig that have their names"
