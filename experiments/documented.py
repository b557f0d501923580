"""Fly the paper's three rows on a drone with the published speed law: accept the drone, then fly every arm once.

    python -m experiments.documented [--jobs N] [--output FILE]

Finished flights are kept beside the page: the baselines that accept the drone in `documented_accepted.jsonl.gz`, those
of the arms in `documented_flights.jsonl.gz`; the same command flies only the flights that are missing there.
"""

from __future__ import annotations

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

import itertools
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from experiments.flights import Flights, Scored, Varied, fly_arms, holds, names_of
from experiments.operating_point import CRUISE, LIGHT
from experiments.pages import Row, blocks, table, write
from scaloft_fi.analysis.detection import ALPHA, adjusted, holm
from scaloft_fi.analysis.score import sample
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import INVALID
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

NAME = "documented"
ACCEPTED, FLIGHTS = f"{NAME}_accepted.jsonl.gz", f"{NAME}_flights.jsonl.gz"
Numbers = Mapping[str, float | str]
DRONE: Numbers = {"stack.navigator.law": "published", "stack.control.accel_mps2": 3.0}
"""What the drone with the published speed law changes in the study, but for its speed."""
CRUISE_MPS = 1.8
"""The published speed, and the one that is accepted."""
TUNED, ASKED, SEEDS = range(1000, 1010), range(2000, 2010), range(10)
"""Seeds of the baselines that were tuned on, of those that accept, and of the registered flights."""
SAFETY, HELD, LEAST_HELD = ("SR1", "SR2"), ("SR1", "SR2", "OP1"), 9

DOCUMENTED: Numbers = {**DRONE, CRUISE: CRUISE_MPS}
ARMS: Mapping[str, Numbers] = {
    "documented": DOCUMENTED,
    **{f"{speed:g} m/s": {**DRONE, CRUISE: speed} for speed in (1.5, 1.2, 1.0, 0.8, 0.5)},
    "yaw 60 deg/s": {**DOCUMENTED, "stack.control.yaw_rate_radps": 1.047},
    "yaw 90 deg/s": {**DOCUMENTED, "stack.control.yaw_rate_radps": 1.571},
    "heading 90 deg": {**DOCUMENTED, "world.mission.yaw_deg": 90.0},
    "turning, 0.5 m/s": {},
    "turning, 1.8 m/s": {CRUISE: CRUISE_MPS},
}
ROWS = {
    "LATE": tuple(f"LATE-human@{delay}s" for delay in ("0.5", "1", "3", "5")),
    "UNINTENDED": tuple(f"UNINTENDED-collision@{period}s" for period in (60, 20, 10, 5)),
    "MORE": tuple(f"MORE-goal@{radius}m" for radius in ("0.3", "0.6", "1", "3")),
}
"""The ladder of the cell of each of the paper's rows."""
MUTANTS = tuple(itertools.chain.from_iterable(ROWS.values()))
SUBJECTS = (BASELINE, *MUTANTS)
PRIMARY = ("documented", "MORE-goal@1m", "SR1")
PER_ARM = len(SUBJECTS) * len(LIGHT) * len(SEEDS)


def varied(study: Study, numbers: Numbers) -> Study:
    """The study with changed numbers."""
    return Varied(study.folder, overrides=tuple(numbers.items()))


def holding(outcomes: Iterable[Outcome]) -> dict[str, tuple[int, int, str]]:
    """By light situation the baselines that hold, all, and what the others violate first."""
    by_key: dict[str, list[Outcome]] = {key: [] for key in LIGHT}
    for outcome in outcomes:
        if outcome.mutant == BASELINE:
            by_key[outcome.situation].append(outcome)
    found = {}
    for key, own in by_key.items():
        broken = (violation for one in own for violation in one.violations[:1])
        others = "; ".join(f"{v.requirement} at {v.t_s:.1f} s, {v.struck or '-'}" for v in broken)
        found[key] = sum(holds(one, HELD) for one in own), len(own), others
    return found


def is_accepted(outcomes: Iterable[Outcome]) -> bool:
    """Whether at least nine of ten baselines hold in each light situation."""
    return all(count >= LEAST_HELD and whole == len(ASKED) for count, whole, _ in holding(outcomes).values())


def acceptance(flights: Flights) -> str:
    """The lines on the baselines of the seeds of acceptance."""
    parts = []
    for arm, outcomes in flights.items():
        verdict = "accepted" if is_accepted(outcomes.values()) else "not accepted"
        rows = (
            (key, f"{count} of {whole}", bad or "-") for key, (count, whole, bad) in holding(outcomes.values()).items()
        )
        parts += [f"**{arm}: {verdict}.**", "\n".join(table(("situation", "hold", "the others"), rows))]
    return blocks(*parts).strip("\n")


class Flown(Scored):
    """The flights of an arm, scored."""

    @property
    def complete(self) -> bool:
        """Whether every flight of the arm was flown and counts."""
        return len(self.valid) == PER_ARM

    def p(self, mutant: str, requirement: str) -> float:
        """The exact test of one requirement alone, without any adjustment."""
        found = next((own for subject, own in self.rulings.items() if subject.id == mutant), {})
        flown = {key: [one for one in ruled if one.ruling is not INVALID] for key, ruled in found.items()}
        samples = [sample(key, ruled) for key, ruled in flown.items() if ruled]
        return adjusted(samples, self.pool, (requirement,))[requirement]

    def violated(self, mutant: str, requirement: str) -> str:
        """Flights that violate a requirement where it is steady and the mutant infects, of all there; pool likewise."""
        results = [one for one in self.scores[mutant].results if requirement in one.steady]
        pairs = [self.pool.pairs[one.situation, requirement] for one in results]
        own = sum(dict(one.violated).get(requirement, 0) for one in results), sum(one.flown for one in results)
        clean = sum(pair.violated for pair in pairs), sum(pair.judged for pair in pairs)
        return f"{own[0]}/{own[1]}, pool {clean[0]}/{clean[1]}"


def told(flights: Flights, space: Space) -> str:
    """The section with the results: every arm, as far as it was flown."""
    arms = {name: Flown(flights.get(name, {}), space, MUTANTS) for name in ARMS}
    done = {name: one for name, one in arms.items() if one.complete}
    missing = [name for name in arms if name not in done]
    left = f"Not flown yet: {', '.join(missing)}.  The secondary tests are decided when every arm was flown."
    counts = {name: holding(one.valid).values() for name, one in done.items()}
    hold = ((name, *(f"{count}/{whole}" for count, whole, _ in own)) for name, own in counts.items())
    return blocks(
        "## Flown",
        f"{sum(map(len, flights.values())):,} of {PER_ARM * len(ARMS):,} flights.  {left if missing else ''}".rstrip(),
        "### The primary test",
        primary(done),
        "### The paper's rows",
        "Flights that violate where the requirement is steady and the fault acts, and the pool's there; p of the "
        "requirement alone; *shown*: at most 0.01 after Holm over every secondary test.",
        table(("row", "arm", "mutant", "SR1", "p", "SR2", "p", "verdict", "shown by"), rows(done, decided=not missing)),
        "### Baselines that hold SR1, SR2 and OP1",
        table(("arm", *LIGHT), hold),
    )


def primary(arms: Mapping[str, Flown]) -> str:
    """The sentence of the primary test."""
    arm, mutant, requirement = PRIMARY
    if arm not in arms:
        return "Not decided: its arm was not flown yet."
    p, score = arms[arm].p(mutant, requirement), arms[arm].scores[mutant]
    firm = score.firmness.words if score.firmness and requirement in score.safety.by else "not detected by it"
    verdict = "shown" if p <= ALPHA else "not shown"
    return (
        f"**{mutant} is {verdict} by {requirement}**: {arms[arm].violated(mutant, requirement)}, p = {p:.2g}; {firm}."
    )


def rows(arms: Mapping[str, Flown], *, decided: bool) -> Iterator[Row]:
    """A row for each of the paper's rows, arm and mutant."""
    tests = itertools.product(arms, MUTANTS, SAFETY)
    raw = {test: arms[test[0]].p(*test[1:]) for test in tests}
    secondary = holm({test: p for test, p in raw.items() if test != PRIMARY}) if decided else {}
    for row, mutants in ROWS.items():
        for arm, mutant in itertools.product(arms, mutants):
            score = arms[arm].scores[mutant]
            cells = [part for n in SAFETY for part in (arms[arm].violated(mutant, n), f"{raw[arm, mutant, n]:.2g}")]
            shown = [name for name in SAFETY if secondary.get((arm, mutant, name), 1.0) <= ALPHA]
            if (arm, mutant) == PRIMARY[:2] and raw[PRIMARY] <= ALPHA:
                shown.append(f"{PRIMARY[2]}, the primary test")
            verdict = f"{score.verdict.words}, {score.firmness.words}" if score.firmness else score.verdict.words
            yield row, arm, mutant, *cells, verdict, " ".join(shown) or ("-" if decided else "open")


def results(study: Study, jobs: int, folder: Path) -> str:
    """Fly what is missing, and tell."""
    drone = varied(study, DOCUMENTED), (), names_of([BASELINE], LIGHT, ASKED)
    fly_arms(folder / ACCEPTED, jobs, {f"{CRUISE_MPS:g} m/s": drone})
    mutants, names = [realise(study.matrix, name) for name in MUTANTS], names_of(SUBJECTS, LIGHT, SEEDS)
    arms = {arm: (varied(study, numbers), mutants, names) for arm, numbers in ARMS.items()}
    return told(fly_arms(folder / FLIGHTS, jobs, arms), study.space)


if __name__ == "__main__":
    write(__doc__, NAME, results)
