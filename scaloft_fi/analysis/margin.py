"""Margins: the smallest magnitude of a fault that is killed, as an interval; and when a fault strikes.

What a ladder, or a search between its rungs, shows of one fault in one situation.
"""

from __future__ import annotations

import math
import statistics
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.survivor import FAILING, PhasedFault, Reaction, Tried, detection_of, steady_of, tried_in
from scaloft_fi.hazop.matrix import Magnitude, Matrix, Worse, neutral, parse, worse
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import apart
from scaloft_fi.marks import About, Bounds
from scaloft_fi.registry import grouped

RELATIVE = 0.1
"""An interval no wider than a tenth of its strong end counts as one number, and is what a search ends at."""


@dataclass(frozen=True)
class Scale:
    """The magnitudes of a fault in the order of their strength.

    Attributes:
        unit: of the magnitudes.
        sign: +1 where larger is worse, -1 where smaller is.
        neutral: the magnitude at which nothing is wrong: it survives without being flown; None where none is known.
    """

    unit: str
    sign: int = 1
    neutral: float | None = None

    @classmethod
    def of(cls, magnitude: Magnitude) -> Scale | None:
        """The scale of a ladder; None where it has no order."""
        direction = worse(magnitude)
        if direction is Worse.UNORDERED:
            return None
        return cls(magnitude.unit, 1 if direction is Worse.LARGER else -1, neutral(magnitude))

    def strength(self, magnitude: float) -> float:
        """Sort key: mild before strong."""
        return self.sign * magnitude

    def close(self, survives: float, kills: float) -> bool:
        """Whether the interval is narrow beside the strong end's distance from no fault at all."""
        size = abs(kills - self.neutral) if self.neutral is not None else abs(kills)
        return math.isfinite(kills) and abs(kills - survives) <= RELATIVE * size * (1 + 1e-9)


Magnitudes = Annotated[float, Bounds(infinite=True)]
"""A magnitude of a fault, in its unit."""


@dataclass(frozen=True)
class Margin:
    """The threshold of a fault in a situation, or the lowest of several.

    Attributes:
        scale: of its magnitudes.
        survives: the strongest magnitude below the others that survives [the fault's unit]; null: none is known.
        kills: the mildest magnitude that is killed [the fault's unit]; null: none is.
        seen: the mildest magnitude, below the killed one, at which most flights violate, with too few to decide [the
            fault's unit]; null: there is none.
        again: magnitudes that survive although a milder one is killed or seen: the response is not monotone.
        tried: every magnitude flown, mild to strong.
        situations: keys of those it holds in.
        shown: whether any magnitude was killed, seen or put to the test; else nothing is known of the threshold.
    """

    scale: Scale
    survives: Magnitudes | None
    kills: Magnitudes | None
    seen: Magnitudes | None = None
    again: tuple[Annotated[Magnitudes, About("a magnitude [the fault's unit]")], ...] = ()
    tried: tuple[Tried, ...] = ()
    situations: tuple[str, ...] = ()
    shown: bool = True

    @property
    def end(self) -> float | None:
        """The mildest magnitude that is killed or seen: what a search takes for the strong end of the interval."""
        return self.kills if self.seen is None else self.seen

    @property
    def known(self) -> bool:
        """Whether the flights bound the threshold from either side."""
        return self.shown and (self.survives is not None or self.end is not None)

    @property
    def monotone(self) -> bool:
        """Whether no magnitude survives where a milder one is killed or seen."""
        return not self.again

    def at(self, magnitude: float | None) -> Tried:
        """What was flown at a magnitude; nothing where it was not."""
        return next((entry for entry in self.tried if entry.magnitude == magnitude), _NOTHING)

    @property
    def strong(self) -> Tried:
        """What was flown at the magnitude that is killed, else at the one that is seen."""
        return self.at(self.seen if self.kills is None else self.kills)


_NOTHING = Tried(math.nan, Reaction.UNTESTED)


def margin_of(scale: Scale, tried: Iterable[Tried], situation: str = "") -> Margin:
    """What the flights of one situation say of the threshold there."""
    entries = sorted(tried, key=lambda entry: scale.strength(entry.magnitude))
    failing = [entry for entry in entries if entry.reaction in FAILING]
    kills = next((entry.magnitude for entry in failing if entry.reaction is Reaction.KILLED), None)
    end = failing[0].magnitude if failing else None
    survived = [entry.magnitude for entry in entries if entry.reaction in (Reaction.SURVIVED, Reaction.HARMLESS)]
    milder = [m for m in survived if end is None or scale.strength(m) < scale.strength(end)]
    return Margin(
        scale,
        survives=milder[-1] if milder else None,
        kills=kills,
        seen=None if end == kills else end,
        again=() if end is None else tuple(m for m in survived if scale.strength(m) > scale.strength(end)),
        tried=tuple(entries),
        situations=(situation,) if situation else (),
        shown=bool(failing) or any(entry.reaction is Reaction.SURVIVED for entry in entries),
    )


def lowest(margins: Iterable[Margin]) -> Margin | None:
    """The margin over several situations: the least magnitude killed in any of them; None where none is known.

    A situation whose threshold lies between `survives` and `kills` bounds the least one from above by `kills`; from
    below it is bounded by the mildest of the survivors.
    """
    known = [margin for margin in margins if margin.known]
    if not known:
        return None
    scale = known[0].scale
    kills = min((m.kills for m in known if m.kills is not None), key=scale.strength, default=None)
    seen = min((m.seen for m in known if m.seen is not None), key=scale.strength, default=None)
    if seen is not None and kills is not None and scale.strength(seen) >= scale.strength(kills):
        seen = None
    floors = [m.survives for m in known if m.survives is not None]
    survives = min(floors, key=scale.strength) if len(floors) == len(known) else None
    again = tuple(sorted({m for margin in known for m in margin.again}, key=scale.strength))
    situations = tuple(key for margin in known for key in margin.situations)
    return Margin(scale, survives, kills, seen, again, situations=situations)


def margins(
    outcomes: Iterable[Outcome], scored: Score, matrix: Matrix, kind: Kind = Kind.SAFETY
) -> Mapping[PhasedFault, tuple[Margin, ...]]:
    """The margins of every fault that has an order, by situation, from stored outcomes alone; as `tried_in`."""
    ladders = ((cell.name, fault.magnitude) for cell in matrix for fault in cell.faults if fault.magnitude)
    scales = {(cell, magnitude.unit): Scale.of(magnitude) for cell, magnitude in ladders}
    by_fault = defaultdict[PhasedFault, list[Margin]](list)
    for (fault, situation), entries in tried_in(outcomes, scored, matrix, kind).items():
        scale = scales.get((fault.cell, fault.unit))
        if scale is not None:
            by_fault[fault].append(margin_of(scale, entries, situation))
    return {fault: tuple(listed) for fault, listed in by_fault.items()}


@dataclass(frozen=True)
class Strike:
    """One phase of a fault.

    Attributes:
        id: id of the mutant.
        phase: as in the id, such as `#5s` or `#sight`; empty for phase 0.
        at_event: whether the phase is an event of the flight, not a time.
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
    lasts = grouped((outcome for outcome in clean if not outcome.invalid), lambda outcome: outcome.situation)
    acts = defaultdict[str, list[float]](list)
    for outcome in flown:
        if not outcome.invalid and outcome.infected_at_s is not None:
            acts[outcome.mutant].append(outcome.infected_at_s)
    by_fault = grouped(scored.mutants, lambda mutant: mutant.subject.id.partition("#")[0])
    several = {fault: sorted(own, key=_order) for fault, own in by_fault.items() if len(own) > 1}
    return tuple(
        When(fault, _median_of(lasts, own), tuple(_strike(mutant, acts[mutant.id], kind) for mutant in own))
        for fault, own in several.items()
    )


def _order(mutant: MutantScore) -> tuple[bool, float, str]:
    name = parse(mutant.subject.id)
    return bool(name.event), name.phase_s, name.event


def _median_of(lasts: Mapping[str, Sequence[Outcome]], listed: Iterable[MutantScore]) -> float:
    keys = {result.situation for mutant in listed for result in mutant.results}
    return statistics.median([outcome.duration_s for key in sorted(keys) for outcome in lasts[key]] or [0.0])


def _strike(mutant: MutantScore, acts_s: list[float], kind: Kind) -> Strike:
    name = parse(mutant.subject.id)
    tested = [result for result in mutant.results if steady_of(result, kind)]
    killed = [r for r in tested if (r.kills if kind is Kind.SAFETY else r.operability_kills)]
    acts = (min(acts_s), statistics.median(acts_s), max(acts_s)) if acts_s else None
    kills, verdict = Ratio(len(killed), len(tested)), detection_of(mutant, kind).verdict
    return Strike(mutant.id, name.phase, bool(name.event), acts, kills, verdict)
