"""For a program outside: talk to a flight over the border `lines`, with nothing but the standard library.

    from scaloft_fi.outside.client import connect

    border = connect(publishes=["/cmd_vel"])
    for message in border:
        if "clock" in message:
            border.send("/cmd_vel", {"velocity": [0.5, 0.0, 0.0], "turn_radps": 0.0})

A message has `topic`, `t_s` and `data`; the last one of a tick has `clock` alone.
"""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator, Sequence
from typing import Any

VARIABLE = "SCALOFT_BORDER"
"""The environment variable with the path of the flight's socket."""


class Connection:
    """A connection to a flight; iterating over it yields its messages until the flight ends."""

    def __init__(self, connected: socket.socket) -> None:
        self._socket = connected
        self._lines = connected.makefile("rb")

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return map(json.loads, self._lines)

    def send(self, topic: str, data: Any, **more: Any) -> None:
        """Send a message."""
        self._write({"topic": topic, "data": data, **more})

    def close(self) -> None:
        """End the connection."""
        self._lines.close()
        self._socket.close()

    def _write(self, message: Any) -> None:
        self._socket.sendall(json.dumps(message).encode() + b"\n")


def connect(publishes: Sequence[str] = ()) -> Connection:
    """Connect to the flight that started this process; `publishes` are the topics that this process will send.

    Raises:
        KeyError: this process was not started by a flight.
    """
    connected = socket.socket(socket.AF_UNIX)
    connected.connect(os.environ[VARIABLE])
    connection = Connection(connected)
    connection._write({"publishes": list(publishes)})
    return connection
