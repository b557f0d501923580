from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.pool import ATTEMPTS, Pool, cores


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


def _pool(work: Callable[[Any, Callable[[Any], None]], None], jobs: int = 1, **options: Any) -> Pool[Any, Any]:
    return Pool(work, jobs, left=lambda task, _home: task, lost=lambda _task, how: [how], **options)


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_result_comes_home_once(jobs: int) -> None:
    assert sorted(_pool(_square, jobs).map(range(20))) == [(n, n * n) for n in range(20)]


def test_a_task_that_kills_its_worker_is_lost_and_no_other() -> None:
    results = list(_pool(_die_on_three, 2).map(range(8)))
    assert sorted(map(str, results)) == sorted([*"0124567", "died every time it was flown"])


def test_a_task_whose_worker_dies_once_is_tried_again(tmp_path: Path) -> None:
    assert ATTEMPTS > 1
    assert list(_pool(_die_once).map([str(tmp_path)])) == ["done"]


def test_what_is_home_when_a_worker_dies_is_not_done_again() -> None:
    pool: Pool[str, str] = Pool(
        _letters, 1, left=lambda word, home: word[len(home) :] or None, lost=lambda word, how: [how, *word[1:]]
    )
    assert list(pool.map(["abxcd"])) == ["a", "b", "died every time it was flown", "c", "d"]


def test_a_worker_that_hangs_is_lost_and_no_other_task() -> None:
    results = list(_pool(_sleep_on_three, 2, patience_s=0.2).map(range(5)))
    assert sorted(map(str, results)) == sorted([*"0124", "hung every time it was flown"])


def test_once_stopped_no_task_is_handed_out_and_those_in_the_air_come_home() -> None:
    home: list[int] = []
    home.extend(_pool(_slow, 2, stop=lambda: len(home) >= 3).map(range(100)))
    assert 3 <= len(home) < 12


def test_once_stopped_a_long_task_is_left_after_its_next_result() -> None:
    home: list[str] = []
    home.extend(_pool(_letters, stop=lambda: len(home) >= 2).map(["abcdefgh" * 1000]))
    assert 2 <= len(home) <= 3


def test_no_worker_outlives_the_pool() -> None:
    list(_pool(_square, 2).map(range(4)))
    assert multiprocessing.active_children() == []


def test_what_the_work_raises_reaches_the_caller() -> None:
    with pytest.raises(TypeError, match="no a"):
        list(_pool(_refuse).map(["a"]))


def test_there_is_at_least_one_core() -> None:
    assert cores() >= 1
