"""No batch replaces a file that it reads: not its own scan's, not another's, not what a scan names beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.errors import InputError
from engine.files.npz import write_npz
from engine.scan.range_image import RangeImage
from studio.batch.options import read_jobs
from studio.batch.project import project_items
from studio.cli import main
from studio.project import store
from studio.project.document import Project, new_id

Make = Callable[..., tuple[Project, str]]


def item(scan: str, out: str, more: str = "", fiducials: str = "f.json") -> str:
    return f'[[item]]\nscan = "{scan}"\nfiducials = "{fiducials}"\nout = "{out}"\n{more}'


def project_of(make: Make, positions: dict[str, tuple[float, float]], *files: Path) -> Project:
    """Return a project with a scan of every file, called after it."""
    project, scan_id = make(positions, "first")
    one = project.scan(scan_id)
    for number, path in enumerate(files):
        source = replace(one.source, depth_file=str(path))
        project.insert_scan(number, replace(one, id=new_id(), name=path.stem, source=source))
    project.remove_scan(scan_id)
    return project


@pytest.mark.parametrize("ending", ["glb", "obj"])
def test_a_project_s_faces_never_replace_its_meshes(
    make_project: Make, fiducials: dict[str, tuple[float, float]], tmp_path: Path, ending: str
) -> None:
    meshes = [tmp_path / f"{name}.{ending}" for name in ("james", "mary")]
    for mesh in meshes:
        mesh.write_bytes(b"the photogrammetry of " + mesh.stem.encode())
    project = project_of(make_project, fiducials, *meshes)
    place = store.save(project, tmp_path / "t.qface")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert main(["batch", str(place), "--out", str(tmp_path), "--format", ending]) == 2
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
    (tmp_path / "link").symlink_to(tmp_path)
    with pytest.raises(InputError, match="would replace an input"):  # what the window asks
        project_items(project, tmp_path / "link", ending)
    swapped = project_of(make_project, fiducials, *meshes)
    for scan, name in zip(swapped.scans, ("mary", "other"), strict=True):
        swapped.change_scan(scan.id, name=name)
    with pytest.raises(InputError, match=rf"scan mary: .*mary\.{ending}"):  # the mesh of another scan
        project_items(swapped, tmp_path, ending)
    swapped.change_scan(swapped.scans[0].id, name="one")
    items, _ = project_items(swapped, tmp_path, ending)
    assert len(items) == 2, "other names are written"
    assert all(set(meshes) <= set(one.sources) for one in items)


def test_materials_and_pictures_of_a_mesh_are_kept(
    make_project: Make, fiducials: dict[str, tuple[float, float]], tmp_path: Path
) -> None:
    (tmp_path / "head.obj").write_text("mtllib skin.mtl\nv 0 0 0\n")
    (tmp_path / "skin.mtl").write_text("newmtl a\nmap_Kd -s 1 1 1 other_texture.png\n")
    project = project_of(make_project, fiducials, tmp_path / "head.obj")
    for name in ("skin", "other"):
        with pytest.raises(InputError, match=r"skin\.mtl|other_texture\.png"):
            project_items(project, tmp_path, "obj", name)
        assert project_items(project, tmp_path, "glb", name)[0]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (item("a.glb", "x.glb") + item("b.glb", "a.glb"), "item.1.out"),
        (item("b.glb", "a.glb") + item("a.glb", "x.glb"), "item.0.out"),
        (item("a.npz", "x.obj") + item("x.mtl", "y.glb"), "item.0.out"),
        (item("a.npz", "a b.obj") + item("b.npz", "a_b.obj"), "a_b.mtl"),
        (item("s.json", "s.obj"), "s_texture.png"),
        (item("a.npz", "x.obj", fiducials="x.mtl"), "item.0.out"),
        (item("a.npz", "x.glb", fiducials="jobs.done.json"), "jobs.done.json"),
    ],
)
def test_items_never_replace_what_any_of_them_reads(tmp_path: Path, text: str, named: str) -> None:
    (tmp_path / "s.json").write_text('{"depth": "d.png", "colour": "s_texture.png"}')
    jobs = tmp_path / "jobs.toml"
    jobs.write_text('stage = "scan"\n' + text)
    with pytest.raises(InputError) as caught:
        read_jobs(jobs)
    assert named in str(caught.value) and str(tmp_path) in str(caught.value)


def test_limits_given_beside_the_jobs_are_kept(folder: Path) -> None:
    (folder / "jobs.toml").write_text('stage = "scan"\n' + item("base.npz", "strict.glb"))
    assert read_jobs(folder / "jobs.toml").items
    with pytest.raises(InputError, match="replace an input"):
        read_jobs(folder / "jobs.toml", keep=[folder / "strict.glb"])


def test_a_fit_that_is_fresh_is_held_back_from_a_source_too(saved: Path, tmp_path: Path, scan: RangeImage) -> None:
    write_npz(tmp_path / "base.npz", scan)
    project = store.load(saved)
    target = tmp_path / "base.glb"
    target.write_bytes(b"mesh")
    one = project.scans[0]
    project.change_scan(one.id, source=replace(one.source, depth_file=str(target)))
    from studio.batch.job import attempt

    items, _ = project_items(project, tmp_path / "faces")
    result, _ = attempt(replace(items[0], out=target), project.limits)
    assert result.state == "failed" and "would be replaced" in result.error and target.read_bytes() == b"mesh"
    assert np.isfinite(project.range_image(one.id).points).any()
