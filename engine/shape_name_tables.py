"""Tables of names: the 52 ARKit blendshapes, other words for them, and FACS action units in short."""

from __future__ import annotations

from dataclasses import dataclass

_BOTH = (
    "browDown", "browOuterUp", "cheekSquint", "eyeBlink", "eyeLookDown", "eyeLookIn", "eyeLookOut", "eyeLookUp",
    "eyeSquint", "eyeWide", "mouthDimple", "mouthFrown", "mouthLowerDown", "mouthPress", "mouthSmile", "mouthStretch",
    "mouthUpperUp", "noseSneer", "jaw", "mouth",
)  # fmt: skip
_SINGLE = (
    "browInnerUp", "cheekPuff", "jawForward", "jawOpen", "mouthClose", "mouthFunnel", "mouthPucker", "mouthRollLower",
    "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper", "tongueOut",
)  # fmt: skip

ARKIT: tuple[str, ...] = tuple(sorted([*_SINGLE, *(name + side for name in _BOTH for side in ("Left", "Right"))]))
"""The 52 blendshape locations of ARKit's face anchors, in alphabetical order."""

ALIASES: dict[str, tuple[tuple[str, ...], ...]] = {
    "browDown": (("brow", "lower"), ("brow", "lowerer"), ("brows", "down"), ("eyebrow", "down")),
    "browInnerUp": (("inner", "brow", "raise"), ("inner", "brow", "raiser"), ("brow", "raise", "inner")),
    "browOuterUp": (("outer", "brow", "raise"), ("outer", "brow", "raiser"), ("brow", "raise", "outer")),
    "cheekPuff": (("puff",), ("cheeks", "puff")),
    "cheekSquint": (("cheek", "raise"), ("cheek", "raiser")),
    "eyeBlink": (("blink",), ("eye", "close"), ("eye", "closed"), ("eyelid", "close")),
    "eyeSquint": (("squint",), ("lid", "tightener")),
    "eyeWide": (("eye", "widen"), ("upper", "lid", "raiser"), ("lid", "raise")),
    "jawForward": (("jaw", "thrust"),),
    "jawOpen": (("jaw", "drop"), ("mouth", "open")),
    "mouthDimple": (("dimple",), ("dimpler",)),
    "mouthFrown": (("frown",), ("lip", "corner", "down"), ("lip", "corner", "depressor")),
    "mouthFunnel": (("funnel",), ("lip", "funneler"), ("lips", "funnel")),
    "mouthPress": (("lip", "press"), ("lip", "pressor"), ("lips", "press")),
    "mouthPucker": (("pucker",), ("kiss",), ("lips", "pucker"), ("lip", "pucker")),
    "mouthSmile": (("smile",), ("lip", "corner", "up"), ("lip", "corner", "puller"), ("lip", "corner", "pull")),
    "mouthStretch": (("lip", "stretch"), ("lip", "stretcher")),
    "mouthUpperUp": (("upper", "lip", "up"), ("upper", "lip", "raise"), ("upper", "lip", "raiser")),
    "mouthLowerDown": (("lower", "lip", "down"), ("lower", "lip", "depressor")),
    "mouthShrugLower": (("chin", "raise"), ("chin", "raiser")),
    "noseSneer": (("sneer",), ("nose", "wrinkle"), ("nose", "wrinkler")),
    "tongueOut": (("tongue", "show"),),
}
"""Other words for the ARKit shapes, without their side."""


@dataclass(frozen=True)
class ActionUnit:
    """An action unit: its number, the usual name, what is seen (our words), and the ARKit shapes that show it."""

    number: int
    name: str
    seen: str
    arkit: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """``AU12`` for number 12."""
        return f"AU{self.number}"


def _both(*names: str) -> tuple[str, ...]:
    return tuple(name + side for name in names for side in ("Left", "Right"))


ACTION_UNITS: tuple[ActionUnit, ...] = (
    ActionUnit(1, "Inner brow raiser", "the inner ends of the eyebrows rise", ("browInnerUp",)),
    ActionUnit(2, "Outer brow raiser", "the outer halves of the eyebrows rise", _both("browOuterUp")),
    ActionUnit(4, "Brow lowerer", "the eyebrows come down and together", _both("browDown")),
    ActionUnit(5, "Upper lid raiser", "the upper lids open wide", _both("eyeWide")),
    ActionUnit(6, "Cheek raiser", "the cheeks push up against the lower lids", _both("cheekSquint")),
    ActionUnit(7, "Lid tightener", "the lids narrow the eye", _both("eyeSquint")),
    ActionUnit(9, "Nose wrinkler", "the skin beside the nose is drawn up in wrinkles", _both("noseSneer")),
    ActionUnit(10, "Upper lip raiser", "the upper lip rises and bares the teeth", _both("mouthUpperUp")),
    ActionUnit(11, "Nasolabial deepener", "the fold from nose to mouth deepens in its middle"),
    ActionUnit(12, "Lip corner puller", "the corners of the mouth go up and out", _both("mouthSmile")),
    ActionUnit(13, "Sharp lip puller", "the corners of the mouth go straight up"),
    ActionUnit(14, "Dimpler", "the corners of the mouth are drawn in tight", _both("mouthDimple")),
    ActionUnit(15, "Lip corner depressor", "the corners of the mouth go down", _both("mouthFrown")),
    ActionUnit(16, "Lower lip depressor", "the lower lip goes down", _both("mouthLowerDown")),
    ActionUnit(17, "Chin raiser", "the chin pushes the lower lip up", ("mouthShrugLower",)),
    ActionUnit(18, "Lip pucker", "the lips are drawn together and forward", ("mouthPucker",)),
    ActionUnit(19, "Tongue show", "the tongue comes out", ("tongueOut",)),
    ActionUnit(20, "Lip stretcher", "the corners of the mouth go sideways", _both("mouthStretch")),
    ActionUnit(22, "Lip funneler", "the lips turn outward as a funnel", ("mouthFunnel",)),
    ActionUnit(23, "Lip tightener", "the red of the lips becomes narrow"),
    ActionUnit(24, "Lip pressor", "the lips are pressed upon each other", _both("mouthPress")),
    ActionUnit(25, "Lips part", "the lips come apart, the jaw does not move"),
    ActionUnit(26, "Jaw drop", "the jaw falls", ("jawOpen",)),
    ActionUnit(27, "Mouth stretch", "the jaw is pulled down as far as it goes"),
    ActionUnit(28, "Lip suck", "the lips roll in over the teeth", ("mouthRollLower", "mouthRollUpper")),
    ActionUnit(29, "Jaw thrust", "the jaw comes forward", ("jawForward",)),
    ActionUnit(30, "Jaw sideways", "the jaw goes to one side", _both("jaw")),
    ActionUnit(34, "Puff", "the cheeks fill with air", ("cheekPuff",)),
    ActionUnit(45, "Blink", "the eyes close and open", _both("eyeBlink")),
    ActionUnit(61, "Eyes turn left", "both eyes look to the subject's left", ("eyeLookOutLeft", "eyeLookInRight")),
    ActionUnit(62, "Eyes turn right", "both eyes look to the subject's right", ("eyeLookInLeft", "eyeLookOutRight")),
    ActionUnit(63, "Eyes up", "both eyes look up", _both("eyeLookUp")),
    ActionUnit(64, "Eyes down", "both eyes look down", _both("eyeLookDown")),
)
"""Action units that move the face (Ekman & Friesen 1978), as far as a sculptor makes shapes for them."""
