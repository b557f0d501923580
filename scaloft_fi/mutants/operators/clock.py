"""Operators on the time stamps of a message: faults of clocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from scaloft_fi.mutants.operator import STAMP, Example, Hold, Number, Period, Range, Seconds, Tap, TapContext, operator
from scaloft_fi.mutants.sample import on_each, reclocked, within
from scaloft_fi.stack.messages import Stamps


def _stamps(t_s: float) -> Stamps:
    return Stamps(t_s, t_s, t_s)


@operator(
    "clock_rate",
    need=STAMP,
    example=Example(Stamps, {"share": 0.1}, (_stamps(0.0), _stamps(10.0)), (_stamps(0.0), _stamps(11.0))),
)
def clock_rate(_context: TapContext, *, share: Annotated[float, Range(above=-1.0, most=10.0)]) -> Tap:
    """Let the sender's clock run fast (slow where negative) by `share` of the time since take-off.

    A wrong oscillator setting.
    """
    return on_each(lambda stamps: reclocked(stamps, lambda t_s: t_s * (1.0 + share)))


@operator(
    "epoch",
    need=STAMP,
    example=Example(Stamps, {"offset_s": 1000.0}, (_stamps(1.0), None), (_stamps(1001.0), None)),
)
def epoch(_context: TapContext, *, offset_s: Number = 1.7e9) -> Tap:
    """Count the sender's clock from another epoch, `offset_s` [s] earlier.

    Wall-clock time (1.7e9 s since 1970) for time since take-off.
    """
    return on_each(lambda stamps: reclocked(stamps, lambda t_s: t_s + offset_s))


@dataclass
class _Disorder:
    count: int
    poll_s: float
    place: int = 0

    def __call__(self, _t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        back_s = 2 * self.place * self.poll_s
        self.place = (self.place + 1) % self.count
        return reclocked(sample, lambda t_s: t_s - back_s)


@operator(
    "disorder",
    need=STAMP,
    example=Example(
        Stamps, {"count": 2}, tuple(_stamps(i / 20) for i in range(4)), tuple(_stamps(i / 20) for i in (0, -1, 2, 1))
    ),
)
def disorder(context: TapContext, *, count: Annotated[int, Range(least=2, most=1000)]) -> Tap:
    """Give every `count` stamps in reverse order: the messages arrive in time, each with the stamp of another."""
    return _Disorder(count, context.period_s)


@operator(
    "stale_pulse",
    need=STAMP,
    example=Example(
        Stamps,
        {"hold_s": 0.05, "period_s": 0.05, "age_s": 0.05, "phase_s": 0.05},
        (_stamps(0.0), _stamps(0.05), _stamps(0.1)),
        (_stamps(0.0), _stamps(0.05), _stamps(0.05)),
    ),
)
def stale_pulse(
    context: TapContext,
    *,
    age_s: Seconds = 1.0,
    hold_s: Hold = 1.0,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
) -> Tap:
    """Let every stamp be `age_s` [s] old for `hold_s` [s], each `period_s` [s]: a spurious time-out."""
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    return within(windows, lambda stamps: reclocked(stamps, lambda t_s: t_s - age_s))
