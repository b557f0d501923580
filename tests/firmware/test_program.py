"""A firmware's program: its threads take turns, its clock moves as it is granted, its network is its own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from scaloft_fi.firmware import program as module
from scaloft_fi.firmware.program import Datagram, FirmwareError, Program, library
from scaloft_fi.outside import guard
from scaloft_fi.outside.border import BorderError

HERE = Path(__file__).parent
STEP_NS = 4_000_000


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("programs")
    for name in ("loop", "threads", "blocks"):
        source = str(HERE / f"{name}.c")
        subprocess.run(["cc", "-O1", "-o", str(folder / name), source, "-lpthread"], check=True, timeout=60)
    return folder


@contextmanager
def started(path: Path, study: Path) -> Iterator[Program]:
    program = Program.start([str(path)], {"parameters": b"1"}, study, [study / "elsewhere"])
    try:
        yield program
    finally:
        program.close()


@contextmanager
def load() -> Iterator[None]:
    """Other work on every core."""
    busy = [subprocess.Popen(["sh", "-c", "while :; do :; done"]) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for one in busy:
            one.kill()
            one.wait()


def talk(path: Path, study: Path, steps: int = 100) -> list[tuple[int, int, bytes]]:
    """What the program says, with the step and the port."""
    with started(path, study) as program:
        said = []
        for step in range(steps):
            sent = [Datagram(4001, b"hello %d" % step)] if step % 10 == 0 else []
            said += [(step, *one) for one in program.step((step + 1) * STEP_NS, sent)]
        assert program.now_ns == steps * STEP_NS
        return said


def test_a_program_that_waits_for_the_clock_of_the_wall_says_the_same_at_the_same_step_under_load(
    built: Path, tmp_path: Path
):
    quiet = talk(built / "loop", tmp_path)
    with load():
        assert talk(built / "loop", tmp_path) == quiet
    assert [port for _, port, _ in quiet] == [4002] * len(quiet)
    assert 38 <= len(quiet) <= 40
    assert sum(b"hello" in text for _, _, text in quiet) == 10
    times_s = [float(text.split()[0]) for _, _, text in quiet]
    assert times_s == pytest.approx([0.01 * (1 + number) for number in range(len(times_s))], abs=3e-4)


def test_twenty_threads_with_a_mutex_and_conditions_take_turns_in_one_order(built: Path, tmp_path: Path):
    ((_, _, first),) = talk(built / "threads", tmp_path, 300)
    with load():
        ((_, _, second),) = talk(built / "threads", tmp_path, 300)
    assert first == second
    taken = [word.split(b"<") for word in first.split()]
    assert len(taken) == 400
    assert {int(giver) for _, giver in taken} == set(range(10))
    assert len({int(taker) for taker, _ in taken}) > 3


def test_whatever_a_program_waits_for_it_gets_there_at_the_same_time_under_load(built: Path, tmp_path: Path):
    quiet = talk(built / "blocks", tmp_path, 30)
    with load():
        assert talk(built / "blocks", tmp_path, 30) == quiet
    told = [text.decode().partition(" ")[::2] for _, _, text in quiet]
    times_s = {what: float(time_s) for time_s, what in told}
    said = [what for _, what in told]
    assert [what for what in said if "joined" in what] == [f"joined {result}" for result in (700, 1050, 4, 5, 6, 7)]
    assert [said.count(f"{who} {how}") for who in ("taker 4", "taker 5") for how in ("in time", "late")] == [2, 2, 3, 1]
    assert [said.count(f"waiter 6 {how}") for how in ("in time", "late")] == [3, 1]
    assert [what for what in said if "select" in what][:6] == [
        "select 1 hello ", "select 1 0", "select 0 -", "select 1 hello ", "select 1 10", "select 0 -",
    ]  # fmt: skip
    assert times_s["asked please"] - times_s["joined 7"] < 1e-5  # a child takes no time, its answer does
    assert times_s["child 7"] - times_s["asked please"] == pytest.approx(0.02, abs=1e-5)


def test_a_program_may_be_a_script_that_replaces_itself(built: Path, tmp_path: Path):
    script = tmp_path / "script"
    script.write_text(f"#!/bin/sh\ndate > today\nexec {built / 'loop'}\n")
    script.chmod(0o755)
    assert talk(script, tmp_path) == talk(built / "loop", tmp_path)


def test_a_script_may_read_the_clock_before_it_replaces_itself(built: Path, tmp_path: Path):
    script = tmp_path / "script"
    script.write_text(f"#!/bin/bash\necho $SECONDS > seconds\nexec bash -c 'exec {built / 'loop'}'\n")
    script.chmod(0o755)
    alone = talk(built / "loop", tmp_path)
    with load():
        assert talk(script, tmp_path) == alone


def test_two_programs_at_once_share_no_port(built: Path, tmp_path: Path):
    alone = talk(built / "loop", tmp_path)
    with multiprocessing.get_context("spawn").Pool(3) as pool:
        assert pool.starmap(talk, [(built / "loop", tmp_path)] * 3) == [alone] * 3


def test_a_program_that_ends_is_the_drones_fault_and_one_that_is_killed_the_harnesss(built: Path, tmp_path: Path):
    with pytest.raises(FirmwareError, match="ended with code 3"):
        talk(built / "loop", tmp_path, 3000)
    with started(built / "loop", tmp_path) as program:
        program.step(STEP_NS, [])
        (pid,) = [one for one in guard.descendants(os.getpid()) if _name(one) == "loop"]
        os.kill(pid, signal.SIGKILL)
        with pytest.raises(BorderError, match="SIGKILL"):
            program.step(2 * STEP_NS, [])


def _name(pid: int) -> str:
    path = Path(f"/proc/{pid}/comm")
    return path.read_text().strip() if path.is_file() else ""


def test_nothing_is_left_of_a_program(built: Path, tmp_path: Path):
    with started(built / "loop", tmp_path) as program:
        folder = program.folder
        assert (folder / "parameters").read_bytes() == b"1"
        program.step(STEP_NS, [])
        (tmp_path / "elsewhere").touch()  # as the program might
    assert not folder.exists()
    assert not (tmp_path / "elsewhere").exists()
    assert not [one for one in guard.descendants(os.getpid()) if _name(one) == "loop"]


def test_what_cannot_be_started_is_named(tmp_path: Path):
    with pytest.raises(BorderError, match="lacking cannot be started: No such file"):
        Program.start([str(tmp_path / "lacking")], {}, tmp_path)


def test_a_machine_without_a_compiler_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BorderError, match="needs a C compiler"):
        library()


def test_a_library_is_compiled_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = library()
    written_ns = first.stat().st_mtime_ns
    assert library() == first
    assert first.stat().st_mtime_ns == written_ns
    assert [path.parent for path in tmp_path.rglob("*.so")] == [tmp_path / "scaloft-fi" / "turns"]


def test_the_library_knows_no_firmware_by_name():
    text = module.TURNS.read_text().lower()
    assert not [name for name in ("betaflight", "px4", "ardu", "mavlink") if name in text]
