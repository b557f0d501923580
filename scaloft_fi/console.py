"""Standard output and standard error, whatever they are: terminals, files on a full disk, closed pipes, nothing.

Every text that leaves through them is made inert here.  A reader that leaves early is no error; a result that cannot be
written is one; a message that cannot be written never stops the work that it is about.
"""

from __future__ import annotations

import errno
import io
import os
import sys
from contextlib import suppress
from typing import TextIO

from scaloft_fi.errors import InputError
from scaloft_fi.inert import line, printable
from scaloft_fi.terminal import Marked, Style, coloured, styled

_STYLES = {"error": Style.BAD, "ratchet": Style.BAD, "warning": Style.DOUBT}


def stand() -> None:
    """Prepare the standard streams of this process.

    The place of a stream that is closed is taken by one that cannot be written, because a file that is opened later
    would get its number, and with it what libraries print.  Letters that the encoding lacks are spelled out.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDONLY), True)  # the lowest free number is this one
    if sys.stdout is None:
        sys.stdout = _stream(1)
    if sys.stderr is None:
        sys.stderr = _stream(2)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def tell(content: str | bytes) -> None:
    """Write a result to standard output.

    Args:
        content: a text, or the bytes of a file, which only a terminal gets as printable text.  A `Marked` text keeps
            its marks.

    Raises:
        InputError: it cannot be written.
    """
    if isinstance(content, bytes) and sys.stdout.isatty():
        content = content.decode(errors="backslashreplace")
    text = content if isinstance(content, bytes | Marked) else printable(content)
    try:
        sys.stdout.flush()
        if isinstance(text, bytes):
            sys.stdout.buffer.write(text)
        else:
            sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        lost(error)


def lost(error: OSError) -> None:
    """Give up standard output, where writing failed: quietly where its reader has left.

    Raises:
        InputError: it cannot be written for another reason.
    """
    _silence(sys.stdout)
    if not isinstance(error, BrokenPipeError):
        reason = "it is closed" if error.errno == errno.EBADF else error.strerror
        raise InputError(f"standard output cannot be written: {reason}") from error


def tell_line(sentence: str) -> None:
    """Write a result of one line to standard output.

    Raises:
        InputError: it cannot be written.
    """
    tell(f"{line(sentence)}\n")


def say(sentence: str) -> None:
    """Write a line to standard error, if it can be written; a terminal gets `error:` and `warning:` marked."""
    show(sys.stderr, f"{marked_sentence(line(sentence), sys.stderr)}\n")


def marked_sentence(sentence: str, stream: TextIO) -> str:
    """The sentence, in which `error:` and `warning:` are marked where the stream has colours."""
    word, colon, rest = sentence.partition(":")
    style = _STYLES.get(word)
    return f"{styled(word + colon, style)}{rest}" if style and coloured(stream) else sentence


def show(stream: TextIO, text: str) -> None:
    """Write to a stream for messages, which is given up when it cannot be written."""
    try:
        stream.write(text)
        stream.flush()
    except (OSError, ValueError):  # ValueError: the stream is closed
        _silence(stream)


def _stream(number: int) -> TextIO:
    return open(number, "w", encoding="utf-8", closefd=False)


def _silence(stream: TextIO) -> None:
    """Send nowhere what a stream still holds and all that follows: the interpreter flushes it again at its end."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
