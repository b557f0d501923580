"""What the environment refuses a process: files, descriptors, memory, its working directory."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from pathlib import Path

from scaloft_fi.errors import InputError

try:
    import resource
except ImportError:  # Windows has no such limits
    resource = None  # type: ignore[assignment]

DESCRIPTORS = "too many open files: raise the limit (`ulimit -n 256`)"
MEMORY = "not enough memory: raise the limit (`ulimit -v unlimited`), or give fewer --jobs"
DIRECTORY = "the working directory does not exist: change to another one"
FLYING, READING = 800_000_000, 320_000_000
"""Address space that verbs need which fly, and which read results; they took 675 and 262 MB for one flight [bytes]."""
_LOADER = {"Too many open files": DESCRIPTORS, "failed to map segment": MEMORY, "annot allocate memory": MEMORY}
"""What the dynamic loader says when a library cannot be loaded."""


def check_memory(verb: str) -> None:
    """Refuse early what would end in a crash or an endless loop of a numeric library, which does not answer a signal.

    Raises:
        InputError: the limit of the address space is too small for the verb.
    """
    if resource is None or verb == "matrix":
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    least = FLYING if verb in {"run", "margin", "replay"} else READING
    if limit != resource.RLIM_INFINITY and limit < least:
        raise InputError(
            f"{verb}: not enough memory: the limit is {limit // 1_000_000} MB of at least {least // 1_000_000}; "
            f"raise it (`ulimit -v {least // 1000}`)"
        )


def refusal(error: BaseException) -> str:
    """The sentence of an error that comes from the environment; "" for any other error.

    >>> refusal(MemoryError())
    'not enough memory: raise the limit (`ulimit -v unlimited`), or give fewer --jobs'
    >>> refusal(PermissionError(13, "Permission denied", "a.txt")), refusal(ValueError("odd"))
    ("'a.txt': Permission denied", '')
    """
    return next(filter(None, map(_sentence, _chain(error))), "")


def _sentence(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return MEMORY
    if isinstance(error, ImportError):
        return next((sentence for said, sentence in _LOADER.items() if said in str(error)), "")
    if not isinstance(error, OSError):
        return ""
    if error.errno in (errno.EMFILE, errno.ENFILE):
        return DESCRIPTORS
    if error.errno == errno.ENOMEM:
        return MEMORY
    if error.filename is None and not _has_directory():
        return DIRECTORY
    said = error.strerror or str(error)
    return said if error.filename is None else f"{os.fsdecode(error.filename)!r}: {said}"


def _has_directory() -> bool:
    try:
        Path.cwd()
    except FileNotFoundError:
        return False
    return True


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """The error and its causes, the last cause first: an importer wraps what the loader says."""
    if error is not None:
        yield from _chain(error.__cause__ or error.__context__)
        yield error
