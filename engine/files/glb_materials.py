"""Materials of a GLB file: base colours and pictures, each decoded once."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from engine.errors import InputError
from engine.files.glb_scene import numbers
from engine.files.gltf_data import GltfData
from engine.files.mesh_parts import MAX_MATERIALS
from engine.files.source import beside
from engine.files.textures import Material, PictureBudget
from engine.mesh import FloatArray
from engine.scan.range_image import ColourImage


class GlbMaterials:
    """The materials that primitives name, in the order of their first use; ``notes`` says what was left out."""

    def __init__(self, data: GltfData) -> None:
        self.made: list[Material] = []
        self.files: list[Path] = []
        self.notes: list[str] = []
        self._data = data
        self._known: dict[int, tuple[int, int | None, FloatArray]] = {}
        self._pictures: dict[int, ColourImage | None] = {}
        self._budget = PictureBudget()

    def material(self, index: Any) -> tuple[int, int | None, FloatArray]:
        """Return the number of a material, the channel of its coordinates (None without a picture), their transform."""
        if index is None:
            return -1, None, np.eye(3)
        if isinstance(index, int) and index in self._known:
            return self._known[index]
        where = f"materials[{index}]"
        surface = self._data.item("materials", index).get("pbrMetallicRoughness", {})
        surface = surface if isinstance(surface, dict) else {}
        factor = surface.get("baseColorFactor", [1, 1, 1, 1])
        tint = numbers(factor[:3], 3) if isinstance(factor, list) else None
        if tint is None or not np.isfinite(tint).all():
            raise self._data.wrong(f"{where}.baseColorFactor", "is not four numbers")
        tint = np.clip(tint, 0, 1)
        info = surface.get("baseColorTexture")
        picture: ColourImage | None = None
        channel, transform = 0, np.eye(3)
        if isinstance(info, dict):
            channel = self._data.number(info.get("texCoord"), f"{where}.texCoord", 0)
            channel, transform = _moved(self._data, info, channel, where)
            picture = self._picture(info.get("index"))
        if len(self.made) >= MAX_MATERIALS:
            raise self._data.wrong("materials", f"more than {MAX_MATERIALS} are used", "bake them into fewer")
        red, green, blue = (255 * encoded(tint)).tolist()
        self._known[index] = len(self.made), channel if picture is not None else None, transform
        self.made.append(Material(picture, (255.0, 255.0, 255.0) if tint.min() == 1 else (red, green, blue)))
        return self._known[index]

    def _picture(self, index: Any) -> ColourImage | None:
        source = self._data.item("textures", index).get("source")
        if source is None:
            self.notes.append("a texture of an unknown kind was left out")
            return None
        image = self._data.item("images", source)
        if source not in self._pictures:
            try:
                self._pictures[source] = self._decoded(image, f"images[{source}]")
            except InputError as error:
                self.notes.append(f"images[{source}] {error.problem}: left out")
                self._pictures[source] = None
        return self._pictures[source]

    def _decoded(self, image: dict[str, Any], where: str) -> ColourImage:
        uri = image.get("uri")
        if not isinstance(uri, str):
            return self._budget.decode(self._data.view(image.get("bufferView"))[0], f"{self._data.path}, {where}")
        if uri.startswith("data:"):
            try:
                content = base64.b64decode(uri.partition(",")[2], validate=True)
            except ValueError as error:  # binascii.Error among them
                raise self._data.wrong(where, "is no base64") from error
            return self._budget.decode(content, f"{self._data.path}, {where}")
        path = beside(self._data.path, unquote(uri), where)
        picture = self._budget.read(path)
        self.files.append(path)
        return picture


def encoded(linear: FloatArray) -> FloatArray:
    """Return sRGB 0..1 of linear light 0..1 (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-12) ** (1 / 2.4) - 0.055)


def _moved(data: GltfData, info: dict[str, Any], channel: int, where: str) -> tuple[int, FloatArray]:
    """Return channel and matrix (3, 3) of KHR_texture_transform."""
    extensions = info.get("extensions")
    change = extensions.get("KHR_texture_transform") if isinstance(extensions, dict) else None
    if not isinstance(change, dict):
        return channel, np.eye(3)
    offset, scale = numbers(change.get("offset", [0, 0]), 2), numbers(change.get("scale", [1, 1]), 2)
    turn = numbers([change.get("rotation", 0.0)], 1)
    if offset is None or scale is None or turn is None or not (np.abs([*offset, *scale, *turn]) < 1e6).all():
        raise data.wrong(f"{where}.KHR_texture_transform", "is not made of numbers")
    angle = turn[0]
    cosine, sine = np.cos(angle), np.sin(angle)
    matrix = np.eye(3)
    matrix[:2, :2] = np.array([[cosine, sine], [-sine, cosine]]) * scale
    matrix[:2, 2] = offset
    return data.number(change.get("texCoord"), where, channel), matrix
