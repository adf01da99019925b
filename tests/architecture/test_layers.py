"""The arrow studio -> widgets -> engine, and what must run without Qt and VTK."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WINDOWLESS = ("PySide6", "pyvista", "pyvistaqt", "vtkmodules", "qtawesome")


def test_import_contracts_hold() -> None:
    lint = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run([lint, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_engine_tests_run_where_qt_and_vtk_cannot_be_imported() -> None:
    """All engine tests are collected, and those of the geometry run, with Qt and VTK blocked."""
    code = f"""
import sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split('.')[0] in {WINDOWLESS!r}:
            raise ImportError(name + ' is blocked')
sys.meta_path.insert(0, Blocked())
import pytest
common = ['-c', 'tests/engine/pytest.ini', '-p', 'no:pytest-qt', '-p', 'no:xvfb', '-p', 'no:cacheprovider']
collected = pytest.main(['tests/engine', '--collect-only', *common])
sys.exit(collected or pytest.main(['tests/engine/geometry', 'tests/engine/scan/test_warp_fit.py', *common]))
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


@pytest.mark.parametrize("folder", ["engine", "widgets", "studio", "resources"])
def test_files_stay_readable(folder: str) -> None:
    long = {str(p): n for p in (ROOT / folder).rglob("*.py") if (n := len(p.read_text().splitlines())) > 400}
    assert not long, f"split these files: {long}"


def test_nothing_is_pickled() -> None:
    for folder in ("engine", "widgets", "studio"):
        for path in (ROOT / folder).rglob("*.py"):
            text = path.read_text()
            assert "import pickle" not in text, path
            assert "allow_pickle=True" not in text, path
