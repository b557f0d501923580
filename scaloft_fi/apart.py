"""Read a file of somebody else in a process of its own, bounded in memory, time and disk whatever the file declares.

A record, a mesh or a sheet of some kilobytes may unpack to gigabytes, and no library of its format can be trusted to
look at what it unpacks to.
"""

from __future__ import annotations

import errno
import math
import os
import pickle
import select
import shutil
import signal
import sys
import tempfile
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
"""What reading a file apart may take in memory, or write into a file, and for each of its bytes besides [bytes]."""
APART_S, BYTES_A_S = 15.0, 1 << 20
"""How long it may take [s, wall], and how many bytes more of the file allow a second more."""
PLAIN = frozenset({".bin", ".tlog", ".ulg", ".csv", ".obj", ".stl", ".off"})
"""Ends of the names of files that pack nothing.  Of any other file only bytes that were read allow more time: little of
a bomb is read while it unpacks."""
NO_ROOM = "Failed to resize buffer"
"""What lz4 says, in a plain RuntimeError, where there is no memory."""
LOOK_S = 0.1
"""How often it is looked at how much was read [s, wall]."""


def most_unpacked(size: int) -> int:
    """What a file of this size may unpack to [bytes]."""
    return APART_BYTES + BYTES_A_BYTE * size


def read_apart(path: Path, work: Callable[[], T]) -> T:
    """What `work` makes of a file, in a process of its own whose memory and time are bounded.

    What a file unpacks to is bounded so whatever it declares; the bounds grow with its size on the disk.  What it is
    unpacked to on the disk is removed with the process.  Where a process cannot be forked, `work` runs in this one.

    Raises:
        InputError: as `work`; or it takes too much memory, time or disk, or ends its process.
    """
    if not hasattr(os, "fork"):
        return work()
    files = [path, *path.iterdir()] if is_folder(path) else [path]
    size = sum(file.stat().st_size for file in files if is_file(file))
    most_bytes, most_s = most_unpacked(size), APART_S + size / BYTES_A_S
    folder = tempfile.mkdtemp(prefix="scaloft-")
    end, other_end = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(end)
        _work_apart(other_end, path, work, most_bytes, most_s, folder)
    os.close(other_end)
    content, began_s, late_s = bytearray(), time.monotonic(), 0.0
    try:
        while not late_s:
            if select.select([end], [], [], min(LOOK_S, APART_S))[0]:
                if not (piece := os.read(end, MIB)):
                    break
                content += piece
            elif (past_s := time.monotonic() - began_s) > APART_S:
                read = size if path.suffix.lower() in PLAIN else min(size, _read_by(pid))
                late_s = past_s if past_s > APART_S + read / BYTES_A_S else 0.0
    finally:
        os.close(end)
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        _, status = os.waitpid(pid, 0)
        shutil.rmtree(folder, ignore_errors=True)
    if late_s:
        raise InputError(f"{path}: reading it takes more than {late_s:.0f} s, which what was read of it may take")
    if not content:
        code = os.waitstatus_to_exitcode(status)
        raise InputError(f"{path}: reading it ended its process ({code}); it may be damaged, or unpack to too much")
    done, told = pickle.loads(content)
    if not done:
        raise InputError(told)
    made: T = told
    return made


def _read_by(pid: int) -> int:
    """The bytes that a process has read, as far as the system tells it."""
    try:
        return int(Path(f"/proc/{pid}/io").read_text().split()[1])
    except (OSError, ValueError):
        return sys.maxsize


def _work_apart(end: int, path: Path, work: Callable[[], Any], most_bytes: int, most_s: float, folder: str) -> NoReturn:
    """Do `work` in a forked process, whose temporary files are in a folder of its own, and send what it makes."""
    silent = os.open(os.devnull, os.O_WRONLY)  # libraries print what they skip, some of them beside Python
    for stream in (1, 2):
        os.dup2(silent, stream)
    limits = import_module("resource")
    used = int(Path("/proc/self/statm").read_text().split()[0]) * limits.getpagesize() if _LINUX else 0
    before, cpu_s = limits.getrlimit(limits.RLIMIT_AS), 2 * math.ceil(most_s)  # for the case that nobody waits for it
    memory = used + most_bytes if _LINUX else limits.RLIM_INFINITY
    too_much = False, f"{path}: it unpacks to more than {most_bytes // MIB:,} MiB, which a file of its size may take"
    try:
        for what, most in ((limits.RLIMIT_FSIZE, most_bytes), (limits.RLIMIT_CPU, cpu_s), (limits.RLIMIT_AS, memory)):
            soft, hard = limits.getrlimit(what)
            limits.setrlimit(
                what, (min((one for one in (most, soft, hard) if one != limits.RLIM_INFINITY), default=soft), hard)
            )
        tempfile.tempdir = folder
        try:
            told = True, work()
        except InputError as error:
            told = too_much if lacks_room(error) else (False, str(error))
        except MemoryError:
            told = too_much
        limits.setrlimit(limits.RLIMIT_AS, before)  # to tell it takes memory too
        with os.fdopen(end, "wb") as file:
            pickle.dump(told, file)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(0)


def lacks_room(error: BaseException | None) -> bool:
    """Whether the cause of an error is a file that became too large, or want of memory."""
    while error is not None:
        if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == errno.EFBIG):
            return True
        if NO_ROOM in str(error):
            return True
        error = error.__cause__ or error.__context__
    return False
