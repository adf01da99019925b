"""How linked views share the room of their viewer: in one run, or in the cells of a grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

Rect = tuple[float, float, float, float]
"""Left, bottom, width and height in pixels, from the lower left."""


class Cell(NamedTuple):
    """Where a view stands in a grid, rows from the top, and how many rows and columns it takes."""

    row: int
    column: int
    rows: int = 1
    columns: int = 1


def in_a_run(views: Sequence[int], width: int, height: int, gap: int) -> dict[int, Rect]:
    """Return views of one size side by side in a wide room, one over the other in a high one."""
    if height >= width:
        return in_a_grid({view: Cell(k, 0) for k, view in enumerate(views)}, width, height, gap)
    return in_a_grid({view: Cell(0, k) for k, view in enumerate(views)}, width, height, gap)


def in_a_grid(cells: Mapping[int, Cell], width: int, height: int, gap: int) -> dict[int, Rect]:
    """Return the views of a grid whose rows and columns are ``gap`` pixels apart; edges lie on whole pixels."""
    if not cells:
        return {}
    rows = max(cell.row + cell.rows for cell in cells.values())
    columns = max(cell.column + cell.columns for cell in cells.values())
    step_x, step_y = (width + gap) / columns, (height + gap) / rows
    rects: dict[int, Rect] = {}
    for view, cell in cells.items():
        left, right = round(cell.column * step_x), round((cell.column + cell.columns) * step_x - gap)
        top, bottom = round(cell.row * step_y), round((cell.row + cell.rows) * step_y - gap)
        rects[view] = (left, height - bottom, max(right - left, 1), max(bottom - top, 1))
    return rects
