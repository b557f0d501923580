"""What repeated flights of one mutant in one situation decide together: killed, survived, undecided.

**The question.**  A kill rate counts kills that were observed.  A decision says whether chance explains them: every
drone violates a requirement now and then, and over 32 situations a naive "any violation kills" finds a fault in
PLACEBO.

**The test**, per situation and safety requirement: the mutant violates it in k of n flights, the unmutated drone in b
of n0 of the baseline pool of that situation; Fisher's exact test, one-sided.  A flight cut short before it violated
the requirement counts among the n as one that does not, and leaves the pool; so a mutant that does nothing has at
most the pool's rate of violations.  Violating sooner what the baseline violates too is no kill; here it stands on
both sides.

**The family** is what one mutant's fault was put to the test of: the requirements that the paired baseline of an
infected flight held to its end, per situation, by the first 3 flights there.  Holm's adjustment over this family
bounds the probability of any false kill of the mutant at 5 %.  A situation with fewer flights counts in full, so that
flying on can only lighten the adjustment.  The family is closed at the first look.

**The looks**, after 3, 5 and 10 flights of a situation in the order of their seeds, spend a third of the 5 % each
(Bonferroni; Holm over looks as in Maurer and Bretz, Stat. Biopharm. Res. 5, 2013).  What is decided stays decided, so
that flights that the decision spares would not have changed it; flights between two looks wait for the next, those
after the tenth decide nothing and count in the kill rates.

**Killed**: an adjusted p of at most 5 %, and k/n - b/n0 of at least 0.2, so that significance alone is not enough.
Against 0 of n0 it needs, for a family of 1 / 32 / 64 tests:

| n0 | of 3 | of 5 | of 10 |
|---|---|---|---|
| 3 | - / - / - | - / - / - | 9 / - / - |
| 10 | 3 / - / - | 4 / 5 / - | 5 / 8 / 9 |
| 50 | 2 / 3 / 3 | 2 / 3 / 4 | 3 / 4 / 5 |

So fly a large pool once.  One flight decides nothing.

**Survived**: a fault that shows in at least half of its flights would have shown more often.  The exact binomial test
of the paired kills among the eligible flights rejects 1/2 within 5 %, of which nothing is spent at 3 flights, two
thirds at 5 and one third at 10: 0 of 5 (p = 1/32 = .031 <= .033) and 0 or 1 of 10 (p = 11/1024 = .011 <= .017)
survive, 0 of 3 (.125) does not.  With all flights eligible the error is .036 in all.  It bounds the error per
situation, not per mutant, and says nothing of faults that show more rarely.  Where the test of a kill would succeed
in a family of its own, the two contradict each other and nothing is decided.

**What a decision withstands.**  More flights of seeds above those flown never change a decision.  What may: another
pool (fly it first), an earlier seed flown later, and another situation, which enlarges the family.  Mutant and
baseline share their noise seed by seed; the test takes them as independent, which makes it the stricter.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise

from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.rulings import Situations, rulings_of
from scaloft_fi.results.scoring.exact import at_most, fisher
from scaloft_fi.results.status import INVALID, Ruling, Status

LOOKS = (3, 5, 10)
"""Flights of a situation after which it may be decided."""
ALPHA = Fraction(1, 20)
"""Error of both rules: of any false kill of a mutant, and of a wrong survival of a situation."""
FLOOR = Fraction(1, 5)
"""Least difference of the rates of violation that is a kill."""
FUTILITY = (Fraction(0), ALPHA * 2 / 3, ALPHA / 3)
"""What each look may spend on a wrong survival."""


class Decision(StrEnum):
    """What repeated flights of one mutant in one situation say together."""

    KILLED = "killed"
    SURVIVED = "survived"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Decided:
    """The decision on a mutant in a situation, with its figures.

    Attributes:
        decision: the decision.
        requirement: that kills it, or came nearest to it when undecided; empty when it survived or nothing was tested.
        p: adjusted for family and looks, to be compared with 5 %; of the binomial test when it survived.
        k, n: flights of the mutant that violate the requirement, of those looked at; when it survived, paired kills of
            the eligible flights.
        b, n0: the same of the baseline pool; 0 when it survived.
        look: flights at the look that decided, or at the last one reached; 0 before the first.
    """

    decision: Decision
    requirement: str = ""
    p: float = 1.0
    k: int = 0
    n: int = 0
    b: int = 0
    n0: int = 0
    look: int = 0


Pool = Mapping[str, Sequence[Outcome]]
"""Baseline outcomes of each situation."""


def decisions(outcomes: Iterable[Outcome], pool: Pool) -> Mapping[tuple[str, str], Decided]:
    """The decision on every mutant and situation with an eligible flight.

    Args:
        outcomes: of mutants and of their baselines, paired by situation and seed; only of whole flights.
        pool: baseline outcomes by situation: those among `outcomes`, and whatever more there are.
    """
    rates = PoolRates(pool)
    return {
        (mutant.id, situation): decided
        for mutant, situations in rulings_of(outcomes).mutants.items()
        for situation, decided in decide(situations, rates).items()
    }


class PoolRates:
    """Violations b of n0 in the pool, per situation and safety requirement, counted once."""

    def __init__(self, pool: Pool) -> None:
        self._rates = defaultdict[str, dict[str, tuple[int, int]]](dict)
        for situation, baselines in pool.items():
            for baseline in baselines:
                for reading in () if baseline.invalid else baseline.readings:
                    if reading.kind is Kind.SAFETY:
                        violated, counted = self._rates[situation].get(reading.requirement, (0, 0))
                        # what a flight cut short has not violated it has not held either
                        rate = violated + reading.violated, counted + (not reading.open)
                        self._rates[situation][reading.requirement] = rate

    def of(self, situation: str) -> Mapping[str, tuple[int, int]]:
        """B and n0 of each safety requirement, in the study's order."""
        return self._rates.get(situation, {})


def decide(situations: Situations, rates: PoolRates) -> dict[str, Decided]:
    """The decisions on one mutant in each situation with an eligible flight."""
    valid = {key: [one.ruling for one in flights if one.ruling is not INVALID] for key, flights in situations.items()}
    samples = [_sample(key, valid[key], rates) for key in sorted(valid) if valid[key]]
    family = sum(len(sample.family) for sample in samples)
    settled: dict[str, Decided] = {}
    latest: dict[str, Decided] = {}
    for number, look in enumerate(LOOKS):
        due = [sample for sample in samples if sample.reached >= look and sample.situation not in settled]
        killed = _killed(due, number, family)
        family -= sum(len(sample.family) for sample in due if sample.situation in killed)
        said = {sample.situation: told for sample in due if (told := sample.told(number, family))} | killed
        settled |= {key: decided for key, decided in said.items() if decided.decision is not Decision.UNDECIDED}
        latest |= said
    nothing = Decided(Decision.UNDECIDED)
    return {sample.situation: latest.get(sample.situation, nothing) for sample in samples if sample.eligible}


def _killed(due: Iterable[_Sample], number: int, family: int) -> dict[str, Decided]:
    """Holm's step-down at one look: the smallest p first, each times the tests of situations not yet killed.

    A killed situation takes all its tests out of the family: the error that is bounded is that of a false kill of a
    situation, and a second requirement cannot make a true one false.
    """
    found: dict[str, Decided] = {}
    tests = [(sample, name, sample.tests[number][name]) for sample in due for name in sample.family]
    largest = Fraction(0)
    for sample, name, test in sorted(tests, key=lambda entry: entry[2].order):
        p = max(largest, test.p * family * len(LOOKS))
        if p > ALPHA:
            break
        if test.differs and sample.situation not in found:
            found[sample.situation] = test.decided(Decision.KILLED, name, float(p), LOOKS[number])
            largest = p
            family -= len(sample.family)
    return found


@dataclass(frozen=True)
class _Test:
    """A 2 x 2 table; of each there is one object, which keeps what follows from it."""

    k: int
    n: int
    b: int
    n0: int

    @cached_property
    def p(self) -> Fraction:
        return fisher(self.k, self.n, self.b, self.n0)

    @cached_property
    def order(self) -> tuple[float, Fraction]:
        """Sorts as p does, but faster: rounding keeps the order, and fractions are only compared where it left none."""
        return float(self.p), self.p

    def adjusted(self, family: int) -> float:
        """P in a family of so many tests over all looks, at most 1."""
        return _adjusted(self.k, self.n, self.b, self.n0, family)

    @cached_property
    def differs(self) -> bool:
        """Whether the rates differ by the floor."""
        return self.n0 > 0 and Fraction(self.k, self.n) - Fraction(self.b, self.n0) >= FLOOR

    @cached_property
    def possible(self) -> bool:
        """Whether it would kill in a family of its own."""
        return self.differs and self.p * len(LOOKS) <= ALPHA

    def decided(self, decision: Decision, requirement: str, p: float, look: int) -> Decided:
        return Decided(decision, requirement, p, self.k, self.n, self.b, self.n0, look)


_test = cache(_Test)


@cache
def _adjusted(k: int, n: int, b: int, n0: int, family: int) -> float:
    return float(min(Fraction(1), fisher(k, n, b, n0) * family * len(LOOKS)))


@dataclass(frozen=True)
class _Sample:
    """A situation's flights that count, at each look that they reach.

    Attributes:
        situation: key.
        reached: the last look reached; 0 before the first.
        family: requirements that the situation brings into the family.
        tests: per look reached, the test of every safety requirement.
        kills: per look reached, paired kills and eligible flights.
        eligible: whether any flight is.
    """

    situation: str
    reached: int
    family: tuple[str, ...]
    tests: tuple[Mapping[str, _Test], ...]
    kills: tuple[tuple[int, int], ...]
    eligible: bool

    def told(self, number: int, family: int) -> Decided | None:
        """What this look says where nothing kills, with so many tests left; None where a later one will say more."""
        survival = self._survival(number)
        return self._nearest(number, family) if survival is None and self.reached == LOOKS[number] else survival

    def _survival(self, number: int) -> Decided | None:
        """The survival at this look, if it is one."""
        survival = _survival(number, *self.kills[number])
        if survival and any(test.possible for tests in self.tests[: number + 1] for test in tests.values()):
            return None
        return survival

    def _nearest(self, number: int, family: int) -> Decided:
        """The test that came nearest to a kill at this look, in a family of so many that are left."""
        name = min(self.family, key=lambda name: self.tests[number][name].order, default=None)
        if name is None:
            return Decided(Decision.UNDECIDED, look=LOOKS[number])
        test = self.tests[number][name]
        return test.decided(Decision.UNDECIDED, name, test.adjusted(family), LOOKS[number])


@cache
def _survival(number: int, kills: int, eligible: int) -> Decided | None:
    """What so many kills of the eligible flights say at a look, when they speak of survival."""
    spent, p = FUTILITY[number], at_most(kills, eligible)
    if p > spent:
        return None
    return Decided(Decision.SURVIVED, "", float(p * ALPHA / spent), kills, eligible, look=LOOKS[number])


def _sample(situation: str, rulings: Sequence[Ruling], rates: PoolRates) -> _Sample:
    reached = [look for look in LOOKS if look <= len(rulings)]
    pool = rates.of(situation)
    violated: Counter[str] = Counter()
    kills = eligible = 0
    tests, paired = [], []
    for start, look in pairwise((0, *reached)):
        for ruling in rulings[start:look]:
            for name in ruling.violated:
                violated[name] += 1
            kills += ruling.eligible and ruling.status is Status.KILLED
            eligible += ruling.eligible
        tests.append({name: _test(violated[name], look, *rate) for name, rate in pool.items()})
        paired.append((kills, eligible))
    tested = set().union(*(ruling.tested for ruling in rulings[: LOOKS[0]]))
    return _Sample(
        situation=situation,
        reached=max(reached, default=0),
        family=tuple(name for name in pool if not reached or name in tested),
        tests=tuple(tests),
        kills=tuple(paired),
        eligible=any(ruling.eligible for ruling in rulings),
    )
