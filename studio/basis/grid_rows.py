"""Values that the widgets of the basis stage show: a shape of the grid, how many times one error is another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from engine.mesh import FloatArray

if TYPE_CHECKING:
    from engine.shapes import Rig
    from studio.basis.results import Analysis
    from widgets.basis.view_grid import GridRow


def grid_rows(rig: Rig, analysis: Analysis | None, amounts: FloatArray | None) -> list[GridRow]:
    """Return name, hand shape, shape in use, and the cosine between them; ``amounts`` (n,) tell what is in use."""
    if analysis is None or amounts is None:
        return [(name, rig.basis.displacements[i], None, None) for i, name in enumerate(rig.basis.names)]
    cosines = analysis.measures.cosine(amounts)
    rows: list[GridRow] = []
    for i, (name, amount) in enumerate(zip(analysis.names, amounts, strict=True)):
        hand, quasi = analysis.hand_shapes[i], analysis.quasi_shapes[i]
        used = quasi if amount == 1.0 else (1 - amount) * hand + amount * quasi
        rows.append((name, hand, used, float(cosines[i])))
    return rows


def ratio(above: float, below: float) -> float | None:
    """Return how many times ``below`` is ``above``; None where that cannot be said."""
    return above / below if below > 0 else None
