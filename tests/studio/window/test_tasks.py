"""Tasks: results arrive in order of wish, cancelled ones never, and shutting down waits."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest

from engine.errors import Cancelled, InputError
from studio.tasks import Task, TaskRunner, TaskState


@pytest.fixture
def runner(qapp: Any) -> Iterator[TaskRunner]:
    made = TaskRunner()
    yield made
    made.shutdown()


def test_result_arrives_in_the_gui_thread(runner: TaskRunner, qtbot: Any) -> None:
    seen: list[tuple[Any, threading.Thread]] = []
    threads: list[threading.Thread] = []

    def work(progress: Any) -> int:
        threads.append(threading.current_thread())
        progress(0.5, "half")
        return 42

    task = runner.submit("Work", work, lambda result: seen.append((result, threading.current_thread())))
    qtbot.waitUntil(lambda: bool(seen), timeout=5000)
    assert seen == [(42, threading.main_thread())]
    assert threads[0] is not threading.main_thread()
    assert task.state is TaskState.DONE and task.fraction == 1.0


def test_cancelled_task_stops_at_its_next_report_and_never_delivers(runner: TaskRunner, qtbot: Any) -> None:
    running, go, stopped = threading.Event(), threading.Event(), threading.Event()
    delivered: list[Any] = []

    def work(progress: Any) -> str:
        running.set()
        go.wait(5)
        try:
            progress(0.5, "")
        except Cancelled:
            stopped.set()
            raise
        return "late"

    task = runner.submit("Work", work, delivered.append)
    assert running.wait(5)
    runner.cancel(task)
    go.set()
    assert stopped.wait(5)
    qtbot.wait(50)
    assert delivered == [] and task.state is TaskState.CANCELLED and not runner.busy


def test_result_of_a_task_that_does_not_listen_is_dropped(runner: TaskRunner, qtbot: Any) -> None:
    go, ended = threading.Event(), threading.Event()
    delivered: list[Any] = []

    def work(_progress: Any) -> str:
        go.wait(5)
        ended.set()
        return "late"

    task = runner.submit("Work", work, delivered.append)
    runner.cancel(task)
    go.set()
    ended.wait(5)
    qtbot.wait(50)
    assert delivered == []


def test_the_latest_of_a_key_wins(runner: TaskRunner, qtbot: Any) -> None:
    go = threading.Event()
    delivered: list[int] = []

    def work(number: int) -> Any:
        def inner(progress: Any) -> int:
            go.wait(5)
            progress(0.9, "")
            return number

        return inner

    for number in range(5):
        runner.submit("Preview", work(number), delivered.append, key="preview", quiet=True)
    go.set()
    qtbot.waitUntil(lambda: bool(delivered), timeout=5000)
    qtbot.wait(50)
    assert delivered == [4]


def test_failure_says_what_to_do(runner: TaskRunner, qtbot: Any) -> None:
    def work(_progress: Any) -> None:
        raise InputError("a.ply", "is cut off", "save it again")

    with qtbot.waitSignal(runner.failed, timeout=5000) as caught:
        runner.submit("Open a.ply", work, lambda _result: None)
    task: Task = caught.args[0]
    assert task.error == "a.ply: is cut off; save it again" and task.state is TaskState.FAILED


def test_our_own_fault_goes_to_the_crash_handler(runner: TaskRunner, qtbot: Any) -> None:
    crashes: list[BaseException] = []
    runner.on_crash = crashes.append
    runner.submit("Work", lambda _progress: 1 / 0, lambda _result: None)
    qtbot.waitUntil(lambda: bool(crashes), timeout=5000)
    assert isinstance(crashes[0], ZeroDivisionError)


def test_progress_is_throttled_and_time_left_follows_it(runner: TaskRunner, qtbot: Any) -> None:
    reports: list[float] = []
    runner.changed.connect(lambda task: reports.append(task.fraction))
    done: list[int] = []

    def work(progress: Any) -> int:
        for k in range(20000):
            progress(k / 20000, "step")
        return 1

    runner.submit("Work", work, done.append)
    qtbot.waitUntil(lambda: bool(done), timeout=10000)
    assert 2 <= len(reports) < 200
    assert reports == sorted(reports)


def test_shutdown_waits_for_the_threads(qapp: Any) -> None:
    runner = TaskRunner()
    ended = threading.Event()
    started = threading.Event()

    def work(progress: Any) -> None:
        started.set()
        try:
            while True:
                progress(0.1, "")
        finally:
            ended.set()

    runner.submit("Work", work, lambda _result: None)
    assert started.wait(5)
    runner.shutdown()
    assert ended.is_set()
    assert runner.submit("Late", work, lambda _result: None).state is TaskState.CANCELLED
