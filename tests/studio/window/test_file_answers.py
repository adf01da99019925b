"""The defined answers: a file changed outside, write-protected, in use, from an older program, and a full disk."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QLockFile

from engine.errors import InputError
from studio.project import store
from studio.project.document import Project
from studio.project.stamp import Stamp
from studio.project_lock import ProjectInUseError, ProjectLock
from studio.scan.commands import RenameScan
from studio.session import Session
from studio.settings import Settings

OLD = Path(__file__).parents[1] / "data" / "version1.qface"
Open = Callable[[], Session]


@pytest.fixture
def sessions(qapp: Any, tmp_path: Path) -> Iterator[Open]:
    """Return what makes a session, as a window has one."""
    made: list[Session] = []

    def make() -> Session:
        session = Session(Settings(tmp_path / f"{len(made)}.ini"))
        session.told = []
        session.message.connect(lambda kind, text: session.told.append((kind, text)))
        made.append(session)
        return session

    yield make
    for session in made:
        session.close()


@pytest.fixture
def project_file(tmp_path: Path) -> Path:
    folder = tmp_path / "work"
    folder.mkdir()
    return store.save(store.load(OLD), folder / "a.qface")


def rename(session: Session, name: str) -> None:
    """Make a step."""
    project = session.project
    session.stack.push(RenameScan(project, project.scans[0].id, name))


def first_name(path: Path) -> str:
    return store.load(path).scans[0].name


# -- older versions ----------------------------------------------------------------------------------------------------


def test_opening_an_older_file_changes_nothing_and_the_first_saving_keeps_it(sessions: Open, tmp_path: Path) -> None:
    path = Path(shutil.copy(OLD, tmp_path / "old.qface"))
    before, session = path.read_bytes(), sessions()
    session.open(path)
    assert path.read_bytes() == before and not session.is_dirty and not session.told
    rename(session, "another")
    session.save()
    kept = tmp_path / "old.v1.qface.bak"
    assert kept.read_bytes() == before and first_name(path) == "another"
    assert session.told == [("info", "old.qface was of an older version; it is kept as old.v1.qface.bak")]
    rename(session, "a third")
    session.save()
    assert kept.read_bytes() == before and len(session.told) == 1
    assert not list(tmp_path.glob("*.bak.*")) and len(list(tmp_path.glob("*.bak"))) == 1


def test_a_backup_never_replaces_another(sessions: Open, tmp_path: Path) -> None:
    path = Path(shutil.copy(OLD, tmp_path / "old.qface"))
    (tmp_path / "old.v1.qface.bak").write_text("somebody's")
    session = sessions()
    session.open(path)
    session.save()
    assert (tmp_path / "old.v1.qface.bak").read_text() == "somebody's"
    assert (tmp_path / "old.v1-2.qface.bak").read_bytes() == OLD.read_bytes()


# -- changed outside ---------------------------------------------------------------------------------------------------


def test_a_change_from_outside_is_known_and_touching_is_none(sessions: Open, project_file: Path) -> None:
    session = sessions()
    session.open(project_file)
    assert not session.changed_outside
    os.utime(project_file, (1.0, 1.0))
    assert not session.changed_outside, "the content is the same"
    other = store.load(project_file)
    other.change_scan(other.scans[0].id, name="theirs")
    store.save(other, project_file)
    assert session.changed_outside
    rename(session, "mine")
    session.save()
    assert not session.changed_outside and first_name(project_file) == "mine"


def test_one_digit_in_the_header_is_a_change(project_file: Path) -> None:
    stamp = Stamp.of(project_file)
    data = project_file.read_bytes()
    at = data.index(b'"name":"base"') + 8
    project_file.write_bytes(data[:at] + b"x" + data[at + 1 :])
    assert stamp is not None and not stamp.fits(project_file)
    assert Stamp.of(project_file.parent / "none") is None and not stamp.fits(project_file.parent / "none")


def test_a_file_that_is_gone_is_written_again(sessions: Open, project_file: Path) -> None:
    session = sessions()
    session.open(project_file)
    rename(session, "mine")
    project_file.unlink()
    assert not session.changed_outside
    session.save()
    assert first_name(project_file) == "mine"


def test_restored_work_knows_that_the_file_was_changed_meanwhile(sessions: Open, project_file: Path) -> None:
    session = sessions()
    project, digest = store.load(project_file), Stamp.of(project_file).digest
    session.take_over(project, digest)
    assert session.is_dirty and not session.changed_outside
    session.new()
    other = store.load(project_file)
    other.change_scan(other.scans[0].id, name="theirs")
    store.save(other, project_file)
    session.take_over(project, digest)
    assert session.changed_outside


# -- a disk that will not ----------------------------------------------------------------------------------------------


def test_a_write_protected_file_is_not_gone_past(sessions: Open, project_file: Path) -> None:
    session = sessions()
    session.open(project_file)
    rename(session, "mine")
    project_file.chmod(0o444)
    before = project_file.read_bytes()
    with pytest.raises(InputError, match=r"a\.qface: is write-protected; save the project under another name"):
        session.save()
    assert project_file.read_bytes() == before and session.is_dirty
    session.save(project_file.with_name("b.qface"))
    assert first_name(project_file.with_name("b.qface")) == "mine" and not session.is_dirty


def test_the_rights_of_a_file_are_kept(sessions: Open, project_file: Path) -> None:
    session = sessions()
    session.open(project_file)
    project_file.chmod(0o664)
    rename(session, "mine")
    session.save()
    assert project_file.stat().st_mode & 0o777 == 0o664


FULL = """
import resource, signal, sys
from pathlib import Path
from engine.errors import InputError
from studio.project import store
path = Path(sys.argv[1])
project = store.load(path)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
try:
    store.save(project, path)
except InputError as error:
    print(error)
    sys.exit(2)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on the size of files")
@pytest.mark.parametrize("size", [0, 4096, 50_000, 140_000])
def test_a_full_disk_leaves_the_old_file_and_nothing_else(project_file: Path, size: int) -> None:
    """The system itself refuses to write on, as it does where a disk is full."""
    before = project_file.read_bytes()
    assert len(before) > 140_000
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(project_file), str(size)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2, done.stderr
    assert "a.qface: cannot be written (" in done.stdout and "space" in done.stdout and done.stdout.count("\n") == 1
    assert project_file.read_bytes() == before and list(project_file.parent.iterdir()) == [project_file]


# -- two studios -------------------------------------------------------------------------------------------------------


def test_a_second_window_is_told_and_gets_a_copy(sessions: Open, project_file: Path) -> None:
    one, two = sessions(), sessions()
    one.open(project_file)
    with pytest.raises(ProjectInUseError, match=r"a\.qface: is open in another window since .*; go on there"):
        two.open(project_file)
    assert not two.project.scans
    two.open(project_file, as_copy=True)
    assert two.project.path is None and two.project.scans == one.project.scans
    rename(two, "theirs")
    with pytest.raises(ProjectInUseError):
        two.save(project_file)
    rename(one, "mine")
    one.save()
    assert first_name(project_file) == "mine"
    one.new()
    two.save(project_file)
    assert first_name(project_file) == "theirs"
    one.close()
    two.close()
    assert list(project_file.parent.iterdir()) == [project_file]


def test_a_failing_open_or_save_changes_no_lock(sessions: Open, project_file: Path) -> None:
    one, two = sessions(), sessions()
    one.open(project_file)
    bad = project_file.with_name("bad.qface")
    bad.write_text("no project")
    with pytest.raises(InputError):
        one.open(bad)
    assert not list(bad.parent.glob(".bad*"))
    with pytest.raises(ProjectInUseError):
        two.open(project_file)
    one.save(project_file.with_name("b.qface"))
    two.open(project_file)


def test_the_lock_of_a_dead_process_is_taken_over(sessions: Open, project_file: Path) -> None:
    code = (
        "import os, sys\nfrom pathlib import Path\nfrom studio.project_lock import ProjectLock\n"
        "lock = ProjectLock(Path(sys.argv[1]))\nlock.take()\nos.kill(os.getpid(), 9)"
    )
    subprocess.run([sys.executable, "-c", code, str(project_file)], timeout=60)
    assert ProjectLock(project_file).file.exists()
    sessions().open(project_file)


def test_the_lock_of_another_machine_is_taken_only_by_force(sessions: Open, project_file: Path) -> None:
    lock = ProjectLock(project_file)
    with_lock = QLockFile(str(lock.file))
    assert with_lock.tryLock(0)
    text = lock.file.read_text()
    with_lock.unlock()
    assert socket.gethostname() in text
    lock.file.write_text(text.replace(socket.gethostname(), "render-07"))
    os.utime(lock.file, (time.time() - 1e6, time.time() - 1e6))
    session = sessions()
    with pytest.raises(ProjectInUseError, match=r"is open on render-07 since") as caught:
        session.open(project_file)
    assert caught.value.can_take
    session.open(project_file, by_force=True)
    assert session.project.scans
    with pytest.raises(ProjectInUseError) as caught:
        sessions().open(project_file, by_force=True)
    assert not caught.value.can_take, "a living window of this machine is never pushed aside"


def test_restored_work_whose_file_is_open_elsewhere_has_no_name(sessions: Open, project_file: Path) -> None:
    one, two = sessions(), sessions()
    one.open(project_file)
    two.take_over(store.load(project_file), "")
    assert two.project.path is None and two.is_dirty and "has no file yet" in two.told[0][1]


def test_what_a_killed_saving_left_goes_with_the_next_and_nobody_elses_does(
    sessions: Open, project_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The other one is in the middle of its saving, and its name begins like this one's."""
    temporaries: list[Path] = []
    real = store._write

    def write(project: Project, path: Path, *more: Any) -> None:
        temporaries.append(path)
        real(project, path, *more)

    monkeypatch.setattr(store, "_write", write)
    own, other = [project_file.with_name(f"{'the scans of the second day, all faces ' * 2}{end}.qface") for end in "ab"]
    for path in (own, other):
        store.save(store.load(project_file), path)
    others = [temporaries[1], *(own.with_name(f".{own.name}{end}") for end in (".part", ".0123abcd.part"))]
    for path in (temporaries[0], *others):
        path.touch()
    session = sessions()
    session.open(own)
    session.save()
    assert not temporaries[0].exists() and all(path.exists() for path in others)


def test_a_project_without_a_file_needs_no_lock(sessions: Open) -> None:
    session = sessions()
    session.take_over(Project())
    session.new()
    assert session.stamp is None and session.stamp_digest == ""
