"""Detected, undecided, not detected, not tested: what all flights of a mutant say together; firm; the noise of a stack.

**The pool** is what the unmutated drone does in each situation; it says which pairs put a fault to the test.

**The question.**  Would the tests have shown this fault, or does chance explain what was seen?  Every drone violates a
requirement now and then, so one flight beside its baseline is an observation; the verdict is one test a mutant.

**The test.**  Per requirement the exact stratified test of the mutant's flights against the baseline pool
(`p_value`), over all situations flown whose pair is neither vacuous nor open.  A flight of the mutant that is cut
short before it violated the requirement counts as one that does not; such a flight of the pool leaves the pool.  So a
fault that does nothing has at most the pool's rate.  Holm's adjustment over the requirements of one kind (Scand. J.
Statist. 6, 1979) bounds the chance that a fault which does nothing is called detected by alpha.

Each situation is a stratum.  Given the t violations among the n flights of the subject and the m flights of the pool,
the subject's k are hypergeometric if both violate at the same rate (Fisher, The Design of Experiments, 1935).  A
situation contributes k to the statistic where t - k <= m/10, else 0.  This gate is part of the statistic: situations
that were chosen first by a lucky pool and tested afterwards would call noise a detection.  The contributions' exact
distributions are convolved over the situations (as in the exact test of a common odds ratio of 2 x 2 tables: Gart,
Biometrika 57, 1970); p is the chance of a sum at least as large as the one observed.

**Alpha is spent by number of seeds.**  A campaign whose size is fixed before it flies spends all of alpha once.  Where
more seeds were asked for later, each look at 1, 3, 5 and 10 seeds spends a quarter (Bonferroni), whichever of them were
looked at: what is detected at one stays detected.

**What it needs**, with ten flights in the pool, none of which violates, alpha 0.01 and two requirements: one seed about
three violating situations (two give p = 0.0165), three seeds one situation (0.0070).

Mutant and pool share their noise seed by seed, and the pool has the mutant's own seeds in it; the test takes them as
independent, which makes it the stricter.  Mutants share seeds with one another, so false detections come in groups.

Detected says what these flights support; firm says what another seed would say.  A detected mutant is firm if it stays
detected when any one seed is left out of its own flights and, separately, any one out of the pool's (the jackknife of
Quenouille, Biometrika 43, 1956, over seeds).  States of pairs and the gate's allowance stay those of the whole pool,
else leaving out one of ten flights would change what is asked and not only what answers.

The simulator repeats its bits for a situation and seed, so two such flights of the same drone differ by what their
stack did.  PLACEBO alters nothing: its flight beside the baseline of the same situation and seed is such a pair.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property, lru_cache
from itertools import product
from typing import Annotated, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome, Violation
from scaloft_fi.judge.requirement import Compliance, Kind, Reading
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import baselines_of
from scaloft_fi.marks import About
from scaloft_fi.registry import grouped

LEAST = 10
"""Baseline flights that a situation needs before its pairs have a state."""


class State(StrEnum):
    """What the pool says of a requirement in a situation; the first that fits."""

    UNKNOWN = "unknown"
    """Fewer than ten baseline flights: a green one makes nothing steady."""
    VACUOUS = "vacuous"
    """Less than half of the flights trigger the requirement: nothing is tested by it."""
    OPEN = "open"
    """More than a tenth of the flights are cut short before the requirement is judged."""
    STEADY = "steady"
    """At least nine tenths hold it: here a fault is put to the test."""
    RED = "red"
    """Most violate it: the unmutated drone's own finding."""
    UNSTEADY = "unsteady"
    """Between: the unmutated drone holds it or not by chance."""


@dataclass(frozen=True)
class Pair:
    """A requirement in a situation, by the baseline flights that count.

    Attributes:
        situation: key of the situation.
        requirement: name of the requirement.
        kind: of the requirement.
        flights: of the baseline.
        violated: flights that violate the requirement.
        open: flights cut short before it was judged.
        triggered: flights in which its trigger came true, or that violate it.
    """

    KEYS = ("*", "state")

    situation: str
    requirement: str
    kind: Kind
    flights: int
    violated: int
    open: int
    triggered: int

    @cached_property
    def judged(self) -> int:
        """Flights that violate the requirement or hold it to their end: what a mutant's flights are compared with."""
        return self.flights - self.open

    @cached_property
    def state(self) -> State:
        """What the pool says."""
        if self.flights < LEAST:
            return State.UNKNOWN
        if 2 * self.triggered < self.flights:
            return State.VACUOUS
        if 10 * self.open > self.flights:
            return State.OPEN
        if 10 * (self.judged - self.violated) >= 9 * self.flights:
            return State.STEADY
        return State.RED if 2 * self.violated > self.flights else State.UNSTEADY

    def called(self, *, of_tests: bool) -> State:
        """The state as people are told it: a test with a red run among ten is called flaky, though it tests faults."""
        flaky = of_tests and self.state is State.STEADY and self.violated
        return State.UNSTEADY if flaky else self.state

    @cached_property
    def tests(self) -> bool:
        """Whether the pair enters the stratified test: it is neither unknown nor vacuous nor open."""
        return self.state in (State.STEADY, State.RED, State.UNSTEADY)


@dataclass(frozen=True)
class Pool:
    """The pairs of a campaign.

    Attributes:
        pairs: by situation and requirement, requirements in the study's order; none of kind `reported`.
        by_seed: what each seed adds to `violated` and `judged` of the pairs in which it was flown.
    """

    pairs: Mapping[tuple[str, str], Pair]
    by_seed: Mapping[int, Mapping[tuple[str, str], tuple[int, int]]] = field(default_factory=dict)

    @classmethod
    def of(cls, baselines: Iterable[Outcome]) -> Pool:
        """The pool of baseline flights; invalid ones and flights of mutants say nothing."""
        counts: dict[tuple[str, str], list[int]] = {}
        by_seed: dict[int, dict[tuple[str, str], tuple[int, int]]] = {}
        kinds: dict[str, Kind] = {}
        for outcome in baselines:
            if outcome.subject.id != BASELINE or outcome.invalid:
                continue
            for reading in outcome.readings:
                if reading.kind is Kind.REPORTED:
                    continue
                kinds[reading.requirement] = reading.kind
                tally = counts.setdefault((outcome.situation, reading.requirement), [0, 0, 0, 0])
                tally[0] += 1
                tally[1] += reading.violated
                tally[2] += reading.open
                tally[3] += reading.violated or reading.triggered > 0
                place = outcome.situation, reading.requirement
                seeds = by_seed.setdefault(outcome.seed, {})
                violated, judged = seeds.get(place, (0, 0))
                seeds[place] = violated + reading.violated, judged + (not reading.open)
        pairs = {place: Pair(*place, kinds[place[1]], *tally) for place, tally in counts.items()}
        return cls(pairs, by_seed)

    @cached_property
    def states(self) -> Mapping[tuple[str, str], State]:
        """The state of each pair."""
        return {place: pair.state for place, pair in self.pairs.items()}

    @cached_property
    def tested(self) -> Mapping[str, Mapping[str, Pair]]:
        """By requirement, the pairs that enter the stratified test, by situation."""
        testing = grouped((pair for pair in self.pairs.values() if pair.tests), lambda pair: pair.requirement)
        return {name: {pair.situation: pair for pair in own} for name, own in testing.items()}

    @cached_property
    def _requirements(self) -> Mapping[str, Kind]:
        return {name: pair.kind for (_, name), pair in self.pairs.items()}

    def requirements(self, kind: Kind) -> tuple[str, ...]:
        """The requirements of a kind, in the study's order."""
        return tuple(name for name, own in self._requirements.items() if own is kind)

    def steady(self, situation: str, kind: Kind) -> tuple[str, ...]:
        """The requirements of a kind that are steady in a situation."""
        return self._steady.get((situation, kind), ())

    @cached_property
    def _steady(self) -> Mapping[tuple[str, Kind], tuple[str, ...]]:
        order = {name: place for place, name in enumerate(self._requirements)}
        steady = [pair for pair in self.pairs.values() if pair.state is State.STEADY]
        steady.sort(key=lambda pair: order[pair.requirement])
        groups = grouped(steady, lambda pair: (pair.situation, pair.kind))
        return {place: tuple(pair.requirement for pair in own) for place, own in groups.items()}

    @cached_property
    def flown(self) -> frozenset[str]:
        """Situations with as many flights as a pool needs."""
        return frozenset(place[0] for place, state in self.states.items() if state is not State.UNKNOWN)


@dataclass(frozen=True)
class SituationBaseline:
    """A situation's baseline over the seeds.

    Attributes:
        situation: key of the situation.
        flown: baseline flights that count.
        violated: requirements that any of them violates, in the study's order.
        open: requirements left open by a flight cut short, and violated in none.
        vacuous: requirements whose trigger never came true in any.
        first: the earliest safety violation and its seed.
        red: flights that violate a safety requirement.
    """

    KEYS = ("situation", "violated")
    situation: str
    flown: int
    violated: tuple[str, ...]
    open: tuple[str, ...]
    vacuous: tuple[str, ...]
    first: tuple[Violation, int] | None
    red: int


def findings(outcomes: Iterable[Outcome], space: Space) -> tuple[SituationBaseline, ...]:
    """One finding per situation with a baseline that counts, in the grid's order."""
    counting = (one for one in outcomes if one.mutant == BASELINE and not one.invalid)
    flown = grouped(counting, lambda one: one.situation)
    return tuple(_finding(key, flown[key]) for key in sorted(flown, key=space.rank))


def _finding(situation: str, baselines: list[Outcome]) -> SituationBaseline:
    read = grouped((each for one in baselines for each in one.readings), lambda each: each.requirement)
    shown = {name: {each.compliance for each in own} for name, own in read.items()}
    firsts = [(v, outcome.seed) for outcome in baselines if (v := outcome.first_violation)]
    return SituationBaseline(
        situation=situation,
        flown=len(baselines),
        violated=tuple(name for name, own in shown.items() if Compliance.VIOLATED in own),
        open=tuple(name for name, own in shown.items() if Compliance.OPEN in own and Compliance.VIOLATED not in own),
        vacuous=tuple(name for name, own in shown.items() if own == {Compliance.VACUOUS}),
        first=min(firsts, key=lambda pair: (pair[0].t_s, pair[1]), default=None),
        red=len(firsts),
    )


@dataclass(frozen=True)
class Tally:
    """A requirement over flights: how many of each compliance, how often it was triggered, the least robustness.

    The robustness is that of flights that put it to the test; None when none did.
    """

    requirement: str
    kind: Kind
    compliances: tuple[tuple[Compliance, int], ...]
    triggered: int
    least_rho: float | None


def tallies(outcomes: Iterable[Outcome]) -> tuple[Tally, ...]:
    """One tally per requirement over the baseline flights that count, in the study's order."""
    counting = (one for one in outcomes if one.mutant == BASELINE and not one.invalid)
    read = grouped((each for one in counting for each in one.readings), lambda each: each.requirement)
    return tuple(_tally(name, readings) for name, readings in read.items())


def _tally(name: str, readings: list[Reading]) -> Tally:
    compliances = [reading.compliance for reading in readings]
    return Tally(
        requirement=name,
        kind=readings[0].kind,
        compliances=tuple((compliance, compliances.count(compliance)) for compliance in Compliance),
        triggered=sum(reading.triggered for reading in readings),
        least_rho=min((rho for r in readings if (rho := r.robustness) is not None), default=None),
    )


K = TypeVar("K")

ALPHA = 0.01
"""Accepted chance that a fault which does nothing is called detected, where the study names none."""
MOST_ALPHA = 0.1
"""Largest alpha that a study may name."""
LOOKS = (1, 3, 5, 10)
"""Numbers of seeds at which a campaign that grows is looked at."""
LARGER = (20, 50)
"""Sizes of a campaign of its own that are tried where no look would decide."""
ROUNDING = 1e-9
"""Floats that are equal but for rounding."""


class Verdict(StrEnum):
    """What the flights of a mutant say together."""

    DETECTED = "detected"
    """It violates requirements more often than chance explains: the tests would have shown it."""
    UNDECIDED = "undecided"
    """Violations were seen, or so few flights were flown that no result of theirs could have decided."""
    NOT_DETECTED = "not_detected"
    """It was put to the test, and nothing was seen."""
    NOT_TESTED = "not_tested"
    """It changes no sample in any situation whose baseline holds a requirement steadily."""

    @property
    def words(self) -> str:
        """As people read it: `not detected`."""
        return self.value.replace("_", " ")


@dataclass(frozen=True)
class Spending:
    """How alpha is spent.

    Attributes:
        alpha: the study's.
        grown: ids of the mutants that runs asked to fly with more than one set of seeds.
    """

    alpha: float = ALPHA
    grown: frozenset[str] = frozenset()

    def looks(self, mutant: str, flown: int) -> tuple[tuple[int, float], ...]:
        """The numbers of seeds at which a mutant with `flown` flights in a situation is judged, each with its share.

        >>> Spending(0.01).looks("a", 3), Spending(0.01, frozenset({"a"})).looks("a", 4)
        (((3, 0.01),), ((1, 0.0025), (3, 0.0025)))
        """
        if mutant not in self.grown:
            return ((flown, self.alpha),)
        return tuple((look, self.alpha / len(LOOKS)) for look in LOOKS if look <= flown)


@dataclass(frozen=True)
class Look:
    """One look.

    Attributes:
        seeds: number of seeds at this look.
        mutants: number of mutants judged at this look.
        flights: number of their flights that the look planned.
        detected: mutants detected.
        undecided: mutants undecided.
        not_detected: mutants not detected.
        not_tested: mutants not tested.
    """

    seeds: int
    mutants: int
    flights: int
    detected: int
    undecided: int
    not_detected: int
    not_tested: int


@dataclass(frozen=True)
class Sample:
    """A mutant's flights in a situation, in the order of their seeds.

    Attributes:
        situation: key.
        violated: per flight that counts, the requirements it violates.
        infected: whether the fault changed a sample in any.
        seeds: of these flights; empty where nobody asks for them.
    """

    situation: str
    violated: tuple[tuple[str, ...], ...]
    infected: bool
    seeds: tuple[int, ...] = ()

    @classmethod
    def of(cls, flown: Sequence[Outcome]) -> Sample:
        """The flights of a mutant in one situation, all of which count, without their seeds."""
        violated = tuple(tuple(violation.requirement for violation in one.violations) for one in flown)
        return cls(flown[0].situation, violated, any(one.altered for one in flown))

    def at(self, look: int) -> Sample:
        """The first flights alone; whether they are infected is asked of all."""
        if look >= len(self.violated):
            return self
        return Sample(self.situation, self.violated[:look], self.infected, self.seeds[:look])

    def without(self, seed: int) -> Sample:
        """The flights with other seeds; whether they are infected is asked of all."""
        kept = [place for place, own in enumerate(self.seeds) if own != seed]
        if len(kept) == len(self.seeds):
            return self
        violated = tuple(self.violated[place] for place in kept)
        return Sample(self.situation, violated, self.infected, tuple(self.seeds[place] for place in kept))

    @cached_property
    def counts(self) -> Mapping[str, int]:
        """Flights that violate each requirement, where any does."""
        counts: dict[str, int] = {}
        for names, flights in Counter(self.violated).items():  # few of them differ
            for name in names:
                counts[name] = counts.get(name, 0) + flights
        return counts

    def count(self, requirement: str) -> int:
        """Flights that violate a requirement."""
        return self.counts.get(requirement, 0)

    @cached_property
    def places(self) -> Mapping[int, int]:
        """Place of the flight with each seed."""
        return {seed: place for place, seed in enumerate(self.seeds)}


@dataclass(frozen=True)
class Detection:
    """The verdict on a mutant by the requirements of one kind.

    Attributes:
        verdict: detected or not.
        p: by requirement, the chance of as many violations if the fault did nothing: exact test, adjusted by Holm, at
            the look that decided or the last one reached.
        by: the requirements whose p is at most `share`.
        seeds: seeds that the p rest on.
        share: the share of alpha that p is held against (0..1).
        needed: least number of seeds that would decide if what was seen goes on; null: decided, or none would.
        anew: whether that takes a campaign of its own, whose size is fixed before it flies.
    """

    KEYS = ("seeds", "alpha=share", "needed", "anew")
    verdict: Verdict
    p: Mapping[str, Annotated[float, About("p (0..1)")]] = field(default_factory=dict)
    by: tuple[str, ...] = ()
    seeds: int = 0
    share: float = ALPHA
    needed: int | None = None
    anew: bool = False

    @property
    def detected(self) -> bool:
        """Whether the tests would have shown the fault."""
        return self.verdict is Verdict.DETECTED


def detect(mutant: str, samples: Sequence[Sample], pool: Pool, spending: Spending, kind: Kind) -> Detection:
    """The verdict on one mutant by the requirements of a kind.

    Args:
        mutant: id, by which `spending` knows whether it grew.
        samples: one per situation flown.
        pool: what the flights are compared with.
        spending: of alpha.
        kind: safety or operability.
    """
    names = pool.requirements(kind)
    flown = max((len(sample.violated) for sample in samples), default=0)
    share, seeds, p = spending.alpha, 0, dict.fromkeys(names, 1.0)
    tested = [sample for sample in samples if sample.infected and pool.steady(sample.situation, kind)]
    lacking = names and any(sample.infected and sample.situation not in pool.flown for sample in samples)
    if not tested:
        return Detection(Verdict.UNDECIDED if lacking else Verdict.NOT_TESTED, p, (), flown, share)
    for seeds, share in spending.looks(mutant, flown):
        p = adjusted([sample.at(seeds) for sample in samples], pool, names)
        by = tuple(name for name in names if reaches(p[name], share))
        if by:
            return Detection(Verdict.DETECTED, p, by, seeds, share)
    seen = any(sample.count(name) for sample in tested for name in pool.steady(sample.situation, kind))
    looked = [sample.at(seeds) for sample in tested]  # flights after the last look count at the next one
    able = reaches(min(adjusted(at_worst(looked, pool, kind), pool, names).values()), share)
    if able and not seen and not lacking:
        return Detection(Verdict.NOT_DETECTED, p, (), seeds, share)
    needed, anew = _needed(tested if seen else at_worst(tested, pool, kind), pool, names, spending.alpha)
    return Detection(Verdict.UNDECIDED, p, (), seeds, share, needed, anew)


def adjusted(samples: Iterable[Sample], pool: Pool, names: Sequence[str]) -> dict[str, float]:
    """The p of each requirement, adjusted by Holm over all of them.

    Args:
        samples: one per situation flown.
        pool: what they are compared with.
        names: the requirements.
    """
    listed = list(samples)
    return holm({name: p_value(_strata(listed, pool, name)) for name in names})


def holm(raw: Mapping[K, float]) -> dict[K, float]:
    """Each p adjusted for the number of tests (Holm, Scand. J. Statist. 6, 1979).

    >>> holm({"a": 0.25, "b": 0.125})
    {'a': 0.25, 'b': 0.25}
    """
    adjusted_p, largest = {}, 0.0
    for number, name in enumerate(sorted(raw, key=lambda name: raw[name])):
        largest = max(largest, min(1.0, (len(raw) - number) * raw[name]))
        adjusted_p[name] = largest
    return {name: adjusted_p[name] for name in raw}


def _strata(
    samples: Iterable[Sample], pool: Pool, name: str, left_out: int | None = None, own: int | None = None
) -> Iterable[Stratum]:
    """The situations that test a requirement, without a seed of the pool, and without a seed of the mutant's `own`.

    States of pairs and the gate stay those of the whole pool.
    """
    tested = pool.tested.get(name, {})
    gone = pool.by_seed.get(left_out, {}) if left_out is not None else {}
    for sample in samples:
        pair = tested.get(sample.situation)
        if pair is not None:
            violated, judged = gone.get((sample.situation, name), (0, 0)) if gone else (0, 0)
            k, n, at = sample.counts.get(name, 0), len(sample.violated), None if own is None else sample.places.get(own)
            if at is not None:
                k, n = k - (name in sample.violated[at]), n - 1
            yield Stratum(k, n, pair.violated - violated, pair.judged - judged, pair.judged // GATE)


def _violating(samples: Iterable[Sample], pool: Pool, name: str) -> list[Sample]:
    """The situations where subject or pool violate a requirement: others weigh nothing, whatever is left out."""
    tested = pool.tested.get(name, {})
    pairs = ((sample, tested.get(sample.situation)) for sample in samples)
    return [sample for sample, pair in pairs if pair is not None and (pair.violated or sample.count(name))]


def reaches(p: float, share: float) -> bool:
    """Whether p is at most this share of alpha, but for rounding."""
    return p <= share * (1 + ROUNDING)


def at_worst(tested: Iterable[Sample], pool: Pool, kind: Kind) -> list[Sample]:
    """The same flights if each violated every requirement that is steady in its situation."""
    return [Sample(s.situation, (pool.steady(s.situation, kind),) * len(s.violated), s.infected) for s in tested]


def _needed(samples: Sequence[Sample], pool: Pool, names: Sequence[str], alpha: float) -> tuple[int | None, bool]:
    """The least number of seeds at which the rates of `samples` would be detected, and whether by a campaign anew."""
    flown = max(len(sample.violated) for sample in samples)
    tries = [*((seeds, alpha / len(LOOKS), False) for seeds in LOOKS), *((seeds, alpha, True) for seeds in LARGER)]
    for seeds, share, anew in tries:
        if seeds > flown and _decides(samples, pool, names, seeds, share):
            return seeds, anew
    return None, False


def _decides(samples: Sequence[Sample], pool: Pool, names: Sequence[str], seeds: int, share: float) -> bool:
    def strata(name: str) -> Iterable[Stratum]:
        for sample in samples:
            pair = pool.pairs.get((sample.situation, name))
            if pair is not None and pair.state is State.STEADY:
                expected = (2 * sample.count(name) * seeds + len(sample.violated)) // (2 * len(sample.violated))
                judged = max(pair.judged, seeds)
                yield Stratum(expected, seeds, (2 * pair.violated * judged + pair.judged) // (2 * pair.judged), judged)

    return reaches(len(names) * min(p_value(strata(name)) for name in names), share)


class Firmness(StrEnum):
    """What remains of a verdict `detected` when one seed is left out."""

    FIRM = "firm"
    """It stays detected, whichever seed is left out of its own flights or of the pool."""
    FIRM_BY_POOL = "firm_by_pool"
    """It has one seed of its own, and stays detected whichever seed is left out of the pool."""
    HANGS = "hangs_on_a_seed"
    """Without some seed it is not detected."""
    TOO_FEW = "too_few_seeds"
    """Without some seed the flights that remain could not be detected whatever they show."""

    @property
    def firm(self) -> bool:
        """Whether it counts as firm."""
        return self in (Firmness.FIRM, Firmness.FIRM_BY_POOL)

    @property
    def words(self) -> str:
        """As people read it."""
        return _WORDS[self]


_WORDS = {
    Firmness.FIRM: "firm",
    Firmness.FIRM_BY_POOL: "firm by the pool alone",
    Firmness.HANGS: "hangs on a seed",
    Firmness.TOO_FEW: "too few seeds to say",
}


def firmness(mutant: str, samples: Sequence[Sample], pool: Pool, spending: Spending, kind: Kind) -> Firmness:
    """What remains of the verdict on a detected mutant when one seed is left out.

    Each number of seeds at which the mutant is judged is judged again without the seed, at its share of alpha.

    Args:
        mutant: its id.
        samples: one per situation flown, with their seeds.
        pool: what the flights are compared with.
        spending: of alpha.
        kind: safety or operability.
    """
    flown = max(len(sample.violated) for sample in samples)
    looks = [([sample.at(seeds) for sample in samples], share) for seeds, share in spending.looks(mutant, flown)]
    own = sorted({seed for sample in samples for seed in sample.seeds})
    names = pool.requirements(kind)
    # what decides without a seed is most often what decides with it, so that is asked first
    tries = sorted(
        ((_violating(looked, pool, name), name, share) for looked, share in looks for name in names),
        key=lambda one: p_value(_strata(one[0], pool, one[1])) / one[2],
    )

    def detected(tries: Iterable[tuple[Sequence[Sample], str, float]], seed: int | None, own_seed: int | None) -> bool:
        return any(  # the least of Holm's
            significant(_strata(left, pool, name, seed, own_seed), len(names), share) for left, name, share in tries
        )

    left_out = (*((None, seed) for seed in own if len(own) > 1), *((seed, None) for seed in pool.by_seed))
    lost = [(seed, own_seed) for seed, own_seed in left_out if not detected(tries, seed, own_seed)]
    if not lost:
        return Firmness.FIRM if len(own) > 1 else Firmness.FIRM_BY_POOL
    for (seed, own_seed), (looked, share) in product(lost, looks):
        left = looked if own_seed is None else [sample.without(own_seed) for sample in looked]
        # the flights that put the fault to the test, if each violated all that it could
        worst = at_worst([one for one in left if one.infected and pool.steady(one.situation, kind)], pool, kind)
        if detected([(worst, name, share) for name in names], seed, None):
            return Firmness.HANGS
    return Firmness.TOO_FEW


@dataclass(frozen=True)
class Noise:
    """The noise of the robustness of one requirement, in its unit.

    Attributes:
        requirement: name of the requirement.
        pairs: pairs of flights of one situation and seed that both measure it.
        stack: standard deviation of one flight by what the stack did alone: the root mean square of the differences,
            divided by the root of two; null: there is no pair.
        seeds: standard deviation between the seeds of a situation, by sensors and stack together, pooled over the
            situations; null: no situation has two baselines.
        apart: pairs of which one flight violates it and the other one holds it.
    """

    requirement: str
    pairs: int
    stack: float | None
    seeds: float | None
    apart: int


def noise_of(outcomes: Iterable[Outcome]) -> tuple[Noise, ...]:
    """The noise of each safety and operability requirement, in the study's order; empty without a valid baseline."""
    listed = [outcome for outcome in outcomes if not outcome.invalid]
    known = baselines_of(listed)
    placebo = (outcome for outcome in listed if outcome.mutant == PLACEBO_ID)
    pairs = [(known[place], one) for one in placebo if (place := (one.situation, one.seed)) in known]
    baselines = [outcome for outcome in listed if outcome.mutant == BASELINE]
    names = {r.requirement: None for o in baselines for r in o.readings if r.kind is not Kind.REPORTED}
    return tuple(_noise(name, pairs, baselines) for name in names)


def _noise(name: str, pairs: Sequence[tuple[Outcome, Outcome]], baselines: Sequence[Outcome]) -> Noise:
    both = [(_rho(name, first), _rho(name, second)) for first, second in pairs]
    squares = [(one - other) ** 2 for one, other in both if one is not None and other is not None]
    groups = defaultdict[str, list[float]](list)
    for outcome in baselines:
        if (rho := _rho(name, outcome)) is not None:
            groups[outcome.situation].append(rho)
    within = sum((rho - sum(own) / len(own)) ** 2 for own in groups.values() for rho in own)
    freedom = sum(map(len, groups.values())) - len(groups)
    return Noise(
        requirement=name,
        pairs=len(squares),
        stack=math.sqrt(sum(squares) / len(squares) / 2.0) if squares else None,
        seeds=math.sqrt(within / freedom) if freedom else None,
        apart=sum(_violates(name, first) != _violates(name, second) for first, second in pairs),
    )


def _rho(name: str, outcome: Outcome) -> float | None:
    reading = outcome.reading(name)
    measured = reading.robustness if reading else None
    return measured if measured is not None and math.isfinite(measured) else None


def _violates(name: str, outcome: Outcome) -> bool:
    return any(violation.requirement == name for violation in outcome.violations)


GATE = 10
"""A situation contributes where at most one in `GATE` of its pool flights violates."""


class Stratum(NamedTuple):
    """A situation: the subject violates in k of n flights, the pool in b of m.

    Attributes:
        most: violating pool flights up to which the situation contributes; a tenth of m where none is given.
    """

    k: int
    n: int
    b: int
    m: int
    most: int | None = None


Margin = tuple[int, int, int, int]
"""What a stratum's chances rest on: n, m, the violations of both together, and `most`."""


def p_value(strata: Iterable[Stratum]) -> float:
    """Chance of at least the observed sum of contributions, if subject and pool violate at the same rates.

    >>> f"{p_value([Stratum(3, 3, 0, 10)]):.4f}", f"{p_value([Stratum(1, 1, 0, 10)] * 2):.4f}"
    ('0.0035', '0.0083')
    >>> p_value([Stratum(3, 3, 8, 10)])
    1.0

    Raises:
        ValueError: not 0 <= k <= n, or not 0 <= b <= m.
    """
    observed, margins = _margins(strata)
    return min(1.0, float(_tails(tuple(sorted(margins)))[observed])) if observed else 1.0


def significant(strata: Iterable[Stratum], tests: int, share: float) -> bool:
    """Whether `tests` times the p of these strata is at most a share of alpha, but for rounding."""
    observed, margins = _margins(strata)
    # Chernoff's bound, P(S >= s) <= E[e^S] / e^s, is far cheaper than p and most often enough
    if sum(map(_log_mean_exp, margins)) - observed < math.log(share / tests) - 1.0:
        return True
    return reaches(min(1.0, tests * float(_tails(tuple(sorted(margins)))[observed])) if observed else 1.0, share)


def _margins(strata: Iterable[Stratum]) -> tuple[int, list[Margin]]:
    """The sum of the contributions, and the margins of the strata with a violation: others contribute nothing.

    Raises:
        ValueError: not 0 <= k <= n, or not 0 <= b <= m.
    """
    observed, margins = 0, []
    for k, n, b, m, given in strata:
        if not (0 <= k <= n and 0 <= b <= m):
            raise ValueError(f"{k} of {n} against {b} of {m} is no stratum")
        if k + b:
            most = m // GATE if given is None else given
            observed += k if b <= most else 0
            margins.append((n, m, k + b, most))
    return observed, margins


@lru_cache(maxsize=8192)
def _tails(margins: tuple[Margin, ...]) -> NDArray[np.float64]:
    """Chance of a sum of at least 0, 1, 2, ... over strata with these (n, m, t, most)."""
    chances = np.ones(1)
    for n, m, t, most in margins:
        entries = _contributions(n, m, t, most)
        wider = np.zeros(len(chances) + entries[-1][0])
        for contribution, chance in entries:
            wider[contribution : contribution + len(chances)] += chance * chances
        chances = wider
    return np.cumsum(chances[::-1])[::-1]


@lru_cache(maxsize=8192)
def _contributions(n: int, m: int, t: int, most: int) -> tuple[tuple[int, float], ...]:
    """What a stratum may contribute, each with its chance, least first."""
    ways = math.comb(n + m, t)
    weights: dict[int, int] = {}
    for k in range(max(0, t - m), min(n, t) + 1):
        contribution = k if t - k <= most else 0
        weights[contribution] = weights.get(contribution, 0) + math.comb(n, k) * math.comb(m, t - k)
    return tuple((contribution, weights[contribution] / ways) for contribution in sorted(weights))


@lru_cache(maxsize=8192)
def _log_mean_exp(margin: Margin) -> float:
    """Logarithm of the mean of e to the power of what a stratum contributes; infinite where floats are too small."""
    entries = _contributions(*margin)
    if entries[-1][0] > MOST_EXPONENT:
        return math.inf
    return math.log(math.fsum(chance * math.exp(contribution) for contribution, chance in entries))


MOST_EXPONENT = 700
"""Greatest power of e below the largest float, but for a little."""
