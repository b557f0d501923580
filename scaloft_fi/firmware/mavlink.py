"""The few messages of MAVLink 2 that the adapters of PX4 and ArduPilot exchange (mavlink.io, common.xml)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from scaloft_fi.firmware.kind import VelocityOrder
from scaloft_fi.stack.messages import Array


class Message(NamedTuple):
    """A kind of message: its number, the seed of its checksum, its layout in `struct`."""

    number: int
    extra: int
    layout: str


HEARTBEAT = Message(0, 50, "<IBBBBB")
PARAMETER = Message(23, 168, "<fBB16sB")
COMMAND = Message(76, 152, "<7fHBBB")
TARGET = Message(84, 143, "<I11fHBBB")
CONTROLS = Message(93, 47, "<QQ16fB")
VISION = Message(102, 158, "<Q6f21fB")
SENSORS = Message(107, 108, "<Q13fIB")
TEXT = Message(253, 83, "<B50s")
ARM, TAKE_OFF, SET_MODE = 400, 22, 176
ARMED = 0x80
"""Flag of a heartbeat's base mode."""
_BEGIN, _HEAD = 0xFD, 10
_VELOCITY_AND_YAW = 0b100111000111
_LOCAL_NED = 1


def checksum(data: bytes, extra: int) -> int:
    """CRC-16/MCRF4XX of the bytes and the seed.

    >>> hex(checksum(b"12345678", ord("9")))
    '0x6f91'
    """
    crc = 0xFFFF
    for byte in (*data, extra):
        low = (byte ^ crc) & 0xFF
        low = (low ^ (low << 4)) & 0xFF
        crc = (crc >> 8) ^ (low << 8) ^ (low << 3) ^ (low >> 4)
    return crc


@dataclass(eq=False)
class Talk:
    """What goes to an autopilot and comes from it.

    Attributes:
        system: number under which the ground station speaks.
    """

    system: int = 255
    _count: int = 0
    _rest: bytes = b""

    def said(self, message: Message, *values: float | bytes) -> bytes:
        """The bytes of a message."""
        payload = struct.pack(message.layout, *values)
        head = struct.pack("<BBBBBBBHB", _BEGIN, len(payload), 0, 0, self._count & 0xFF, self.system, 190,
                           message.number & 0xFFFF, message.number >> 16)  # fmt: skip
        self._count += 1
        return head + payload + struct.pack("<H", checksum(head[1:] + payload, message.extra))

    def heartbeat(self) -> bytes:
        """A ground station is there."""
        return self.said(HEARTBEAT, 0, 6, 8, 0, 4, 3)

    def command(self, number: int, *values: float) -> bytes:
        """A command to system 1, with up to seven values."""
        return self.said(COMMAND, *values, *[0.0] * (7 - len(values)), number, 1, 1, 0)

    def velocity(self, order: VelocityOrder) -> bytes:
        """A velocity with a heading; the autopilot's axes are x ahead of the study's x axis, y right, z down."""
        x, y, z = order.velocity.tolist()
        values = (0.0, 0.0, 0.0, x, -y, -z, 0.0, 0.0, 0.0, -order.yaw_rad, 0.0)
        return self.said(TARGET, int(order.stamp_s * 1e3), *values, _VELOCITY_AND_YAW, 1, 1, _LOCAL_NED)

    def parameter(self, name: str, value: float) -> bytes:
        """A parameter of system 1, which is a number of 32 bits."""
        return self.said(PARAMETER, value, 1, 1, name.encode(), 9)

    def heard(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Number and payload of each whole message; zeros at the end of a payload are left out on the wire."""
        self._rest += data
        while (at := self._rest.find(bytes([_BEGIN]))) >= 0:
            self._rest = self._rest[at:]
            if len(self._rest) < _HEAD or len(self._rest) < (length := _HEAD + self._rest[1] + 2):
                return
            yield int.from_bytes(self._rest[7:10], "little"), self._rest[_HEAD : length - 2].ljust(280, b"\0")
            self._rest = self._rest[length:]
        self._rest = b""


def values_of(message: Message, payload: bytes) -> tuple[float, ...]:
    """The values of a payload."""
    return struct.unpack_from(message.layout, payload)


@dataclass(eq=False)
class News:
    """What an autopilot has told.

    Attributes:
        armed: whether its newest heartbeat says so.
        mode: number of its mode.
        text: its newest status text.
        throttles: (4,) newest order to the motors.
    """

    armed: bool = False
    mode: int = -1
    text: str = ""
    throttles: Array = field(default_factory=lambda: np.zeros(4))

    def take(self, number: int, payload: bytes) -> None:
        """Note a message."""
        if number == HEARTBEAT.number:
            mode, kind, _, base, *_ = values_of(HEARTBEAT, payload)
            if kind != 6:  # a ground station
                self.mode, self.armed = int(mode), bool(int(base) & ARMED)
        elif number == TEXT.number:
            self.text = payload[1:51].split(b"\0")[0].decode("utf-8", "replace")
        elif number == CONTROLS.number:
            self.throttles = np.array(values_of(CONTROLS, payload)[2:6])
