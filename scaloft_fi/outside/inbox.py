"""What came over an inward topic of a border."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from scaloft_fi.console import line as inert
from scaloft_fi.outside.border import Arrival, Topic

AHEAD_S = 0.1
"""A message may be stamped this much later than the flight's clock [s]."""
SAID = 300
"""Most characters of a sentence on a refused message."""


@dataclass
class Inbox:
    """What came since it was last taken.

    Attributes:
        topic: the topic.
        sample: the newest sound sample.
        count: number of messages.
        refused: about the first refused message.
        fresh: whether a sound one came since the last clock.
    """

    topic: Topic
    sample: Any | None = None
    count: int = 0
    refused: str = ""
    fresh: bool = False

    def begin_tick(self) -> None:
        """What comes from now on answers this tick."""
        self.fresh = False

    def refuse(self, reason: str) -> None:
        """Note why a message was refused, if it is the first one."""
        self.refused = self.refused or f"{self.topic.name}: {inert(reason)[:SAID]}"

    def take(self) -> Arrival:
        """What came, and an empty box."""
        arrival = Arrival(self.sample, self.count, self.refused)
        self.sample, self.count, self.refused = None, 0, ""
        return arrival
