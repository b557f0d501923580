"""Ctrl-C, SIGTERM, SIGHUP while drones fly: the first signal lets a run save and end, the second ends it at once."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

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

    def again(self) -> bool:
        """Note a signal; returns whether the user asks for the second time."""
        now_s = time.monotonic()
        if self._since_s is None:
            self._since_s = now_s
            return False
        return now_s - self._since_s > ECHO_S


@contextmanager
def interruptible(flag: Flag) -> Iterator[None]:
    """In this context the first signal that asks to stop sets the flag, the second one does what it did before.

    A SIGHUP that is ignored, as `nohup` has it, stays ignored.
    """
    if threading.current_thread() is not threading.main_thread():  # only the main thread can handle signals
        yield
        return
    before: dict[int, Any] = {}

    def handle(number: int, frame: FrameType | None) -> None:
        if flag.again():
            if not callable(before[number]):
                raise KeyboardInterrupt
            before[number](number, frame)

    hangup = [number for number in HANGUP if signal.getsignal(number) != signal.SIG_IGN]
    for number in (signal.SIGINT, signal.SIGTERM, *hangup):
        before[number] = signal.getsignal(number)
        signal.signal(number, handle)
    try:
        yield
    finally:
        for changed, handler in before.items():
            signal.signal(changed, handler)
