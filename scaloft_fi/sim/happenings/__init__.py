"""Things that happen during a flight; each kind is declared in a file of its own."""

from scaloft_fi.sim.happenings import appear, drift, dust, light, walk, wind  # noqa: F401 - they declare their kinds
from scaloft_fi.sim.happenings.happening import Effect, Happening, Start, Surroundings, signals_of
from scaloft_fi.sim.happenings.kinds import (
    HAPPENINGS,
    HappeningKind,
    Read,
    check_happenings,
    read_happening,
    read_happenings,
)

__all__ = [
    "HAPPENINGS",
    "Effect",
    "Happening",
    "HappeningKind",
    "Read",
    "Start",
    "Surroundings",
    "check_happenings",
    "read_happening",
    "read_happenings",
    "signals_of",
]
