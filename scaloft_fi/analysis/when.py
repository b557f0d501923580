"""When a fault strikes: what each of its phases, times and events of the flight, shows in stored outcomes."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.scoring.detection import Verdict
from scaloft_fi.analysis.scoring.mutant_score import MutantScore
from scaloft_fi.analysis.scoring.score import Score
from scaloft_fi.analysis.tried import detection_of, steady_of
from scaloft_fi.hazop.name import parse
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import apart


@dataclass(frozen=True)
class Strike:
    """One phase of a fault.

    Attributes:
        id: of the mutant.
        phase: as in the id, such as `#5s` or `#sight`; empty for phase 0.
        at_event: whether the phase is an event of the flight.
        acts_s: first, median and last time of the first altered sample over all flights [s]; None where none has one.
        kills: situations with a kill, of those that put it to the test.
        verdict: on the mutant.
    """

    id: str
    phase: str
    at_event: bool
    acts_s: tuple[float, float, float] | None
    kills: Ratio
    verdict: Verdict


@dataclass(frozen=True)
class When:
    """A fault at one magnitude, at each phase that was flown: times in order, then events.

    Attributes:
        fault: id without a phase.
        lasts_s: median duration of the baselines in the situations flown [s].
        strikes: at least two phases.
    """

    fault: str
    lasts_s: float
    strikes: tuple[Strike, ...]

    def told(self, *, at_events: bool) -> tuple[Strike, ...]:
        """The strikes at events, or those at times."""
        return tuple(strike for strike in self.strikes if strike.at_event == at_events)


def whens(outcomes: Iterable[Outcome], scored: Score, kind: Kind = Kind.SAFETY) -> tuple[When, ...]:
    """Every fault that was flown at two phases or more, magnitude by magnitude.

    Args:
        outcomes: of a campaign.
        scored: their score, in whose order of mutants the faults stand.
        kind: of the requirements whose violation kills.
    """
    clean, flown = apart(outcomes)
    lasts, acts = defaultdict[str, list[float]](list), defaultdict[str, list[float]](list)
    for outcome in clean:
        if not outcome.invalid:
            lasts[outcome.situation].append(outcome.duration_s)
    for outcome in flown:
        if not outcome.invalid and outcome.infected_at_s is not None:
            acts[outcome.mutant].append(outcome.infected_at_s)
    by_fault = defaultdict[str, list[MutantScore]](list)
    for mutant in scored.mutants:
        by_fault[mutant.subject.id.partition("#")[0]].append(mutant)
    return tuple(
        When(
            fault, _median_of(lasts, listed), tuple(_strike(mutant, acts[mutant.subject.id], kind) for mutant in listed)
        )
        for fault, own in by_fault.items()
        if len(listed := sorted(own, key=_order)) > 1
    )


def _order(mutant: MutantScore) -> tuple[bool, float, str]:
    name = parse(mutant.subject.id)
    return bool(name.event), name.phase_s, name.event


def _median_of(lasts: dict[str, list[float]], listed: Iterable[MutantScore]) -> float:
    keys = {result.situation for mutant in listed for result in mutant.results}
    return statistics.median([duration_s for key in sorted(keys) for duration_s in lasts[key]] or [0.0])


def _strike(mutant: MutantScore, acts_s: list[float], kind: Kind) -> Strike:
    name = parse(mutant.subject.id)
    tested = [result for result in mutant.results if steady_of(result, kind)]
    killed = [r for r in tested if (r.kills if kind is Kind.SAFETY else r.operability_kills)]
    return Strike(
        mutant.subject.id,
        name.phase,
        bool(name.event),
        (min(acts_s), statistics.median(acts_s), max(acts_s)) if acts_s else None,
        Ratio(len(killed), len(tested)),
        detection_of(mutant, kind).verdict,
    )
