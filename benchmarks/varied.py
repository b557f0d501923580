"""Fly the study with changed numbers, for scripts that test the effect of an assumption.

Each flight is flown whole and outside a campaign; the script gets its outcome and its log.
"""

from __future__ import annotations

import checkout  # noqa: F401 - first: it sets the path and the threads

# isort: split

import argparse
import multiprocessing
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from scaloft_fi.campaign.flights.fly import facts
from scaloft_fi.judge.outcome import Outcome, Subject, outcome_of
from scaloft_fi.mutants.derive import realise
from scaloft_fi.mutants.wire import contexts, wire_for
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.load import load
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.study import Study


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
    study = Study.open(beside.folder)
    config = load(beside.folder / "sim", beside.overrides)
    scenario = config.scenario(config.grid.situation(beside.situation))
    known = facts(scenario, config.stack.parameters)
    for mutant_id in ("", *beside.mutants):
        mutant = realise(study.matrix, mutant_id) if mutant_id else None
        context = contexts(mutant_id or "baseline", beside.situation, beside.seed, known)
        log = fly(config, scenario.situation, beside.seed, wire_for(mutant, study.stack, context))
        yield (
            outcome_of(
                log,
                Subject.of(mutant),
                beside.situation,
                beside.seed,
                requirements=study.requirements,
                realisation=None,
            ),
            log,
        )


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
