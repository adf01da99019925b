"""The dot on the tab of the basis stage while the stage itself is not made yet."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from studio.main_window import MainWindow


def follow_basis_tab(window: MainWindow) -> None:
    """Say on the tab what an opened project has for the basis stage, and show the stage where it has nothing else.

    Once made, the stage says itself how far it is.
    """

    def tell() -> None:
        if "basis" in window.stages:
            return
        basis = window.session.project.basis
        counts = ((len(basis.rigs), "rig"), (len(basis.motions), "performance"))
        held = " and ".join(f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts if count)
        reason = f"{held}, not looked at yet" if held else "open a hand-sculpted rig"
        window.set_stage_state("basis", "stale" if held else "missing", reason)

    def show() -> None:
        project = window.session.project
        if not project.scans and (project.basis.rigs.all or project.basis.motions.all):
            window.show_stage("basis")

    window.session.replaced.connect(tell)
    window.session.replaced.connect(show)
    tell()
