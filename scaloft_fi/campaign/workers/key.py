"""The key of a cluster: a file that a run and its workers have, and the signature that it gives to each message."""

from __future__ import annotations

import hmac
import json
import os
import stat
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, Final

from scaloft_fi.document import read_bytes
from scaloft_fi.errors import InputError

VARIABLE: Final = "SCALOFT_CLUSTER_KEY"
"""The environment variable with the path of the key file."""
MAKE = "(umask 077; head -c 32 /dev/urandom | base64 > cluster.key)"
"""A command that makes a key file."""
LEAST_BYTES, MOST_BYTES = 32, 4096
"""Least and greatest size of a key file [bytes]."""
MOST_MESSAGE: Final = 1 << 20
"""Greatest length of a sealed message; the largest of the reference campaign has 35,500, of a track of 25,857 bytes."""
_MAC_LENGTH = 64


@dataclass(frozen=True)
class Message:
    """What a run and a worker tell each other.

    Attributes:
        run: id of the run.
        number: number of the task in the run.
        worker: address of the worker that sends it, or that it is for; "" = any worker.
        order: 1 for the first message of this worker about this task, then 2, 3, ...; a repeated message is ignored.
        kind: what the message says.
        content: plain JSON values.
    """

    run: str
    number: int
    worker: str
    order: int
    kind: str
    content: Any = None


def read_key(path: Path) -> bytes:
    """Read a key file.

    Raises:
        InputError: it is no regular file, too short or too long, or others may read it.
    """
    content = read_bytes(path, MOST_BYTES).strip()
    mode = stat.S_IMODE(path.stat().st_mode)
    if os.name == "posix" and mode & 0o077:
        raise InputError(f"{path}: mode={mode:03o} lets others read the key; `chmod 600 {path}` stops that")
    if len(content) < LEAST_BYTES:
        raise InputError(f"{path}: a key file has {LEAST_BYTES} to {MOST_BYTES} bytes; {MAKE} makes one")
    return content


def sealed(key: bytes, message: Message) -> str:
    """The signature of a message, then the message.

    Raises:
        ValueError: the message is longer than `MOST_MESSAGE`, or a number in it is not finite.
    """
    body = json.dumps(astuple(message), allow_nan=False)
    if _MAC_LENGTH + len(body) > MOST_MESSAGE:
        raise ValueError(f"a message of {len(body)} bytes is longer than {MOST_MESSAGE}")
    return _mac(key, body) + body


def unsealed(key: bytes, text: object) -> Message:
    """The message in a sealed text; nothing of it is parsed before its signature is found right.

    Raises:
        ValueError: the text is too long, of another type, or not signed with this key.
    """
    if not isinstance(text, str) or not _MAC_LENGTH < len(text) <= MOST_MESSAGE:
        raise ValueError("no sealed message")
    mac, body = text[:_MAC_LENGTH], text[_MAC_LENGTH:]
    if not hmac.compare_digest(mac.encode(errors="replace"), _mac(key, body).encode()):
        raise ValueError("the message is not signed with this key")
    parts = json.loads(body)
    if not isinstance(parts, list) or list(map(type, parts[:-1])) != [str, int, str, int, str]:
        raise ValueError("the message has other parts")
    return Message(*parts)


def topic_of(key: bytes) -> str:
    """The topic of the events of all runs with this key; the scheduler keeps the last thousand events of each topic."""
    return f"scaloft-fi-{_mac(key, 'topic')[:16]}"


def _mac(key: bytes, body: str) -> str:
    return hmac.new(key, f"scaloft-fi 1 {body}".encode(errors="surrogatepass"), "sha256").hexdigest()
