"""Ask whether MORE-goal is shown: with and without turning first, at three speeds, in all light situations.

    python -m experiments.more_goal [--jobs N] [--output FILE]

The page states the flights and the rules of decision.  Finished flights are kept beside the page, in
`more_goal_flights.jsonl.gz`, at the latest after ten seconds; the same command flies only the flights that are missing
there.  Delete the file after a change of the study or of the code.
"""

from __future__ import annotations

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from experiments.flights import Flights, Scored, Varied, fly_arms, holds, name_of, names_of, published
from experiments.operating_point import CRUISE, LIGHT, NO_TURN
from experiments.pages import Row, blocks, table, write
from scaloft_fi.analysis.detection import ALPHA, Detection, Spending
from scaloft_fi.analysis.score import MutantScore, mutant_score
from scaloft_fi.judge.outcome import BASELINE, Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

CRUISES_MPS = (0.5, 1.0, 1.2)
MUTANTS = ("MORE-goal@0.3m", "MORE-goal@0.6m", "MORE-goal@1m", "MORE-goal@3m")
"""The ladder of the cell."""
SUBJECTS = (BASELINE, *MUTANTS)
SEEDS = tuple(range(10))
DRAWS = len(LIGHT) * len(SEEDS)


class Arm(NamedTuple):
    """An arm: whether the planner turns before it moves, and the cruise speed [m/s]."""

    turns_first: bool
    cruise_mps: float

    @property
    def name(self) -> str:
        """As the page and the file of flights name it."""
        return f"{'turning first' if self.turns_first else 'not turning first'}, {self.cruise_mps:g} m/s"

    @property
    def overrides(self) -> tuple[tuple[str, float], ...]:
        """The changed numbers of the study."""
        return ((CRUISE, self.cruise_mps), *(() if self.turns_first else NO_TURN.items()))


ARMS = tuple(Arm(turns_first, cruise_mps) for turns_first in (True, False) for cruise_mps in CRUISES_MPS)
AS_IT_IS, NOT_TURNING = Arm(turns_first=True, cruise_mps=0.5), Arm(turns_first=False, cruise_mps=0.5)
"""The study as it is, and the same without turning first: the two arms of the rule for the stack."""
NAMES = names_of(SUBJECTS, LIGHT, SEEDS)
"""Of an arm's flights, draw by draw in the order of their seeds."""
FLIGHTS = len(ARMS) * len(NAMES)


STRICT = ALPHA / (len(ARMS) * len(MUTANTS))
"""What p is compared with where all arms and magnitudes together decide."""

SAFETY, HELD = ("SR1", "SR2"), ("SR1", "SR2", "OP1")
PAIRED = {"SR1": LIGHT, "SR2": tuple(key for key in LIGHT if key.endswith("H1"))}
"""The situations in which a safety requirement can be triggered."""


@dataclass(frozen=True)
class Flown(Scored):
    """The flights of an arm, scored.

    Attributes:
        arm: the arm.
    """

    arm: Arm

    def safety(self, mutant: str) -> Detection | None:
        """The verdict on a mutant by safety requirements; None if it was not flown."""
        return self.scores[mutant].safety if mutant in self.scores else None

    def remains(self, score: MutantScore) -> str:
        """What remains of rule 2 when one seed of the mutant, or one of the pool, is left out."""
        own = self.rulings[score.subject]
        strict = mutant_score(score.subject, own, self.space, self.pool, Spending(STRICT)).firmness
        return strict.words if strict else "not shown"

    def held(self, requirement: str, ending: str = "") -> int:
        """Baselines that hold a requirement, in the situations whose key has this ending."""
        own = (one for one in self.valid if one.mutant == BASELINE and one.situation.endswith(ending))
        return sum(holds(one, [requirement]) for one in own)

    def violations(self, subject: str) -> Iterator[tuple[str, Violation]]:
        """Yield situation and violation: of a mutant in steady pairs that it infects, of the baseline in all pairs."""
        steady = {r.situation: r.steady for r in self.scores[subject].results} if subject in self.scores else {}
        for outcome in self.valid:
            tests = SAFETY if subject == BASELINE else steady.get(outcome.situation, ())
            if outcome.mutant == subject:
                yield from ((outcome.situation, v) for v in outcome.violations if v.requirement in tests)


def flown(flights: Mapping[str, Mapping[str, Outcome]], reference: Mapping[str, str], space: Space) -> str:
    """The section with the results.

    Args:
        flights: outcomes by the name of the arm and of the flight.
        reference: digests of the reference campaign by the name of the flight.
        space: the grid.
    """
    arms = [Flown(flights.get(arm.name, {}), space, MUTANTS, arm) for arm in ARMS]
    by_arm = {one.arm: one for one in arms}
    valid = sum(len(one.valid) for one in arms)
    rules = ["Flights are missing or invalid, so no rule is decided."]
    if valid == FLIGHTS:
        rules = [*shown(arms), *masked(by_arm), stack(by_arm)]
    brackets = "In brackets: the pair does not put the fault to the test; for a baseline: the pair is not steady."
    violated: list[str | Iterable[str]] = []
    for name in SAFETY:
        violated += [f"### Flights that violate {name}, of {len(SEEDS)}", brackets, _by_situation(arms, name)]
    return blocks(
        "## Flown",
        f"{valid:,} of {FLIGHTS:,} flights.  {_repeated(by_arm[AS_IT_IS], reference)}",
        "### Rules",
        rules,
        "### Baselines that hold",
        f"H0: of {DRAWS // 2} draws without a person; H1: of {DRAWS // 2} with a person.",
        _held(arms),
        "### Verdicts",
        _verdicts(arms),
        *violated,
        "### What was violated, where",
        "Of mutants the violations in steady pairs, of baselines all; least and greatest time and position.",
        _places(arms),
    )


def _repeated(as_it_is: Flown, reference: Mapping[str, str]) -> str:
    both = [outcome for name, outcome in as_it_is.outcomes.items() if name in reference]
    equal = sum(outcome.digest == reference[outcome.name] for outcome in both)
    return f"{len(both)} flights of *{as_it_is.arm.name}* are in the reference campaign; {equal} have its digest."


def shown(arms: Iterable[Flown]) -> Iterator[str]:
    """Yield the sentences of rule 2."""
    found = False
    for one in arms:
        for mutant, score in one.scores.items():
            for name in (name for name, p in score.safety.p.items() if p <= STRICT):
                found = True
                as_seen = ", as the paper saw it" if name == "SR1" else ""
                p, kept = f"{score.safety.p[name]:.2g}", one.remains(score)
                yield f"- {mutant} is shown by {name} in *{one.arm.name}*{as_seen} (p = {p}; {kept})."
    if not found:
        yield "- MORE-goal is shown in no arm."


def masked(arms: Mapping[Arm, Flown]) -> Iterator[str]:
    """Yield the sentences of rule 3."""
    for cruise_mps in CRUISES_MPS:
        found = []
        for mutant in MUTANTS:
            without, with_it = (arms[Arm(turns, cruise_mps)].safety(mutant) for turns in (False, True))
            if without and with_it and without.p.get("SR1", 1.0) <= STRICT and "SR1" not in with_it.by:
                found.append(mutant)
        verb = f"masks {', '.join(found)}" if found else "is not shown to mask any magnitude"
        yield f"- At {cruise_mps:g} m/s turning first {verb}."


def stack(arms: Mapping[Arm, Flown]) -> str:
    """The sentence of rule 4."""
    pairs = {name: tuple(arms[arm].held(name) for arm in (NOT_TURNING, AS_IT_IS)) for name in HELD}
    may = all(without >= with_it for without, with_it in pairs.values())
    counts = ", ".join(f"{name} {without} against {with_it}" for name, (without, with_it) in pairs.items())
    told = "the clean baselines justify a change of the stack" if may else "the stack stays as it is"
    return f"- Baselines that hold without and with turning first at 0.5 m/s: {counts} of {DRAWS}: {told}."


def _held(arms: Iterable[Flown]) -> Iterator[str]:
    columns = [(name, ending) for name in HELD for ending in ("H0", "H1")]
    head = ["arm", *(f"{name} {ending}" for name, ending in columns), "steady pairs of SR1", "steady pairs of SR2"]
    rows = []
    for one in arms:
        steady = (sum(name in one.pool.steady(key, Kind.SAFETY) for key in LIGHT) for name in SAFETY)
        rows.append((one.arm.name, *(one.held(*column) for column in columns), *steady))
    return table(head, rows)


def _verdicts(arms: Iterable[Flown]) -> Iterator[str]:
    head = ("arm", "mutant", "by safety", "p of SR1", "p of SR2", "situations that test it", "that kill it", "by OP1")
    return table(head, (_verdict(one.arm, score) for one in arms for score in one.scores.values()))


def _verdict(arm: Arm, score: MutantScore) -> Row:
    verdict = score.verdict.words + (f" by {' and '.join(score.safety.by)}" if score.safety.by else "")
    verdict += f", {score.firmness.words}" if score.firmness else ""
    ps = (f"{score.safety.p.get(name, 1.0):.2g}" for name in SAFETY)
    rate, operability = score.kill_rate, score.operability.verdict.words
    return arm.name, score.subject.id, verdict, *ps, rate.whole, rate.part, operability


def _by_situation(arms: Iterable[Flown], requirement: str) -> Iterator[str]:
    keys = PAIRED[requirement]
    subjects = ((one, subject) for one in arms for subject in (BASELINE, *one.scores))
    rows = ((one.arm.name, subject, *_cells(one, subject, requirement, keys)) for one, subject in subjects)
    return table(("arm", "subject", *keys), rows)


def _cells(one: Flown, subject: str, requirement: str, keys: Iterable[str]) -> Iterator[str]:
    tested = {r.situation: r.steady for r in one.scores[subject].results} if subject in one.scores else {}
    own = (outcome for outcome in one.valid if outcome.mutant == subject)
    counts = Counter(o.situation for o in own for violation in o.violations if violation.requirement == requirement)
    for key in keys:
        steady = one.pool.steady(key, Kind.SAFETY) if subject == BASELINE else tested.get(key, ())
        yield str(counts[key]) if requirement in steady else f"({counts[key]})"


def _places(arms: Iterable[Flown]) -> Iterator[str]:
    head = ("arm", "subject", "violated", "struck", "flights", "situations", "time [s]", "x [m]", "y [m]")
    return table(head, (row for one in arms for subject in (BASELINE, *one.scores) for row in _struck(one, subject)))


def _struck(one: Flown, subject: str) -> Iterator[Row]:
    groups: dict[tuple[str, str], list[tuple[str, Violation]]] = {}
    for key, violation in one.violations(subject):
        groups.setdefault((violation.requirement, violation.struck or "-"), []).append((key, violation))
    for (requirement, struck), found in sorted(groups.items()):
        spans = (_span([getattr(violation, name) for _, violation in found]) for name in ("t_s", "x", "y"))
        yield one.arm.name, subject, requirement, struck, len(found), len({key for key, _ in found}), *spans


def _span(numbers: Sequence[float]) -> str:
    return f"{min(numbers):.1f} to {max(numbers):.1f}"


def fly(study: Study, path: Path, jobs: int, draws: int = DRAWS) -> Flights:
    """Fly what is missing in the file of flights; returns all flights of the file.

    Args:
        study: the study.
        path: the file of flights.
        jobs: number of processes.
        draws: number of draws of each arm.
    """
    mutants, names = [realise(study.matrix, name) for name in MUTANTS], NAMES[: draws * len(SUBJECTS)]
    varied = {arm.name: Varied(study.folder, overrides=arm.overrides) for arm in ARMS}
    return fly_arms(path, jobs, {arm: (own, mutants, names) for arm, own in varied.items()})


def results(study: Study, jobs: int, folder: Path) -> str:
    """Fly what is missing, and tell."""
    digests = {name_of(row): row["digest"] for row in published()}
    return flown(fly(study, folder / "more_goal_flights.jsonl.gz", jobs), digests, study.space)


if __name__ == "__main__":
    write(__doc__, "more_goal", results)
