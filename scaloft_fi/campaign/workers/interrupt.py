"""Ctrl-C, SIGTERM, SIGHUP: the first signal lets a run save and end, the second signal ends it at once."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from scaloft_fi.campaign.processes.start import HANGUP
from scaloft_fi.errors import ScaloftError

ECHO_S = 1.0
"""A second signal within this time is ignored, because terminal and wrapper may both pass on the first [s, wall]."""


class Interrupted(ScaloftError):  # noqa: N818 - an event, not an error
    """The user stopped the run; all outcomes are saved."""

    exit_code = 130


class Flag:
    """Whether the user asked to stop."""

    def __init__(self) -> None:
        self._since_s: float | None = None

    def __call__(self) -> bool:
        """Whether a signal has arrived."""
        return self._since_s is not None

    def raise_it(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal.

        Raises:
            KeyboardInterrupt: the signal is the second one.
        """
        now_s = time.monotonic()
        if self._since_s is None:
            self._since_s = now_s
        elif now_s - self._since_s > ECHO_S:
            raise KeyboardInterrupt


@contextmanager
def interruptible() -> Iterator[Flag]:
    """In this context the first signal that asks to stop sets the flag, the second one raises.

    A SIGHUP that is ignored, as `nohup` has it, stays ignored.
    """
    flag = Flag()
    if threading.current_thread() is not threading.main_thread():  # only the main thread can handle signals
        yield flag
        return
    hangup = [number for number in HANGUP if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, flag.raise_it) for number in (signal.SIGINT, signal.SIGTERM, *hangup)}
    try:
        yield flag
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
