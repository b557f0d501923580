"""The mutation score: what the campaign's flights say about each mutant, and about all of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from scaloft_fi.results.flights import baseline_pool
from scaloft_fi.results.kills.condition import condition
from scaloft_fi.results.outcome import PLACEBO, Outcome, Subject
from scaloft_fi.results.roster import Roster
from scaloft_fi.results.rulings import Rulings, Situations, rulings_of
from scaloft_fi.results.scoring.decision import Decided, Decision, Pool, PoolRates, decide
from scaloft_fi.results.scoring.ratio import Ratio
from scaloft_fi.results.scoring.redraw import Redraw, redraw
from scaloft_fi.results.space import Space
from scaloft_fi.results.status import Ruling, Status, mutant_status


@dataclass(frozen=True)
class Kill:
    """One killed flight: by which requirement, when [s from take-off], where [m, world], what was struck."""

    requirement: str
    t_s: float
    situation: str
    seed: int
    position: tuple[float, float, float]
    struck: str


@dataclass(frozen=True)
class Result:
    """A mutant in a situation: its flights over the seeds.

    Attributes:
        situation: key.
        status: the highest rung over the eligible flights.
        kills: killed among the eligible flights.
        eligible: flights that are infected beside a baseline that held a safety requirement to its end.
        flown: flights that count.
        killed: whether any flight is killed, eligible or not.
        harmless: whether every flight's fault changed no sample.
        decided: what the flights decide together; None without an eligible one.
    """

    situation: str
    status: Status
    kills: int
    eligible: int
    flown: int
    killed: bool
    harmless: bool
    decided: Decided | None

    @property
    def rate(self) -> Ratio:
        """Killed of the eligible flights."""
        return Ratio(self.kills, self.eligible)


@dataclass(frozen=True)
class MutantScore:
    """A mutant over all its situations.

    Attributes:
        subject: the mutant.
        status: the highest rung over its eligible flights.
        results: one per situation flown, in the grid's order.
        kill_rate: situations killed, of the eligible ones.
        kill_rate_flown: situations killed, of those flown.
        requirements: per requirement that killed it, operability too, the situations killed by it, of those where the
            fault infects and the baseline held the requirement to its end.
        tested: requirements that the baseline held to its end in a situation where the fault infects.
        operability: situations killed by an operability requirement, of those where the baseline held one to its end.
        earliest: the earliest kill.
        rungs: flights of each status.
        infected: whether any flight that counts is infected.
    """

    subject: Subject
    status: Status
    results: tuple[Result, ...]
    kill_rate: Ratio
    kill_rate_flown: Ratio
    requirements: tuple[tuple[str, Ratio], ...]
    tested: tuple[str, ...]
    operability: Ratio
    earliest: Kill | None
    rungs: tuple[tuple[Status, int], ...]
    infected: bool

    @property
    def flown(self) -> bool:
        """Whether any of its flights counts."""
        return self.kill_rate_flown.whole > 0

    @property
    def killed(self) -> bool:
        """Whether it is killed in an eligible situation."""
        return self.kill_rate.part > 0

    @property
    def killing(self) -> tuple[str, ...]:
        """Keys of the situations where a flight is killed."""
        return tuple(result.situation for result in self.results if result.killed)

    def decisions(self, decision: Decision) -> tuple[str, ...]:
        """Keys of the situations with this decision."""
        return tuple(r.situation for r in self.results if r.decided and r.decided.decision is decision)

    @property
    def surviving(self) -> tuple[str, ...]:
        """Keys of the situations where no flight is killed though the fault was tested, or could change nothing."""
        return tuple(r.situation for r in self.results if not r.killed and (r.eligible or (r.flown and r.harmless)))

    def condition(self, space: Space) -> str:
        """The killing situations in words; empty when there are none."""
        return _condition(space, self.killing, self.surviving)


@lru_cache(maxsize=4096)
def _condition(space: Space, killing: tuple[str, ...], surviving: tuple[str, ...]) -> str:
    """The condition, found once: several tables show it."""
    return condition(space, killing, surviving)


@dataclass(frozen=True)
class Score:
    """The campaign's score.  Ratios count the default mutants of credible cells and nothing else.

    Attributes:
        exercised: cells flown, of all credible cells.
        infected: mutants infected, of those flown.
        mutation_score: mutants killed, of those infected in an eligible situation.
        strict_score: mutants killed, of those flown.
        decided_score: mutants that repeated flights decide are killed in some situation, of those flown often enough in
            one to decide anything.
        operability: mutants killed by an operability requirement, of those infected where the baseline held one.
        mutants: every mutant flown, ladders too, in the canonical order.
        controls: every control flown.
        placebo: PLACEBO, when flown.
        redraw: how often the kill rule kills what does nothing.
        eligible: per situation, the eligible flights of the counted mutants.
    """

    exercised: Ratio
    infected: Ratio
    mutation_score: Ratio
    strict_score: Ratio
    decided_score: Ratio
    operability: Ratio
    mutants: tuple[MutantScore, ...]
    controls: tuple[MutantScore, ...]
    placebo: MutantScore | None
    redraw: Redraw
    eligible: Mapping[str, int]

    @property
    def false_kills(self) -> tuple[float, int] | None:
        """False kills expected of the counted mutants' eligible flights, and of how many of these it says so."""
        return self.redraw.expected(self.eligible)

    @property
    def fates(self) -> Counter[Status]:
        """Mutants of each status; they sum to the mutants."""
        return Counter(mutant.status for mutant in self.mutants)


def score(outcomes: Iterable[Outcome], roster: Roster, space: Space, pool: Pool | None = None) -> Score:
    """Score a campaign's outcomes, in whatever order they come.

    Args:
        outcomes: of the campaign.
        roster: which mutants count.
        space: the grid.
        pool: baselines that the decisions compare with, and REDRAW with each other; the campaign's by default.
    """
    return score_of(rulings_of(outcomes), roster, space, pool)


def score_of(rulings: Rulings, roster: Roster, space: Space, pool: Pool | None = None) -> Score:
    """The same of flights that are ruled already."""
    baselines = baseline_pool(rulings.baselines) if pool is None else pool
    rates = PoolRates(baselines)
    ranked = sorted(rulings.mutants.items(), key=lambda mutant: roster.rank(mutant[0].id))
    scored = [mutant_score(subject, situations, space, rates) for subject, situations in ranked]
    mutants = tuple(m for m in scored if m.subject.id != PLACEBO and not roster.is_control(m.subject))
    counted = [mutant for mutant in mutants if roster.counts(mutant.subject) and mutant.flown]
    killed = sum(mutant.killed for mutant in counted)
    eligible = Counter[str]()
    for mutant in counted:
        eligible.update({result.situation: result.eligible for result in mutant.results})
    return Score(
        exercised=Ratio(len(counted), len(roster.defaults)),
        infected=Ratio(sum(mutant.infected for mutant in counted), len(counted)),
        mutation_score=Ratio(killed, sum(mutant.kill_rate.whole > 0 for mutant in counted)),
        strict_score=Ratio(killed, len(counted)),
        decided_score=Ratio(
            sum(bool(mutant.decisions(Decision.KILLED)) for mutant in counted),
            sum(any(result.decided and result.decided.look for result in mutant.results) for mutant in counted),
        ),
        operability=Ratio(
            sum(mutant.operability.part > 0 for mutant in counted),
            sum(mutant.operability.whole > 0 for mutant in counted),
        ),
        mutants=mutants,
        controls=tuple(mutant for mutant in scored if roster.is_control(mutant.subject)),
        placebo=next((mutant for mutant in scored if mutant.subject.id == PLACEBO), None),
        redraw=redraw(baselines),
        eligible=eligible,
    )


def mutant_score(subject: Subject, situations: Situations, space: Space, rates: PoolRates) -> MutantScore:
    """Score one mutant; `rates` are what its decisions compare with."""
    decided = decide(situations, rates)
    # few rulings differ, so they are counted and each looked at once
    counted = {key: Counter([one.ruling for one in situations[key]]) for key in sorted(situations, key=space.rank)}
    every = Counter[Ruling]()
    for rulings in counted.values():
        every.update(rulings)
    results = tuple(_result(key, rulings, decided.get(key)) for key, rulings in counted.items())
    operable = [rulings for rulings in counted.values() if any(r.operability_eligible for r in rulings)]
    inoperable = sum(any(r.operability_eligible and r.operability_kills for r in rulings) for rulings in operable)
    rungs = Counter[Status]()
    for ruling, number in every.items():
        rungs[ruling.status] += number
    requirements = _by_requirement(every, counted.values())
    return MutantScore(
        subject=subject,
        status=mutant_status(every),
        results=results,
        kill_rate=Ratio(sum(r.kills > 0 for r in results), sum(r.eligible > 0 for r in results)),
        kill_rate_flown=Ratio(sum(r.killed for r in results), sum(r.flown > 0 for r in results)),
        requirements=tuple((name, ratio) for name, ratio in requirements if ratio.part),
        tested=tuple(name for name, ratio in requirements if ratio.whole),
        operability=Ratio(inoperable, len(operable)),
        earliest=_earliest(situations, space),
        rungs=tuple((status, rungs[status]) for status in Status if rungs[status]),
        infected=any(ruling.status.infected for ruling in every),
    )


def _result(situation: str, rulings: Counter[Ruling], decided: Decided | None) -> Result:
    valid = [(ruling, number) for ruling, number in rulings.items() if ruling.status is not Status.INVALID]
    eligible = [(ruling.status, number) for ruling, number in valid if ruling.eligible]
    return Result(
        situation=situation,
        status=mutant_status(rulings),
        kills=sum(number for status, number in eligible if status is Status.KILLED),
        eligible=sum(number for _, number in eligible),
        flown=sum(number for _, number in valid),
        killed=any(ruling.status is Status.KILLED for ruling, _ in valid),
        harmless=not any(ruling.status.infected for ruling, _ in valid),
        decided=decided,
    )


def _earliest(situations: Situations, space: Space) -> Kill | None:
    kills = [(one.kill, key, one.seed) for key, flights in situations.items() for one in flights if one.kill]
    if not kills:
        return None
    first_s = min([violation.t_s for violation, _, _ in kills])
    first = [kill for kill in kills if kill[0].t_s == first_s]
    violation, situation, seed = min(first, key=lambda kill: (space.rank(kill[1]), kill[2]))
    position = violation.x, violation.y, violation.z
    return Kill(violation.requirement, first_s, situation, seed, position, violation.struck)


def _by_requirement(every: Iterable[Ruling], situations: Collection[Iterable[Ruling]]) -> tuple[tuple[str, Ratio], ...]:
    """Per requirement: situations it killed in, of those the fault infects and the baseline held it in to its end.

    Args:
        every: ruling, in the order of the flights.
        situations: the rulings in each of them.
    """
    found = []
    for name in dict.fromkeys(name for ruling in every for name in ruling.tested):
        able = [rulings for rulings in ([r for r in rulings if name in r.tested] for rulings in situations) if rulings]
        killed = sum(any(name in r.kills or name in r.operability_kills for r in rulings) for rulings in able)
        found.append((name, Ratio(killed, len(able))))
    return tuple(found)
