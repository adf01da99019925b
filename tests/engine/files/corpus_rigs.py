"""The corpus's rigs: targets without end, arrays that unpack to gigabytes, folders that lead elsewhere."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from tests.engine.files.corpus_runner import Make
from tests.engine.files.rig_samples import MorphGlb

OBJ = "v 0 0 0\nv 200 0 0\nv 0 200 0\nv 200 200 {}\nf 1 2 3\nf 2 4 3\n"
MOVE = np.full((4, 3), 0.01, "<f4")


def rig_bombs() -> dict[str, Make]:
    """Return what writes each file or folder, by name."""
    return {
        "glb with one target 100,001 times": _glb(lambda glb: [glb.accessor(MOVE, "VEC3", 5126)] * 100_001),
        "glb with 5000 targets in 20,000 nodes": _instances,
        "glb whose zeros are nowhere": _zeros(40_000_000, 5),
        "glb of a million zeros": _zeros(1_000_000, 3),
        "glb of many zeros": _zeros(30_000, 550),
        "glb with targets of NaN": _glb(lambda glb: [glb.accessor(MOVE * np.nan, "VEC3", 5126)]),
        "glb with infinite targets": _glb(lambda glb: [glb.accessor(MOVE * np.inf, "VEC3", 5126)]),
        "glb with targets that are no list": _changed({"targets": {"POSITION": 0}}),
        "glb with targets that are no objects": _changed({"targets": [1, [], "x"]}),
        "glb with runs of 10^9 faces": _changed({"extras": {"parts": ["skin"], "sourceFaces": [0, 1 << 30]}}),
        "glb with runs of text": _changed({"extras": {"parts": [1, {}], "sourceFaces": ["a", None]}}),
        "glb with giant names": _names([["x" * 10**6]]),
        "glb with names that are none": _names([[[], {}, None, True, "\ud800"]]),
        "glb with names of control signs": _names([["\0\n\t", "a\nb"]]),
        "glb with one name of all": _names([["a"] * 5]),
        "npz of the largest size": _npz((300, 55_000, 3)),
        "npz beyond the largest size": _npz((5000, 5_000, 3)),
        "npz of 10^18 numbers": _npz((10**6, 10**6, 10**6)),
        "npz with a million names": lambda folder: _archive(folder, names=np.arange(10**6).astype("U7")),
        "npz with giant names": lambda folder: _archive(folder, names=np.array(["x" * 10**6, "y"])),
        "npz with pickles": lambda folder: _archive(folder, names=np.array([{}, []], dtype=object)),
        "npz of NaN": lambda folder: _archive(folder, displacements=np.full((2, 4, 3), np.nan)),
        "npz with faces of 2^64": lambda folder: _archive(folder, faces=np.full((2, 3), 2**64 - 1, "u8")),
        "npz that is 1e300 large": lambda folder: _archive(folder, neutral=np.eye(4, 3) * 1e300),
        "folder without a neutral face": _folder({"a.obj": OBJ, "b.obj": OBJ}),
        "folder of nothing": _folder({"a.txt": "x"}, ""),
        "folder with another topology": _folder({"neutral.obj": OBJ, "a.obj": OBJ + "v 1 2 3\n"}),
        "folder of huge numbers": _folder({"neutral.obj": OBJ, "a.obj": OBJ.format("1e308"), "b.obj": OBJ}),
        "folder of 5001 shapes": _folder({"neutral.obj": OBJ} | {f"s{k}.obj": "v" for k in range(5001)}),
        "folder with digits without end": _folder({"neutral.obj": OBJ, "9" * 200 + ".obj": OBJ}),
        "list of 10^6 brackets": _listed("[" * 10**6),
        "list that leads out": _listed(_list(file="../../../etc/passwd")),
        "list that leads to the root": _listed(_list(file="/etc/passwd")),
        "list of a device": _listed(_list(file="zero.obj"), link="/dev/zero"),
        "list that is a pipe's": _listed(_list(file="zero.obj"), link="/dev/stdin"),
        "list with runs of 10^7": _listed(_list(parts={"skin": [0, 10_000_000] * 1000})),
        "list with a shape 1000 times": _listed(_list(count=1000)),
    }


def _glb(targets: Any, mesh: Any = None) -> Make:
    def make(folder: Path) -> Path:
        glb = MorphGlb()
        primitive = glb.triangle(targets(glb))
        return glb.meshes({"primitives": [primitive]} | (mesh or {})).save(folder / "r.glb")

    return make


def _changed(change: dict[str, Any]) -> Make:
    def make(folder: Path) -> Path:
        glb = MorphGlb()
        return glb.meshes({"primitives": [glb.triangle([MOVE]) | change]}).save(folder / "r.glb")

    return make


def _names(names: list[Any]) -> Make:
    return _glb(lambda _glb: [MOVE] * len(names[0]), {"extras": {"targetNames": names[0]}})


def _instances(folder: Path) -> Path:
    glb = MorphGlb()
    glb.meshes({"primitives": [glb.triangle([glb.accessor(MOVE, "VEC3", 5126)] * 5000)]})
    glb.document["nodes"] = [{"mesh": 0}] * 19_000
    glb.document["scenes"] = [{"nodes": list(range(19_000))}]
    return glb.save(folder / "r.glb")


def _zeros(count: int, targets: int) -> Make:
    """Targets without any data, on as many vertices as a file of that many bytes may name."""

    def make(folder: Path) -> Path:
        glb = MorphGlb()
        here = min(count, 1_000_000)
        points = np.zeros((here, 3), "<f4")
        points[:3] = [[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0]]
        position = glb.accessor(points, "VEC3", 5126)
        entry = {"componentType": 5126, "count": count, "type": "VEC3"}
        glb.document["accessors"] += [entry] * targets
        made = [{"POSITION": position + 1 + k} for k in range(targets)]
        indices = glb.accessor(np.array([0, 1, 2], "<u2"), "SCALAR", 5123)
        primitive = {"attributes": {"POSITION": position}, "indices": indices, "targets": made}
        return glb.meshes({"primitives": [primitive]}).save(folder / "r.glb")

    return make


def _archive(folder: Path, **change: Any) -> Path:
    values = {
        "neutral": np.eye(4, 3) * 200, "faces": np.array([[0, 1, 2], [1, 3, 2]]), "names": np.array(["a", "b"]),
        "displacements": np.ones((2, 4, 3)),
    }  # fmt: skip
    np.savez(folder / "r.npz", **(values | change))
    return folder / "r.npz"


def _npz(shape: tuple[int, int, int]) -> Make:
    """An archive whose displacements announce a shape, and hold it where that may be read."""

    def make(folder: Path) -> Path:
        head = io.BytesIO()
        np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": shape})
        vertices = min(shape[1], 100_000)
        neutral = np.zeros((vertices, 3), "f4")
        neutral[:3] = np.eye(3) * 200
        path = folder / "r.npz"
        names = np.arange(min(shape[0], 10_000)).astype("U5")
        np.savez(path, neutral=neutral, faces=np.array([[0, 1, 2]]), names=names)
        length = 8 * shape[0] * shape[1] * shape[2]
        length = length if length < 400 << 20 else 1 << 20
        with (
            zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
            archive.open("displacements.npy", "w", force_zip64=True) as member,
        ):
            member.write(head.getvalue())
            for _ in range(length >> 20):
                member.write(bytes(1 << 20))
            member.write(bytes(length & ((1 << 20) - 1)))
        return path

    return make


def _folder(files: dict[str, str], name: str | None = None) -> Make:
    def make(folder: Path) -> Path:
        for file, text in files.items():
            (folder / file).write_text(text.replace("{}", "0"))
        return folder if name == "" else folder / next(iter(files))

    return make


def _list(file: str = "a.obj", count: int = 1, **more: Any) -> str:
    shapes = [{"name": f"s{k}", "file": file} for k in range(count)]
    return json.dumps({"unit": "mm", "neutral": "neutral.obj", "shapes": shapes} | more)


def _listed(text: str, link: str | None = None) -> Make:
    def make(folder: Path) -> Path:
        for file in ("neutral.obj", "a.obj"):
            (folder / file).write_text(OBJ.format(0))
        if link is not None:
            (folder / "zero.obj").symlink_to(link)
        (folder / "shapes.json").write_text(text)
        return folder / "neutral.obj"

    return make


def read_rig_beside(path: Path) -> object:
    """Read the folder of OBJs that a list of shapes lies in."""
    from engine.files.rig import read_rig

    return read_rig(path.parent)
