"""What an operator needs of a message; it fits every seam whose message has it, in any stack."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scaloft_fi.stack.fields import image_fields, number_fields, stamp_fields


@dataclass(frozen=True)
class Need:
    """What a message must have.

    Attributes:
        words: as it stands behind "needs".
        met_by: whether a message type has it.
    """

    words: str
    met_by: Callable[[type], bool]


ANYTHING = Need("any message", lambda _message: True)
NUMBERS = Need("a field of numbers", lambda message: bool(number_fields(message)))
STAMP = Need("a time stamp", lambda message: bool(stamp_fields(message)))
IMAGE = Need("an image", lambda message: bool(image_fields(message)))


def the(message: type) -> Need:
    """The message of that type, or of one derived from it.

    >>> from scaloft_fi.stack.messages import Battery, Imu
    >>> the(Imu).met_by(Imu), the(Imu).met_by(Battery), the(Imu).words
    (True, False, 'the message Imu')
    """
    return Need(f"the message {message.__name__}", lambda candidate: issubclass(candidate, message))
