"""A border: it carries samples between a flight and the processes outside, topic by topic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

from scaloft_fi.registry import Registry
from scaloft_fi.sim.flight import StackError

NOTHING: Mapping[str, Any] = MappingProxyType({})


class BorderError(StackError):
    """The border, or what the processes outside need before take-off, is missing: a failure of the harness."""


@dataclass(frozen=True)
class Topic:
    """One topic of a border, over which the samples of one seam go.

    Attributes:
        seam: name of the seam.
        name: of the topic, as the border spells it: "/odom".
        message: type of the seam's samples, a named tuple.
        outward: whether samples go to the processes outside; otherwise they come from there.
        type: type of the border's messages, such as "nav_msgs/msg/Odometry"; "" = the border's usual one for `message`.
        frame: frame of the border's messages: the frame id of those that go out, "world" or "body" for those that come.
        qos: quality of service as the border names it, such as {"reliability": "best_effort", "depth": 1}.
        fields: field of the border's message by path, "linear.x", to that of the sample, "velocity.x"; empty = the
            border's usual mapping.  A number may be multiplied: "velocity.x * 1000".
        awaited: whether the flight waits before take-off until the topic has its other end.
    """

    seam: str
    name: str
    message: type
    outward: bool
    type: str = ""
    frame: str = ""
    qos: Mapping[str, Any] = field(default_factory=dict)
    fields: Mapping[str, str] = field(default_factory=dict)
    awaited: bool = True


@dataclass(frozen=True)
class Arrival:
    """What came over a topic since the last tick, the newest message last.

    Attributes:
        sample: the newest sound sample; None without any.
        count: number of messages that came.
        refused: why a message was refused, a sentence about the first such message; "" if none was.
    """

    sample: Any | None = None
    count: int = 0
    refused: str = ""


class Border(Protocol):
    """Carries samples between one flight and its processes.  It is used in one process, which flies one flight.

    Whatever comes in is untrusted: sizes and numbers of messages are bounded, nothing is unpickled, and a message that
    does not fit, or has a number that is not finite, is refused with a sentence.  Listeners bind to loopback.
    """

    @property
    def environment(self) -> Mapping[str, str]:
        """What the processes need in their environment to find this border, and no other one on this machine."""
        ...

    def open(self) -> None:
        """Open the topics.

        Raises:
            BorderError: a library or a type of message is missing; the sentence says what to install.
        """
        ...

    def lacking(self) -> str:
        """What is not there yet on the other side, in words; "" when every awaited topic has its other end."""
        ...

    def send(self, seam: str, t_s: float, sample: Any) -> None:
        """Send a sample of an outward seam at the simulated time `t_s` [s]."""
        ...

    def clock(self, t_s: float) -> None:
        """Tell the processes the simulated time [s]; the last message of a tick."""
        ...

    def wait(self, seam: str, within_s: float) -> bool:
        """Wait until a message of an inward seam comes, at most `within_s` of wall time [s]; whether one came.

        A message counts that came after the last call of `clock`.
        """
        ...

    def take(self, seam: str) -> Arrival:
        """What came over an inward seam since the last call."""
        ...

    def close(self) -> None:
        """Close the topics; may be called twice."""
        ...


class BorderKind(Protocol):
    """A kind of border, usually its class."""

    def __call__(self, topics: Sequence[Topic], folder: Path, /) -> Border:
        """A border, not open yet; `folder` is empty and private to the flight."""
        ...

    def misfit(self, topic: Topic, /) -> str:
        """What of a topic's settings it cannot carry, in words; "" if all of it.  It needs no other software."""
        ...

    def need(self) -> None:
        """Look for the software that it needs, without importing it.

        Raises:
            InputError: something is missing; the sentence says how to get it.
        """
        ...


BORDERS = Registry[BorderKind]("border")
BORDERS.promise("lines", "scaloft_fi.outside.lines:LinesBorder")
BORDERS.promise("ros2", "scaloft_fi.outside.ros2:Ros2Border")
BORDERS.promise("ros1", "scaloft_fi.outside.ros1:Ros1Border")
