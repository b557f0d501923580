"""Code of others in this process: what it prints, and what it raises.

The key of a flight covers this module, so it imports nothing that has to do with answers.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress

ENDING = "scaloft_fi.output"
"""The module whose handler of Ctrl-C ends the process without an exception."""


def foreign() -> tuple[type[BaseException], ...]:
    """What code of others may raise, for an `except`: also what would end the process.

    A `KeyboardInterrupt` is the user's where a handler raises it: workers ignore Ctrl-C, and the command ends at it.
    """
    handler = signal.getsignal(signal.SIGINT)
    users = callable(handler) and handler.__module__ != ENDING
    return (Exception, SystemExit) if users else (Exception, SystemExit, KeyboardInterrupt)


@contextmanager
def answers_apart() -> Iterator[None]:
    """In this context what is printed goes to standard error, from C too: standard output gets answers alone.

    The framework tells and says nothing in it.
    """
    _flush_all()
    try:
        os.fstat(2)
        kept = os.dup(1)
    except OSError:  # one of them is closed: there is nothing to keep apart
        yield
        return
    os.dup2(2, 1)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _flush_all()
        os.dup2(kept, 1)
        os.close(kept)


def _flush_all() -> None:
    """Write what Python and C hold back for standard output."""
    with suppress(OSError, ValueError, AttributeError):  # a stream may be closed or missing
        sys.stdout.flush()
    if os.name == "posix":
        import ctypes  # takes long to import, and who flies has it

        ctypes.CDLL(None).fflush(None)
