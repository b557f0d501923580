"""The guard of a flight: the parent of all its processes, which ends them all when the flight ends, however that ends.

It is a program of its own that imports nothing but the standard library, so it starts in a few milliseconds.  Standard
input is its lifeline: the first line is the order, in JSON; the end of the input, which the death of the flight's
process brings about too, ends every process below the guard.  On Linux the guard adopts every process whose parent has
ended, so one that detached itself is found too, and a process that the guard started dies with it.  Elsewhere it ends
the process groups of what it started, which a process can leave.

With the path of a folder, and of files elsewhere, as its arguments it is the keeper of that folder: it takes no order,
and removes the folder and the files at the end of the input, which comes when the flight's process and the guards of
its processes have ended.
"""

import ctypes
import json
import os
import select
import signal
import subprocess
import sys
import time
from contextlib import suppress
from typing import Any

LINUX = sys.platform.startswith("linux")
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36
STOPS = ((signal.SIGINT, 0.5), (signal.SIGTERM, 0.5))
"""How processes are asked to end, and how long each way is given [s]."""
LOOK_S = 0.05
CHUNK = 65_536


def prctl(option: int, value: int) -> None:
    """Set an attribute of this process, on Linux."""
    if LINUX:
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def descendants(root: int) -> set[int]:
    """The processes below `root`, on Linux; none elsewhere."""
    parents: dict[int, list[int]] = {}
    for name in os.listdir("/proc") if LINUX else ():  # noqa: PTH208 - this program imports little
        if not name.isdigit():
            continue
        try:
            with open(f"/proc/{name}/stat", "rb") as file:  # noqa: PTH123 - this program imports little
                state, parent = file.read().rpartition(b")")[2].split()[:2]
        except OSError:
            continue
        if state != b"Z":
            parents.setdefault(int(parent), []).append(int(name))
    found: set[int] = set()
    new = [root]
    while new:
        new = [child for parent in new for child in parents.get(parent, ()) if child not in found]
        found.update(new)
    return found


def kill_below(root: int, spared: frozenset[int] = frozenset()) -> None:
    """Kill the processes below `root` until none is left, but for `spared` ones and what is below them."""
    kept = spared.union(*(descendants(pid) for pid in spared)) if spared else spared
    while left := descendants(root) - kept:
        for pid in left:
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(0.002)


class Output:
    """The last output of the processes, in two files of at most `CHUNK` bytes."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.size = 0
        self.file = open(path, "wb", buffering=0)  # noqa: PTH123, SIM115 - it stays open

    def write(self, text: bytes) -> None:
        """Keep output; the older of the two files makes room."""
        if self.size + len(text) > CHUNK:
            self.file.close()
            os.replace(self.path, self.path + ".old")  # noqa: PTH105
            self.file, self.size = open(self.path, "wb", buffering=0), 0  # noqa: PTH123, SIM115
        self.file.write(text)
        self.size += len(text)


class Guard:
    """Starts the processes of an order, watches them, and ends them."""

    def __init__(self, order: dict[str, Any]) -> None:
        self.output = Output(order["output"])
        self.source, sink = os.pipe()
        self.started: dict[int, subprocess.Popen[bytes]] = {}
        for number, command in enumerate(order["commands"]):
            try:
                self.started[number] = subprocess.Popen(
                    command["run"],
                    env=command["env"],
                    cwd=command["folder"],
                    stdin=subprocess.DEVNULL,
                    stdout=sink,
                    stderr=sink,
                    start_new_session=True,
                    preexec_fn=lambda: prctl(PR_SET_PDEATHSIG, signal.SIGKILL),
                )
            except OSError as error:
                program, why = command["run"][0], error.strerror or str(error)
                missing = isinstance(error, FileNotFoundError) and error.filename == program and "/" in program
                if missing and os.path.exists(os.path.join(command["folder"], program)):  # noqa: PTH110, PTH118
                    why = "the file is there, and the interpreter that its first line names is not"
                self.tell("failed", number, why)
                break
        else:
            self.tell("started", 0, "")
        os.close(sink)

    def tell(self, what: str, number: int, detail: object) -> None:
        """Tell the flight's process; it may be dead."""
        with suppress(OSError):
            os.write(1, f"{what} {number} {detail}\n".encode())

    def watch(self) -> None:
        """Return when the lifeline ends."""
        told: set[int] = set()
        sources = [0, self.source]
        while True:
            for ready in select.select(sources, [], [], LOOK_S)[0]:
                text = os.read(ready, CHUNK)
                if ready == 0 and not text:
                    return
                if ready == self.source and text:
                    self.output.write(text)
                elif ready == self.source:
                    sources.remove(ready)
            for number, process in self.started.items():
                if number not in told and process.poll() is not None:
                    told.add(number)
                    self.drain()
                    self.tell("ended", number, process.returncode)

    def drain(self) -> None:
        """Keep what a process wrote before it ended."""
        while select.select([self.source], [], [], 0.0)[0] and (text := os.read(self.source, CHUNK)):
            self.output.write(text)

    def stop(self) -> None:
        """Ask all processes to end, then kill whatever is left."""
        for number, given_s in STOPS:
            for process in self.started.values():
                if process.poll() is None:
                    send(process.pid, number)
            due = time.monotonic() + given_s
            while self.alive() and time.monotonic() < due:
                if select.select([self.source], [], [], 0.0)[0]:  # what writes while it ends waits for a reader
                    self.output.write(os.read(self.source, CHUNK))
                time.sleep(0.005)
        for process in self.started.values():
            if process.poll() is None or not LINUX:  # the number of a process that was reaped may be another's
                send(process.pid, signal.SIGKILL)
        kill_below(os.getpid())

    def alive(self) -> bool:
        """Whether a process is left."""
        return any(one.poll() is None for one in self.started.values()) or bool(descendants(os.getpid()))


def send(group: int, number: int) -> None:
    """Send a signal to a process group, which may have ended."""
    with suppress(OSError):
        os.killpg(group, number)


def keep(folder: str, files: list[str]) -> None:
    """Wait for the end of the input, then remove a folder with all that is in it, and the files."""
    while os.read(0, CHUNK):
        pass
    import shutil  # only now: whoever flies need not wait for it

    shutil.rmtree(folder, ignore_errors=True)
    for file in files:
        with suppress(OSError):
            os.unlink(file)  # noqa: PTH108 - this program imports little


def main() -> None:
    """Keep a folder, or follow the order on standard input until it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.argv[1:]:
        return keep(sys.argv[1], sys.argv[2:])
    prctl(PR_SET_CHILD_SUBREAPER, 1)
    line = b""
    while not line.endswith(b"\n"):
        text = os.read(0, CHUNK)
        if not text:
            return None
        line += text
    guard = Guard(json.loads(line))
    try:
        guard.watch()
    finally:
        guard.stop()
    return None


if __name__ == "__main__":
    main()
