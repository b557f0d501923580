"""Operators on samples that only a stage outside takes as they are."""

from __future__ import annotations

from scaloft_fi.mutants.operator import Hold, Period, Seconds, Tap, TapContext, on
from scaloft_fi.mutants.sample import within
from scaloft_fi.stack.messages import Bumper

_FREE = Bumper(0.0, hull=False, gear=False)


@on(
    Bumper,
    "false_contact",
    {"hold_s": 0.05, "period_s": 0.1},
    (_FREE,) * 4,
    (_FREE, _FREE, _FREE._replace(hull=True), _FREE),
)
def false_contact(context: TapContext, *, hold_s: Hold = 0.5, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Report contact of the hull without cause for `hold_s` [s] each `period_s` [s]: noise on the touch sensor."""
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    return within(windows, lambda bumper: bumper._replace(hull=True))
