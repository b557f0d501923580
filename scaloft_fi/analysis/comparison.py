"""Two campaigns of one matrix, flown with different stacks, versions or settings: what only one of them shows.

A fault is lost if it is firmly detected in the first campaign, put to the test and not detected in the second one, and
its flights violate more often in the first.  That is one exact stratified test a fault and requirement (`p_value`,
without its gate): the situations are the strata, the mutant's flights of both campaigns are compared with each other,
in the situations where the unmutated drone of both holds the requirement steadily.  Holm's adjustment is over the
requirements of a fault and over all faults that both campaigns flew; so the chance that any fault is called lost,
where the two drones do the same, is at most alpha.  Gained is the same with the campaigns exchanged.  Few flights can
say nothing: `least_p` tells what p the greatest difference would have.

The faults are all cells of a closed list and no sample, so agreement and kappa (Cohen, Educ. Psychol. Meas. 20, 1960)
have no interval.  Other seeds of one campaign do not agree with each other in every fault either: the halves of the
seeds of each campaign, each judged by itself, say how far.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Annotated

from scaloft_fi.analysis.detection import Pool, Sample, State, Stratum, Verdict, holm, p_value, reaches
from scaloft_fi.analysis.roster import OfSubject, Ratio, Roster
from scaloft_fi.analysis.score import MutantScore, Score, sample, score_of
from scaloft_fi.hazop.matrix import SeverityClass, worst_first
from scaloft_fi.judge.outcome import Subject
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import INVALID, Rulings, Situations
from scaloft_fi.marks import About


class Change(StrEnum):
    """What two campaigns say of a fault, held against each other."""

    LOST = "lost"
    """Firmly detected in the first, put to the test and not detected in the second, and more often violated."""
    GAINED = "gained"
    """The same with the campaigns exchanged."""
    UNSURE = "unsure"
    """Detected in one of them alone, and the flights do not say that the campaigns differ."""
    SAME = "same"
    """Detected in both, or in neither."""


@dataclass(frozen=True)
class ComparedMutant(OfSubject):
    """A fault that both campaigns flew: the default mutant of a credible cell.

    Attributes:
        subject: the mutant.
        change: what the two campaigns say of it.
        first: verdict of the first campaign.
        second: verdict of the second campaign.
        first_firm: whether the first campaign detects it whichever one seed is left out.
        second_firm: whether the second campaign does.
        situations: in which both campaigns put it to the same test.
        lost_p: chance of as many violations more in the first campaign if both drones do the same, after Holm.
        gained_p: the same of the second campaign.
        least_p: what either would be, after Holm, were every fault violated by all flights of one campaign there and by
            none of the other; above alpha the flights are too few to call the fault lost or gained.
        requirement: the safety requirement in which the campaigns differ most there, of equals the one that is violated
            most; null: there is none.
        first_violated: flights of the first campaign that violate it there, of all.
        second_violated: the same of the second campaign.
        severity: class of its cell; None where the cell has none.
    """

    KEYS = (
        *("subject.*", "severity=severity_id", "change", "first", "second"),
        *("first_firm", "second_firm", "situations", "lost_p", "gained_p", "least_p"),
        *("requirement", "first_violated", "second_violated"),
    )
    subject: Subject
    change: Change
    first: Verdict
    second: Verdict
    first_firm: bool
    second_firm: bool
    situations: int
    lost_p: Annotated[float, About("p (0..1)")]
    gained_p: Annotated[float, About("p (0..1)")]
    least_p: Annotated[float, About("p (0..1)")]
    requirement: str | None
    first_violated: Ratio
    second_violated: Ratio
    severity: SeverityClass | None = None

    @property
    def severity_id(self) -> str | None:
        """Class of severity, one of the study's own; null: it has none."""
        return self.severity.id if self.severity else None


@dataclass(frozen=True)
class Agreement:
    """In how many faults two sets of verdicts agree whether it is detected.

    Attributes:
        same: faults in which they agree, of all.
        kappa: agreement beyond what the two shares of detected faults give by chance; null: one of the shares is 0 or
            1 in both.
    """

    same: Ratio
    kappa: float | None

    @classmethod
    def of(cls, pairs: Iterable[tuple[bool, bool]]) -> Agreement:
        """The agreement of pairs of verdicts.

        >>> Agreement.of([(True, True), (True, False), (False, False), (False, False)])
        Agreement(same=Ratio(part=3, whole=4), kappa=0.5)
        """
        counts = Counter(pairs)
        whole, same = counts.total(), counts[True, True] + counts[False, False]
        one, other = counts[True, True] + counts[True, False], counts[True, True] + counts[False, True]
        by_chance = one * other + (whole - one) * (whole - other)
        beyond = whole * whole - by_chance
        return cls(Ratio(same, whole), (same * whole - by_chance) / beyond if beyond else None)


@dataclass(frozen=True)
class Flown:
    """A campaign, as far as a comparison needs it.

    Attributes:
        name: of the campaign.
        rulings: what each flight shows beside its baseline.
        score: of the campaign.
    """

    name: str
    rulings: Rulings
    score: Score


@dataclass(frozen=True)
class ComparedCampaigns:
    """What only one of two campaigns shows.

    Attributes:
        first: name of the first campaign.
        second: name of the second campaign.
        alpha: accepted chance that any fault is called lost where the drones do the same (0..1); likewise gained.
        mutants: those that both campaigns flew and one counts, the worst class of severity first.
        only_first: ids of mutants that only the first campaign flew, other magnitudes than the default too.
        only_second: ids of mutants that only the second campaign flew, other magnitudes than the default too.
        uncounted: ids of other magnitudes than the default that both flew; they are not compared.
        agreement: of the two campaigns, whether a fault is detected.
        first_halves: of the two halves of the first campaign's seeds; null: it has one seed.
        second_halves: the same of the second campaign.
    """

    first: str
    second: str
    alpha: float
    mutants: tuple[ComparedMutant, ...]
    only_first: tuple[str, ...]
    only_second: tuple[str, ...]
    agreement: Agreement
    first_halves: Agreement | None
    second_halves: Agreement | None
    uncounted: tuple[str, ...] = ()
    KEYS = (
        *("first", "second", "alpha", "lost", "gained", "unsure", "could_be_lost", "could_be_gained", "agreement"),
        *("first_halves", "second_halves", "mutants", "only_first", "only_second", "uncounted"),
    )

    def of(self, change: Change) -> tuple[str, ...]:
        """Ids of the faults of which the campaigns say this."""
        return tuple(mutant.id for mutant in self.mutants if mutant.change is change)

    @property
    def lost(self) -> tuple[str, ...]:
        """Ids of the faults that only the first campaign shows."""
        return self.of(Change.LOST)

    @property
    def gained(self) -> tuple[str, ...]:
        """Ids of the faults that only the second campaign shows."""
        return self.of(Change.GAINED)

    @property
    def unsure(self) -> tuple[str, ...]:
        """Ids of the faults that one campaign detects, where the flights do not say that the campaigns differ."""
        return self.of(Change.UNSURE)

    @property
    def could_be_lost(self) -> Ratio:
        """Faults with enough flights to be called lost, of those that are firm in the first campaign."""
        return self._enough([mutant for mutant in self.mutants if mutant.first_firm])

    @property
    def could_be_gained(self) -> Ratio:
        """Faults with enough flights to be called gained, of those that are firm in the second campaign."""
        return self._enough([mutant for mutant in self.mutants if mutant.second_firm])

    def _enough(self, firm: Sequence[ComparedMutant]) -> Ratio:
        return Ratio(sum(reaches(mutant.least_p, self.alpha) for mutant in firm), len(firm))


def compared(first: Flown, second: Flown, roster: Roster, space: Space) -> ComparedCampaigns:
    """Hold two campaigns of one matrix and one grid against each other."""
    here, there = ({mutant.id: mutant for mutant in flown.score.mutants if mutant.flown} for flown in (first, second))
    counted = {mutant.id for flown in (first, second) for mutant in flown.score.counted}
    both = [id_ for id_ in here if id_ in there and id_ in counted]
    samples = [{s.id: _samples(flights) for s, flights in flown.rulings.mutants.items()} for flown in (first, second)]
    pools = first.score.pool, second.score.pool
    strata = {id_: _strata(samples[0][id_], samples[1][id_], *pools) for id_ in both}
    lost_p, gained_p, least_p = (_over_faults(strata, each) for each in (_itself, _exchanged, _extreme))
    alpha = min(first.score.alpha, second.score.alpha)
    mutants = [
        _compared(here[id_], there[id_], strata[id_], (lost_p[id_], gained_p[id_], least_p[id_]), alpha) for id_ in both
    ]
    return ComparedCampaigns(
        first=first.name,
        second=second.name,
        alpha=alpha,
        mutants=tuple(worst_first(mutants, lambda mutant: mutant.severity)),
        only_first=tuple(id_ for id_ in here if id_ not in there),
        only_second=tuple(id_ for id_ in there if id_ not in here),
        agreement=Agreement.of((here[id_].detected, there[id_].detected) for id_ in both),
        first_halves=_halves(first, roster, space),
        second_halves=_halves(second, roster, space),
        uncounted=tuple(id_ for id_ in here if id_ in there and id_ not in counted),
    )


Strata = Mapping[str, Mapping[str, Stratum]]
"""By requirement and situation: the flights of the mutant that violate it, of all, in the first and in the second."""


def _samples(situations: Situations) -> dict[str, Sample]:
    valid = {key: [one for one in flights if one.ruling is not INVALID] for key, flights in situations.items()}
    return {key: sample(key, flights) for key, flights in valid.items() if flights}


def _strata(here: Mapping[str, Sample], there: Mapping[str, Sample], pool: Pool, other: Pool) -> Strata:
    """The situations in which both unmutated drones hold a safety requirement steadily and the fault acts in one."""
    steady = State.STEADY
    return {
        name: {
            key: Stratum(one.count(name), len(one.violated), two.count(name), len(two.violated), len(two.violated))
            for key, one in here.items()
            if (two := there.get(key)) is not None
            and (one.infected or two.infected)
            and pool.states.get((key, name)) is steady
            and other.states.get((key, name)) is steady
        }
        for name in pool.requirements(Kind.SAFETY)
    }


def _itself(own: Stratum) -> Stratum:
    return own


def _exchanged(own: Stratum) -> Stratum:
    return Stratum(own.b, own.m, own.k, own.n, own.n)


def _extreme(own: Stratum) -> Stratum:
    """The greatest difference that these flights could have shown; exchanged it has the same p."""
    return Stratum(own.n, own.n, 0, own.m, own.m)


def _over_faults(strata: Mapping[str, Strata], each: Callable[[Stratum], Stratum]) -> dict[str, float]:
    """The p of each fault that its flights, changed by `each`, violate more often in the first campaign, after Holm."""

    def least(own: Strata) -> float:
        return min(holm({name: p_value(map(each, one.values())) for name, one in own.items()}).values(), default=1.0)

    return holm({id_: least(own) for id_, own in strata.items()})


def _compared(
    here: MutantScore, there: MutantScore, strata: Strata, p: tuple[float, float, float], alpha: float
) -> ComparedMutant:
    lost_p, gained_p, least_p = p
    change = Change.SAME if here.detected == there.detected else Change.UNSURE
    if here.firm and there.tested and not there.detected and reaches(lost_p, alpha):
        change = Change.LOST
    elif there.firm and here.tested and not here.detected and reaches(gained_p, alpha):
        change = Change.GAINED
    sums = {
        name: tuple(map(sum, zip(*((o.k, o.n, o.b, o.m) for o in own.values()), strict=True)))
        for name, own in strata.items()
        if own
    }
    apart = {name: abs(k / n - b / m) for name, (k, n, b, m) in sums.items()}
    requirement = max(apart, key=lambda name: (apart[name], sums[name][0] + sums[name][2]), default=None)
    k, n, b, m = sums[requirement] if requirement is not None else (0, 0, 0, 0)
    situations = len({key for by_situation in strata.values() for key in by_situation})
    return ComparedMutant(
        subject=here.subject,
        change=change,
        first=here.verdict,
        second=there.verdict,
        first_firm=here.firm,
        second_firm=there.firm,
        situations=situations,
        lost_p=lost_p,
        gained_p=gained_p,
        least_p=least_p,
        requirement=requirement,
        first_violated=Ratio(k, n),
        second_violated=Ratio(b, m),
        severity=here.severity,
    )


def _halves(flown: Flown, roster: Roster, space: Space) -> Agreement | None:
    """The agreement of every other seed of a campaign's mutants with the rest, both beside the whole pool."""
    rulings = flown.rulings
    seeds = sorted({one.seed for by in rulings.mutants.values() for ruled in by.values() for one in ruled})
    if len(seeds) < 2:
        return None
    halves = (score_of(of_seeds(rulings, half), roster, space) for half in (seeds[::2], seeds[1::2]))
    one, two = ({mutant.id: mutant.detected for mutant in half.counted} for half in halves)
    return Agreement.of((one[id_], two[id_]) for id_ in one if id_ in two)


def of_seeds(rulings: Rulings, seeds: Sequence[int]) -> Rulings:
    """The flights of mutants with these seeds, beside all baselines."""
    mutants = {
        subject: {key: [one for one in ruled if one.seed in seeds] for key, ruled in situations.items()}
        for subject, situations in rulings.mutants.items()
    }
    return replace(rulings, mutants=mutants)
