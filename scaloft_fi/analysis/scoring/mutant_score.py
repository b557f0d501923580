"""The score of one mutant: its verdicts, and situation by situation what tests it, what was seen, what kills it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from scaloft_fi.analysis.condition import condition
from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.scoring.detection import Detection, Sample, Spending, Verdict, detect
from scaloft_fi.analysis.scoring.firmness import Firmness, firmness
from scaloft_fi.analysis.scoring.pool import Pool
from scaloft_fi.hazop.matrix import SeverityClass
from scaloft_fi.judge.outcome import Subject
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import INVALID, Ruled, Situations, Status, furthest

MOST_KILLED = 0.9
"""A detected mutant that is killed in this share of the situations that put it to the test is trivial."""
EARLY_S = 5.0
"""So is one that a kill shows within this time of take-off [s]."""


class Moment(NamedTuple):
    """A violation: of which requirement, when [s from take-off], where [m, world], what was struck."""

    requirement: str
    t_s: float
    situation: str
    seed: int
    position: tuple[float, float, float]
    struck: str


@dataclass(frozen=True)
class Kill:
    """A steady pair in which most flights of a detected mutant violate.

    Attributes:
        situation, requirement: the pair.
        violated: flights that violate it; flights: those that count.
        first: the earliest violation.
    """

    situation: str
    requirement: str
    violated: int
    flights: int
    first: Moment


@dataclass(frozen=True)
class Result:
    """A mutant in a situation: its flights over the seeds.

    Attributes:
        situation: key.
        status: the furthest stage that a flight reached.
        flown: flights that count.
        reached: whether the seam carried a sample in any.
        infected: whether the fault changed a sample in any.
        violated: per requirement, the flights that violate it, where any does.
        steady: the safety requirements that put the fault to the test here: steady in the pool, and it infects.
        steady_operability: the same of operability requirements.
        kills: those of `steady` that kill the mutant here.
        operability_kills: those of `steady_operability` that do.
    """

    situation: str
    status: Status
    flown: int
    reached: bool
    infected: bool
    violated: tuple[tuple[str, int], ...]
    steady: tuple[str, ...]
    steady_operability: tuple[str, ...]
    kills: tuple[str, ...]
    operability_kills: tuple[str, ...]

    @property
    def tested(self) -> bool:
        """Whether the situation puts the fault to the test by a safety requirement."""
        return bool(self.steady)

    @property
    def seen(self) -> tuple[str, ...]:
        """The safety requirements among `steady` that a flight violates."""
        return tuple(name for name, _ in self.violated if name in self.steady)


@dataclass(frozen=True)
class MutantScore:
    """A mutant over all its situations.

    Attributes:
        subject: the mutant.
        status: the furthest stage that a flight reached.
        safety: the verdict, by safety requirements.
        operability: the same by operability requirements.
        results: one per situation with a flight that counts, in the grid's order.
        kills: by safety requirements, in the grid's order; operability_kills: by operability requirements.
        first: the earliest violation in a kill; of a mutant without one the earliest in a pair that tests it.
        statuses: flights of each status.
        firmness: what remains of the verdict when one seed is left out; None where it is not detected.
        severity: class of its cell; None where the cell has none.  It enters no ratio.
    """

    subject: Subject
    status: Status
    safety: Detection
    operability: Detection
    results: tuple[Result, ...]
    kills: tuple[Kill, ...]
    operability_kills: tuple[Kill, ...]
    first: Moment | None
    statuses: tuple[tuple[Status, int], ...]
    firmness: Firmness | None = None
    severity: SeverityClass | None = None

    @property
    def verdict(self) -> Verdict:
        """By safety requirements."""
        return self.safety.verdict

    @property
    def detected(self) -> bool:
        """Whether the tests would have shown the fault by a safety requirement."""
        return self.safety.detected

    @property
    def firm(self) -> bool:
        """Whether it is detected, and stays so without any one seed."""
        return self.firmness is not None and self.firmness.firm

    @property
    def killed_broadly(self) -> bool:
        """Whether nearly all situations that put it to the test kill it."""
        rate = self.kill_rate
        return self.detected and rate.part >= MOST_KILLED * rate.whole > 0

    @property
    def killed_early(self) -> bool:
        """Whether a kill shows it right after take-off."""
        return any(kill.first.t_s <= EARLY_S for kill in self.kills)

    @property
    def trivial(self) -> bool:
        """Whether it is detected where any test would do: in nearly all situations, or right after take-off."""
        return self.killed_broadly or self.killed_early

    @property
    def without_effect(self) -> bool:
        """Whether each of its flights equals the baseline's to the bit."""
        return self.flown and self.status.stage <= Status.MASKED.stage

    @property
    def acted(self) -> Ratio:
        """Flights in which it changed a sample, of those that count."""
        counts = [(status.infected, count) for status, count in self.statuses if status is not Status.INVALID]
        return Ratio(sum(count for infected, count in counts if infected), sum(count for _, count in counts))

    @property
    def flown(self) -> bool:
        """Whether any of its flights counts."""
        return bool(self.results)

    @property
    def infected(self) -> bool:
        """Whether any flight is infected."""
        return any(result.infected for result in self.results)

    @property
    def tested(self) -> bool:
        """Whether it is put to the test in some situation."""
        return any(result.tested for result in self.results)

    @property
    def kill_rate(self) -> Ratio:
        """Situations with a kill, of those that put it to the test."""
        return Ratio(len(self.killing), sum(result.tested for result in self.results))

    @property
    def kill_rate_flown(self) -> Ratio:
        """Situations with a kill, of those flown."""
        return Ratio(len(self.killing), len(self.results))

    @property
    def killing(self) -> tuple[str, ...]:
        """Keys of the situations with a kill."""
        return tuple(result.situation for result in self.results if result.kills)

    @property
    def seen_in(self) -> tuple[str, ...]:
        """Keys of the situations where a flight violates a requirement that tests the fault."""
        return tuple(result.situation for result in self.results if result.seen)

    @property
    def requirements(self) -> tuple[tuple[str, Ratio], ...]:
        """Per requirement that kills it, operability too, the situations it does so in, of those where it is a test."""
        kills = Counter(name for r in self.results for name in (*r.kills, *r.operability_kills))
        tests = Counter(name for r in self.results for name in (*r.steady, *r.steady_operability))
        return tuple((name, Ratio(kills[name], tests[name])) for name in tests if kills[name])

    @property
    def tests(self) -> tuple[str, ...]:
        """Requirements that put it to the test somewhere."""
        return tuple(dict.fromkeys(n for r in self.results for n in (*r.steady, *r.steady_operability)))

    def condition(self, space: Space) -> str:
        """The situations with a kill in words; of a mutant without one those where a violation was seen."""
        where = self.killing or self.seen_in
        spared = tuple(r.situation for r in self.results if r.situation not in where and (r.tested or not r.infected))
        return _condition(space, where, spared)


@lru_cache(maxsize=4096)
def _condition(space: Space, killing: tuple[str, ...], surviving: tuple[str, ...]) -> str:
    """The condition, derived once: several tables show it."""
    return condition(space, killing, surviving)


def mutant_score(
    subject: Subject, situations: Situations, space: Space, pool: Pool, spending: Spending, *, firm: bool = True
) -> MutantScore:
    """Score one mutant beside the pool; `firm`: whether a detected one is judged again without each seed."""
    valid = {key: [one for one in situations[key] if one.ruling is not INVALID] for key in situations}
    flown = {key: valid[key] for key in sorted(valid, key=space.rank) if valid[key]}
    samples = [_sample(key, flights) for key, flights in flown.items()]
    safety = detect(subject.id, samples, pool, spending, Kind.SAFETY)
    operability = detect(subject.id, samples, pool, spending, Kind.OPERABILITY)
    results = tuple(
        _result(sample, flown[sample.situation], pool, safety.detected, operability.detected) for sample in samples
    )
    kills = tuple(_kill(r, name, flown[r.situation]) for r in results for name in r.kills)
    seen = [kill.first for kill in kills] or [_first(r, n, flown[r.situation]) for r in results for n in r.seen]
    statuses = Counter[Status]()
    # few rulings differ, so they are counted first
    for ruling, number in Counter([one.ruling for flights in situations.values() for one in flights]).items():
        statuses[ruling.status] += number
    return MutantScore(
        subject=subject,
        status=furthest(statuses),
        safety=safety,
        operability=operability,
        results=results,
        kills=kills,
        operability_kills=tuple(_kill(r, name, flown[r.situation]) for r in results for name in r.operability_kills),
        first=min(seen, key=lambda moment: (moment.t_s, space.rank(moment.situation), moment.seed), default=None),
        statuses=tuple((status, statuses[status]) for status in Status if statuses[status]),
        firmness=firmness(subject.id, samples, pool, spending, Kind.SAFETY) if firm and safety.detected else None,
    )


def _sample(situation: str, flights: Sequence[Ruled]) -> Sample:
    infected = any(ruling.status.infected for ruling in {one.ruling for one in flights})
    violated, seeds = tuple([one.ruling.violated for one in flights]), tuple([one.seed for one in flights])
    return Sample(situation, violated, infected, seeds)


def _result(sample: Sample, flights: Sequence[Ruled], pool: Pool, detected: bool, operability_detected: bool) -> Result:
    steady, operable = (
        pool.steady(sample.situation, kind) if sample.infected else () for kind in (Kind.SAFETY, Kind.OPERABILITY)
    )
    status = furthest({ruling.status for ruling in {one.ruling for one in flights}})
    most = {name for name, count in sample.counts.items() if 2 * count > len(flights)}
    return Result(
        situation=sample.situation,
        status=status,
        flown=len(flights),
        reached=status is not Status.NOT_REACHED,
        infected=sample.infected,
        violated=tuple(sorted(sample.counts.items())),
        steady=steady,
        steady_operability=operable,
        kills=tuple(name for name in steady if detected and name in most),
        operability_kills=tuple(name for name in operable if operability_detected and name in most),
    )


def _kill(result: Result, requirement: str, flights: Sequence[Ruled]) -> Kill:
    violated = dict(result.violated)[requirement]
    return Kill(result.situation, requirement, violated, result.flown, _first(result, requirement, flights))


def _first(result: Result, requirement: str, flights: Sequence[Ruled]) -> Moment:
    """The earliest violation of a requirement by flights that are known to violate it."""
    return min(
        (
            Moment(requirement, v.t_s, result.situation, one.seed, (v.x, v.y, v.z), v.struck)
            for one in flights
            for v in one.violations
            if v.requirement == requirement
        ),
        key=lambda moment: (moment.t_s, moment.seed),
    )
