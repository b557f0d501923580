from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest

from scaloft_fi.campaign.pool import ATTEMPTS, Pool, cores


def _square(number: int) -> int:
    return number * number


def _die_on_three(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def _die_once(folder: str) -> str:
    mark = Path(folder) / "was here"
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


def _slow(number: int) -> int:
    time.sleep(0.05)
    return number


def _lost_word(task: object) -> str:
    return "lost"


def _lost(task: object) -> int:
    return -1


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_task_comes_home_once(jobs: int) -> None:
    assert sorted(Pool(_square, _lost, jobs).map(range(20))) == [(n, n * n) for n in range(20)]


def test_a_task_that_kills_its_worker_is_lost_and_no_other() -> None:
    assert sorted(Pool(_die_on_three, _lost, 2).map(range(8))) == [(n, -1 if n == 3 else n) for n in range(8)]


def test_a_task_whose_worker_dies_once_is_tried_again(tmp_path: Path) -> None:
    assert ATTEMPTS > 1
    assert list(Pool(_die_once, _lost_word, 1).map([str(tmp_path)])) == [(str(tmp_path), "done")]


def test_once_stopped_no_task_is_handed_out_and_those_in_the_air_come_home() -> None:
    home: list[tuple[int, int]] = []
    home.extend(Pool(_slow, _lost, 2, stop=lambda: len(home) >= 3).map(range(100)))
    assert 3 <= len(home) < 12


def test_no_worker_outlives_the_pool() -> None:
    import multiprocessing

    list(Pool(_square, _lost, 2).map(range(4)))
    assert multiprocessing.active_children() == []


def test_what_the_work_raises_reaches_the_caller() -> None:
    with pytest.raises(TypeError):
        list(Pool(_square, _lost, 1).map(["a"]))  # type: ignore[list-item]


def test_there_is_at_least_one_core() -> None:
    assert cores() >= 1
