"""What source files mean, kept between processes: to parse the package takes half a second, to read it a hundredth.

An entry is found by the hash of a file's whole content, so none can grow old.  Where the user's cache folder cannot be
read or written, every process parses.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from scaloft_fi.errors import InputError
from scaloft_fi.output import write_whole
from scaloft_fi.reading import MIB, read_bytes

MOST_BYTES = 4 * MIB
Meaning = tuple[str, tuple[str, ...]]
"""Hash of a file's code, and the names that the file may import."""


class SourceCache:
    """The meanings of sources by content.

    Args:
        reader: the code that finds a meaning; another reader finds other meanings.
    """

    def __init__(self, reader: bytes) -> None:
        self._reader = hashlib.sha256(reader)
        self._kept: dict[str, Meaning] | None = None
        self._new: dict[str, Meaning] = {}

    def get(self, content: bytes) -> Meaning | None:
        """The meaning of a file with this content; None where it is not known."""
        if self._kept is None:
            self._kept = dict(_read(_path()))
        return self._kept.get(self._key(content))

    def put(self, content: bytes, meaning: Meaning) -> None:
        """Keep a meaning until `save`."""
        self._new[self._key(content)] = meaning

    def save(self) -> None:
        """Write what is new, if anything is."""
        if not self._new:
            return
        self._kept, self._new = {**(self._kept or {}), **self._new}, {}
        text = json.dumps(self._kept).encode()
        with suppress(OSError, ValueError, RuntimeError):
            path = _path()
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, text if len(text) <= MOST_BYTES else b"{}")

    def _key(self, content: bytes) -> str:
        digest = self._reader.copy()
        digest.update(content)
        return digest.hexdigest()


def _path() -> Path:
    """The file, of this version of Python, whose syntax trees differ from those of others."""
    folder = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(folder).expanduser() / "scaloft-fi" / f"sources-{sys.implementation.cache_tag}-{sys.hexversion:x}.json"


def _read(path: Path) -> Mapping[str, Meaning]:
    with suppress(InputError, OSError, ValueError, TypeError, AttributeError, RuntimeError):
        kept = json.loads(read_bytes(path, MOST_BYTES))
        return {str(key): (str(meaning), tuple(map(str, imports))) for key, (meaning, imports) in kept.items()}
    return {}
