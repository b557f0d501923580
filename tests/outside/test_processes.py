from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import alive, marked, soon

from scaloft_fi.outside.border import BorderError
from scaloft_fi.outside.exchange import Command, Processes

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks through /proc")

DETACHED = """
import os, subprocess, sys, time
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"], start_new_session=True)
leaving = os.fork()
if leaving == 0:
    os.setsid()
    if os.fork() == 0:
        time.sleep(60)
    os._exit(0)
os.waitpid(leaving, 0)
print("up", flush=True)
time.sleep(60)
"""
"""A program that leaves two processes behind, of which one has lost its parent."""
FLYING = """
import sys, time
from pathlib import Path
from scaloft_fi.outside.border import BorderError
from scaloft_fi.outside.exchange import Command, Processes
folder = Path(sys.argv[1])
with_guard = Processes([Command(("{python}", "-c", sys.argv[2]))], folder, {"MARK": sys.argv[3]}, folder)
with_guard.start()
while "up" not in with_guard.last_lines():
    time.sleep(0.01)
print(with_guard._guard.pid, flush=True)
try:
    while not with_guard.ended():
        time.sleep(0.01)
except BorderError as error:
    print(error, flush=True)
with_guard.stop()
print("stopped", flush=True)
"""
"""A flying process: it goes on until something ends, then stops the rest."""


def processes(folder: Path, *commands: str, **environment: str) -> Processes:
    run = [Command(("{python}", "-c", textwrap.dedent(command))) for command in commands]
    return Processes(run, folder, environment, folder)


def below(guard: int, mark: str) -> list[int]:
    """What the guard started, then what it adopted: no leader of a session."""
    status = {pid: Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split() for pid in marked(mark)}
    return sorted((pid for pid in status if int(status[pid][1]) == guard), key=lambda pid: int(status[pid][3]) != pid)


@pytest.fixture
def mark(tmp_path: Path) -> str:
    return f"{os.getpid()}-{tmp_path.name}"


def test_processes_run_with_the_environment_of_the_border_and_their_output_is_kept(tmp_path: Path):
    both = processes(
        tmp_path, "import os, time; print('hello', os.environ['ROOM'], flush=True); time.sleep(60)", ROOM="7"
    )
    both.start()
    assert soon(lambda: both.last_lines() == "hello 7")
    assert both.ended() == ""
    both.stop()
    both.stop()


def test_the_first_process_that_ends_is_named_with_its_code_and_what_it_wrote(tmp_path: Path):
    one = processes(tmp_path, "import sys; print('no\\x1b[31m route'); sys.exit(3)")
    one.start()
    assert soon(lambda: bool(one.ended()))
    assert one.ended().endswith("ended with code 3")
    assert one.last_lines() == "no\\x1b[31m route"
    one.stop()


def test_a_program_that_does_not_exist_is_named(tmp_path: Path):
    lost = Processes([Command(("no-such-program",))], tmp_path, {}, tmp_path)
    with pytest.raises(BorderError, match="no-such-program cannot be started: No such file or directory"):
        lost.start()
    lost.stop()


def test_an_interpreter_that_is_not_there_is_told_from_a_program_that_is_not_there(tmp_path: Path):
    (tmp_path / "plan.py").write_text("#!/no/such/python\n")
    (tmp_path / "plan.py").chmod(0o755)
    lost = Processes([Command(("./plan.py",))], tmp_path, {}, tmp_path)
    with pytest.raises(BorderError, match=r"plan\.py cannot be started: the file is there, and the interpreter"):
        lost.start()
    lost.stop()


def test_output_without_end_fills_no_disk(tmp_path: Path):
    loud = processes(tmp_path, "while True: print('x' * 1000)")
    loud.start()
    time.sleep(0.5)
    loud.stop()
    assert 0 < sum(path.stat().st_size for path in tmp_path.glob("output*")) <= 2 * 65_536


def test_a_process_that_asks_for_nothing_but_the_end_is_killed(tmp_path: Path, mark: str):
    deaf = """
        import signal, time
        for number in (signal.SIGINT, signal.SIGTERM): signal.signal(number, signal.SIG_IGN)
        print('up', flush=True)
        time.sleep(60)
    """
    stubborn = processes(tmp_path, deaf, MARK=mark)
    stubborn.start()
    assert soon(lambda: stubborn.last_lines() == "up")
    stubborn.stop()
    assert marked(mark) == []


def test_processes_that_detached_themselves_end_with_the_flight(tmp_path: Path, mark: str):
    leaving = processes(tmp_path, DETACHED, MARK=mark)
    leaving.start()
    assert soon(lambda: leaving.last_lines() == "up")
    assert soon(lambda: len(marked(mark)) == 3)
    leaving.stop()
    assert marked(mark) == []


@pytest.fixture
def flying(tmp_path: Path, mark: str) -> Iterator[subprocess.Popen[str]]:
    words = [sys.executable, "-c", FLYING, str(tmp_path), DETACHED, mark]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as process:
        yield process
        process.kill()


@pytest.mark.parametrize("victim", ["flying process", "guard", "process", "orphan"])
def test_whatever_is_killed_nothing_is_left(flying: subprocess.Popen[str], mark: str, victim: str):
    guard = int(flying.stdout.readline())
    assert soon(lambda: len(marked(mark)) == 3 and len(below(guard, mark)) == 2)
    process, orphan = below(guard, mark)
    os.kill(
        {"flying process": flying.pid, "guard": guard, "process": process, "orphan": orphan}[victim], signal.SIGKILL
    )
    if victim == "orphan":  # the flight goes on without it
        assert soon(lambda: len(marked(mark)) == 2)
        flying.kill()
    assert soon(lambda: marked(mark) == []), marked(mark)
    assert soon(lambda: not alive(guard))
    if victim == "guard":
        assert flying.stdout.readline() == "the guard of the processes ended; their last lines: up\n"
    if victim in ("guard", "process"):
        assert flying.stdout.readline() == "stopped\n"
