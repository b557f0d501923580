"""Test whether LATE-human is revealed at other headings at take-off; its page states flights and rule of decision.

python -m experiments.heading [--jobs N] [--output FILE]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from experiments.flights import Beside, flown_draws
from experiments.pages import blocks, table, write
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import flight_of
from scaloft_fi.study import Study

YAW, PAUSES = "world.mission.yaw_deg", ("stack.mission.dwell_s", "world.mission.nominal.dwell_s")
ARMS: Mapping[str, Mapping[str, float]] = {
    "0 deg (the study)": {YAW: 0.0},
    "90 deg": {YAW: 90.0},
    "90 deg, pause 3 s": {YAW: 90.0, **dict.fromkeys(PAUSES, 3.0)},
}
DELAYS_S = (1, 3, 5)
MUTANTS = tuple(f"LATE-human@{delay_s}s" for delay_s in DELAYS_S)
SITUATIONS = tuple(f"T{turns}O{obstacle}W0D0H1" for turns in (0, 1) for obstacle in (0, 1))
SEEDS = (0, 1)
DRAWS = len(SITUATIONS) * len(SEEDS)
APART = 5
"""Least difference of counts of eight flights for which Fisher's exact p is below 0.05 for all counts."""


def results(study: Study, jobs: int, _folder: Path) -> str:
    """Fly, and tell: per arm, per situation and seed the baseline, then the mutants."""
    draws = [(key, seed) for key in SITUATIONS for seed in SEEDS]
    found = flown_draws([Beside(study.folder, arm, *draw, MUTANTS) for arm in ARMS.values() for draw in draws], jobs)
    flown = {name: found[number * DRAWS : (number + 1) * DRAWS] for number, name in enumerate(ARMS)}
    seen = {arm: [_seen(draw) for draw in own] for arm, own in flown.items()}
    counts = {arm: [sum(column) for column in zip(*rows, strict=True)] for arm, rows in seen.items()}
    hold = {arm: sum(draw[0].first_violation is None for draw in own) for arm, own in flown.items()}
    study_arm, turned, paused = ARMS
    by_seed = {
        arm: [", ".join(str(sum(column[place :: len(SEEDS)])) for place in SEEDS) for column in zip(*rows, strict=True)]
        for arm, rows in seen.items()
    }
    answers = [
        f"- {mutant} {'depends' if abs(a - b) >= APART else 'is not shown to depend'} on the {what}: "
        f"{a} and {b} of {DRAWS}; seed by seed {by_seed[one][place]} and {by_seed[other][place]} of {len(SITUATIONS)}."
        for what, one, other in (("heading", study_arm, turned), ("pause", turned, paused))
        for place, (mutant, a, b) in enumerate(zip(MUTANTS, counts[one], counts[other], strict=True))
    ]
    rows = (
        (arm, draw[0].situation, draw[0].seed, *("+" if mark else "-" for mark in marks), f"{_least(draw[0]):.2f}")
        for arm, own in flown.items()
        for draw, marks in zip(own, seen[arm], strict=True)
    )
    return blocks(
        "## Flown",
        f"Flights in which SR2 reveals the fault, of {DRAWS}:",
        table(("start", "baselines that hold SR1 and SR2", *MUTANTS), ((arm, hold[arm], *counts[arm]) for arm in ARMS)),
        answers,
        "Each draw (`+`: SR2 reveals the fault, `-`: it does not) and its baseline's robustness of SR2:",
        table(("start", "situation", "seed", *MUTANTS, "baseline"), rows),
    )


def _least(baseline: Outcome) -> float:
    return next(reading.rho for reading in baseline.readings if reading.requirement == "SR2")


def _seen(draw: Sequence[Outcome]) -> list[bool]:
    baseline, *mutants = draw
    return ["SR2" in flight_of(outcome, baseline).revealed for outcome in mutants]


if __name__ == "__main__":
    write(__doc__, "heading", results)
