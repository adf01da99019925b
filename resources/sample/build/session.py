"""The scan session: two people are modelled, painted, lit, scanned and written."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial.transform import Rotation

from engine.mesh import TriangleMesh
from engine.scan.range_image import Camera
from engine.scan.raster import rasterise
from engine.scan.virtual import VirtualScan, VirtualScanner, visible_points
from resources.sample.build import light, paint, points, shapes
from resources.sample.build.source import FloatArray, HeadSource, unpack_wheel
from resources.sample.head import Heads, Surface, eyeball_points, subdivide

WIDTH, HEIGHT = 640, 480
UNIT_MM = 0.02
# The middle of the face stands 650 mm before the scanner, which sees 225 mm of it from top to bottom.
CAMERA = Camera(1390.0, 1390.0, 319.5, 239.5)
STAND = np.array([0.0, 2.0, -735.0])
BACKGROUND = (66, 69, 74)

# scan: the word somebody says, and the letters at which the mouth is held
WORDS = {
    "base": ("", ""),
    "car": ("car", "ar"),
    "man": ("man", "an"),
    "she": ("she", "sh"),
    "eel": ("eel", "ee"),
    "too": ("too", "oo"),
}
# Nobody holds still: turn about x, y, z in degrees and shift in mm, scan by scan.
MOTIONS = {
    "base": ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    "car": ((1.2, -0.7, 0.4), (0.8, -1.4, 1.9)),
    "man": ((0.8, 1.1, -0.5), (-1.2, 0.6, -2.1)),
    "she": ((-1.6, 0.9, 0.7), (1.6, 1.0, 1.2)),
    "eel": ((-0.6, -1.3, 0.3), (-1.9, -0.8, 1.4)),
    "too": ((-1.7, 0.6, -0.7), (0.5, 1.7, -1.6)),
    "stranger": ((-0.7, 0.8, 0.6), (1.1, 4.0, -1.0)),
}
CLOSED = ("base", "stranger")


@dataclass(frozen=True)
class Masks:
    """The wheel's painted masks at the dense skin vertices, 0..1."""

    lips: FloatArray
    mouth: FloatArray
    lids: FloatArray


def build(wheel: Path | None, out: Path) -> None:
    """Write the whole sample into ``out``."""
    source = HeadSource(unpack_wheel(wheel))
    truth, masks = _truth(source)
    (out / "subject").mkdir(parents=True, exist_ok=True)
    (out / "stranger").mkdir(parents=True, exist_ok=True)
    np.savez_compressed(out / "truth.npz", **truth)
    heads = Heads.load(out / "truth.npz")
    rest = heads.vertices("base")
    skin = heads.faces[heads.parts["skin"]]
    normals = light.vertex_normals(rest, skin)
    count = len(masks.lips)
    for folder, person in (("subject", paint.SUBJECT), ("stranger", paint.STRANGER)):
        painted = paint.paint_skin(person, rest[:count], normals[:count])
        Image.fromarray(painted.texture).save(out / folder / "skin.jpg", quality=90, subsampling=0)
        scans = [s for s in heads.scans if (s == "stranger") == (folder == "stranger")]
        for number, scan in enumerate(scans):
            result = _scan(heads, scan, person, painted, masks, seed=person.seed * 100 + number)
            _write(out / folder, "base" if scan == "stranger" else scan, result, heads, scan)
    (out / "sample.toml").write_text(_list_of_scans())


def _truth(source: HeadSource) -> tuple[dict[str, Any], Masks]:
    subject = shapes.neutral(source, shapes.SUBJECT)
    stranger = shapes.neutral(source, shapes.STRANGER)
    names = [*WORDS, "stranger"]
    used = source.used
    turns = [Rotation.from_euler("xyz", MOTIONS[n][0], degrees=True).as_matrix() for n in names]
    data: dict[str, Any] = {
        "scans": np.array(names),
        "cage_subject": subject[used].astype(np.float32),
        "cage_stranger": stranger[used].astype(np.float32),
        "eyes_subject": shapes.eyeballs(source, subject),
        "eyes_stranger": shapes.eyeballs(source, stranger),
        "cage_uv": paint.chart_uv(subject[used]),
        "white_uv": np.array([0.5 * paint.WHITE_SPOT / paint.WIDTH, 0.5 * paint.WHITE_SPOT / paint.HEIGHT]),
        "rotations": np.array(turns),
        "translations": np.array([STAND + MOTIONS[n][1] for n in names]),
        "face_skin": np.zeros(0, dtype=np.int32),
    }
    for part, quads in source.quads.items():
        data[f"quads_{part}"] = quads.astype(np.int32)
        data[f"levels_{part}"] = np.array(3 if part.startswith("teeth") else 2)
    inner = np.unique(np.concatenate([q.ravel() for n, q in source.quads.items() if n != "skin"]))
    data["cage_uv"][inner] = data["white_uv"]
    for pose, weights in shapes.POSES.items():
        data[f"pose_{pose}"] = shapes.expression(source, weights)[used].astype(np.float32)
    for kind in ("fiducial", "anatomy"):
        data[f"{kind}_names"], data[f"{kind}_vertices"] = np.zeros(0, dtype="U1"), np.zeros(0, dtype=np.int32)

    draft = Heads(data)
    masks = _masks(source)
    rest = draft.vertices("base")
    skin = draft.faces[draft.parts["skin"]]
    count = len(masks.lips)
    normals = light.vertex_normals(rest, skin)
    chooser = points.PointChooser(rest[:count], normals[:count])
    found = points.face_points(chooser)
    anatomy = points.anatomical_points(chooser)
    mouths = {}
    for name in names:
        mesh = _mesh(draft.surface(name))
        truth_points = rasterise(mesh, CAMERA, WIDTH, HEIGHT).points
        mouths[name] = (name not in CLOSED, (mesh, CAMERA, points.clearly_seen(mesh, CAMERA, truth_points)))
    corner = float(rest[found["mouth_left"], 0])
    lips, own_points = points.lip_points(chooser, masks.lips, draft.vertices("car")[:count], corner, mouths)
    found |= lips
    for point, own in own_points.items():
        data |= {f"fiducial_{point}_{scan}": np.array(vertex, dtype=np.int32) for scan, vertex in own.items()}
    for kind, named in (("fiducial", found), ("anatomy", anatomy)):
        data[f"{kind}_names"] = np.array(list(named))
        data[f"{kind}_vertices"] = np.array(list(named.values()), dtype=np.int32)
    seen = rasterise(_mesh(draft.surface("base")), CAMERA, WIDTH, HEIGHT).face_index
    occlusion = light.ambient_occlusion(light.DepthMaps(rest, draft.faces, light.vertex_normals(rest, draft.faces)))
    inside = np.maximum(masks.mouth, (_nostrils(rest[:count], occlusion[:count])).astype(float))
    data["face_skin"] = points.face_skin(
        rest, skin, np.unique(seen), found, lambda faces: inside[skin[faces]].max(axis=1) > 0.4
    ).astype(np.int32)
    return data, masks


def _masks(source: HeadSource) -> Masks:
    """Read the wheel's masks over its own chart, which is cut at lips and lids: corner by corner, then averaged."""
    local = np.unique(source.quads["skin"], return_inverse=True)[1].reshape(-1, 4)
    _, fine = subdivide(local, int(local.max()) + 1, 2)
    carry, chart_fine = subdivide(source.chart_quads, len(source.charts), 2)
    own, vertex = np.unique(fine, return_inverse=True)
    place = (carry @ source.charts)[chart_fine.ravel()]

    def sample(name: str, blur: float) -> FloatArray:
        picture = gaussian_filter(source.mask(name), blur)
        height, width = picture.shape
        corners = map_coordinates(picture, [place[:, 1] * height - 0.5, place[:, 0] * width - 0.5], order=1)
        vertex_of = vertex.ravel()
        return np.bincount(vertex_of, corners, len(own)) / np.bincount(vertex_of, minlength=len(own))

    return Masks(sample("lips", 2), sample("inside-mouth", 2), sample("eyelids", 3))


def _nostrils(neutral: FloatArray, occlusion: FloatArray) -> NDArray[np.bool_]:
    x, y, z = neutral.T
    inside: NDArray[np.bool_] = (
        (np.abs(x) < 16) & (np.abs(x) > 2) & (y < -8) & (y > -19.5) & (z > 80) & (occlusion < 0.48)
    )
    return inside


def _mesh(surface: Surface) -> TriangleMesh:
    return TriangleMesh(surface.vertices, surface.faces, surface.uv, parts=surface.parts)


def _scan(
    heads: Heads, scan: str, person: paint.Complexion, painted: paint.SkinPaint, masks: Masks, seed: int
) -> VirtualScan:
    surface = heads.surface(scan)
    own_parts = {name: np.unique(surface.faces[faces]) for name, faces in surface.parts.items()}
    own = heads.vertices("stranger" if scan == "stranger" else "base")
    normals = light.vertex_normals(surface.vertices, surface.faces)
    maps = light.DepthMaps(surface.vertices, surface.faces, normals)
    occlusion = light.ambient_occlusion(maps)

    count = len(masks.lips)
    tone = np.array(person.tone)
    albedo = np.empty_like(surface.vertices)
    strength = np.full(len(albedo), 0.15)
    power = np.full(len(albedo), 14.0)
    wrap = np.zeros(len(albedo))
    wrap[:count] = 1
    albedo[:count] = _skin_albedo(own[:count], heads.vertices("base")[:count], heads.eyes(scan), person, masks)
    strength[:count] += 0.22 * masks.lips
    power[:count] += 24 * masks.lips
    for part in ("teeth_upper", "teeth_lower"):
        albedo[own_parts[part]] = paint.teeth_colours(own[own_parts[part]])
    albedo[own_parts["tongue"]] = (172, 88, 88)
    for side, part in ((1, "eye_left"), (-1, "eye_right")):
        albedo[own_parts[part]] = paint.eye_colours(person, eyeball_points(), side)
    for name, shine, exponent in (("teeth", 0.3, 40.0), ("tongue", 0.3, 30.0), ("eye", 0.95, 110.0)):
        for part, vertices in own_parts.items():
            if part.startswith(name):
                strength[vertices], power[vertices] = shine, exponent
    deep = occlusion.copy()
    # Teeth and eyes are bright and smooth: light that bounces round them makes up for the narrow opening.
    for part in ("teeth_upper", "teeth_lower", "eye_left", "eye_right"):
        vertices = own_parts[part]
        least = 0.66 * np.clip((20 - np.abs(own[vertices, 0])) / 8, 0, 1) if part.startswith("teeth") else 0.0
        occlusion[vertices] = np.maximum(occlusion[vertices] ** 0.6, least)
    lit = light.shade(maps, occlusion, albedo, light.Gloss(strength, power, wrap), np.zeros(3))
    # The texture brings the skin's tone itself: what is left over is a factor.
    lit[:count] *= 255 / tone

    lost = np.zeros(len(albedo))
    inside = (masks.mouth > 0.5) & (occlusion[:count] < 0.5)
    lost[:count] = inside | _nostrils(own[:count], occlusion[:count])
    lost[own_parts["tongue"]] = 1
    for part in ("teeth_upper", "teeth_lower"):
        lost[own_parts[part]] = deep[own_parts[part]] < 0.32
    for part in ("eye_left", "eye_right"):
        ball = eyeball_points()
        lost[own_parts[part]] = np.hypot(ball[:, 0], ball[:, 1]) < 0.19
    scanner = VirtualScanner(CAMERA, WIDTH, HEIGHT, background=BACKGROUND)
    return scanner.scan(
        _mesh(surface), colours=lit, texture=painted.texture, lost=lost, lost_texture=painted.unseen > 0.5, seed=seed
    )


def _skin_albedo(
    neutral: FloatArray, subject: FloatArray, eyes: FloatArray, person: paint.Complexion, masks: Masks
) -> FloatArray:
    colour = np.repeat(np.array([person.tone], dtype=float), len(neutral), axis=0)

    def lay(amount: FloatArray, paint_colour: tuple[float, float, float]) -> None:
        colour[:] += np.clip(amount, 0, 1)[:, None] * (np.array(paint_colour) - colour)

    lay(0.92 * masks.lips, person.lips)
    lay(masks.mouth, person.mouth)
    lay(0.30 * masks.lids, person.shadow)
    x, y, _ = subject.T
    ear = np.clip((np.abs(x) - 70) / 8, 0, 1) * np.clip((42 - y) / 10, 0, 1) * np.clip((y + 33) / 10, 0, 1)
    lay(0.35 * ear, person.blush)
    for eye in eyes:
        distance = np.linalg.norm(neutral - eye[:3], axis=1) - eye[3]
        rim = np.exp(-((np.clip(distance, 0, None) / 1.0) ** 2)) * (neutral[:, 2] > eye[2] - 1)
        lay(rim * np.where(neutral[:, 1] > eye[1] - 1, 0.9, 0.5), (46.0, 30.0, 27.0))
    return colour


def _write(folder: Path, name: str, result: VirtualScan, heads: Heads, scan: str) -> None:
    depth = np.nan_to_num(-result.scan.points[..., 2] / UNIT_MM)
    picture = cv2.cvtColor(np.asarray(result.scan.colour), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(folder / f"{name}_depth.png"), np.rint(depth).astype(np.uint16), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    cv2.imwrite(str(folder / f"{name}_colour.png"), picture, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    camera = {"fx": CAMERA.fx, "fy": CAMERA.fy, "cx": CAMERA.cx, "cy": CAMERA.cy}
    header = {"depth": f"{name}_depth.png", "colour": f"{name}_colour.png", "unit_mm": UNIT_MM, **camera}
    (folder / f"{name}.json").write_text(json.dumps(header, indent=2) + "\n")
    mesh = _mesh(heads.surface(scan))
    inner = ("lip_upper_inner", "lip_lower_inner")
    chosen = {n: v for n, v in heads.fiducials_of(scan).items() if scan not in CLOSED or not n.startswith(inner)}
    pixels, visible = visible_points(mesh, CAMERA, mesh.vertices[list(chosen.values())])
    if not visible.all():
        hidden = [n for n, seen in zip(chosen, visible, strict=True) if not seen]
        print(f"{scan}: hidden fiducials {hidden}")
    places = {n: [round(float(x), 6), round(float(y), 6)] for n, (x, y) in zip(chosen, pixels, strict=True)}
    document = {"image_size": [WIDTH, HEIGHT], "points": places}
    (folder / f"{name}_fiducials.json").write_text(json.dumps(document, indent=2) + "\n")


def _list_of_scans() -> str:
    entries = ['title = "Six scans of one subject, and one of a stranger"', 'truth = "truth.npz"']
    for scan, (word, held) in [*WORDS.items(), ("stranger", ("", ""))]:
        folder, name = ("stranger", "base") if scan == "stranger" else ("subject", scan)
        fields = {
            "id": scan,
            "subject": folder,
            "name": name,
            "word": word,
            "held": held,
            "scheme": "closed" if scan in CLOSED else "open",
            "scan": f"{folder}/{name}.json",
            "fiducials": f"{folder}/{name}_fiducials.json",
            "skin": f"{folder}/skin.jpg",
        }
        entries.append("\n[[scan]]\n" + "\n".join(f'{key} = "{value}"' for key, value in fields.items()))
    return "\n".join(entries) + "\n"
