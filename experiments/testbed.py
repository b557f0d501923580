"""Fly the mission scripts of the SCALOFT testbed, unmodified, over ROS 1 above our planner, with and without faults.

    python -m experiments.testbed SETUP_SCRIPT TRIAL_SCRIPT [--keep FOLDER] [--output results/published/testbed.md]

It needs what `examples/testbed/setup.sh` and `pip install ./examples/ros1` install.  Each flight keeps what crossed
the seams of the border, with simulated and wall time, and what the scripts wrote; `--keep` has the files.  No
flight is repeated and none left out.
"""

from __future__ import annotations

from experiments import ROOT

# isort: split

import argparse
import importlib.util
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from experiments.testbed_page import page
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.flights.fly import judged, wire_of
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.output import write_whole
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.stack.declaration import Wire
from scaloft_fi.study import Study

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


def make_study(folder: Path, scripts: Sequence[Path]) -> Study:
    """Write the example's study with these scripts."""
    path = ROOT / "examples" / "testbed" / "make_study.py"
    spec = importlib.util.spec_from_file_location("make_testbed_study", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.make_study(folder, scripts, ROOT)
    return Study.open(folder)


def main() -> int:
    """Fly, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("setup", type=Path)
    parser.add_argument("trial", type=Path)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--output", type=Path, default=ROOT / "results" / "published" / "testbed.md")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        keep = options.keep or Path(temporary) / "files"
        study = make_study(Path(temporary) / "study", [options.setup, options.trial])
        flights = []
        for name in FLIGHTS:
            flights.append(flown(study, name, keep / name.replace("/", "_")))
            print(f"{name}: {flights[-1].outcome.ending}, {flights[-1].wall_s:.0f} s", file=sys.stderr)
    digests = {path.name: sha256(path.read_bytes()).hexdigest() for path in (options.setup, options.trial)}
    write_whole(options.output, page(flights, digests).encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
