"""Ctrl-C, SIGTERM and SIGHUP end the process of the command at once, with one sentence and the exit code 130.

A `KeyboardInterrupt` would be raised at any place: in an import, a compiler, a destructor.  Some of them swallow it,
others print a traceback.  Nothing needs it to be saved: a store has each flight in a transaction of its own, files are
written beside their place, and processes end with their parent.  A run has handlers of its own while it flies.
"""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from types import FrameType

from scaloft_fi.exit_codes import ExitCode

SENTENCE = "error: interrupted"
_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_unfinished: set[str] = set()


def end_at_signals() -> None:
    """Install the handlers; what is ignored, as `nohup` has it, stays ignored."""
    for number in _SIGNALS:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _end)


def ignore_signals() -> None:
    """Ignore them: the process is about to end."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def unfinished(path: str) -> None:
    """Remember a file that is only worth something once it is finished."""
    _unfinished.add(path)


def finished(path: str) -> None:
    """Forget a file that is finished, or gone."""
    _unfinished.discard(path)


def _end(_number: int, _frame: FrameType | None) -> None:
    """End the process without a way back: no `finally`, no destructor, no traceback."""
    ignore_signals()
    for path in _unfinished:
        with suppress(OSError):
            os.unlink(path)  # noqa: PTH108 - a handler of signals imports nothing
    with suppress(OSError):
        # below the ^C that a terminal shows; not through a stream, which this may have interrupted
        os.write(2, f"\n{SENTENCE}\n".encode())
    os._exit(ExitCode.INTERRUPTED)
