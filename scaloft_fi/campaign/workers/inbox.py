"""What the topic of a cluster brings to a run: messages with its key are kept, all others are counted."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

from scaloft_fi.campaign.workers.key import Message, sealed, unsealed


class Inbox:
    """The messages of one run.

    Args:
        key: key of the cluster.

    Attributes:
        strange: number of messages that were none of this run's.
        nonsense: number of messages with the key that made no sense.
        lost: number of times at which messages of our workers may have been lost among strange ones.
    """

    def __init__(self, key: bytes) -> None:
        self._key, self._run = key, uuid.uuid4().hex
        self._messages: SimpleQueue[Message] = SimpleQueue()
        self._numbers = 0
        self._heard: dict[tuple[int, str], int] = {}
        self.strange, self.nonsense, self.lost = 0, 0, 0

    def order(self, kind: str, content: Any, worker: str = "") -> tuple[int, str]:
        """The number of a new task, and the sealed order for it; `worker` = "" is for any worker."""
        self._numbers += 1
        return self._numbers, sealed(self._key, Message(self._run, self._numbers, worker, 1, kind, content))

    @property
    def run(self) -> str:
        """Id of the run."""
        return self._run

    def receive(self, event: Any) -> None:
        """Receive an event of the topic, a pair of time and sealed message; called in a thread of the client."""
        try:
            message = unsealed(self._key, event[1])
        except (ValueError, TypeError, LookupError):
            self.strange += 1
            return
        if message.run != self._run:  # another run with the same key uses the same topic
            return
        sender = message.number, message.worker
        if message.number > self._numbers or message.order <= self._heard.get(sender, 0):
            self.strange += 1
            return
        self._heard[sender] = message.order
        self._messages.put(message)

    def skip(self) -> None:
        """Count what the connection did not read; messages of our workers may have been packed with it."""
        self.strange += 1
        self.lost += 1

    def messages(self, wait_s: float) -> Iterator[Message]:
        """The messages that have arrived; wait at most `wait_s` for the first of them [s, wall]."""
        with suppress(Empty):
            while True:
                yield self._messages.get(block=wait_s > 0.0, timeout=wait_s)
                wait_s = 0.0

    def summary(self) -> Iterator[str]:
        """How many messages were ignored, for the end of a run."""
        if self.strange:
            yield f"warning: {self.strange} messages on the scheduler did not carry the key of the run and were ignored"
        if self.nonsense:
            yield f"warning: {self.nonsense} messages of workers held no outcome that was asked for and were ignored"
