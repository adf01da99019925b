"""Every file of the hostile corpus gives a value or one line of advice, in little time and memory, and in silence."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from studio import cli
from tests.engine.files.corpus import Case, cases, complaint, read_all
from tests.engine.files.corpus_bombs import zeros
from tests.engine.files.corpus_runner import MOST_MB, READERS, ROOT
from tests.engine.files.corpus_seeds import seeds

pytestmark = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is measured on Linux only")

SEEDS = seeds()
DAMAGED_OF_WHICH_ONE_IS_READ = 5
"""``python -m tests.engine.files.corpus`` reads all of them; here every bomb and a fifth of the damaged files."""


def sample() -> list[Case]:
    """Every hand-made file, and every fifth of those made by damaging a good one."""
    bombs = [case for case in cases() if case.name.split(":")[0] not in SEEDS]
    damaged = [case for case in cases() if case.name.split(":")[0] in SEEDS]
    return bombs + damaged[::DAMAGED_OF_WHICH_ONE_IS_READ]


@pytest.mark.timeout(600)
def test_no_file_gets_the_better_of_a_reader():
    chosen = sample()
    assert len(chosen) > 500
    assert {case.reader for case in chosen} == set(READERS)
    outcomes, printed = read_all(chosen)
    wrong = {case.name: text for case, found in zip(chosen, outcomes, strict=True) if (text := complaint(case, found))}
    assert wrong == {}
    assert printed == ""


def test_every_seed_is_a_good_file():
    chosen = [Case(name, seed.reader, _whole(seed)) for name, seed in SEEDS.items()]
    outcomes, _ = read_all(chosen)
    assert [case.name for case, found in zip(chosen, outcomes, strict=True) if found.kind != "value"] == []


def test_the_measurement_sees_memory_tracebacks_and_crashes(tmp_path, monkeypatch):
    code = (
        "import sys, numpy, runpy, types; import tests.engine.files.corpus_runner as r\n"
        "bad = types.ModuleType('bad')\n"
        "bad.large = lambda path: numpy.ones(150_000_000).sum()\n"
        "bad.wrong = lambda path: {}['key']\n"
        "bad.end = lambda path: __import__('os')._exit(3)\n"
        "sys.modules['bad'] = bad\n"
        "r.READERS.clear()\n"
        "r.READERS.update(large=('bad', 'large'), wrong=('bad', 'wrong'), end=('bad', 'end'))\n"
        "r._serve()\n"
    )
    asked = "".join(json.dumps([name, "x"]) + "\n" for name in ("large", "wrong", "end"))
    done = subprocess.run(
        [sys.executable, "-c", code], input=asked, capture_output=True, text=True, cwd=ROOT, timeout=100, check=False
    )
    ready, large, wrong = done.stdout.splitlines()
    assert ready == "ready"
    assert json.loads(large)["megabytes"] > MOST_MB
    assert json.loads(wrong)["kind"] == "traceback"
    assert done.returncode == 3


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.sampled_from(sorted(SEEDS)), data=st.data())
def test_anything_spliced_into_a_good_file_of_any_kind(tmp_path, name, data):
    seed = SEEDS[name]
    module, function = READERS[seed.reader]
    reader = getattr(__import__(module, fromlist=[function]), function)
    start = data.draw(st.integers(0, len(seed.data)))
    stop = data.draw(st.integers(start, min(len(seed.data), start + 60)))
    middle = data.draw(st.binary(max_size=60) | st.sampled_from([b"-1", b"1e999", b"nan", b"\0", b"\n", b"9" * 40]))
    path = _whole(seed)(tmp_path)
    path.write_bytes(seed.data[:start] + middle + seed.data[stop:])
    try:
        reader(path)
    except InputError as error:
        assert "\n" not in str(error)
        assert error.remedy
        assert str(tmp_path) in error.subject


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("s.pcd", SEEDS["pcd binary"].data[:-7]),
        ("s.abs", SEEDS["abs"].data[:-70]),
        ("s.abs.gz", b"\x1f\x8b\x08\0\0\0\0\0\0\3" + zeros(1 << 20)),
        ("s.xyz", b"1 2 3\n" * 500),
        ("s.npz", SEEDS["npz"].data[:-7]),
        ("s.ply", SEEDS["ply ascii grid"].data[:-70]),
        ("s.json", b'{"depth": "../../etc/passwd"}'),
        ("m.obj", b"v 0 0 0\nf 1 2 1000000000\n"),
        ("m.glb", SEEDS["glb"].data[:-7]),
    ],
)
def test_the_command_line_refuses_in_one_line(tmp_path, name, data, capfd):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(SystemExit) as ended:
        sys.exit(cli.main(["scan", "info", str(tmp_path / name)]))
    out, err = capfd.readouterr()
    assert ended.value.code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert name in err


def _whole(seed):
    def make(folder: Path) -> Path:
        for name, content in ((seed.name, seed.data), *seed.beside):
            (folder / name).write_bytes(content)
        return folder / seed.name

    return make
