"""Opens what a performance is set up with: unit, axes, rate, head markers, pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from engine.errors import InputError

if TYPE_CHECKING:
    from studio.basis.controller import BasisStage


class MotionSettings:
    """Shows the settings of the performance in use, and sets up what was chosen."""

    def __init__(self, stage: BasisStage) -> None:
        self._stage = stage

    def open(self) -> None:
        """Show them.

        Raises
        ------
        InputError
            Without a performance.
        """
        if self._stage.context.motion is None:
            raise InputError("settings", "need a performance", "open one first")
