"""Windows in which a fault is active."""

from __future__ import annotations

import math
from dataclasses import dataclass

TOLERANCE_S = 1e-6
"""Poll times are k/20 or k/240 in floating point; with this tolerance windows open and close at the intended poll."""


@dataclass(frozen=True)
class Windows:
    """Windows open at `first_s` + `period_s` * k, k = 0, 1, ..., for `length_s` [s] each."""

    first_s: float
    period_s: float
    length_s: float

    @classmethod
    def periodic(cls, period_s: float, phase_s: float, length_s: float) -> Windows:
        """Windows at `period_s`, 2 `period_s`, ..., each `phase_s` later [s].

        >>> windows = Windows.periodic(period_s=20.0, phase_s=5.0, length_s=2.0)
        >>> [t for t in (4.95, 5.0, 24.95, 25.0, 26.95, 27.0, 45.0) if windows.open(t)]
        [25.0, 26.95, 45.0]
        """
        return cls(period_s + phase_s, period_s, length_s)

    @classmethod
    def polls(cls, period_s: float, phase_s: float, hold_s: float, poll_s: float) -> Windows:
        """Periodic windows of `hold_s` [s] that hold at least one poll, where polls come every `poll_s` [s]."""
        return cls.periodic(period_s, phase_s, max(hold_s, poll_s))

    @classmethod
    def since(cls, at_s: float) -> Windows:
        """One window that opens at `at_s` [s] and never closes."""
        return cls(at_s, math.inf, math.inf)

    def open(self, t_s: float) -> bool:
        """Whether a window is open at `t_s` [s]."""
        return self.number(t_s) is not None

    def number(self, t_s: float) -> int | None:
        """Number of the window that is open at `t_s` [s], counted from 0; None between windows.

        A window that is longer than the period never closes.
        """
        since_s = t_s - self.first_s + TOLERANCE_S
        if since_s < 0:
            return None
        count = math.floor(since_s / self.period_s)
        return count if since_s < self.length_s or since_s - self.period_s * count < self.length_s else None
