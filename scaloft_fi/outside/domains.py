"""Domains of ROS 2 that nobody else on this machine uses."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from dataclasses import dataclass

FIRST_PORT, PORTS_OF_DOMAIN = 7400, 250
"""A domain has the UDP ports from `FIRST_PORT + PORTS_OF_DOMAIN * domain` on (DDSI-RTPS 2.5, section 9.6.2.3)."""
FREE, FIRST_PARTICIPANT = 9, 10
"""Offsets of a port that DDS never uses, and of the first participant's."""
DOMAINS = range(1, 101)
"""Their ports lie below those that Linux hands out.  0 is everybody's default."""


@dataclass(frozen=True)
class Domain:
    """A domain that is held until `close`, or the end of this process."""

    number: int
    held: socket.socket

    def close(self) -> None:
        """Let others have it."""
        self.held.close()


def take_domain() -> Domain | None:
    """A domain that no other flight holds, and in which nobody listens; None without a free one."""
    for number in _tried():
        first = FIRST_PORT + PORTS_OF_DOMAIN * number
        held = _bound(first + FREE)
        if held is None:
            continue
        used = _bound(first + FIRST_PARTICIPANT)
        if used is not None:
            used.close()
            return Domain(number, held)
        held.close()
    return None


def _tried() -> Iterator[int]:
    """All domains but the user's own; processes begin at different ones."""
    own = os.environ.get("ROS_DOMAIN_ID", "")
    begin = os.getpid() % len(DOMAINS)
    yield from (number for number in (*DOMAINS[begin:], *DOMAINS[:begin]) if str(number) != own)


def _bound(port: int) -> socket.socket | None:
    """A socket on a port of loopback; None where somebody has the port there, or on every address."""
    one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        one.bind(("127.0.0.1", port))
    except OSError:
        one.close()
        return None
    return one
