"""Fly the mission scripts of the SCALOFT testbed, unmodified, over ROS 1 above our planner, with and without faults.

    python -m experiments.testbed SETUP_SCRIPT TRIAL_SCRIPT [--output FILE]

It needs what `examples/testbed/setup.sh` and `pip install ./examples/ros1` install.  Each flight keeps what crossed
the seams of the border, with simulated and wall time, and what the scripts printed.  No
flight is repeated and none left out.  It writes the head and the tables of the page; the published one says besides,
in two sections of sentences, what its tables show and what they do not.
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from itertools import pairwise
from pathlib import Path
from runpy import run_path
from typing import Any

from experiments import ROOT
from experiments.pages import Row, blocks, parser, registered, table
from scaloft_fi.campaign.flights.fly import Flight, judged, wire_of
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.stack.declaration import Wire
from scaloft_fi.study import Study

SLOW_MPS = 0.25
"""A speed limit up to this is a slow order [m/s]."""
GAP_S = 0.5
"""Goals that pause for longer have another script after the pause [s]."""
PLACES = {"(0, 7)": (0.0, 7.0), "(-3, 8)": (-3.0, 8.0)}


def page(flights: Sequence[Flown], scripts: Mapping[str, str]) -> str:
    """Head and tables of the page of these flights; `scripts` has the SHA-256 of each script by its name."""
    files = [f"- `{name}`, SHA-256 `{digest}`" for name, digest in scripts.items()]
    return registered("testbed", end="\n- `") + "\n".join(files) + "\n" + blocks(*_flights(flights), *_orders(flights))


def _flights(flights: Sequence[Flown]) -> Iterator[str | Iterable[str]]:
    yield "## Flights"
    yield "`within`: the least distance to the waypoint, in the plane.  `home`: that of the last sample to (0, 0)."
    heads = "flight", "ended", *(f"within of {place}" for place in PLACES), "home", "SR1", "SR2", "OP1"
    yield table((*heads, "simulated", "wall", "digest", "stack error"), map(_flight, flights))


def _flight(one: Flown) -> Row:
    x, y = one.log.signals["x_m"], one.log.signals["y_m"]
    near = (min(math.hypot(a - px, b - py) for a, b in zip(x, y, strict=True)) for px, py in PLACES.values())
    metres = (f"{distance_m:.2f} m" for distance_m in (*near, math.hypot(x[-1], y[-1])))
    readings = (_reading(one, name) for name in ("SR1", "SR2", "OP1"))
    ended = one.outcome.ending + (f", struck {one.log.struck}" if one.log.struck else "")
    times = f"{float(one.log.signals['elapsed_s'][-1]):.2f} s", f"{one.wall_s:.0f} s"
    digest = f"`{one.outcome.digest[:8]}`"
    return f"`{one.name}`", ended, *metres, *readings, *times, digest, one.log.stack_error or "none"


def _reading(one: Flown, name: str) -> str:
    reading = next(r for r in one.outcome.readings if r.requirement == name)
    said = "not triggered" if not reading.triggered else f"{reading.rho:+.2f}"
    at = "" if reading.violated_at_s is None else f", violated at {reading.violated_at_s:.2f} s"
    return f"{'open' if reading.open else said}{at}"


def second_script(one: Flown) -> float | None:
    """When the first goal after the longest pause came: that of the second script [s]."""
    times = [c.t_s for c in one.crossings if c.seam == "destination" and c.sent is not None]
    later = [(b - a, b) for a, b in pairwise(times) if b - a > GAP_S]
    return max(later)[1] if later else None


FIRSTS: Mapping[str, tuple[str, Callable[[Crossing], bool]]] = {
    "seen": ("person", lambda c: c.sent is not None and bool(c.sent.persons)),
    "told": ("person", lambda c: c.delivered is not None and bool(c.delivered.persons)),
    "slow": ("speed", lambda c: c.delivered is not None and c.delivered.limit_mps <= SLOW_MPS),
    "land": ("landing", lambda c: c.delivered is not None),
}
"""By word of the page the seam, and the first of its messages that is meant."""


def first(one: Flown, word: str) -> Crossing | None:
    """The first message that a word of the page means."""
    seam, holds = FIRSTS[word]
    return next((c for c in one.crossings if c.seam == seam and holds(c)), None)


def touched(one: Flown) -> list[float]:
    """When the contacts began that the script could hear of [s]."""
    times = [c.t_s for c in one.crossings if c.seam == "contact" and c.delivered is not None and c.delivered.hull]
    return [t_s for place, t_s in enumerate(times) if place == 0 or t_s - times[place - 1] > GAP_S]


def last_goal(one: Flown) -> Crossing | None:
    """The last goal that the planner got."""
    goals = [c for c in one.crossings if c.seam == "destination" and c.delivered is not None]
    return goals[-1] if goals else None


def _orders(flights: Sequence[Flown]) -> Iterator[str | Iterable[str]]:
    yield "## Orders"
    yield (
        "Simulated time, and in brackets wall time since the first message.  `seen`: the detector's first message\n"
        "with a person; `told`: the first one that the script could get; `slow`: its first slow order at the planner."
    )
    heads = "second script's first goal", "seen", "told", "slow", "seen to slow", "contacts told", "last goal", "land"
    yield table(("flight", *heads), map(_order, flights))


def _order(one: Flown) -> Row:
    firsts = (_at(first(one, word)) for word in ("seen", "told", "slow"))
    told = ", ".join(f"{t_s:.2f} s" for t_s in touched(one)) or "none"
    ends = _at(last_goal(one)), _at(first(one, "land"))
    return f"`{one.name}`", _seconds(second_script(one)), *firsts, _seconds(delay(one)), told, *ends


def _at(crossing: Crossing | None) -> str:
    return "none" if crossing is None else f"{crossing.t_s:.2f} s ({crossing.wall_s:.2f} s)"


def _seconds(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f} s"


def delay(one: Flown) -> float | None:
    """From the detector's first person to the first slow order [s, simulated]."""
    begin, end = first(one, "seen"), first(one, "slow")
    return None if begin is None or end is None else end.t_s - begin.t_s


FLIGHTS = (
    "baseline/H0/0",
    "baseline/H1/0",
    "PLACEBO/H1/0",
    "LATE-human@3s/H1/0",
    "UNINTENDED-collision@20s/H0/0",
    "UNINTENDED-collision@20s/H1/0",
    "MORE-goal@1.01x/H0/0",
    "MORE-goal@1.02x/H0/0",
    "MORE-goal@1.1x/H0/0",
    "MORE-goal@1.3x/H0/0",
)
FILES = "TESTBED_FILES"


@dataclass(frozen=True)
class Crossing:
    """A sample over a seam.  t_s: simulated time; wall_s: since the first crossing; sent, delivered: None for none."""

    seam: str
    t_s: float
    wall_s: float
    sent: Any
    delivered: Any


class Tape:
    """A wire that notes what crosses the seams of the border."""

    def __init__(self, wire: Wire, seams: Sequence[str]) -> None:
        self._wire, self._seams = wire, frozenset(seams)
        self._began_s = time.monotonic()
        self.crossings: list[Crossing] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._wire, name)

    def cross(self, seam: str, t_s: float, sample: Any) -> Any:
        """Carry the sample, and note it."""
        delivered = self._wire.cross(seam, t_s, sample)
        if seam in self._seams and (sample is not None or delivered is not None):
            if not self.crossings:
                self._began_s = time.monotonic()
            self.crossings.append(Crossing(seam, t_s, time.monotonic() - self._began_s, sample, delivered))
        return delivered


@dataclass(frozen=True)
class Flown:
    """One flight.

    Attributes:
        name: of the flight.
        log, outcome: what happened, and how it is judged.
        crossings: what crossed the seams of the border, in order.
        said: what the scripts printed.
        wall_s: how long the flight took, processes and all.
    """

    name: str
    log: FlightLog
    outcome: Outcome
    crossings: Sequence[Crossing]
    said: Sequence[str]
    wall_s: float


def flown(study: Study, name: str, folder: Path) -> Flown:
    """Fly a flight; the scripts' files are in `folder`."""
    subject, situation, seed = name.split("/")
    flight: Flight = flight_named(study, subject, situation, int(seed))
    os.environ[FILES] = str(folder)
    began_s = time.monotonic()
    tape = Tape(wire_of(study, flight), tuple(study.sim.stack.settings(study.stack).seams))
    log = fly(study.sim, flight.situation, flight.seed, tape)
    wall_s = time.monotonic() - began_s
    said = (folder / "said.txt").read_text().splitlines()
    return Flown(name, log, judged(study, flight, log), tape.crossings, said, wall_s)


def main() -> None:
    """Fly, and write the page."""
    asked = parser(__doc__, "testbed")
    asked.add_argument("setup", type=Path)
    asked.add_argument("trial", type=Path)
    options = asked.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder, scripts = Path(temporary) / "study", (options.setup, options.trial)
        run_path(str(ROOT / "examples" / "testbed" / "make_study.py"))["make_study"](folder, scripts, ROOT)
        study = Study.open(folder)
        flights = []
        for name in FLIGHTS:
            flights.append(flown(study, name, Path(temporary) / name.replace("/", "_")))
            print(f"{name}: {flights[-1].outcome.ending}, {flights[-1].wall_s:.0f} s", file=sys.stderr)
    digests = {path.name: sha256(path.read_bytes()).hexdigest() for path in scripts}
    options.output.write_text(page(flights, digests), encoding="utf-8")


if __name__ == "__main__":
    main()
