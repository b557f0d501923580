"""Own simulator by command: it must have the verdicts of the built-in flyer on the same flights.

    python benchmarks/own_simulator.py [--record study|study_bag] [--jobs N]

Flies 20 flights twice: with the built-in flyer, and with `examples/own_simulator`, a program that gets situation, seed
and fault as words and writes a table, or with `study_bag` a rosbag2, from which the flight is judged.  Exit code 1: a
flight is judged differently.
"""

from __future__ import annotations

from checkout import ROOT  # first: it sets the path and the threads

# isort: split

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.campaign.flights.fly import Flyer
from scaloft_fi.campaign.flights.physics import Commanded, Physics
from scaloft_fi.campaign.plan import alone
from scaloft_fi.campaign.processes import cores
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.campaign.workers.local import Local
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

COPY = ROOT / "examples" / "own_simulator" / "copy_study.py"
MUTANTS = ("baseline", "PLACEBO", "LATE-human@3s", "UNINTENDED-collision@20s", "REVERSE-velcmd")
SITUATIONS = ("T0O0W0D0H0", "T0O0W0D0H1", "T1O0W0D1H0", "T1O1W1D0H1")
"""Every kind of flight: nothing violated, a person passed too fast, a contact, one not landed."""


@dataclass(frozen=True)
class Verdict:
    """What a flight says, by either way.  readings: requirement, compliance, robustness, time of the violation [s]."""

    ending: str
    invalid: str
    readings: tuple[tuple[str, str, float, float | None], ...]
    samples: tuple[int, int, float | None]
    realised: tuple[tuple[str, bool], ...]


def verdict_of(outcome: Outcome) -> Verdict:
    """The verdict of a flight."""
    return Verdict(
        ending=outcome.ending,
        invalid=outcome.invalid,
        readings=tuple((r.requirement, r.compliance.value, r.rho, r.violated_at_s) for r in outcome.readings),
        samples=(outcome.carried, outcome.altered, outcome.infected_at_s),
        realised=outcome.realised,
    )


def flown(study: Study, flyer: Flyer, names: Sequence[str], jobs: int) -> dict[str, Outcome]:
    """The outcomes of the flights, by name."""
    flights = [flight_named(study, *_parts(name)) for name in names]
    with Local(jobs).workers(
        study, flyer, stop=lambda: False, say=lambda text: print(text, file=sys.stderr)
    ) as workers:
        return {outcome.name: outcome for outcome in workers.map(alone(flights))}


def _parts(name: str) -> tuple[str, str, int]:
    mutant, situation, seed = name.split("/")
    return mutant, situation, int(seed)


def main() -> int:
    """Fly both ways, and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=cores())
    parser.add_argument("--record", choices=("study", "study_bag"), default="study")
    options = parser.parse_args()
    jobs = options.jobs
    ours = Study.open(ROOT)
    names = [f"{mutant}/{situation}/0" for mutant in MUTANTS for situation in SITUATIONS]
    with tempfile.TemporaryDirectory() as made:
        subprocess.run([sys.executable, str(COPY), f"{made}/own", options.record], cwd=ROOT, check=True)
        theirs = flown(Study.open(Path(made) / "own"), Commanded(), names, jobs)
    built_in = flown(ours, Physics(), names, jobs)
    same = [name for name in names if verdict_of(built_in[name]) == verdict_of(theirs[name])]
    for name in names:
        violated = ", ".join(found.requirement for found in theirs[name].violations) or "nothing"
        print(f"{'same' if name in same else 'OTHER'}  {name}: {theirs[name].ending}, violates {violated}")
    print(f"{len(same)} of {len(names)} flights are judged alike")
    return 0 if same == names else 1


if __name__ == "__main__":
    sys.exit(main())
