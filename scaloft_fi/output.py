r"""The one way out: files written whole or not at all, and the standard streams.

A file is written whole or not at all: beside its place under another name, then renamed; a signal leaves no such file.
Ctrl-C, SIGTERM and SIGHUP end the process of the command at once, with one sentence and the exit code 130.  A
`KeyboardInterrupt` would be raised at any place: in an import, a compiler, a destructor.  Some of them swallow it,
others print a traceback.  Nothing needs it to be saved: a store has each flight in a transaction of its own, files
are written beside their place, and processes end with their parent.  A run has handlers of its own while it flies.

Standard output and standard error may be terminals, files on a full disk, closed pipes, nothing.  Every text that
leaves through them is made inert here: control characters (C0, C1, DEL), characters that are not seen or turn the
direction of writing (zero width, bidirectional formatting, tags), line separators and lone surrogates of file names are
written as `\x1b`, `\u202e` and so on.  Line breaks and tabs stay, except where a text must be one line.  Lines end
between words: never within an id or a path, a command that fits a line, or before a `%`.  A reader that leaves early is
no error; a result that cannot be written is one; a message that cannot be written never stops the work.
"""

from __future__ import annotations

import errno
import io
import json
import os
import re
import secrets
import shlex
import signal
import stat
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from enum import StrEnum
from pathlib import Path
from textwrap import TextWrapper
from types import FrameType
from typing import Any, TextIO

from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.errors import ExitCode, InputError

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


def write_named(path: Path, content: bytes, name: str = "--output") -> None:
    """The same as `write_whole`, for a file that the user names.

    Args:
        path: path of the file.
        content: the whole content.
        name: option or argument that names the file, for errors.

    Raises:
        InputError: the file cannot be written.
    """
    with writing(f"{name}={str(path)!r} cannot be written"):
        write_whole(path, content)


def write_own(path: Path, content: bytes) -> None:
    """The same as `write_whole`, for a file whose place we choose.

    Raises:
        InputError: the file cannot be written.
    """
    with writing(f"{path}: cannot be written"):
        write_whole(path, content)


@contextmanager
def writing(told: str) -> Iterator[None]:
    """In this context a file that the system cannot write is an error of the user.

    Args:
        told: what cannot be done, as the error begins.

    Raises:
        InputError: the system refuses something.
    """
    try:
        yield
    except (OSError, ValueError) as error:
        raise InputError(f"{told}: {unwritable(error)}") from error


def unwritable(error: OSError | ValueError) -> str:
    """Why a file cannot be written."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file; after a failure an earlier file is as it was, and no other file is left.

    The permissions of an earlier file stay, and a symbolic link keeps its place and gets a new target.  What is no
    regular file (a terminal, a pipe, `/dev/null`), what is the standard output or the standard error, and a file whose
    folder takes no other file are written directly.

    Args:
        path: path of the file; its folder exists.
        content: the whole content.

    Raises:
        OSError, ValueError: the file cannot be written, or its name cannot be the name of a file.
    """
    target = Path(os.path.realpath(path))
    try:
        before = path.stat()
    except FileNotFoundError:
        before = None
    if before is None:
        _replace(target, content, None)
    elif stream := _stream(before):
        _write(stream, content)
    elif _is_replaceable(target, before):
        _replace(target, content, before)
    else:
        path.write_bytes(content)


def _stream(file: os.stat_result) -> int:
    """The descriptor of the standard output or error, if it is this file; else 0."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # a stream may be closed, missing or have no descriptor
            descriptor = stream.fileno()
            if descriptor and os.path.samestat(file, os.fstat(descriptor)) and not stat.S_ISCHR(file.st_mode):
                stream.flush()
                return descriptor
    return 0


def _is_replaceable(target: Path, file: os.stat_result) -> bool:
    """Whether `target` is the regular file `file` and can be written, in a folder that takes other files."""
    with suppress(OSError):
        same = os.path.samestat(target.stat(), file)
        return same and stat.S_ISREG(file.st_mode) and all(os.access(p, os.W_OK) for p in (target, target.parent))
    return False


def _replace(target: Path, content: bytes, before: os.stat_result | None) -> None:
    beside = target.with_name(f".scaloft-fi-{os.getpid()}-{secrets.token_hex(4)}.part")
    unfinished(str(beside))
    descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        try:
            _write(descriptor, content)
            if before is not None:
                with suppress(PermissionError):  # the owner of the earlier file may be another user
                    os.fchown(descriptor, before.st_uid, before.st_gid)
                os.fchmod(descriptor, stat.S_IMODE(before.st_mode))
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        _rename(beside, target, content)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
    finally:
        finished(str(beside))


def _rename(beside: Path, target: Path, content: bytes) -> None:
    try:
        beside.replace(target)
    except OSError as error:
        if error.errno != errno.EBUSY:
            raise
        beside.unlink()
        target.write_bytes(content)  # a file that is a mount point of its own cannot be renamed
    with suppress(OSError):  # the name is on the disk, too, where the file system can say so
        folder = os.open(target.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def _write(descriptor: int, content: bytes) -> None:
    left = memoryview(content)
    while left:
        left = left[os.write(descriptor, left) :]


_OBEYED = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f"
    "\ud800-\udfff\ufeff\ufff9-\ufffb\ufffe\uffff\U000e0000-\U000e007f]"
)


def printable(text: str) -> str:
    r"""The text with every character spelled out that a terminal would obey or hide; other texts stay as they are.

    >>> printable("a\x1b[31mb\tc")
    'a\\x1b[31mb\tc'
    """
    return text if text.isprintable() else _OBEYED.sub(lambda found: repr(found[0])[1:-1], text)


def line(text: str) -> str:
    """The printable text on one line."""
    shown = printable(text)
    return " ".join(shown.split()) if "\n" in shown or "\t" in shown else shown.strip()


def json_text(values: Any, *, indent: int | None = None, letters: bool = False) -> str:
    r"""JSON in which everything is escaped that a terminal would obey or hide.

    Args:
        values: plain JSON values.
        indent: as of `json.dumps`.
        letters: whether letters beyond ASCII stand as they are.

    >>> json_text("\x7f\x9b Ü"), json_text("\x7f\x9b Ü", letters=True)
    ('"\\u007f\\u009b \\u00dc"', '"\\u007f\\u009b Ü"')

    Raises:
        ValueError: a number is not finite.
    """
    text = json.dumps(values, indent=indent, ensure_ascii=not letters, allow_nan=False).replace("\x7f", "\\u007f")
    return _OBEYED.sub(lambda found: json.dumps(found[0])[1:-1], text) if letters else text


def all_printable(values: Any) -> Any:
    r"""Plain JSON values with every text printable, keys too.

    >>> all_printable({"struck": ["\x1b[2J", 1.5]})
    {'struck': ['\\x1b[2J', 1.5]}
    """
    if isinstance(values, str):
        return printable(values)
    if isinstance(values, Mapping):
        return {all_printable(key): all_printable(value) for key, value in values.items()}
    if isinstance(values, list | tuple):
        return [all_printable(value) for value in values]
    return values


PIPED = 100
"""Width of a text that goes to no terminal [characters]."""
LEAST = 40
"""Texts are laid out for no less than this [characters]."""
PROSE = 100
"""Sentences are no longer than this on a wider terminal [characters]."""


class Style(StrEnum):
    """A way to mark a text on a terminal, as the number that ANSI has for it.  A style never says what no word says."""

    STRONG = "1"
    BAD = "31"
    GOOD = "32"
    DOUBT = "33"
    COMMAND = "36"


class Marked(str):
    """A text with the marks of styles; every text that came from elsewhere was made printable before."""

    __slots__ = ()


def width() -> int:
    """How wide texts may be: $COLUMNS, else the width of the terminal, else `PIPED` [characters]."""
    told = os.environ.get("COLUMNS", "")
    columns = int(told) if told.isdecimal() and len(told) < 5 else 0
    if not columns:
        try:
            columns = os.get_terminal_size(sys.stdout.fileno()).columns
        except (OSError, ValueError):  # ValueError: the stream has no descriptor
            columns = 0
    return max(LEAST, columns) if columns else PIPED


def coloured(stream: TextIO | None = None) -> bool:
    """Whether a stream gets colours; standard output when None.

    $NO_COLOR forbids them (https://no-color.org), $FORCE_COLOR and $CLICOLOR_FORCE demand them even where no terminal
    is; else a terminal gets them that is not dumb.
    """
    said = os.environ.get
    if said("NO_COLOR"):
        return False
    if any(said(name, "0") not in ("", "0") for name in ("FORCE_COLOR", "CLICOLOR_FORCE")):
        return True
    return (stream or sys.stdout).isatty() and said("TERM") != "dumb" and said("CLICOLOR") != "0"


def styled(text: str, style: Style) -> str:
    r"""The text with the marks of a style.

    >>> styled("killed", Style.BAD)
    '\x1b[31mkilled\x1b[0m'
    """
    return f"\x1b[{style}m{text}\x1b[0m" if text else text


def joined(texts: Sequence[str]) -> str:
    """Texts below each other; marked if any of them is, and then the others must be printable."""
    text = "\n".join(texts)
    return Marked(text) if any(isinstance(each, Marked) for each in texts) else text


COMMAND = re.compile(r"`[^`]+`")
"""A command in a paragraph."""
STUDY_OPTION: ContextVar[str] = ContextVar("STUDY_OPTION", default="")
"""The option that names the study as the user did, with a space before it; "" where the same one is found without."""
WITHOUT_STUDY = ("completion", "example", "new")
"""Verbs that need no study."""
_UNNAMED = re.compile(rf"`scaloft-fi (?!(?:{'|'.join(WITHOUT_STUDY)})\b)[a-z]+(?![^`]*--study)[^`]*")


def with_study(text: str) -> str:
    """The text, whose commands name the study as the user did.

    >>> before = STUDY_OPTION.set(" --study mine")
    >>> with_study("`scaloft-fi status` and `scaloft-fi new DIR`")
    '`scaloft-fi status --study mine` and `scaloft-fi new DIR`'
    >>> STUDY_OPTION.reset(before)
    """
    option = STUDY_OPTION.get()
    return _UNNAMED.sub(lambda command: command[0] + option, text) if option else text


def in_campaign(campaign: str) -> str:
    """The options that name the study, as the user did, and a campaign, with a space before each; empty for defaults.

    >>> in_campaign("wide"), in_campaign("default"), in_campaign("a b")
    (' --campaign wide', '', " --campaign 'a b'")
    """
    return STUDY_OPTION.get() + (f" --campaign {shlex.quote(campaign)}" if campaign != CAMPAIGN else "")


_ON = " \\"
"""Ends a line that a shell is to read on with the next."""
_BLANK = "\x00"
"""Stands for a blank at which no line may end; no printable text holds it."""


_PERCENT = re.compile(r"(?<=\d) (?=%)")


def kept_together(text: str) -> str:
    """The text with a sign that is no blank before each `%`, so that it stays beside its number."""
    return _PERCENT.sub(_BLANK, text)


def broken(text: str, width: int, first: str = "", rest: str = "") -> list[str]:
    """The lines of a text; the arguments are those of `wrapped`, which keeps commands whole, too.

    >>> broken("8/32 = 25 %", 10)
    ['8/32 =', '25 %']
    """
    wrapper = TextWrapper(width, first, rest, break_on_hyphens=False, break_long_words=False)
    return [line.replace(_BLANK, " ") for line in wrapper.wrap(kept_together(text))]


def wrapped(text: str, width: int, first: str = "", rest: str = "") -> str:
    r"""The text in lines of `width` characters; a word that is longer keeps a line of its own.

    Args:
        text: of one paragraph; a command stands between backticks, and is broken so that a shell reads it as one.
        width: of the lines with their indent [characters].
        first: stands before the first line.
        rest: stands before each other line.

    >>> print(wrapped("fly it again: `scaloft-fi replay NO-depth@3s/T0/0`", 40))
    fly it again:
    `scaloft-fi replay NO-depth@3s/T0/0`
    >>> print(wrapped("`scaloft-fi run --mutant NO-depth@3s`", 30))
    `scaloft-fi run --mutant \
    NO-depth@3s`
    """
    room, text = width - max(len(first), len(rest)), with_study(text)
    whole = all(len(command) <= room for command in COMMAND.findall(text))

    def held(command: re.Match[str]) -> str:
        return command[0].replace(" ", _BLANK) if len(command[0]) <= room else command[0]

    lines = "\n".join(broken(COMMAND.sub(held, text), width if whole else width - len(_ON), first, rest))
    return COMMAND.sub(lambda command: command[0].replace("\n", f"{_ON}\n"), lines)


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
    sys.stdout, sys.stderr = sys.stdout or _reopened(1), sys.stderr or _reopened(2)
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
    show(sys.stderr, f"{marked_sentence(line(with_study(sentence)), sys.stderr)}\n")


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


def _reopened(number: int) -> TextIO:
    return open(number, "w", encoding="utf-8", closefd=False)


def _silence(stream: TextIO) -> None:
    """Send nowhere what a stream still holds and all that follows: the interpreter flushes it again at its end."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
