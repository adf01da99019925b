"""GLB as a mesh: all triangles of its scene in one, in their places, with base colour."""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.gltf_data import GltfData
from engine.files.mesh_parts import MAX_MATERIALS, RawMesh, check_counts, check_faces
from engine.files.source import beside
from engine.files.textures import Material, PictureBudget
from engine.mesh import BoolArray, FloatArray, IntArray
from engine.scan.range_image import ColourImage

_UNDERSTOOD = {"KHR_texture_transform", "KHR_materials_unlit", "KHR_mesh_quantization"}
_DEEPEST = 200
_MOST_NODES, _MOST_PRIMITIVES = 20_000, 10_000
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


@dataclass
class _Merged:
    """What the primitives add up to."""

    vertices: list[FloatArray] = field(default_factory=list)
    faces: list[IntArray] = field(default_factory=list)
    uv: list[FloatArray] = field(default_factory=list)
    placed: list[BoolArray] = field(default_factory=list)
    colours: list[FloatArray] = field(default_factory=list)
    materials: list[IntArray] = field(default_factory=list)
    count: int = 0
    triangles: int = 0
    coloured: bool = False
    nodes: int = 0
    primitives: int = 0
    skipped: int = 0
    bent: int = 0
    known: dict[int, tuple[int, int | None, FloatArray]] = field(default_factory=dict)
    made: list[Material] = field(default_factory=list)
    pictures: dict[int, ColourImage | None] = field(default_factory=dict)
    budget: PictureBudget = field(default_factory=PictureBudget)
    files: list[Path] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def read_glb_mesh(path: Path) -> RawMesh:
    """Read the default scene of a GLB file as one mesh, in metres.

    Node transforms are applied; morph targets and skins are left at rest; primitives that are no triangles are passed
    over. Colour comes from the base-colour texture and factor and from ``COLOR_0``.

    Raises
    ------
    InputError
        On data that is not in the file, indices of nothing, loops of nodes, or an extension it cannot do without.
    """
    data = GltfData(path)
    required = data.document.get("extensionsRequired", [])
    unknown = (
        [str(name)[:60] for name in required if str(name) not in _UNDERSTOOD] if isinstance(required, list) else ["?"]
    )
    if unknown:
        raise data.wrong("extensionsRequired", f"needs {', '.join(unknown[:3])}", "export it uncompressed")
    merged = _Merged()
    for index in _roots(data):
        _walk(data, index, np.eye(4), merged)
    if merged.skipped:
        merged.notes.append(f"{merged.skipped} primitives of points, lines or nothing were left out")
    if merged.bent:
        merged.notes.append(f"{merged.bent} meshes with bones are shown at rest")
    if not merged.faces:
        raise InputError(str(path), "holds no triangles", "export the surface, not only points or lines")
    placed = any(block.any() for block in merged.placed)
    uv = np.concatenate(merged.uv)
    faces = np.concatenate(merged.faces)
    uv_faces = np.where(np.concatenate(merged.placed)[faces], faces, -1)
    colours = None
    if merged.coloured:
        colours = np.clip(np.rint(255 * _encoded(np.concatenate(merged.colours))), 0, 255).astype(np.uint8)
    return RawMesh(
        np.concatenate(merged.vertices), faces, np.concatenate(merged.materials), merged.made,
        uv if placed else None, uv_faces if placed else None, colours, "m",
        tuple(dict.fromkeys(merged.notes)), tuple(merged.files),
    )  # fmt: skip


def _roots(data: GltfData) -> list[Any]:
    scenes = data.items("scenes")
    if scenes:
        scene = data.item("scenes", data.document.get("scene", 0))
        nodes = scene.get("nodes", [])
        if not isinstance(nodes, list):
            raise data.wrong("scenes.nodes", "is no list")
        return nodes
    children = {child for node in data.items("nodes") if isinstance(node, dict) for child in _children(data, node)}
    return [index for index in range(len(data.items("nodes"))) if index not in children]


def _children(data: GltfData, node: dict[str, Any]) -> list[int]:
    children = node.get("children", [])
    if not isinstance(children, list):
        raise data.wrong("nodes.children", "is no list")
    return [data.number(child, "nodes.children") for child in children]


def _walk(data: GltfData, root: Any, placing: FloatArray, merged: _Merged) -> None:
    seen: set[int] = set()
    waiting = [(root, placing, 0)]
    merged.nodes += 1
    while waiting:
        index, outer, depth = waiting.pop()
        node = data.item("nodes", index)
        if index in seen or depth > _DEEPEST:
            raise data.wrong(f"nodes[{index}]", "is below itself, or too deep")
        seen.add(index)
        children = _children(data, node)
        merged.nodes += len(children)
        if merged.nodes > _MOST_NODES:
            raise data.wrong("nodes", f"more than {_MOST_NODES} are in the scene", "join its parts, or export the face")
        place = outer @ _local(data, node, index)
        if "mesh" in node:
            merged.bent += "skin" in node
            mesh = data.item("meshes", node["mesh"])
            primitives = mesh.get("primitives", [])
            if not isinstance(primitives, list):
                raise data.wrong(f"meshes[{node['mesh']}].primitives", "is no list")
            merged.primitives += len(primitives)
            if merged.primitives > _MOST_PRIMITIVES:
                problem = f"more than {_MOST_PRIMITIVES} primitives are in the scene"
                raise data.wrong("meshes", problem, "join its parts, or export the face")
            for number, primitive in enumerate(primitives):
                where = f"meshes[{node['mesh']}].primitives[{number}]"
                if not isinstance(primitive, dict) or not isinstance(primitive.get("attributes"), dict):
                    raise data.wrong(where, "is no primitive")
                _add(data, primitive, place, where, merged)
        waiting += [(child, place, depth + 1) for child in children]


def _local(data: GltfData, node: dict[str, Any], index: int) -> FloatArray:
    def numbers(key: str, default: list[float]) -> FloatArray:
        values = _numbers(node.get(key, default), len(default))
        if values is None or not (np.abs(values) < 1e9).all():
            raise data.wrong(f"nodes[{index}].{key}", f"is not {len(default)} numbers")
        return values

    if "matrix" in node:
        matrix = numbers("matrix", np.eye(4).ravel().tolist()).reshape(4, 4).T
        return np.vstack([matrix[:3], [0, 0, 0, 1]])
    x, y, z, w = numbers("rotation", [0, 0, 0, 1])
    length = float(np.linalg.norm([x, y, z, w]))
    if length < 1e-9:
        raise data.wrong(f"nodes[{index}].rotation", "is no rotation")
    x, y, z, w = (value / length for value in (x, y, z, w))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    result = np.eye(4)
    result[:3, :3] = turn * numbers("scale", [1, 1, 1])
    result[:3, 3] = numbers("translation", [0, 0, 0])
    return result


def _numbers(value: Any, count: int) -> FloatArray | None:
    """Return a list of ``count`` numbers of the document, and None for anything else."""
    if not isinstance(value, list) or len(value) != count:
        return None
    if not all(isinstance(number, int | float) and not isinstance(number, bool) for number in value):
        return None
    try:
        return np.array(value, dtype=np.float64)
    except OverflowError:
        return None


def _add(data: GltfData, primitive: dict[str, Any], place: FloatArray, where: str, merged: _Merged) -> None:
    mode, attributes = primitive.get("mode", _TRIANGLES), primitive["attributes"]
    if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
        merged.skipped += 1
        return
    positions = _floats(*data.accessor(attributes["POSITION"], ("VEC3",)))
    if "indices" in primitive:
        values, _ = data.accessor(primitive["indices"], ("SCALAR",))
        if values.dtype.kind != "u":
            raise data.wrong(f"{where}.indices", "are no whole numbers")
        indices = values[:, 0].astype(np.int64)
    else:
        indices = np.arange(len(positions))
    faces = _triangles(indices, mode)
    if not len(faces):
        merged.skipped += 1
        return
    subject = str(data.path)
    check_faces(f"{subject}, {where}", faces, len(positions))
    check_counts(subject, merged.count + len(positions), merged.triangles + len(faces))
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = positions @ place[:3, :3].T + place[:3, 3]
    if np.linalg.det(place[:3, :3]) < 0:
        faces = faces[:, ::-1]
    key, channel, transform = _material(data, primitive.get("material"), merged)
    uv = np.zeros((len(positions), 2))
    placed: BoolArray = np.zeros(len(positions), dtype=bool)
    if channel is not None and f"TEXCOORD_{channel}" in attributes:
        uv = _floats(*data.accessor(attributes[f"TEXCOORD_{channel}"], ("VEC2",)))
        if len(uv) != len(positions):
            raise data.wrong(f"{where}.attributes", "have different counts")
        sound = np.isfinite(uv).all(axis=1, keepdims=True)
        uv = np.where(sound, np.where(sound, uv, 0.0) @ transform[:2, :2].T + transform[:2, 2], np.nan)
        placed = np.ones(len(positions), dtype=bool)
    shade = np.ones((len(positions), 3))
    if "COLOR_0" in attributes:
        found = _floats(*data.accessor(attributes["COLOR_0"], ("VEC3", "VEC4")))
        if len(found) != len(positions):
            raise data.wrong(f"{where}.attributes", "have different counts")
        shade = np.clip(np.nan_to_num(found[:, :3]), 0, 1)
        merged.coloured = True
    merged.vertices.append(vertices)
    merged.faces.append(faces + merged.count)
    merged.uv.append(uv)
    merged.placed.append(placed)
    merged.colours.append(shade)
    merged.materials.append(np.full(len(faces), key))
    merged.count += len(positions)
    merged.triangles += len(faces)


def _triangles(indices: IntArray, mode: int) -> IntArray:
    if mode == _TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    if len(indices) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if mode == _FAN:
        return np.stack([np.full(len(indices) - 2, indices[0]), indices[1:-1], indices[2:]], axis=1)
    strip = np.stack([indices[:-2], indices[1:-1], indices[2:]], axis=1)
    strip[1::2] = strip[1::2, ::-1]
    return strip


def _floats(values: NDArray[Any], normalised: bool) -> FloatArray:
    result = values.astype(np.float64)
    if normalised and values.dtype.kind in "iu":
        result = np.maximum(result / float(np.iinfo(values.dtype).max), -1.0)
    return result


def _encoded(linear: FloatArray) -> FloatArray:
    """Return sRGB 0..1 of linear light 0..1 (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-12) ** (1 / 2.4) - 0.055)


def _material(data: GltfData, index: Any, merged: _Merged) -> tuple[int, int | None, FloatArray]:
    """Return the number of a material, the channel of its coordinates (None without a picture), their transform."""
    if index is None:
        return -1, None, np.eye(3)
    if isinstance(index, int) and index in merged.known:
        return merged.known[index]
    where = f"materials[{index}]"
    surface = data.item("materials", index).get("pbrMetallicRoughness", {})
    surface = surface if isinstance(surface, dict) else {}
    factor = surface.get("baseColorFactor", [1, 1, 1, 1])
    tint = _numbers(factor[:3], 3) if isinstance(factor, list) else None
    if tint is None or not np.isfinite(tint).all():
        raise data.wrong(f"{where}.baseColorFactor", "is not four numbers")
    tint = np.clip(tint, 0, 1)
    info = surface.get("baseColorTexture")
    picture: ColourImage | None = None
    channel, transform = 0, np.eye(3)
    if isinstance(info, dict):
        channel = data.number(info.get("texCoord"), f"{where}.texCoord", 0)
        channel, transform = _moved(data, info, channel, where)
        picture = _picture(data, info.get("index"), merged)
    if len(merged.made) >= MAX_MATERIALS:
        raise data.wrong("materials", f"more than {MAX_MATERIALS} are used", "bake them into fewer")
    red, green, blue = (255 * _encoded(tint)).tolist()
    merged.known[index] = len(merged.made), channel if picture is not None else None, transform
    merged.made.append(Material(picture, (255.0, 255.0, 255.0) if tint.min() == 1 else (red, green, blue)))
    return merged.known[index]


def _moved(data: GltfData, info: dict[str, Any], channel: int, where: str) -> tuple[int, FloatArray]:
    """Return channel and matrix (3, 3) of KHR_texture_transform."""
    extensions = info.get("extensions")
    change = extensions.get("KHR_texture_transform") if isinstance(extensions, dict) else None
    if not isinstance(change, dict):
        return channel, np.eye(3)
    offset, scale = _numbers(change.get("offset", [0, 0]), 2), _numbers(change.get("scale", [1, 1]), 2)
    turn = _numbers([change.get("rotation", 0.0)], 1)
    if offset is None or scale is None or turn is None or not (np.abs([*offset, *scale, *turn]) < 1e6).all():
        raise data.wrong(f"{where}.KHR_texture_transform", "is not made of numbers")
    angle = turn[0]
    cosine, sine = np.cos(angle), np.sin(angle)
    matrix = np.eye(3)
    matrix[:2, :2] = np.array([[cosine, sine], [-sine, cosine]]) * scale
    matrix[:2, 2] = offset
    return data.number(change.get("texCoord"), where, channel), matrix


def _picture(data: GltfData, index: Any, merged: _Merged) -> ColourImage | None:
    source = data.item("textures", index).get("source")
    if source is None:
        merged.notes.append("a texture of an unknown kind was left out")
        return None
    image = data.item("images", source)
    if source not in merged.pictures:
        try:
            merged.pictures[source] = _decoded(data, image, f"images[{source}]", merged)
        except InputError as error:
            merged.notes.append(f"images[{source}] {error.problem}: left out")
            merged.pictures[source] = None
    return merged.pictures[source]


def _decoded(data: GltfData, image: dict[str, Any], where: str, merged: _Merged) -> ColourImage:
    uri = image.get("uri")
    if not isinstance(uri, str):
        return merged.budget.decode(data.view(image.get("bufferView"))[0], f"{data.path}, {where}")
    if uri.startswith("data:"):
        try:
            content = base64.b64decode(uri.partition(",")[2], validate=True)
        except ValueError as error:  # binascii.Error among them
            raise data.wrong(where, "is no base64") from error
        return merged.budget.decode(content, f"{data.path}, {where}")
    path = beside(data.path, unquote(uri), where)
    picture = merged.budget.read(path)
    merged.files.append(path)
    return picture
