"""The page on the scan stage names keys that exist, and leaves out none of the stage's own."""

from __future__ import annotations

import re
from pathlib import Path

from studio.actions import SPECS
from widgets.canvases.canvas_keys import HABITS
from widgets.viewers import navigation

PAGE = Path(__file__).parents[3] / "docs" / "scan.md"
ELSEWHERE = {"scan.add", "scan.add_folder", "scan.import", "scan.export", "scan.export_face", "scan.fit_all"}
"""Actions of the stage whose keys stand in their menus alone: files, and what every fit has."""


def documented() -> set[str]:
    text = PAGE.read_text("utf-8")
    table = text[text.index("| key | what it does |") :].split("\n\n")[0].splitlines()[2:]
    cells = [row.strip("|").split("|")[0].strip().replace("+,,", "+\0,") for row in table]
    return {key.strip().replace("\0", ",") for cell in cells for key in re.split(r",\s*", cell) if key.strip()}


def test_every_documented_key_does_something() -> None:
    style = navigation.STUDIO
    known = {key.replace("Return", "Enter") for spec in SPECS for key in spec.shortcuts}
    known |= {hand for hand, _ in HABITS} | {gesture.text for gesture in (*style.views, *style.pictures)}
    assert documented() - known == set()


def test_every_key_of_the_scan_stage_is_documented() -> None:
    told = documented()
    keys = {
        spec.id: [key.replace("Return", "Enter") for key in spec.shortcuts]
        for spec in SPECS
        if spec.id.startswith("scan.") and spec.shortcuts and spec.id not in ELSEWHERE
    }
    missing = {action: keys for action, keys in keys.items() if not told & set(keys)}
    assert not missing
