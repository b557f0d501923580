"""End a child process when its parent ends, for whatever reason the parent ends."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Callable
from multiprocessing import parent_process
from multiprocessing.connection import wait

LINUX = sys.platform.startswith("linux")
_PR_SET_PDEATHSIG = 1
_prctl: Callable[..., int] | None = getattr(ctypes.CDLL(None), "prctl", None) if LINUX else None


def die_with(parent: int, sentinel: int | None = None) -> None:
    """End this process when its parent, which has the id `parent`, ends.

    On Linux the kernel ends it.  On other systems a thread waits for `sentinel`, a descriptor that becomes readable
    when the parent ends; None = the sentinel of `multiprocessing`.
    """
    if _prctl is not None:
        _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
        if os.getppid() != parent:  # the parent ended before this call
            os._exit(1)
        return
    process = parent_process()
    if sentinel is None and process is not None:
        sentinel = process.sentinel
    if sentinel is not None:
        threading.Thread(target=_end_after, args=(sentinel,), daemon=True).start()


def _end_after(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


def cause_of_death(status: int) -> str:
    """The exit code or the signal that ended a process, from its wait status.

    >>> cause_of_death(9), cause_of_death(256)
    ('SIGKILL', 'exit code 1')
    """
    code = os.waitstatus_to_exitcode(status)
    return f"exit code {code}" if code >= 0 else signal.Signals(-code).name
