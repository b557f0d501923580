"""Needs: what an operator requires of a message.  It fits every seam of any stack whose message meets its need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scaloft_fi.stack.fields import image_fields, number_fields, stamp_fields


@dataclass(frozen=True)
class Need:
    """A requirement of an operator on a message.

    Attributes:
        words: the need in words, which follow "needs" in a sentence.
        met_by: whether a message type meets the need.
    """

    words: str
    met_by: Callable[[type], bool]


ANYTHING = Need("any message", lambda _message: True)
NUMBERS = Need("a field of numbers", lambda message: bool(number_fields(message)))
STAMP = Need("a time stamp", lambda message: bool(stamp_fields(message)))
IMAGE = Need("an image", lambda message: bool(image_fields(message)))


def the(message: type) -> Need:
    """The need for a message of type `message`, or of a type derived from it.

    >>> from scaloft_fi.stack.messages import Battery, Imu
    >>> the(Imu).met_by(Imu), the(Imu).met_by(Battery), the(Imu).words
    (True, False, 'the message Imu')
    """
    return Need(f"the message {message.__name__}", lambda candidate: issubclass(candidate, message))
