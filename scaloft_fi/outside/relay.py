"""Relays: between a topic that a simulator writes and one that it reads, a tap carries every message.

The simulator, or a remapping of its launch file, writes `/x_raw` where it used to write `/x`; the relay reads `/x_raw`,
lets the wire of the flight carry the sample over the seam, and writes `/x`.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

from scaloft_fi.outside.border import BORDERS, Border, BorderError, Topic
from scaloft_fi.outside.command import ClockTopic, Relay
from scaloft_fi.stack.declaration import Declaration, Seam, Wire
from scaloft_fi.stack.messages import Stamp

CLOCK_S = 0.05
"""How often a border is told the time [s, wall]."""
_RAW, _CLOCK = "_raw", "_clock"


class Tick(NamedTuple):
    """The simulated time."""

    stamp_s: Stamp


@dataclass
class _Line:
    """One relay under way.  polled_s: when its seam was polled last [s, wall]; t_s: the time of that poll."""

    seam: Seam
    polled_s: float = 0.0
    t_s: float = 0.0


@dataclass
class Relays:
    """All relays of one flight.

    A seam is polled whenever a message comes, and at its rate while none comes, so that a late sample can be delivered.
    Time is that of the simulator's clock since it was first told; without a clock that of the stamps of the messages
    since the first one, and it passes as the wall clock between them.

    Attributes:
        relays: by name of the seam.
        stack: declares the seams.
        wire: carries the samples.
        folder: empty, for the borders.
        clock: the topic of the simulator's clock; None without one.
    """

    relays: Mapping[str, Relay]
    stack: Declaration
    wire: Wire
    folder: Path
    clock: ClockTopic | None = None
    _borders: dict[str, Border] = field(default_factory=dict)
    _lines: dict[str, _Line] = field(default_factory=dict)
    _first_stamp_s: float | None = None
    _clock_s: float = 0.0
    _began_s: float = 0.0
    _told_s: float = 0.0

    def begin(self) -> Mapping[str, str]:
        """Open the borders; returns what the simulator needs in its environment to find them.

        Raises:
            BorderError: a border cannot be opened.
        """
        self._began_s = time.monotonic()
        environment: dict[str, str] = {}
        clocks = [self.clock.border] if self.clock and self.relays else []
        for name in dict.fromkeys([*(relay.border for relay in self.relays.values()), *clocks]):
            folder = self.folder / name
            folder.mkdir()
            topics = [
                topic for seam, relay in self.relays.items() if relay.border == name for topic in self._pair(seam)
            ]
            if self.clock and self.clock.border == name:
                topics.append(Topic(_CLOCK, self.clock.name, Tick, outward=False, type=self.clock.type))
            border = BORDERS[name](topics, folder)
            self._borders[name] = border
            border.open()
            environment |= border.environment
        self._lines = {name: _Line(self.stack.by_name[name]) for name in self.relays}
        return environment

    def _pair(self, seam: str) -> tuple[Topic, Topic]:
        relay = self.relays[seam]
        written = Topic(
            seam=seam,
            name=relay.to,
            message=self.stack.by_name[seam].message,
            outward=True,
            type=relay.type,
            frame=relay.frame,
            qos=relay.qos,
            fields=relay.fields,
        )
        return replace(written, seam=seam + _RAW, name=relay.source, outward=False), written

    def attend(self) -> None:
        """Carry what has come since the last call.

        Raises:
            BorderError: a message does not fit its seam, or messages came faster than they can be carried.
        """
        now_s = time.monotonic()
        if self.clock:
            self._hear(self._borders[self.clock.border], self.clock.name)
        for name, relay in self.relays.items():
            border, line = self._borders[relay.border], self._lines[name]
            arrival = border.take(name + _RAW)
            if arrival.refused:
                raise BorderError(f"the relay of seam {name!r} cannot read {relay.source}: {arrival.refused}")
            if arrival.count > 1:
                raise BorderError(
                    f"the relay of seam {name!r} lost {arrival.count - 1} messages, which came all at once"
                )
            since_s = self._clock_s - line.t_s if self.clock else now_s - line.polled_s
            if arrival.sample is None and since_s < 1.0 / line.seam.rate_hz:
                continue
            line.t_s = max(line.t_s, self._time(line, arrival.sample, now_s))
            line.polled_s = now_s
            delivered = self.wire.cross(name, line.t_s, arrival.sample)
            if delivered is not None:
                border.send(name, line.t_s, delivered)
        if now_s - self._told_s >= CLOCK_S:
            self._told_s = now_s
            for border in self._borders.values():
                border.clock(max(line.t_s for line in self._lines.values()))

    def _hear(self, border: Border, name: str) -> None:
        """Take the simulator's time, if it was told."""
        arrival = border.take(_CLOCK)
        if arrival.refused:
            raise BorderError(f"the relays cannot read the clock {name}: {arrival.refused}")
        if arrival.sample is not None:
            if self._first_stamp_s is None:
                self._first_stamp_s = float(arrival.sample.stamp_s)
            self._clock_s = float(arrival.sample.stamp_s) - self._first_stamp_s

    def _time(self, line: _Line, sample: object, now_s: float) -> float:
        """The time of a poll since the first message, or since the borders were opened [s]."""
        if self.clock:
            return self._clock_s
        stamp_s = getattr(sample, "stamp_s", None)
        if isinstance(stamp_s, int | float):
            if self._first_stamp_s is None:
                self._first_stamp_s = float(stamp_s)
            return float(stamp_s) - self._first_stamp_s
        since_s = line.polled_s or self._began_s
        return line.t_s + now_s - since_s

    def close(self) -> None:
        """Close the borders; may be called twice."""
        for border in self._borders.values():
            border.close()
        self._borders.clear()
