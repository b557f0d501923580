"""Test whether LATE-human is revealed at other headings at take-off: the plan and its results.

    python -m experiments.heading [--plan] [--jobs N] [--output results/published/heading.md]

The page states the flights and the rule of decision; `--plan` writes it without flying.
"""

from __future__ import annotations

# isort: split

from collections.abc import Mapping, Sequence

from experiments.varied import Beside, main, outcomes
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

PLAN = f"""# Does whether LATE-human is revealed depend on the heading at take-off?

The paper does not say which way the drone looks when it takes off, nor how long it waits.  The study assumes 0 deg:
across the corridor, so that the drone first sees the corridor, and a person in it, when it turns; the pause is 0.5 s.
At 90 deg it looks along the corridor from the start.

Question, arms and rule were written down, and committed without the section *Flown*, before these flights were flown.
They are no blind test: an earlier look at the same arms, without a plan, had found that LATE-human@3s is revealed at
0 deg and not at 90 deg.  Made by `python -m experiments.heading`.

- **Arms**: heading at take-off (`{YAW}`) 0 deg; 90 deg; 90 deg with a pause of 3 s after take-off
  (`{PAUSES[0]}`, and the same in the nominal flight).  Nothing else is changed.
- **Flights**: {", ".join(MUTANTS)} in {", ".join(SITUATIONS)}
  with seeds {", ".join(map(str, SEEDS))}: {DRAWS} flights a mutant and arm, each beside the baseline of its own arm, \
situation and seed;
  {DRAWS * (1 + len(MUTANTS)) * len(ARMS)} flights in all.
- **Counted**: flights in which SR2 reveals the fault: they violate it, and their baseline held it up to that moment.
  Each is one flight beside one baseline, so an observation; verdicts on mutants are the reference campaign's.
- **Rule**: a mutant *depends on the heading* if the arms 0 deg and 90 deg differ by at least {APART} of the {DRAWS} \
flights, the
  least difference for which Fisher's exact two-sided p is below 0.05 whatever the counts are.  The same rule between
  the two arms at 90 deg says whether it *depends on the pause*.
- **Consequence**: if LATE-human@3s depends on either, the page of the paper's rows says so beside its row.

All arms are reported, whatever they show.
"""


def fly_all(study: Study, jobs: int) -> dict[str, list[list[Outcome]]]:
    """Per arm, per situation and seed: the baseline, then the mutants."""
    draws = [(key, seed) for key in SITUATIONS for seed in SEEDS]
    besides = [Beside(study.folder, arm, *draw, MUTANTS) for arm in ARMS.values() for draw in draws]
    found = outcomes(besides, jobs)
    return {name: found[number * DRAWS : (number + 1) * DRAWS] for number, name in enumerate(ARMS)}


def results(flown: Mapping[str, Sequence[Sequence[Outcome]]]) -> str:
    """The section with the results."""
    seen = {arm: [_seen(draw) for draw in draws] for arm, draws in flown.items()}
    counts = {arm: [sum(column) for column in zip(*rows, strict=True)] for arm, rows in seen.items()}
    lines = ["", "## Flown", "", f"Flights in which SR2 reveals the fault, of {DRAWS}:", ""]
    lines += ["| start | baselines that hold SR1 and SR2 | " + " | ".join(MUTANTS) + " |"]
    lines += ["|---|---|" + "---|" * len(MUTANTS)]
    for arm, draws in flown.items():
        clean = sum(draw[0].first_violation is None for draw in draws)
        lines.append(f"| {arm} | {clean} | " + " | ".join(map(str, counts[arm])) + " |")
    lines.append("")
    study, turned, paused = ARMS
    for what, one, other in (("heading", study, turned), ("pause", turned, paused)):
        for mutant, a, b in zip(MUTANTS, counts[one], counts[other], strict=True):
            verb = "depends" if abs(a - b) >= APART else "is not shown to depend"
            lines.append(f"- {mutant} {verb} on the {what}: {a} and {b} of {DRAWS}.")
    lines += [
        "",
        "Each draw (`+`: SR2 reveals the fault, `-`: it does not) and its baseline's robustness of SR2:",
        "",
    ]
    lines += ["| start | situation | seed | " + " | ".join(MUTANTS) + " | baseline |", "|---|---|---|---|---|---|---|"]
    for arm, draws in flown.items():
        for draw, marks in zip(draws, seen[arm], strict=True):
            least = next(reading.rho for reading in draw[0].readings if reading.requirement == "SR2")
            cells = " | ".join("+" if mark else "-" for mark in marks)
            lines.append(f"| {arm} | {draw[0].situation} | {draw[0].seed} | {cells} | {least:.2f} |")
    return "\n".join(lines) + "\n"


def _seen(draw: Sequence[Outcome]) -> list[bool]:
    baseline, *mutants = draw
    return ["SR2" in flight_of(outcome, baseline).revealed for outcome in mutants]


if __name__ == "__main__":
    main(__doc__, PLAN, lambda study, jobs: results(fly_all(study, jobs)))
