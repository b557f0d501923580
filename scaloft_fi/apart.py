"""Read a file of somebody else in a process of its own, whose memory and time are bounded whatever the file declares.

A record, a mesh or a sheet of some kilobytes may unpack to gigabytes, and no library of its format can be trusted to
look at what it unpacks to.
"""

from __future__ import annotations

import os
import pickle
import select
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from scaloft_fi.document import MIB, is_file, is_folder
from scaloft_fi.errors import InputError

T = TypeVar("T")
_LINUX = sys.platform.startswith("linux")
APART_BYTES, BYTES_A_BYTE = 512 * MIB, 16
"""What reading a file apart may take in memory, and for each of its bytes besides [bytes]."""
APART_S, BYTES_A_S = 15.0, 1 << 20
"""How long it may take [s, wall], and how many bytes more of the file allow a second more."""


def read_apart(path: Path, work: Callable[[], T]) -> T:
    """What `work` makes of a file, in a process of its own whose memory and time are bounded.

    What a file unpacks to is bounded so whatever it declares; the bounds grow with its size on the disk.  Where a
    process cannot be forked, `work` runs in this one.

    Raises:
        InputError: as `work`; or it takes too much memory or time, or ends its process.
    """
    if not hasattr(os, "fork"):
        return work()
    files = [path, *path.iterdir()] if is_folder(path) else [path]
    size = sum(file.stat().st_size for file in files if is_file(file))
    most_bytes, most_s = APART_BYTES + BYTES_A_BYTE * size, APART_S + size / BYTES_A_S
    end, other_end = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(end)
        _work_apart(other_end, path, work, most_bytes)
    os.close(other_end)
    content, until_s, late = bytearray(), time.monotonic() + most_s, False
    try:
        while not late:
            ready = select.select([end], [], [], max(0.0, until_s - time.monotonic()))[0]
            late = not ready
            if ready and not (piece := os.read(end, MIB)):
                break
            content += piece if ready else b""
    finally:
        os.close(end)
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        _, status = os.waitpid(pid, 0)
    if late:
        raise InputError(f"{path}: reading it takes more than {most_s:.0f} s, which a file of its size may take")
    if not content:
        code = os.waitstatus_to_exitcode(status)
        raise InputError(f"{path}: reading it ended its process ({code}); it may be damaged, or unpack to too much")
    done, told = pickle.loads(content)
    if not done:
        raise InputError(told)
    made: T = told
    return made


def _work_apart(end: int, path: Path, work: Callable[[], Any], most_bytes: int) -> NoReturn:
    """Do `work` in a forked process, and send what it makes."""
    silent = os.open(os.devnull, os.O_WRONLY)  # libraries print what they skip, some of them beside Python
    for stream in (1, 2):
        os.dup2(silent, stream)
    limits = import_module("resource")
    used = int(Path("/proc/self/statm").read_text().split()[0]) * limits.getpagesize() if _LINUX else 0
    try:
        if _LINUX:
            limits.setrlimit(limits.RLIMIT_AS, (used + most_bytes, used + most_bytes))
        try:
            told = (True, work())
        except InputError as error:
            told = (False, str(error))
        except MemoryError:
            told = (
                False,
                f"{path}: it unpacks to more than {most_bytes // MIB:,} MiB, which a file of its size may take",
            )
        with os.fdopen(end, "wb") as file:
            pickle.dump(told, file)
    finally:
        os._exit(0)
