"""Pictures of shapes, frames and markers of a rig without a window: for reports, plates and thumbnails."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from types import TracebackType
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from engine.mesh import FloatArray, TriangleMesh
from widgets.scene import camera
from widgets.scene.background import PAPER, ViewColours, apply_background, rgb
from widgets.scene.basis_content import BasisContent, beyond, counted
from widgets.scene.basis_face import Look, RigFace
from widgets.scene.basis_marks import CAPTURED, RECONSTRUCTED, Legend, MarkerPairs
from widgets.scene.basis_plates import CornerPlate
from widgets.scene.basis_rig import Pose, RigLook
from widgets.scene.basis_state import BY_HAND, BY_PCA, BY_QUASI, CHANGE, HAND, ORIGINAL, QUASI
from widgets.scene.colour_bar import ColourBar
from widgets.scene.heatmap import HeatRange, heat_colours
from widgets.scene.lights import add_studio_light
from widgets.scene.overlay import NamePlate

Image = NDArray[np.uint8]
Size = tuple[int, int]
_SUPERSAMPLING = 2
_GAP_PX = 2
_ROOM = 1.06


class RigStills:
    """An off-screen stage for pictures of one size; close it, or use it with ``with``.

    It needs no display: on Linux without one VTK draws through EGL (``libegl1``).

    Parameters
    ----------
    width, height : int
        Size of every picture in pixels.
    colours : ViewColours
        ``PAPER`` for print.
    scale : float
        Pixels to a pixel of the layout: how large names and markers are.
    """

    def __init__(self, width: int, height: int, colours: ViewColours = PAPER, scale: float = 1.0) -> None:
        if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
            os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
        self._size, self._colours = (width, height), colours
        self._scale = scale * _SUPERSAMPLING
        window = [width * _SUPERSAMPLING, height * _SUPERSAMPLING]
        self._plotter: Any = pv.Plotter(off_screen=True, window_size=window, lighting="none")
        stage: Any = self._plotter.render_window
        stage.SetMultiSamples(0)
        self._renderer = self._plotter.renderers[0]
        self._renderer.camera_set = True  # else pyvista's first picture places the camera itself
        add_studio_light(self._renderer)
        self._face = RigFace(self._renderer)
        self._marks = MarkerPairs(self._renderer)
        self._bar, self._legend = ColourBar(self._renderer, movable=False), Legend(self._renderer)
        self._name, self._share = NamePlate(self._renderer), CornerPlate(self._renderer)
        self._bar.hide()
        self.set_colours(colours)

    def __enter__(self) -> RigStills:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def set_colours(self, colours: ViewColours) -> None:
        """Dress the stage in a theme."""
        self._colours = colours
        apply_background(self._renderer, colours)
        self._marks.set_colours(colours, self._scale)

    def look(
        self,
        rig: RigLook,
        view: str | FloatArray = "three_quarter",
        margin: float = _ROOM,
        lift: float = 0.0,
        beside: FloatArray | None = None,
    ) -> None:
        """Place the camera before a rig's neutral face: at a name in ``camera.VIEWS``, or in a direction (3,).

        ``beside`` (k, 3) in mm are to be in the picture too.
        """
        direction = np.array(camera.VIEWS[view]) if isinstance(view, str) else np.asarray(view, dtype=np.float64)
        aspect = self._size[0] / self._size[1]
        points = rig.outline if beside is None else np.vstack([rig.outline, beside])
        camera.frame(self._renderer.camera, points, direction, aspect, margin, lift)
        low, high = rig.neutral.points.min(axis=0) - 60.0, rig.neutral.points.max(axis=0) + 60.0
        camera.clip(self._renderer.camera, [float(x) for x in np.stack([low, high], axis=1).ravel()])

    def picture(
        self,
        rig: RigLook,
        pose: Pose,
        *,
        look: Look = "clay",
        values: FloatArray | None = None,
        heat: HeatRange | None = None,
        captured: FloatArray | None = None,
        rebuilt: FloatArray | None = None,
        name: tuple[str, str] = ("", ""),
        bar: bool = True,
        wire: bool = False,
    ) -> Image:
        """Return a picture (height, width, 3) uint8 of a rig from where ``look`` placed the camera.

        Parameters
        ----------
        values : (N,) float, optional
            In mm, NaN where unknown: worn as a heatmap over ``heat``, with its bar unless ``bar`` is off.
        captured, rebuilt : (K, 3) float, optional
            Markers in mm.
        name : (str, str)
            Title and note in the upper left corner; an empty title writes nothing.
        """
        size = (self._size[0] * _SUPERSAMPLING, self._size[1] * _SUPERSAMPLING)
        heat = heat or HeatRange(0.0, 3.0)
        self._face.set_rig(rig)
        self._face.set_wire(wire, 0.5 * self._scale)
        if values is not None:
            self._face.set_heat(heat_colours(values, heat, self._colours.missing))
        self._face.set_look("heat" if values is not None else look)
        self._face.set_pose(pose)
        marks = [None if m is None else np.array(m, dtype=np.float32).reshape(-1, 3) for m in (captured, rebuilt)]
        self._marks.set(marks[0], marks[1])
        self._marks.turn(self._renderer.camera, size[1])
        barred = values is not None and bar
        self._bar.hide(not barred)
        if barred and values is not None:
            self._bar.set(heat, "", self._colours, size, self._scale)
        share = beyond(values, heat) if barred and values is not None else ""
        self._share.set(share, self._colours, size, self._scale)
        both = captured is not None and rebuilt is not None and bool(name[0])
        colours = (CAPTURED[self._colours.name], "captured"), (RECONSTRUCTED[self._colours.name], "reconstructed")
        self._legend.set(list(colours) if both else [], self._colours, self._scale)
        self._name.set(*name, self._colours, (size[0] - self._share.width - 4 * self._scale, size[1]), self._scale)
        return self._shoot()

    def close(self) -> None:
        """Let go of the stage."""
        for part in (self._face, self._marks, self._bar, self._legend, self._name, self._share):
            part.remove()
        self._plotter.close()

    def _shoot(self) -> Image:
        self._plotter.render()
        image = np.asarray(self._plotter.screenshot(None, return_img=True))[..., :3]
        width, height = self._size
        return halved(image[: height * _SUPERSAMPLING, : width * _SUPERSAMPLING])


def shape_pair_image(
    mesh: TriangleMesh | RigLook,
    hand: FloatArray,
    quasi: FloatArray,
    *,
    skin: NDArray[Any] | None = None,
    heat: HeatRange | None = None,
    view: str = "three_quarter",
    size: Size = (360, 360),
    colours: ViewColours = PAPER,
    names: bool = True,
    shape: str = "",
    change: bool = True,
) -> Image:
    """Return hand | quasi-eigen | change in mm of a shape (Kim & Ko 2007, figure 2), (H, 3 W + gaps, 3) uint8.

    Parameters
    ----------
    mesh : TriangleMesh or RigLook
        The neutral face, mm; a ``RigLook`` is quicker where many pictures are made of one rig.
    hand, quasi : (N, 3) float
        Displacements in mm.
    skin : (V,) int or (N,) bool, optional
        Vertices that the change is measured on.
    heat : HeatRange, optional
        Range of the change, 0..3 mm where left out; take one range for all shapes.
    size : (int, int)
        Width and height of each picture in pixels.
    names : bool
        Whether names are written over the pictures; ``shape`` is the shape's.
    change : bool
        Whether the change stands beside the two shapes.
    """
    content = _content(mesh, skin)
    content.set_shape(shape, hand, quasi, "")
    shots: list[dict[str, Any]] = [
        {"view": HAND, "name": ("Hand", shape)},
        {"view": QUASI, "name": ("Quasi-eigen", shape)},
    ]
    if change:
        shots.append({"view": CHANGE, "values": content.change, "heat": heat, "name": ("Change", "quasi-eigen − hand")})
    return _row(content, shots, view, size, colours, names)


def frame_triplet_image(
    mesh: TriangleMesh | RigLook,
    original: FloatArray,
    by_hand: FloatArray,
    by_quasi: FloatArray,
    *,
    by_pca: FloatArray | None = None,
    rms_mm: tuple[float | None, ...] = (),
    skin: NDArray[Any] | None = None,
    texture: Image | None = None,
    view: str = "three_quarter",
    size: Size = (360, 360),
    colours: ViewColours = PAPER,
    names: bool = True,
    frame: int | None = None,
) -> Image:
    """Return original | by hand | by quasi-eigen (| by PCA) of a frame (Kim & Ko 2007, figure 3), uint8.

    Parameters
    ----------
    original, by_hand, by_quasi, by_pca : (N, 3) float
        Positions in mm.
    rms_mm : tuple of float
        Of the reconstructions, written behind their names.
    frame : int, optional
        Counted from 0; written from 1.

    Other parameters are those of ``shape_pair_image``.
    """
    content = _content(mesh, skin, texture)
    content.set_frame(frame or 0, (original, by_hand, by_quasi, by_pca), rms_mm)
    return _frame_row(content, (), frame, view, size, colours, names)


def marker_error_image(
    mesh: TriangleMesh | RigLook,
    positions: tuple[FloatArray, FloatArray, FloatArray],
    captured: FloatArray,
    by_hand: FloatArray,
    by_quasi: FloatArray,
    *,
    rms_mm: tuple[float | None, ...] = (),
    texture: Image | None = None,
    view: str = "three_quarter",
    size: Size = (360, 360),
    colours: ViewColours = PAPER,
    names: bool = True,
    frame: int | None = None,
) -> Image:
    """Return a frame with captured markers red, reconstructed ones blue (Kim & Ko 2007, figure 4), uint8.

    Parameters
    ----------
    positions : three (N, 3) float
        Original, by hand and by quasi-eigen shapes, mm.
    captured, by_hand, by_quasi : (K, 3) float
        Markers in mm, NaN where one was not seen.

    Other parameters are those of ``frame_triplet_image``.
    """
    content = _content(mesh, None, texture)
    content.set_frame(frame or 0, (*positions, None), rms_mm)
    content.set_markers(captured, by_hand, by_quasi)
    return _frame_row(content, (BY_HAND, BY_QUASI), frame, view, size, colours, names)


def halved(image: NDArray[np.uint8]) -> Image:
    """Return a picture of half the size, every pixel the mean of four."""
    rows, columns = image.shape[0] // 2, image.shape[1] // 2
    parts = [image[y : 2 * rows : 2, x : 2 * columns : 2].astype(np.uint16) for y in (0, 1) for x in (0, 1)]
    return np.asarray((parts[0] + parts[1] + parts[2] + parts[3] + 2) // 4, dtype=np.uint8)


def _content(mesh: TriangleMesh | RigLook, skin: NDArray[Any] | None, texture: Image | None = None) -> BasisContent:
    content = BasisContent()
    content.rig = mesh if isinstance(mesh, RigLook) else RigLook(mesh, skin, texture)
    return content


def _frame_row(
    content: BasisContent,
    marked: Sequence[int],
    frame: int | None,
    view: str,
    size: Size,
    colours: ViewColours,
    names: bool,
) -> Image:
    titles = {ORIGINAL: "Original", BY_HAND: "By hand", BY_QUASI: "By quasi-eigen", BY_PCA: "By PCA"}
    shots: list[dict[str, Any]] = []
    for number, title in titles.items():
        if not content.has(number):
            continue
        note = f"RMS {content.rms[number]:.2f} mm" if number in content.rms else ""
        if number == ORIGINAL:
            note = "" if frame is None else f"frame {counted(frame + 1)}"
        shots.append(
            {
                "view": number, "look": "textured", "name": (title, note), "captured": content.captured,
                "rebuilt": content.rebuilt.get(number) if number in marked else None,
            }
        )  # fmt: skip
    return _row(content, shots, view, size, colours, names)


def _row(
    content: BasisContent,
    shots: Sequence[dict[str, Any]],
    view: str,
    size: Size,
    colours: ViewColours,
    names: bool,
) -> Image:
    """Return pictures side by side, the theme's window colour between them."""
    assert content.rig is not None
    gap = np.tile(np.round(np.array(rgb(colours.window)) * 255).astype(np.uint8), (size[1], _GAP_PX, 1))
    row: list[Image] = []
    with RigStills(*size, colours) as stage:
        stage.look(content.rig, view, *((1.28, 0.04) if names else (_ROOM, 0.0)))
        for shot in shots:
            options = dict(shot)
            pose = content.pose(options.pop("view"))
            assert pose is not None
            if not names:
                options["name"] = ("", "")
            row += [stage.picture(content.rig, pose, **options), gap]
    return np.concatenate(row[:-1], axis=1)
