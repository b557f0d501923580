"""Faults of the battery: operators on its telemetry (message `Battery`) and on the thrust (message `Thrust`)."""

from __future__ import annotations

import numpy as np

from scaloft_fi.mutants.operator import Example, Facts, Hold, Seconds, Share, Tap, TapContext, Windows, operator, the
from scaloft_fi.mutants.sample import on_each, within
from scaloft_fi.stack.messages import Battery, Thrust

_FULL = Battery(0.0, 0.9, 16.0, 4)


def _depleted(battery: Battery, charge: float) -> Battery:
    """Change the charge only: the voltage is measured by another sensor."""
    return battery._replace(charge=charge)


@operator(
    "sag",
    need=the(Thrust),
    example=Example(Thrust, {"share": 0.5}, (Thrust(np.full(4, 4.0)), None), (Thrust(np.full(4, 1.0)), None)),
)
def sag(_context: TapContext, *, share: Share) -> Tap:
    """Multiply the thrust of every rotor by (1 - `share`)^2.

    The voltage under load sags by `share`, thrust goes with its square.
    """
    factor = (1.0 - share) ** 2
    return on_each(lambda thrust: thrust._replace(rotors=thrust.rotors * factor))


@operator(
    "early_depletion",
    need=the(Battery),
    example=Example(
        Battery,
        {"share": 0.5},
        (_FULL, _FULL, _FULL, None),
        (_FULL, _FULL._replace(charge=0.0), _FULL._replace(charge=0.0), None),
        facts=Facts(duration_s=0.1),
    ),
)
def early_depletion(context: TapContext, *, share: Share, charge: Share = 0.0) -> Tap:
    """Report a state of charge of `charge` (0..1) from `share` (0..1) of the nominal mission time on.

    A gauge that drops too early.
    """
    return within(Windows.since(share * context.facts.duration_s), lambda battery: _depleted(battery, charge))


@operator(
    "depleted_pulse",
    need=the(Battery),
    example=Example(
        Battery, {"hold_s": 0.05, "at_s": 0.1}, (_FULL,) * 4, (_FULL, _FULL, _FULL._replace(charge=0.0), _FULL)
    ),
)
def depleted_pulse(
    context: TapContext,
    *,
    hold_s: Hold = 2.0,
    at_s: Seconds = 20.0,
    phase_s: Seconds = 0.0,
    charge: Share = 0.0,
) -> Tap:
    """Report a state of charge of `charge` (0..1) for `hold_s` [s] from `at_s` + `phase_s` [s] on: a glitch."""
    windows = context.window(at_s + phase_s, max(hold_s, context.period_s))
    return within(windows, lambda battery: _depleted(battery, charge))
