"""What was made of a rig and a performance, what it was made of, and whether that is still so. No Qt."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from engine.mesh import FloatArray
from engine.progress import Progress, part, silent
from studio.basis.options import BasisOptions
from studio.project.basis_items import BasisSetup, MotionItem, RigItem
from studio.project.basis_state import BasisState
from studio.project.document import ItemState
from studio.project.shape_edit_text import edits_text

if TYPE_CHECKING:
    from engine.basis.compare import Comparison
    from engine.shapes import ExpressionBasis, Rig
    from studio.basis.job import BasisResult
    from studio.basis.motions import PreparedMotion
    from studio.project.basis_items import MotionData


@dataclass(frozen=True)
class InputsKey:
    """Everything that a basis depends on, one text for each thing that may change."""

    hand: str
    motion: str
    driver: str
    options: str

    @property
    def of_motion(self) -> tuple[str, str, str]:
        """What the motion of the rig depends on: its mesh, the recording, and the rig that drives it."""
        return self.hand.partition(" ")[0], self.motion, self.driver


_REASONS = {"hand": "shapes changed", "motion": "performance changed", "driver": "driving rig changed"}


def changes(old: InputsKey, new: InputsKey) -> tuple[str, ...]:
    """Return what differs between two keys, in words."""
    found = [why for name, why in _REASONS.items() if getattr(old, name) != getattr(new, name)]
    return (*found, *(("options changed",) if old.options != new.options else ()))


def needs(basis: BasisState) -> str:
    """Return what is needed before a basis can be made, in words; empty where nothing is."""
    hand, motion = basis.hand, basis.motion
    if hand is None:
        return "open a hand-sculpted rig" if not basis.rigs.all else "choose the hand-sculpted rig"
    if basis.lacks(hand):
        return basis.lacks(hand)
    if motion is None:
        return "open a performance" if not basis.motions.all else "choose the performance"
    if basis.motion_data(motion.content) is None and (motion.link is None or motion.link.state() != "there"):
        return basis.lacks(motion)
    driver = basis.driver
    return "" if driver is None or driver is hand else basis.lacks(driver)


def inputs_key(basis: BasisState) -> InputsKey | None:
    """Return the key of what the basis would be made of now; None while something is missing."""
    hand, motion = basis.hand, basis.motion
    if hand is None or motion is None or needs(basis):
        return None
    driver = basis.driver
    return InputsKey(
        _rig_text(hand), _motion_text(motion), _driver_text(driver, hand, motion), _options_text(basis.setup.options)
    )


def state_of(basis: BasisState, made: InputsKey | None, trouble: str = "") -> ItemState:
    """Derive the state of the stage from the key of the result that is shown, if there is one."""
    needed = needs(basis)
    if needed:
        return ItemState("missing", needed)
    key = inputs_key(basis)
    if made is None or key is None:
        return ItemState("missing", trouble or "no basis yet")
    differs = changes(made, key)
    return ItemState("stale", trouble or ", ".join(differs)) if differs else ItemState("fresh")


def _rig_text(item: RigItem) -> str:
    return f"{item.content} {_digest(edits_text(item.edits))}"


def _motion_text(item: MotionItem) -> str:
    laid = item.options.model_dump(include={"head", "pairs", "rest_frame", "scale"}) if item.kind == "markers" else {}
    return f"{item.content} {_digest(laid)}"


def _driver_text(driver: RigItem | None, hand: RigItem, motion: MotionItem) -> str:
    if driver is None:
        return ""
    if motion.kind == "weights":
        return _rig_text(driver)
    return "" if driver is hand else driver.content


def _options_text(options: BasisOptions) -> str:
    return _digest(options.model_dump(exclude={"bounds", "memory_mb"}))  # all bounds are computed


def _digest(value: object) -> str:
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), default=list)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


@dataclass(frozen=True)
class Ingredients:
    """Values only, so that a task may use them while the project is edited."""

    key: InputsKey
    hand: Rig
    driver: Rig | None
    motion: MotionItem
    data: MotionData | None
    options: BasisOptions

    @classmethod
    def of(cls, basis: BasisState) -> Ingredients | None:
        """Return what a basis is made of now; None while something is missing.

        Raises
        ------
        InputError
            When the edits of a rig cannot be done.
        """
        key, hand, motion = inputs_key(basis), basis.hand, basis.motion
        if key is None or hand is None or motion is None:
            return None
        rig, item = basis.rig(hand), basis.driver
        driver = None if item is None or item is hand else basis.rig(item)
        if rig is None:
            return None
        return cls(key, rig, driver, motion, basis.motion_data(motion.content), basis.setup.options)


@dataclass(frozen=True)
class Analysis:
    """A quasi-eigen basis with all figures, and what it was made of."""

    key: InputsKey
    hand: Rig
    prepared: PreparedMotion
    result: BasisResult
    options: BasisOptions

    @property
    def names(self) -> tuple[str, ...]:
        """The shapes."""
        return self.hand.basis.names

    @cached_property
    def hand_shapes(self) -> FloatArray:
        """(n, N, 3) displacements of the hand shapes from the neutral face, mm."""
        basis = self.hand.basis
        return basis.displacements if basis.mean is None else basis.displacements + basis.mean

    @cached_property
    def quasi_shapes(self) -> FloatArray:
        """(n, N, 3) displacements of the quasi-eigen shapes from the neutral face, mm; also of an affine basis."""
        basis = self.result.quasi.basis
        return basis.displacements if basis.mean is None else basis.displacements + basis.mean

    @cached_property
    def measures(self) -> ShapeMeasures:
        """How the two forms of every shape lie to each other."""
        return ShapeMeasures.of(self.hand_shapes, self.quasi_shapes, self.hand)

    def amounts(self, setup: BasisSetup) -> FloatArray:
        """Return how much of every shape is quasi-eigen (n,), 0 to 1."""
        return np.array([setup.amount(name) for name in self.names], dtype=np.float64)


@dataclass(frozen=True)
class ShapeMeasures:
    """Inner products over the skin of every hand shape and its quasi-eigen shape, and their RMS distance in mm."""

    hand: FloatArray
    both: FloatArray
    quasi: FloatArray
    apart_mm: FloatArray

    @classmethod
    def of(cls, hand: FloatArray, quasi: FloatArray, rig: Rig) -> ShapeMeasures:
        """Return the measures of shapes (n, N, 3) in mm."""
        at = rig.skin
        products: tuple[list[float], ...] = ([], [], [])
        apart = []
        for one, two in zip(hand, quasi, strict=True):
            a, b = one[at], two[at]
            for found, (x, y) in zip(products, ((a, a), (a, b), (b, b)), strict=True):
                found.append(float(np.vdot(x, y)))
            apart.append(float(np.sqrt(np.square(b - a).sum(axis=1).mean())))
        own, shared, other = (np.array(found) for found in products)
        return cls(own, shared, other, np.array(apart))

    def cosine(self, amounts: FloatArray) -> FloatArray:
        """Return the cosine (n,) between each hand shape and the shape in use; NaN where one does not move."""
        rest = 1.0 - amounts
        along = rest * self.hand + amounts * self.both
        squared = rest**2 * self.hand + 2 * rest * amounts * self.both + amounts**2 * self.quasi
        size = np.sqrt(self.hand * np.maximum(squared, 0.0))
        found: FloatArray = np.divide(along, size, out=np.full(len(along), np.nan), where=size > 1e-12)
        return found

    def change_mm(self, amounts: FloatArray) -> FloatArray:
        """Return the RMS distance (n,) over the skin of the shape in use from the hand shape, mm."""
        return amounts * self.apart_mm


@dataclass(frozen=True)
class Blend:
    """The basis in use between hand and quasi-eigen, and what it makes of the performance.

    ``comparison`` has this basis in the place of ``quasi_eigen``.
    """

    key: InputsKey
    amounts: Mapping[str, float]
    basis: ExpressionBasis
    comparison: Comparison


def prepare_motion(ingredients: Ingredients, progress: Progress = silent) -> PreparedMotion:
    """Return the motion of the rig, reading the recording where it is linked.

    Raises
    ------
    InputError
        When the recording is not there or does not fit the rig.
    """
    from studio.basis.loading import read_linked
    from studio.basis.motions import prepare

    data = ingredients.data
    if data is None:
        data = read_linked(ingredients.motion, part(progress, 0.0, 0.3))
    options = ingredients.motion.options
    return prepare(data, ingredients.hand, options, ingredients.driver, part(progress, 0.3, 1.0))


def analyse(ingredients: Ingredients, prepared: PreparedMotion | None = None, progress: Progress = silent) -> Analysis:
    """Return the quasi-eigen basis of what was chosen, with all figures.

    Raises
    ------
    InputError
        When rig and performance do not fit, or the options ask for what is not there.
    """
    from studio.basis.job import BasisInputs, run

    start = 0.0
    if prepared is None:
        start = 0.3
        prepared = prepare_motion(ingredients, part(progress, 0.0, start))
    inputs = BasisInputs(ingredients.hand, prepared.motion)
    result = run(inputs, ingredients.options, part(progress, start, 0.98))
    analysis = Analysis(ingredients.key, ingredients.hand, prepared, result, ingredients.options)
    progress(0.98, "comparing the shapes")
    _ = analysis.measures
    return analysis


def blended(analysis: Analysis, setup: BasisSetup, progress: Progress = silent) -> Blend:
    """Return the basis in use with its exact figures under every bound.

    Raises
    ------
    Cancelled
        From ``progress``.
    """
    from engine.basis.compare import compare_again
    from engine.basis.quasi_eigen import blend

    hand, result = analysis.hand.basis, analysis.result
    amounts = analysis.amounts(setup)
    if (amounts == 1.0).all():
        return Blend(analysis.key, setup.amounts, result.quasi.basis, result.comparison)
    basis = blend(hand, result.quasi.basis, amounts)
    found = compare_again(
        result.comparison,
        basis,
        analysis.prepared.motion,
        vertices=analysis.hand.skin,
        ridge=analysis.options.ridge,
        progress=progress,
    )
    return Blend(analysis.key, setup.amounts, basis, found)
