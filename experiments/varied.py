"""Fly the study with changed numbers, for scripts that test the effect of an assumption.

`flown` flies each flight whole and yields its outcome and its log; `shared` flies many flights as a campaign does.
"""

from __future__ import annotations

# isort: split

import argparse
import multiprocessing
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.flights.fly import fly_log, judged
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.plan import together
from scaloft_fi.campaign.workers.local import Local
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.sim.grid import Grid
from scaloft_fi.sim.load import SimConfig, load
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Varied(Study):
    """A study with changed numbers.

    Attributes:
        overrides: pairs of a dotted path, as in `sim/sources.yaml`, and a number.
    """

    overrides: tuple[tuple[str, float], ...] = ()

    @cached_property
    def sim(self) -> SimConfig:
        """Mine, vehicle, sensors, stack and situations with the changed numbers."""
        return load(self.folder / "sim", dict(self.overrides))

    @cached_property
    def grid(self) -> Grid:
        """The situations with the changed numbers."""
        return self.sim.grid


class Beside(NamedTuple):
    """A baseline and its mutants in one situation with one seed, with changed numbers of the study.

    overrides: changed numbers by their path in `sim/sources.yaml`.
    """

    folder: Path
    overrides: Mapping[str, float]
    situation: str
    seed: int
    mutants: tuple[str, ...] = ()


def flown(beside: Beside) -> Iterator[tuple[Outcome, FlightLog]]:
    """Yield outcome and log of the baseline, then of the mutants.

    Raises:
        ScaloftError: the study cannot be flown with these numbers.
    """
    study = Varied(Study.open(beside.folder).folder, overrides=tuple(beside.overrides.items()))
    situation = study.grid.situation(beside.situation)
    for mutant in (None, *(realise(study.matrix, mutant_id) for mutant_id in beside.mutants)):
        flight = Flight(mutant, situation, beside.seed)
        log = fly_log(study, flight)
        yield judged(study, flight, log), log


def shared(study: Study, flights: Sequence[Flight], jobs: int) -> Iterator[Outcome]:
    """Yield the outcomes of flights in any order; mutants share the beginning of their baseline, as in a campaign.

    Args:
        study: the study, which may be `Varied`.
        flights: the flights.
        jobs: number of processes.

    Raises:
        ScaloftError: the study cannot be flown.
    """
    with Local(jobs).workers(study, Physics(), stop=lambda: False, say=_say) as workers:
        yield from workers.map(together(flights, lambda flight: study.expected_s(flight.situation), jobs))


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def outcomes(besides: Iterable[Beside], jobs: int) -> list[list[Outcome]]:
    """The outcomes of each draw, the baseline first; `jobs` processes fly."""
    with multiprocessing.Pool(jobs) as pool:
        return pool.map(_outcomes, list(besides), chunksize=1)


def _outcomes(beside: Beside) -> list[Outcome]:
    return [outcome for outcome, _ in flown(beside)]


def main(about: str | None, plan: str, results: Callable[[Study, int], str]) -> None:
    """Write the page of a script: its plan and, without `--plan`, its results.

    Args:
        about: docstring of the script.
        plan: the page without results, in Markdown.
        results: flies with the given number of processes; returns the section with the results.
    """
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", action="store_true", help="fly nothing: the page without results")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--output", type=Path, help="a Markdown file (default: print)")
    options = parser.parse_args()
    text = plan if options.plan else plan + results(Study.open(None), options.jobs)
    if options.output:
        options.output.write_text(text, encoding="utf-8")
    else:
        print(text)
