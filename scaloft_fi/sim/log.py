"""The flight log: signals and events of a flight, recorded during the flight and judged afterwards."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Ending(StrEnum):
    """How a flight ended; not a verdict."""

    LANDED = "landed"
    STRUCK = "struck"
    TIMED_OUT = "timed_out"

    @property
    def cut_short(self) -> bool:
        """Whether the flight ended early, so that a requirement without violation stays open."""
        return self is Ending.STRUCK

    @property
    def sentence(self) -> str:
        """The ending in words."""
        return {
            Ending.LANDED: "touched down",
            Ending.STRUCK: "struck something",
            Ending.TIMED_OUT: "was still flying at the time limit",
        }[self]


@dataclass(frozen=True)
class Event:
    """An event that the map marks: time [s], kind, text; colour of the mark, where a belief has one."""

    t_s: float
    kind: str
    text: str
    colour: str = ""


class Count(Protocol):
    """Counts of a wire on one seam: samples carried, samples altered, time of the first altered sample [s]."""

    @property
    def carried(self) -> int:
        """Number of samples that the seam carried."""
        ...

    @property
    def altered(self) -> int:
        """Number of samples that a fault altered."""
        ...

    @property
    def first_altered_s(self) -> float | None:
        """Time of the first altered sample [s]; None without one."""
        ...


class Recorder:
    """Collects rows of numbers for columns with fixed names."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._rows = np.empty((256, len(self.names)))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, row: Sequence[float] | Array) -> None:
        """Append one sample; its values are in the order of the names."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[self._count] = row
        self._count += 1

    def signals(self) -> dict[str, Array]:
        """Each column (T,) by name."""
        columns = np.ascontiguousarray(self._rows[: self._count].T)
        columns.setflags(write=False)
        return dict(zip(self.names, columns, strict=True))


@dataclass(frozen=True, eq=False)
class FlightLog:
    """One flight.

    Attributes:
        signals: (T,) values by signal name, sampled at 20 Hz; the last sample is the end of the flight.
        ending: how the flight ended.
        struck: name of the body of the first collision; "" without one.  Excused contacts are no collisions.
        struck_at_s: time of the collision [s]; NaN without one.
        stack_error: exception of the stack under test; "" without one.
        counts: counts of the wire by seam.
        events: events in order of time.
        t_max_s: time limit of the situation [s].
        beliefs: names of the signals that are beliefs of the stack; the others are ground truth.
    """

    signals: Mapping[str, Array]
    ending: Ending
    struck: str
    struck_at_s: float
    stack_error: str
    counts: Mapping[str, Count]
    t_max_s: float
    events: tuple[Event, ...] = field(default=())
    beliefs: tuple[str, ...] = ()

    @property
    def duration_s(self) -> float:
        """Time of the last sample [s]."""
        return float(self.signals["elapsed_s"][-1])

    @cached_property
    def digest(self) -> str:
        """SHA-256 over the ground truth: names and bits of its signals, ending, and body struck."""
        names = sorted(set(self.signals) - set(self.beliefs))
        return _digest(self.signals, names, (self.ending, self.struck))

    @cached_property
    def perceived_digest(self) -> str:
        """SHA-256 over the beliefs of the stack and its exception."""
        return _digest(self.signals, sorted(self.beliefs), (self.stack_error,))

    def at(self, t_s: float) -> int:
        """Index of the last sample at or before `t_s`."""
        return max(0, int(np.searchsorted(self.signals["elapsed_s"], t_s + 1e-9, side="right")) - 1)


def _digest(signals: Mapping[str, Array], names: Iterable[str], words: Iterable[str]) -> str:
    whole = hashlib.sha256()
    for name in names:
        values = np.ascontiguousarray(signals[name], dtype="<f8")
        whole.update(f"{name} {len(values)}\n".encode())
        whole.update(values.tobytes())
    whole.update("\n".join(words).encode())
    return whole.hexdigest()


NEVER_S = math.nan
"""Time of an event that did not happen."""
