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
    """Every module of the engine and of its tests imports with Qt and VTK blocked."""
    code = f"""
import importlib, pathlib, sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split('.')[0] in {WINDOWLESS!r}:
            raise ImportError(name + ' is blocked')
sys.meta_path.insert(0, Blocked())
count = 0
for path in sorted(pathlib.Path('engine').rglob('*.py')) + sorted(pathlib.Path('tests/engine').rglob('test_*.py')):
    parts = path.with_suffix('').parts
    importlib.import_module('.'.join(parts[:-1] if parts[-1] == '__init__' else parts))
    count += 1
print(count)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 20


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
