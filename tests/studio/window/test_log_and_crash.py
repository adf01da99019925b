"""The log keeps what is said within bounds; reports say what is needed and no more; native crashes are told once."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from studio import log
from studio.crash import CrashHandler
from studio.crash_report import PACKAGES, without_folders, write_report
from studio.native_crash import NativeWatch


@pytest.fixture
def ring() -> Any:
    log.attach()
    log.ring.clear()
    yield log.ring
    log.ring.clear()
    log.detach()


def test_the_log_keeps_the_last_lines_of_every_thread_and_no_more(ring: Any) -> None:
    heard: list[str] = []
    ring.listener = lambda line: heard.append(line.text)

    def speak(name: str) -> None:
        for k in range(log.KEPT_LINES // 2 + 10):
            log.studio_log.info("%s %d", name, k)

    threads = [threading.Thread(target=speak, args=(name,)) for name in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    ring.listener = None
    assert len(ring.lines) == log.KEPT_LINES and len(heard) == log.KEPT_LINES + 20
    assert [line.text for line in ring.lines] == heard[20:]
    assert sorted(line.text for line in ring.lines[-2:])[0][0] in "ab"


def test_levels_words_and_exceptions_are_kept(ring: Any) -> None:
    try:
        raise KeyError("nose")
    except KeyError:
        log.studio_log.exception("reading failed")
    logging.getLogger("other").warning("careful")
    logging.getLogger("other").info("chatter")
    words = [(line.word, line.source) for line in ring.lines]
    assert words == [("error", "studio"), ("warning", "other")]
    assert "KeyError: 'nose'" in ring.lines[0].text and "reading failed" in log.tail(2)[0]


def test_the_same_lines_go_to_a_file_that_turns_over(
    ring: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log, "FILE_BYTES", 2000)
    with log.to_file(tmp_path) as path:
        for k in range(200):
            log.studio_log.info("line %d", k)
    log.studio_log.info("after")
    files = sorted(tmp_path.iterdir())
    assert path in files and len(files) == log.FILE_COUNT + 1
    assert all(file.stat().st_size <= 2000 for file in files)
    text = path.read_text("utf-8")
    assert "line 199" in text and "after" not in text


def test_a_log_folder_that_cannot_be_written_stops_nothing(ring: Any, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with log.to_file(tmp_path / "file" / "logs"):
        log.studio_log.info("still here")
    assert [line.text for line in ring.lines][-1] == "still here"
    assert "cannot be written" in ring.lines[0].text


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ('  File "/home/ann/work/studio/scan/files.py", line 3, in x', '  File "studio/scan/files.py", line 3, in x'),
        ("No such file: '/home/ann/Big Client/face.ply'", "No such file: 'face.ply'"),
        ("Wrote /srv/Big Client/a.glb", "Wrote a.glb"),
        (r"Wrote C:\Users\ann\Big Client\a.glb", "Wrote a.glb"),
        ("~/clients/a.obj: is empty", "a.obj: is empty"),
        ("1/2 done, 3 mm / s, see https://host/path/x", "1/2 done, 3 mm / s, see https://host/path/x"),
    ],
)
def test_reports_keep_the_names_of_files_and_no_folders(text: str, kept: str) -> None:
    assert without_folders(text) == kept


def test_a_report_says_versions_facts_traceback_and_log_but_not_where_the_user_works(tmp_path: Path) -> None:
    secret = Path.home() / "Secret Client" / "face.ply"
    try:
        secret.open()
    except OSError as error:
        path = write_report(error, tmp_path, {"OpenGL renderer": "llvmpipe"}, (f"12:00 info: Reading {secret}",))
    text = path.read_text("utf-8")
    assert all(f"{name}: " in text for name in (*PACKAGES, "Python", "System", "OpenGL renderer"))
    assert "FileNotFoundError" in text and "face.ply" in text and "Reading face.ply" in text
    assert "Secret Client" not in text and str(Path.home()) + os.sep not in text


@pytest.mark.qt_no_exception_capture
def test_work_is_kept_before_anything_is_shown_and_a_fault_at_the_same_place_is_shown_once(
    tmp_path: Path, ring: Any, capsys: Any
) -> None:
    happened: list[str] = []
    handler = CrashHandler(lambda *_: happened.append("shown"), tmp_path, keep=lambda: happened.append("kept"))
    for _ in range(3):
        try:
            {}["nose"]
        except KeyError as error:
            handler.handle(error)
    try:
        {}["chin"]
    except KeyError as error:
        handler.handle(error)
    assert happened == ["kept", "shown"] * 2
    assert len(list(tmp_path.glob("*.txt"))) == 2
    assert sum("again" in line.text for line in ring.lines) == 2


@pytest.mark.qt_no_exception_capture
def test_a_report_that_cannot_be_written_and_work_that_cannot_be_kept_are_still_told(
    tmp_path: Path, ring: Any, capsys: Any
) -> None:
    (tmp_path / "file").write_text("")
    shown: list[tuple[Any, ...]] = []

    def fail() -> None:
        raise OSError("disk full")

    handler = CrashHandler(lambda *values: shown.append(values), tmp_path / "file", keep=fail)
    handler.handle(ValueError("odd"))
    assert shown[0][2] is None and "could not be written" in shown[0][1] and "odd" in shown[0][1]
    assert any("disk full" in line.text for line in ring.lines)


@pytest.mark.qt_no_exception_capture
def test_a_fault_in_a_thread_is_reported(tmp_path: Path, ring: Any, capsys: Any) -> None:
    handler = CrashHandler(lambda *_: None, tmp_path)
    handler.install()
    try:
        thread = threading.Thread(target=lambda: {}["ear"])
        thread.start()
        thread.join()
    finally:
        handler.uninstall()
    (report,) = tmp_path.glob("*.txt")
    assert "KeyError: 'ear'" in report.read_text("utf-8")


def test_a_native_crash_is_told_once_at_the_next_start_and_a_kill_leaves_nothing(tmp_path: Path) -> None:
    program = (
        "import sys, faulthandler, os, signal; from pathlib import Path; from studio.native_crash import NativeWatch\n"
        "watch = NativeWatch(Path(sys.argv[1])); watch.start()\n"
        "faulthandler._sigsegv() if sys.argv[2] == 'crash' else os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    for way in ("crash", "kill"):
        ended = subprocess.run([sys.executable, "-c", program, str(tmp_path), way], capture_output=True, check=False)
        assert ended.returncode < 0, ended.stderr
    watch = NativeWatch(tmp_path)
    watch.start()
    (report,) = watch.left_behind()
    assert "Segmentation fault" in report.read_text("utf-8")
    assert watch.left_behind() == ()
    watch.stop()
    assert list(tmp_path.iterdir()) == [report]
