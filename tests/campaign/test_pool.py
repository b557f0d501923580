from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from processes import alive, soon

from scaloft_fi.campaign.processes import ATTEMPTS, ProcessPool, Start, cores, forked, started_clean


def _square(number: int, home: Callable[[Any], None]) -> None:
    home((number, number * number))


def _die_on_three(number: int, home: Callable[[Any], None]) -> None:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    home(number)


def _die_once(folder: str, home: Callable[[Any], None]) -> None:
    mark = Path(folder) / "was here"
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    home("done")


def _slow(number: int, home: Callable[[Any], None]) -> None:
    time.sleep(0.05)
    home(number)


def _letters(word: str, home: Callable[[Any], None]) -> None:
    """Dies before each `x`, which nobody can take away."""
    for letter in word:
        if letter == "x":
            os.kill(os.getpid(), signal.SIGKILL)
        home(letter)


def _sleep_on_three(number: int, home: Callable[[Any], None]) -> None:
    if number == 3:
        time.sleep(60.0)
    home(number)


def _refuse(task: Any, home: Callable[[Any], None]) -> None:
    raise TypeError(f"no {task}")


def _process(task: Any, home: Callable[[Any], None]) -> None:
    home(os.getpid())


def _pool(work: Callable[[Any, Callable[[Any], None]], None], jobs: int = 1, **options: Any) -> ProcessPool[Any, Any]:
    """A pool that tries all of a task again, and tells how it was lost."""
    words = {"left": lambda task, _home: task, "lost": lambda _task, how: [how], **options}
    return ProcessPool(work, jobs, **words)


def _map(work: Any, tasks: Iterable[Any], jobs: int = 1, **options: Any) -> list[Any]:
    """What comes home of `tasks`."""
    with _pool(work, jobs, **options) as pool:
        return list(pool.map(tasks))


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_result_comes_home_once(jobs: int):
    assert sorted(_map(_square, range(20), jobs)) == [(n, n * n) for n in range(20)]


def test_a_task_that_kills_its_worker_is_lost_and_no_other():
    results = _map(_die_on_three, range(8), 2)
    assert sorted(map(str, results)) == sorted([*"0124567", "died every time it was flown"])


def test_a_task_whose_worker_dies_once_is_tried_again(tmp_path: Path):
    assert ATTEMPTS > 1
    assert _map(_die_once, [str(tmp_path)]) == ["done"]


def test_what_is_home_when_a_worker_dies_is_not_done_again():
    rest = {"left": lambda word, home: word[len(home) :] or None, "lost": lambda word, how: [how, *word[1:]]}
    assert _map(_letters, ["abxcd"], **rest) == ["a", "b", "died every time it was flown", "c", "d"]


def test_a_worker_that_hangs_is_lost_and_no_other_task():
    results = _map(_sleep_on_three, range(5), 2, patience_s=0.2)
    assert sorted(map(str, results)) == sorted([*"0124", "hung every time it was flown"])


def _stopped_after(most: int, work: Any, tasks: Iterable[Any], jobs: int = 1) -> list[Any]:
    home: list[Any] = []
    with _pool(work, jobs, stop=lambda: len(home) >= most) as pool:
        home.extend(pool.map(tasks))
    return home


def test_once_stopped_no_task_is_handed_out_and_those_in_the_air_come_home():
    assert 3 <= len(_stopped_after(3, _slow, range(100), 2)) < 12


def test_once_stopped_a_long_task_is_left_after_its_next_result():
    assert 2 <= len(_stopped_after(2, _letters, ["abcdefgh" * 1000])) <= 3


def test_an_impatient_pool_does_not_wait_for_what_is_in_the_air():
    begin_s = time.monotonic()
    assert _map(_sleep_on_three, [3], stop=lambda: time.monotonic() > begin_s + 0.2, patient=False) == []
    assert time.monotonic() - begin_s < 10.0


def test_no_worker_outlives_the_pool():
    _map(_square, range(4), 2)
    assert multiprocessing.active_children() == []


def test_a_pool_keeps_its_workers_from_one_map_to_the_next():
    with _pool(_process) as pool:
        first, second = list(pool.map([0])), list(pool.map([0]))
    assert first == second != [os.getpid()]


def test_a_worker_that_died_between_two_maps_is_replaced():
    with _pool(_process) as pool:
        (first,) = pool.map([0])
        os.kill(first, signal.SIGKILL)
        (second,) = pool.map([0])
    assert isinstance(second, int)
    assert second != first


def test_what_the_work_raises_reaches_the_caller():
    with pytest.raises(TypeError, match="no a"):
        _map(_refuse, ["a"])


CLEAN = """
import os

def work(task, home):
    kind, number = task
    if kind == "threads":
        home((number, os.environ["OMP_NUM_THREADS"]))
    elif kind == "print":
        print("printed", number, flush=True)
        os.write(1, b"beside Python\\n")
    elif kind == "raise":
        raise TypeError(f"no {number}")
    elif number == 3:
        os._exit(1)
    else:
        home((number, os.getpid()))
"""


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Work that another interpreter can import."""
    (tmp_path / "clean_work.py").write_text(CLEAN)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    monkeypatch.syspath_prepend(tmp_path)
    return import_module("clean_work").work


def test_a_worker_started_clean_works_on_one_thread(work: Any):
    results = _map(work, [("threads", n) for n in range(3)], 2, start=started_clean)
    assert sorted(results) == [(n, "1") for n in range(3)]


@pytest.mark.parametrize("start", [forked, started_clean])
def test_what_a_worker_prints_goes_to_the_standard_error(work: Any, start: Start, capfd: pytest.CaptureFixture[str]):
    _map(work, [("print", 1), ("print", 2)], start=start)
    assert capfd.readouterr() == ("", "printed 1\nbeside Python\nprinted 2\nbeside Python\n")


def test_a_worker_started_clean_that_dies_is_replaced(work: Any):
    results = _map(work, [("die", n) for n in range(5)], start=started_clean)
    assert "died every time it was flown" in results
    assert len({result[1] for result in results if isinstance(result, tuple)}) == 2


def test_what_raises_in_a_worker_started_clean_reaches_the_caller(work: Any):
    with pytest.raises(TypeError, match="no 7"):
        _map(work, [("raise", 7)], start=started_clean)


def test_a_worker_started_clean_ends_with_the_process_that_started_it(work: Any):
    program = (
        "import os, clean_work; from scaloft_fi.campaign.processes import started_clean\n"
        "started = started_clean(clean_work.work, ()); started.connection.send(('pid', 1))\n"
        "print(started.connection.recv()[1][1], flush=True); os.kill(os.getpid(), 9)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert soon(lambda: not alive(int(done.stdout)))


INTERRUPTED = """
import os, signal, sys
import clean_work
from scaloft_fi.campaign import processes

run, heard = os.getpid(), []

def hear(number, frame):
    if os.getpid() != run:
        raise KeyboardInterrupt
    heard.append(number)

signal.signal(signal.SIGINT, hear)
print("begun", flush=True)
for number in range(8):
    started = getattr(processes, sys.argv[1])(clean_work.work, ())
    started.connection.send(("pid", 0))
    assert started.connection.recv()[0] == "result"
    assert started.connection.recv() == ("done", None)
    started.connection.close()
    started.join()
signal.signal(signal.SIGINT, signal.SIG_IGN)
print(len(heard))
"""
"""Starts workers one after the other; whoever hears Ctrl-C but this process itself ends with a traceback."""


@pytest.mark.parametrize("start", ["forked", "started_clean"])
def test_a_worker_hears_no_ctrl_c_from_its_first_moment_on(work: Any, start: str):
    run = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, start],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert run.stdout
    assert run.stdout.readline() == "begun\n"
    while run.poll() is None:
        os.killpg(run.pid, signal.SIGINT)
        time.sleep(0.0005)
    heard, said = run.communicate()
    assert (run.returncode, said) == (0, "")
    assert int(heard) > 0


def test_there_is_at_least_one_core():
    assert cores() >= 1
