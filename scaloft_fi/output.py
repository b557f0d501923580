"""Write a file whole or not at all: beside its place under another name, then renamed; a signal leaves no such file.

Ctrl-C, SIGTERM and SIGHUP end the process of the command at once, with one sentence and the exit code 130.  A
`KeyboardInterrupt` would be raised at any place: in an import, a compiler, a destructor.  Some of them swallow it,
others print a traceback.  Nothing needs it to be saved: a store has each flight in a transaction of its own, files
are written beside their place, and processes end with their parent.  A run has handlers of its own while it flies.
"""

from __future__ import annotations

import errno
import os
import secrets
import signal
import stat
import sys
from contextlib import suppress
from pathlib import Path
from types import FrameType

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


def write_named(path: Path, content: bytes, name: str) -> None:
    """The same as `write_whole`, for a file that the user names.

    Args:
        path: path of the file.
        content: the whole content.
        name: option or argument that names the file, for errors.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        write_whole(path, content)
    except (OSError, ValueError) as error:
        raise InputError(f"{name}={str(path)!r} cannot be written: {unwritable(error)}") from error


def write_own(path: Path, content: bytes) -> None:
    """The same as `write_whole`, for a file whose place we choose.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        write_whole(path, content)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error


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
