"""One good file for every reader and form: what the hostile corpus damages."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

import resources
from engine.files.depth_json import write_depth_scan
from engine.files.glb import write_glb
from engine.files.images import encode_image
from engine.files.landmarks import write_landmarks
from engine.files.landmarks_json import write_fiducials
from engine.files.npz import write_npz
from engine.files.obj import write_obj
from engine.files.ply import write_ply
from engine.files.rig_out import write_rig
from engine.landmarks import LandmarkSet
from studio.project import store
from studio.project.document import Project, ScanItem, new_id
from tests.engine.files import motion_samples as samples
from tests.engine.files.foreign import abs_bytes, pcd_bytes, xyz_bytes
from tests.engine.files.planted import picture, planted_scan, ply_bytes, seamed_mesh
from tests.engine.files.rig_samples import planted_rig

SMALL = {"width": 16, "height": 12}


@dataclass(frozen=True)
class Seed:
    """A good file: the reader's name, the file's name, its bytes, and the files that it needs beside it."""

    reader: str
    name: str
    data: bytes
    beside: tuple[tuple[str, bytes], ...] = ()


def seeds() -> dict[str, Seed]:
    """Return the good files by a short name."""
    scan = planted_scan(**SMALL)
    found = {
        "pcd ascii": Seed("scan", "s.pcd", pcd_bytes(scan, "ascii")),
        "pcd binary": Seed("scan", "s.pcd", pcd_bytes(scan, "binary")),
        "pcd packed": Seed("scan", "s.pcd", pcd_bytes(scan, "binary_compressed")),
        "pcd one row": Seed("scan", "s.pcd", pcd_bytes(scan, "binary", holes=False)),
        "abs": Seed("scan", "s.abs", abs_bytes(scan)),
        "abs packed": Seed("scan", "s.abs.gz", abs_bytes(scan, packed=True)),
        "xyz": Seed("scan", "s.xyz", xyz_bytes(scan, 4)),
        "xyz commas": Seed("scan", "s.txt", xyz_bytes(scan, 4, ",", heading="# planted\n")),
        "template": Seed("template", "face.json", resources.template_path().read_bytes()),
        "scheme": Seed("scheme", "closed.toml", resources.scheme_path("closed").read_bytes()),
        "mapping": Seed("mapping", "map.toml", resources.mapping_paths()[0].read_bytes()),
    }
    found |= _motions()
    for form in ("full", "grid"):
        for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
            found[f"ply {encoding} {form}"] = Seed("scan", "s.ply", ply_bytes(scan, encoding, form))
    for name, kind in (("png", "png"), ("jpg", "jpeg"), ("tif", "tiff")):
        found[f"picture {name}"] = Seed("image", f"p.{name}", encode_image(picture(16, 12), kind))
    depth = (np.arange(192, dtype=np.uint16) * 331).reshape(12, 16)
    found["depth png"] = Seed("grey", "d.png", encode_image(depth))
    found["depth tif"] = Seed("grey", "d.tif", encode_image(depth.astype(np.float32), "tiff"))
    found["picture ppm"] = Seed("image", "p.ppm", bytes(cv2.imencode(".ppm", picture(16, 12))[1]))
    with tempfile.TemporaryDirectory() as name:
        found |= _written(Path(name))
    return found


def _motions() -> dict[str, Seed]:
    """Return performances as other programs write them."""
    clip = samples.performance(6)
    clip[2, 3] = np.nan
    vertices = samples.performance(5)
    found = {
        "c3d counts": ("m.c3d", samples.c3d_bytes(clip)),
        "c3d floats": ("m.c3d", samples.c3d_bytes(clip, scale=-0.01, analog=2)),
        "trc": ("m.trc", samples.trc_text(clip).encode()),
        "markers": ("m.csv", samples.marker_text(clip).encode()),
        "markers below labels": ("m.csv", samples.marker_text(clip, separator="\t", form="rows", gap="").encode()),
        "live link": ("m.csv", samples.live_link_text().encode()),
        "weights": ("m.csv", b"frame,time_s,smile,jaw\n1,0.0,0.5,1.0\n2,0.04,0.25,0.125\n"),
        "pc2": ("m.pc2", samples.pc2_bytes(vertices)),
        "npz motion": ("m.npz", samples.npz_bytes(vertices=vertices.astype(np.float32), fps=24)),
        "npz motion packed": ("m.npz", samples.npz_bytes(packed=True, vertices=vertices, fps=24, unit="mm")),
        "glb animated": ("m.glb", samples.animated_glb(np.arange(4) / 24, np.linspace(0, 1, 8), ("a", "b"))),
    }
    return {key: Seed("motion", name, data) for key, (name, data) in found.items()} | {
        "pairs": Seed("pairs", "MARKERS.json", samples.PAIRS.encode())
    }


def _written(folder: Path) -> dict[str, Seed]:
    """Return the files that our own writers make."""
    scan = planted_scan(**SMALL)
    mesh, normals = seamed_mesh()
    points = {"chin": (1.0, 2.0), "nose_tip": (3.0, 4.5)}
    found: dict[str, Seed] = {}

    def keep(key: str, reader: str, name: str, write: Callable[[Path], object]) -> None:
        home = folder / key
        home.mkdir()
        write(home / name)
        beside = tuple((path.name, path.read_bytes()) for path in sorted(home.iterdir()) if path.name != name)
        found[key] = Seed(reader, name, (home / name).read_bytes(), beside)

    keep("depth json", "scan", "s.json", lambda path: write_depth_scan(path, scan))
    keep("npz", "scan", "s.npz", lambda path: write_npz(path, scan))
    keep("ply of ours", "scan", "s.ply", lambda path: write_ply(path, scan))
    keep("fiducials", "fiducials", "f.json", lambda path: write_fiducials(path, points, (16, 12)))
    keep("glb", "mesh", "m.glb", lambda path: write_glb(path, mesh, normals=normals, texture=picture()))
    keep("obj", "mesh", "m.obj", lambda path: write_obj(path, mesh, texture=picture()))
    keep("qface", "project", "p.qface", lambda path: store.save(_project(), path))
    keep("rig glb", "rig", "r.glb", lambda path: write_rig(path, planted_rig(mean=True), texture=picture()))
    keep("rig npz", "rig", "r.npz", lambda path: write_rig(path, planted_rig(mean=True)))
    keep("rig list", "rig folder", "shapes.json", lambda path: write_rig(path.parent, planted_rig()))
    keep("rig obj", "rig", "neutral.obj", lambda path: write_rig(path.parent, planted_rig()))
    for name in ("l.pts", "l.ljson", "l.csv"):
        keep(f"landmarks {name}", "landmarks", name, lambda path: _landmarks(path))
    return found


def _landmarks(path: Path) -> None:
    write_landmarks(path, np.array([[1.0, 2.0], [3.0, 4.5], [5.0, 6.0]]), ("a", "b", "c"))


def _project() -> Project:
    project, scan = Project(), planted_scan(**SMALL)
    item = ScanItem(new_id(), "base", project.add_image(scan), landmarks=LandmarkSet.placed({"chin": (1.0, 2.0)}))
    project.insert_scan(0, item)
    return project
