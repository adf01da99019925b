"""The scene of a GLB file: its primitives where their nodes place them, as triangles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.files.gltf_data import GltfData
from engine.files.mesh_parts import check_faces
from engine.mesh import FloatArray, IntArray

_UNDERSTOOD = {"KHR_texture_transform", "KHR_materials_unlit", "KHR_mesh_quantization"}
_UNPACKED = {
    "KHR_draco_mesh_compression": "export it without Draco (in Blender leave 'Compression' unticked)",
    "EXT_meshopt_compression": "export it without meshopt compression (gltfpack: leave out -c and -cc)",
    "KHR_meshopt_compression": "export it without meshopt compression (gltfpack: leave out -c and -cc)",
}
_DEEPEST = 200
_MOST_NODES, _MOST_PRIMITIVES = 20_000, 10_000
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


@dataclass(frozen=True)
class Instance:
    """One primitive of one mesh at one node; ``place`` (4, 4) brings it into the scene, ``where`` is its path."""

    node: int
    mesh: int
    primitive: dict[str, Any]
    place: FloatArray
    where: str
    first: bool
    skinned: bool

    @property
    def mirrored(self) -> bool:
        """Whether the node turns the surface inside out."""
        return bool(np.linalg.det(self.place[:3, :3]) < 0)


def check_extensions(data: GltfData) -> None:
    """Raise InputError when the file needs an extension that is not understood, with what to do about it."""
    required = data.document.get("extensionsRequired", [])
    unknown = (
        [str(name)[:60] for name in required if str(name) not in _UNDERSTOOD] if isinstance(required, list) else ["?"]
    )
    if unknown:
        remedy = next((_UNPACKED[name] for name in unknown if name in _UNPACKED), "export it uncompressed")
        raise data.wrong("extensionsRequired", f"needs {', '.join(unknown[:3])}", remedy)


def instances(data: GltfData) -> Iterator[Instance]:
    """Yield the primitives of the default scene.

    Raises
    ------
    InputError
        On loops of nodes, places that are no numbers, and more nodes or primitives than a face has.
    """
    nodes = primitives = 0
    for root in _roots(data):
        seen: set[int] = set()
        waiting: list[tuple[Any, FloatArray, int]] = [(root, np.eye(4), 0)]
        nodes += 1
        while waiting:
            index, outer, depth = waiting.pop()
            node = data.item("nodes", index)
            if index in seen or depth > _DEEPEST:
                raise data.wrong(f"nodes[{index}]", "is below itself, or too deep")
            seen.add(index)
            children = _children(data, node)
            nodes += len(children)
            if nodes > _MOST_NODES:
                problem = f"more than {_MOST_NODES} are in the scene"
                raise data.wrong("nodes", problem, "join its parts, or export the face")
            place = outer @ _local(data, node, index)
            if "mesh" in node:
                found = _primitives(data, node["mesh"])
                primitives += len(found)
                if primitives > _MOST_PRIMITIVES:
                    problem = f"more than {_MOST_PRIMITIVES} primitives are in the scene"
                    raise data.wrong("meshes", problem, "join its parts, or export the face")
                for number, primitive in enumerate(found):
                    where = f"meshes[{node['mesh']}].primitives[{number}]"
                    if not isinstance(primitive, dict) or not isinstance(primitive.get("attributes"), dict):
                        raise data.wrong(where, "is no primitive")
                    yield Instance(index, node["mesh"], primitive, place, where, number == 0, "skin" in node)
            waiting += [(child, place, depth + 1) for child in children]


def triangles(data: GltfData, instance: Instance) -> tuple[FloatArray, IntArray] | None:
    """Return positions (V, 3) as stored and faces (F, 3) of a primitive; None where it has no triangles.

    Faces are turned round where the node mirrors them.
    """
    primitive, where = instance.primitive, instance.where
    mode, attributes = primitive.get("mode", _TRIANGLES), primitive["attributes"]
    if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
        return None
    positions = numbers_of(*data.accessor(attributes["POSITION"], ("VEC3",)))
    if "indices" in primitive:
        values, _ = data.accessor(primitive["indices"], ("SCALAR",))
        if values.dtype.kind != "u":
            raise data.wrong(f"{where}.indices", "are no whole numbers")
        indices = values[:, 0].astype(np.int64)
    else:
        indices = np.arange(len(positions))
    faces = _as_triangles(indices, mode)
    if not len(faces):
        return None
    check_faces(f"{data.path}, {where}", faces, len(positions))
    return positions, faces[:, ::-1] if instance.mirrored else faces


def attribute(data: GltfData, instance: Instance, name: str, kinds: tuple[str, ...], count: int) -> FloatArray | None:
    """Return an attribute (count, width) of a primitive as numbers; None where it has none of that name."""
    attributes = instance.primitive["attributes"]
    if name not in attributes:
        return None
    values = numbers_of(*data.accessor(attributes[name], kinds))
    if len(values) != count:
        raise data.wrong(f"{instance.where}.attributes", "have different counts")
    return values


def placed(positions: FloatArray, place: FloatArray) -> FloatArray:
    """Return positions (V, 3) where a node puts them."""
    with np.errstate(over="ignore", invalid="ignore"):
        return positions @ place[:3, :3].T + place[:3, 3]


def numbers_of(values: NDArray[Any], normalised: bool) -> FloatArray:
    """Return the numbers that an accessor stands for: those of whole numbers, or -1..1 where it is normalised."""
    with np.errstate(invalid="ignore"):
        result = values.astype(np.float64)
    if normalised and values.dtype.kind in "iu":
        result = np.maximum(result / float(np.iinfo(values.dtype).max), -1.0)
    return result


def numbers(value: Any, count: int) -> FloatArray | None:
    """Return a list of ``count`` numbers of the document, and None for anything else."""
    if not isinstance(value, list) or len(value) != count:
        return None
    if not all(isinstance(number, int | float) and not isinstance(number, bool) for number in value):
        return None
    try:
        return np.array(value, dtype=np.float64)
    except OverflowError:
        return None


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


def _primitives(data: GltfData, index: Any) -> list[Any]:
    primitives = data.item("meshes", index).get("primitives", [])
    if not isinstance(primitives, list):
        raise data.wrong(f"meshes[{index}].primitives", "is no list")
    return primitives


def _local(data: GltfData, node: dict[str, Any], index: int) -> FloatArray:
    def listed(key: str, default: list[float]) -> FloatArray:
        values = numbers(node.get(key, default), len(default))
        if values is None or not (np.abs(values) < 1e9).all():
            raise data.wrong(f"nodes[{index}].{key}", f"is not {len(default)} numbers")
        return values

    if "matrix" in node:
        matrix = listed("matrix", np.eye(4).ravel().tolist()).reshape(4, 4).T
        return np.vstack([matrix[:3], [0, 0, 0, 1]])
    x, y, z, w = listed("rotation", [0, 0, 0, 1])
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
    result[:3, :3] = turn * listed("scale", [1, 1, 1])
    result[:3, 3] = listed("translation", [0, 0, 0])
    return result


def _as_triangles(indices: IntArray, mode: int) -> IntArray:
    if mode == _TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    if len(indices) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if mode == _FAN:
        return np.stack([np.full(len(indices) - 2, indices[0]), indices[1:-1], indices[2:]], axis=1)
    strip = np.stack([indices[:-2], indices[1:-1], indices[2:]], axis=1)
    strip[1::2] = strip[1::2, ::-1]
    return strip
