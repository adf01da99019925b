"""Words and plates in a 3-D view: measured in screen pixels, in the window's own font.

A renderer draws flat parts in the order they were made: what lies in front is made last.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import vtkmodules.vtkRenderingFreeType
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D, vtkTextActor, vtkTextProperty, vtkTextRenderer

from widgets.scene.background import rgb

assert vtkmodules.vtkRenderingFreeType

_REGULAR = ("inter-regular.otf", "inter-regular.ttf", "segoeui.ttf", "arial.ttf", "notosans-regular.ttf")
_BOLD = ("inter-semibold.otf", "inter-semibold.ttf", "seguisb.ttf", "arial bold.ttf", "notosans-semibold.ttf",
         "notosans-bold.ttf")  # fmt: skip
_DPI = 72  # points and pixels are the same


@lru_cache(maxsize=2)
def font_file(bold: bool) -> str:
    """Return the file of Inter, weight 400 or 600, or of the sans-serif font that stands in for it.

    The usual folders are searched by file name: a catalogue of all fonts would take seconds at the first start.
    """
    wanted = _BOLD if bold else _REGULAR
    for folder in _font_folders():
        found = {path.name.lower(): path for path in folder.rglob("*.[ot]t[fc]")} if folder.is_dir() else {}
        for name in wanted:
            if name in found:
                return str(found[name])
    import matplotlib  # its own copy of DejaVu Sans is always there

    return str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / f"DejaVuSans{'-Bold' if bold else ''}.ttf")


def _font_folders() -> tuple[Path, ...]:
    home = Path.home()
    if sys.platform == "win32":
        return (home / "AppData/Local/Microsoft/Windows/Fonts", Path("C:/Windows/Fonts"))
    if sys.platform == "darwin":
        return (home / "Library/Fonts", Path("/Library/Fonts"), Path("/System/Library/Fonts"))
    return (home / ".local/share/fonts", home / ".fonts", Path("/usr/local/share/fonts"), Path("/usr/share/fonts"))


class Words:
    """One line of text in a renderer, its left end and base at a place in pixels from the lower left."""

    def __init__(self, renderer: Any, *, bold: bool = False) -> None:
        self._renderer = renderer
        self.actor = vtkTextActor()
        self.actor.SetTextScaleModeToNone()
        self.actor.PickableOff()
        style = self.actor.GetTextProperty()
        style.SetFontFamily(4)  # VTK_FONT_FILE
        style.SetFontFile(font_file(bold))
        style.SetVerticalJustificationToBottom()
        renderer.AddViewProp(self.actor)
        self.text = ""
        self.width = 0.0

    def set(self, text: str, colour: str, size: float) -> None:
        """Write ``text`` in ``colour``, ``size`` pixels high (em)."""
        style = self.actor.GetTextProperty()
        style.SetColor(*rgb(colour))
        style.SetFontSize(round(size))
        self.text = text
        self.actor.SetInput(text)
        self.actor.SetVisibility(bool(text))
        self.width = text_width(text, style)

    def move(self, x: float, y: float) -> None:
        """Put the left end of the base line at (x, y) pixels."""
        self.actor.SetPosition(round(x), round(y))

    def hide(self, hidden: bool = True) -> None:
        """Hide the line or show it again."""
        self.actor.SetVisibility(not hidden and bool(self.text))

    def remove(self) -> None:
        """Take the line out of its renderer."""
        self._renderer.RemoveViewProp(self.actor)


def text_width(text: str, style: vtkTextProperty) -> float:
    """Return how many pixels wide a line is."""
    if not text:
        return 0.0
    box = [0, 0, 0, 0]
    vtkTextRenderer.GetInstance().GetBoundingBox(style, text, box, _DPI)
    return float(box[1] - box[0] + 1)


class Shape2D:
    """A flat coloured polygon, strip or set of lines in a renderer, in pixels from the lower left."""

    def __init__(self, renderer: Any) -> None:
        self._renderer = renderer
        self._data = vtkPolyData()
        self._mapper = vtkPolyDataMapper2D()
        self._mapper.SetInputData(self._data)
        self.actor = vtkActor2D()
        self.actor.SetMapper(self._mapper)
        self.actor.PickableOff()
        self.actor.VisibilityOff()
        renderer.AddViewProp(self.actor)

    def polygon(self, points: Sequence[Sequence[float]], colour: str, opacity: float = 1.0) -> None:
        """Fill a convex polygon (k, 2)."""
        self._put(np.asarray(points, dtype=np.float64), [list(range(len(points)))], fill=True)
        self._paint(colour, opacity)

    def lines(
        self, points: Sequence[Sequence[float]], runs: Sequence[Sequence[int]], colour: str, width: float
    ) -> None:
        """Draw polylines over points (k, 2)."""
        self._put(np.asarray(points, dtype=np.float64), runs, fill=False)
        self._paint(colour, 1.0)
        self.actor.GetProperty().SetLineWidth(width)

    def strip(self, left: float, right: float, bottom: float, top: float, colours: Any) -> None:
        """Fill a box with a run of colours (k, 3) uint8 from left to right, each an upright band."""
        colours = np.ascontiguousarray(colours, dtype=np.uint8)
        x = np.linspace(left, right, len(colours) + 1)
        points = np.stack([np.repeat(x, 2), np.tile([bottom, top], len(x))], axis=1)
        quads = [[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1] for k in range(len(colours))]
        self._put(points, quads, fill=True)
        scalars = numpy_to_vtk(colours, deep=True)  # type: ignore[no-untyped-call]
        self._data.GetCellData().SetScalars(scalars)
        self._mapper.SetScalarModeToUseCellData()
        self._mapper.ScalarVisibilityOn()
        self.actor.VisibilityOn()

    def hide(self, hidden: bool = True) -> None:
        """Hide the shape or show it again."""
        self.actor.SetVisibility(not hidden)

    def remove(self) -> None:
        """Take the shape out of its renderer."""
        self._renderer.RemoveViewProp(self.actor)

    def _put(self, points: Any, cells: Sequence[Sequence[int]], *, fill: bool) -> None:
        place = vtkPoints()
        place.SetDataTypeToDouble()
        for x, y in points:
            place.InsertNextPoint(float(x), float(y), 0.0)
        array = vtkCellArray()
        for cell in cells:
            array.InsertNextCell(len(cell))
            for index in cell:
                array.InsertCellPoint(int(index))
        self._data.Initialize()
        self._data.SetPoints(place)
        if fill:
            self._data.SetPolys(array)
        else:
            self._data.SetLines(array)

    def _paint(self, colour: str, opacity: float) -> None:
        self._mapper.ScalarVisibilityOff()
        self.actor.GetProperty().SetColor(*rgb(colour))
        self.actor.GetProperty().SetOpacity(opacity)
        self.actor.VisibilityOn()


def rounded(left: float, bottom: float, width: float, height: float, radius: float) -> list[tuple[float, float]]:
    """Return the outline of a box with round corners, in pixels."""
    radius = min(radius, width / 2, height / 2)
    right, top = left + width, bottom + height
    centres = ((right - radius, top - radius, 0), (left + radius, top - radius, 90),
               (left + radius, bottom + radius, 180), (right - radius, bottom + radius, 270))  # fmt: skip
    outline = []
    for x, y, start in centres:
        for step in range(5):
            angle = np.radians(start + 22.5 * step)
            outline.append((float(x + radius * np.cos(angle)), float(y + radius * np.sin(angle))))
    return outline
