"""Windows in which a fault is active: they open at times, or whenever an event of the flight occurs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

TOLERANCE_S = 1e-6
"""Poll times are k/20 or k/240 in floating point; with this tolerance windows open and close at the intended poll."""


class Openings(Protocol):
    """What opens windows."""

    def latest(self, t_s: float) -> tuple[int, float] | None:
        """Number of the latest opening at `t_s` [s], counted from 0, and the time since then [s]; None before any."""
        ...


@dataclass(frozen=True)
class Times:
    """Openings at `first_s` + `period_s` * k [s], k = 0, 1, ..."""

    first_s: float
    period_s: float = math.inf

    def latest(self, t_s: float) -> tuple[int, float] | None:
        """Return number and age of the latest opening."""
        since_s = t_s - self.first_s + TOLERANCE_S
        if since_s < 0:
            return None
        count = math.floor(since_s / self.period_s)
        return count, since_s - self.period_s * count if count else since_s


@dataclass(eq=False)
class _Occurred:
    """Openings at the occurrences of an event that come at least `apart_s` [s] after the opening before."""

    apart_s: float
    number: int = -1
    at_s: float = -math.inf

    def occur(self, t_s: float) -> None:
        if self.number < 0 or t_s - self.at_s >= self.apart_s - TOLERANCE_S:
            self.number, self.at_s = self.number + 1, t_s

    def latest(self, t_s: float) -> tuple[int, float] | None:
        return None if self.number < 0 else (self.number, t_s - self.at_s + TOLERANCE_S)


class Occurrences:
    """The occurrences of an event in one flight: the flight loop tells of each as it comes, openings follow them."""

    def __init__(self) -> None:
        self._openings: list[_Occurred] = []

    @property
    def awaited(self) -> bool:
        """Whether anything opens at them."""
        return bool(self._openings)

    def openings(self, apart_s: float) -> Openings:
        """An opening at each occurrence that comes `apart_s` [s] or more after the one before; inf: at the first."""
        self._openings.append(_Occurred(apart_s))
        return self._openings[-1]

    def occur(self, t_s: float) -> None:
        """Learn of an occurrence at `t_s` [s]."""
        for openings in self._openings:
            openings.occur(t_s)


@dataclass(frozen=True)
class Windows:
    """Windows of `length_s` [s] each; an opening during a window begins the next window."""

    openings: Openings
    length_s: float

    @classmethod
    def periodic(cls, period_s: float, phase_s: float, length_s: float) -> Windows:
        """Windows at `period_s`, 2 `period_s`, ..., each `phase_s` later [s].

        >>> windows = Windows.periodic(period_s=20.0, phase_s=5.0, length_s=2.0)
        >>> [t for t in (4.95, 5.0, 24.95, 25.0, 26.95, 27.0, 45.0) if windows.open(t)]
        [25.0, 26.95, 45.0]
        """
        return cls(Times(period_s + phase_s, period_s), length_s)

    @classmethod
    def since(cls, at_s: float) -> Windows:
        """One window that opens at `at_s` [s] and never closes."""
        return cls(Times(at_s), math.inf)

    def open(self, t_s: float) -> bool:
        """Whether a window is open at `t_s` [s]."""
        return self.number(t_s) is not None

    def number(self, t_s: float) -> int | None:
        """Number of the window that is open at `t_s` [s], counted from 0; None between windows."""
        opening = self.openings.latest(t_s)
        return opening[0] if opening is not None and opening[1] < self.length_s else None
