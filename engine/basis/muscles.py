"""A sculpting checklist: one shape a muscle, six above and twelve below (Kim & Ko 2007, section 5.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Region = Literal["upper", "lower"]


@dataclass(frozen=True)
class Element:
    """One entry of the checklist.

    Attributes
    ----------
    key : str
        Short and stable.
    muscle : str
        Anatomical name.
    region : {"upper", "lower"}
    units : tuple of int
        Action units of the Facial Action Coding System that show the same motion.
    does : str
        What the skin does when this muscle alone is fully tensed.
    words : tuple of str
        What shape names say for it, lower case without separators.
    """

    key: str
    muscle: str
    region: Region
    units: tuple[int, ...]
    does: str
    words: tuple[str, ...]


ELEMENTS: tuple[Element, ...] = (
    Element(
        "brow_inner_up",
        "Frontalis, inner part",
        "upper",
        (1,),
        "Lifts the inner ends of the eyebrows; short furrows across the middle of the forehead.",
        ("browinnerup", "innerbrowraise", "browsup", "browraise", "eyebrowsup", "eyebrowup", "frontalis"),
    ),
    Element(
        "brow_outer_up",
        "Frontalis, outer part",
        "upper",
        (2,),
        "Lifts the outer halves of the eyebrows into an arch; furrows above them.",
        ("browouterup", "outerbrowraise", "browsup", "browraise", "eyebrowsup", "eyebrowup", "frontalis"),
    ),
    Element(
        "brow_down",
        "Corrugator supercilii with procerus",
        "upper",
        (4,),
        "Draws the eyebrows down and together; upright folds between them.",
        (
            "browdown",
            "browlower",
            "browsdown",
            "eyebrowdown",
            "eyebrowsdown",
            "browfrown",
            "frownbrow",
            "corrugator",
            "procerus",
        ),
    ),
    Element(
        "eye_wide",
        "Levator palpebrae superioris",
        "upper",
        (5,),
        "Raises the upper lid until white shows above the iris.",
        ("eyewide", "upperlidraise", "lidraise", "eyesopen", "eyeopen", "levatorpalpebrae"),
    ),
    Element(
        "eye_blink",
        "Orbicularis oculi, lid part",
        "upper",
        (43, 45),
        "Lowers the upper lid over the eye; the lower lid meets it from below.",
        ("eyeblink", "blink", "eyeclose", "eyesclose", "eyelidclose"),
    ),
    Element(
        "eye_squint",
        "Orbicularis oculi, ring around the eye",
        "upper",
        (6, 7),
        "Tightens the lids and lifts the cheeks towards them; small folds at the outer corners.",
        ("eyesquint", "squint", "cheeksquint", "cheekraise", "lidtighten", "orbicularisoculi"),
    ),
    Element(
        "nose_sneer",
        "Levator labii superioris alaeque nasi",
        "lower",
        (9,),
        "Pulls the wings of the nose and the lip below them up; folds beside the bridge.",
        ("nosesneer", "sneer", "nosewrinkle", "alaequenasi"),
    ),
    Element(
        "upper_lip_up",
        "Levator labii superioris",
        "lower",
        (10,),
        "Raises the upper lip so that the teeth show; the fold beside the nose deepens.",
        ("mouthupperup", "upperlipraise", "upperlipup", "lipupperup", "levatorlabii"),
    ),
    Element(
        "smile",
        "Zygomaticus major",
        "lower",
        (12,),
        "Draws the corners of the mouth up and back; the cheeks fill.",
        ("mouthsmile", "smile", "lipcornerpull", "zygomaticus"),
    ),
    Element(
        "dimple",
        "Buccinator",
        "lower",
        (14,),
        "Presses the corners of the mouth back against the teeth; a dimple beside each.",
        ("mouthdimple", "dimple", "buccinator"),
    ),
    Element(
        "stretch",
        "Risorius with platysma",
        "lower",
        (20,),
        "Draws the corners of the mouth straight to the side; the lips grow long and flat.",
        ("mouthstretch", "lipstretch", "stretch", "risorius", "mouthwide", "widen"),
    ),
    Element(
        "corner_down",
        "Depressor anguli oris",
        "lower",
        (15,),
        "Pulls the corners of the mouth down; folds run from them towards the chin.",
        ("mouthfrown", "lipcornerdepress", "mouthcornerdown", "cornerdown", "depressoranguli", "triangularis"),
    ),
    Element(
        "lower_lip_down",
        "Depressor labii inferioris",
        "lower",
        (16,),
        "Lowers the lower lip and turns it out a little; the lower teeth show.",
        ("mouthlowerdown", "lowerlipdepress", "lowerlipdown", "liplowerdown", "depressorlabii"),
    ),
    Element(
        "chin_up",
        "Mentalis",
        "lower",
        (17,),
        "Pushes the chin and the lower lip up; the chin's skin becomes uneven.",
        ("mouthshruglower", "chinraise", "chinup", "mentalis"),
    ),
    Element(
        "pucker",
        "Orbicularis oris, outer ring",
        "lower",
        (18, 22),
        "Gathers the lips forward to a small round, as for a kiss or a funnel.",
        ("mouthpucker", "pucker", "mouthfunnel", "funnel", "kiss", "lippucker", "orbicularisoris"),
    ),
    Element(
        "lip_press",
        "Orbicularis oris, rim of the lips",
        "lower",
        (23, 24, 28),
        "Presses the lips together and rolls their red in; the mouth becomes a line.",
        ("mouthpress", "lippress", "liptight", "mouthroll", "liproll", "lipsuck", "mouthclose"),
    ),
    Element(
        "jaw_open",
        "Digastric and relaxed masseter, temporalis and inner pterygoid",
        "lower",
        (26, 27),
        "Lets the jaw swing open; the cheeks lengthen and the lips part.",
        ("jawopen", "jawdrop", "mouthopen", "openmouth", "masseter"),
    ),
    Element(
        "jaw_side",
        "Outer pterygoid",
        "lower",
        (29, 30),
        "Slides the jaw to one side or forward; the chin leaves the middle.",
        ("jawleft", "jawright", "jawforward", "jawside", "jawthrust", "pterygoid"),
    ),
)
"""The checklist: 6 elements of the upper region, 12 of the lower."""


@dataclass(frozen=True)
class ChecklistEntry:
    """An element and the shapes of a basis that seem to be it, in the basis' order."""

    element: Element
    shapes: tuple[str, ...]

    @property
    def found(self) -> bool:
        """Whether the basis has a shape for it."""
        return bool(self.shapes)


def muscle_checklist(names: Sequence[str]) -> tuple[ChecklistEntry, ...]:
    """Return every element with the shapes whose names say it (ours; the list: Kim & Ko 2007, section 5.3).

    Names are compared without case and separators; ``AU12`` and its like count by their number.
    """
    return tuple(ChecklistEntry(element, tuple(n for n in names if matches(element, n))) for element in ELEMENTS)


def matches(element: Element, name: str) -> bool:
    """Return whether a shape's name says an element."""
    import re

    units = {int(number) for number in re.findall(r"(?<![a-z])au[ _-]?0*(\d+)", name.lower())}
    if units:
        return bool(units.intersection(element.units))
    plain = re.sub(r"[^a-z]", "", name.lower())
    return any(word in plain for word in element.words)
