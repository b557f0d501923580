"""The margin search: choose magnitudes, fly them in all situations, and repeat until none is left to choose.

The choice depends on outcomes alone, and every flight has its ordinary key, so an interrupted search continues where it
stopped, and flights of other verbs are not flown again.  Where a magnitude infects, the baseline pool is flown too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from scaloft_fi.analysis.detection import LEAST, Spending
from scaloft_fi.analysis.margin import Margin, Scale, margin_of
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import PhasedFault, Reaction, Tried, phased_fault, tried_in
from scaloft_fi.campaign.flights.fly import Flight, Flyer
from scaloft_fi.campaign.plan import canary, plan
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import ONE_PROCESS, RunOptions
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.campaign.store.archive import STORE_NAME, promising
from scaloft_fi.campaign.store.held import current_in, grown_in
from scaloft_fi.campaign.store.store import read_store
from scaloft_fi.errors import InputError, refused
from scaloft_fi.hazop.matrix import Fault, Matrix, cell_of, mild_to_strong
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import realise, source_of
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import Study

WIDENINGS = 3
"""Greatest number of magnitudes beyond each end of the ladder; each is half or twice the one before.

Far beyond its strong end a fault becomes another fault; far below its mild end it has no effect.
"""
DIGITS = range(3, 7)
"""Significant digits of a magnitude: as few as separate it from its neighbours, at most as many as an id holds."""


@dataclass(frozen=True)
class Search:
    """A margin search.

    Attributes:
        scale: order of the magnitudes.
        ladder: ladder of the study, mild to strong; all of it is flown, to detect a response that is not monotone.
        allowed: whether the operator accepts a magnitude.
        least, most: bounds of the operator in the ladder's unit.
        tolerance: greatest width of the final interval [the ladder's unit]; None = a tenth of its strong end.
    """

    scale: Scale
    ladder: Sequence[float]
    allowed: Callable[[float], bool] = lambda _magnitude: True
    least: float = -math.inf
    most: float = math.inf
    tolerance: float | None = None

    def asks(self, tried: Mapping[float, Tried]) -> tuple[float, ...]:
        """The magnitudes to fly next in a situation with the results `tried`; none when the search is over.

        A magnitude with a violation in most flights counts as killed for the search, even if it is undecided.
        """
        missing = tuple(rung for rung in self.ladder if rung not in tried)
        if missing:
            return missing
        if all(entry.reaction is Reaction.UNTESTED for entry in tried.values()):
            return ()
        margin = margin_of(self.scale, tried.values())
        if margin.end is None:
            candidates = self._stronger(tried) if margin.survives is not None else iter(())
        elif margin.survives is None:
            candidates = self._milder(tried, margin.end)
        elif self._narrow(margin.survives, margin.end):
            return ()
        else:
            candidates = self._between(margin.survives, margin.end)
        return next(((m,) for m in candidates if m not in tried and self._fits(m)), ())

    def _narrow(self, survives: float, end: float) -> bool:
        if self.tolerance is None:
            return self.scale.close(survives, end)
        return abs(end - survives) <= self.tolerance * (1 + 1e-9)

    def _fits(self, magnitude: float) -> bool:
        return math.isfinite(magnitude) and self.allowed(magnitude)

    def _between(self, survives: float, end: float) -> Iterator[float]:
        """The middle of the interval in as few digits as possible; twice the survivor if the end is infinite."""
        middle = survives + (end - survives) / 2
        if math.isinf(end):
            middle = 2 * survives
        low, high = sorted((survives, end))
        # an operator with a whole-number argument accepts only the number rounded down
        rounded = [float(f"{middle:.{digits}g}") for digits in DIGITS] + [float(math.floor(middle))]
        return (m for m in rounded if low < m < high)

    def _stronger(self, tried: Mapping[float, Tried]) -> Iterator[float]:
        """Beyond the strong end: twice the distance from the neutral magnitude, or half where smaller is stronger."""
        end = max(tried, key=self.scale.strength)
        if self._beyond(tried, self.ladder[-1], 1) >= WIDENINGS:
            return iter(())
        if self.scale.sign < 0:
            return iter(_short(max(end / 2, self.least)))
        start = self.scale.neutral or 0.0
        return iter(_short(min(start + 2 * (end - start), self.most)))

    def _milder(self, tried: Mapping[float, Tried], end: float) -> Iterator[float]:
        """Below the mild end: half the distance from the neutral magnitude; twice the magnitude if smaller is worse."""
        if self._beyond(tried, self.ladder[0], -1) >= WIDENINGS:
            return iter(())
        if self.scale.neutral is not None:
            return iter(_short(self.scale.neutral + (end - self.scale.neutral) / 2))
        return iter(_short(max(end / 2, self.least) if self.scale.sign > 0 else min(2 * end, self.most)))

    def _beyond(self, tried: Mapping[float, Tried], end: float, way: int) -> int:
        return sum(way * (self.scale.strength(m) - self.scale.strength(end)) > 0 for m in tried)


def _short(magnitude: float) -> list[float]:
    """The magnitude with three digits, and rounded down for operators with a whole-number argument."""
    if not math.isfinite(magnitude):
        return []
    return [float(f"{magnitude:.3g}"), float(math.floor(magnitude))]


SHARED_FROM = 2
"""Least number of mutants per situation that share a beginning, because sharing flies the baseline once more."""


@dataclass(frozen=True)
class Target:
    """A fault whose margin is searched."""

    subject: PhasedFault
    fault: Fault
    search: Search

    def id_of(self, magnitude: float) -> str:
        """Id of the mutant with a magnitude."""
        assert self.fault.magnitude is not None
        return self.subject.at(self.fault.magnitude.text(magnitude))


def target(matrix: Matrix, text: str, tolerance: float | None = None) -> Target:
    """The fault of a cell name or a mutant id; of the id's magnitude only the unit counts, which selects the fault.

    Raises:
        InputError: there is no such mutant, or its magnitudes have no order.
    """
    mutant = realise(matrix, text)
    fault, _ = source_of(matrix, mutant)
    scale = Scale.of(fault.magnitude) if fault.magnitude else None
    if fault.magnitude is None or scale is None:
        has = "no magnitude" if fault.magnitude is None else "magnitudes without an order"
        raise InputError(f"mutant {text!r} has no margin: {mutant.cell} has {has}; `scaloft-fi run` shows its effect")
    allowed = OPERATORS[fault.operator].arguments[fault.magnitude.argument].allowed
    least, most = sorted(bound / fault.magnitude.scale for bound in (allowed.least, allowed.most))
    subject = phased_fault(mutant.cell, fault, mutant.phase_s, mutant.event)

    def accepted(magnitude: float) -> bool:
        written = fault.magnitude.text(magnitude) if fault.magnitude else ""
        return not refused(realise, matrix, subject.at(written))

    return Target(subject, fault, Search(scale, mild_to_strong(fault.magnitude), accepted, least, most, tolerance))


def find(
    study: Study,
    targets: Sequence[Target],
    situations: Sequence[Situation],
    seeds: Sequence[int],
    folder: Path,
    options: RunOptions = ONE_PROCESS,
    *,
    kind: Kind = Kind.SAFETY,
    progress: Callable[[], Progress],
    flyer: Flyer | None = None,
) -> Mapping[PhasedFault, tuple[Margin, ...]]:
    """Find the margin of each target in each situation; flies the flights that the campaign lacks.

    Args:
        study: the study.
        targets: the faults.
        situations, seeds: situations and seeds of the flights.
        folder: folder of the campaign.
        options: options of the run; the search decides in each round whether flights share a beginning.
        kind: kind of the requirements whose violation kills.
        progress: makes the progress display of a round.
        flyer: flies; PyBullet when None.

    Raises:
        GateError, InputError, Interrupted: as `campaign.runs.run.run`; all outcomes are saved.
    """
    promising(folder)
    known, spending = dict[str, Outcome](), Spending(study.alpha)
    with read_store(folder / STORE_NAME) as store:
        if store is not None:
            known = {outcome.name: outcome for outcome in current_in(study, store)}
            spending = Spending(study.alpha, grown_in(store))
    cells, wanted, pooled = {target.subject.cell for target in targets}, frozenset(seeds), set[Situation]()
    places = {situation.key: situation for situation in situations}
    while True:
        judged = [
            one
            for one in known.values()
            if one.situation in places and (one.mutant == BASELINE or cell_of(one.mutant) in cells)
        ]
        scored = score(judged, study.roster, study.space, spending)
        tried = {  # the magnitudes that were flown with every seed
            place: {entry.magnitude: entry for entry in entries if entry.seeds >= wanted}
            for place, entries in tried_in(known.values(), scored, study.matrix, kind).items()
        }
        asks = [
            (target.id_of(magnitude), situation)
            for target in targets
            for situation in situations
            for magnitude in target.search.asks(tried.get((target.subject, situation.key), {}))
        ]
        mutants = {id_: realise(study.matrix, id_) for id_, _ in asks}
        flights = [Flight(mutants[id_], situation, seed) for id_, situation in asks for seed in seeds]
        # where a target infects and the campaign has no pool
        lacking = [one for one in situations if one.key in scored.lacking and one not in pooled]
        if not (flights or lacking) and any(outcome.mutant == BASELINE for outcome in known.values()):
            break
        pooled.update(lacking)
        shown = progress()
        shown.line(_asked(flights))
        share = options.share and len(flights) >= SHARED_FROM * len({flight.pair for flight in flights})
        planned = plan(situations, seeds, [], canary(study)).with_pool()
        pool = [flight for situation in lacking for flight in planned.pool(situation, LEAST)]
        # with all baselines that the campaign has, so that the gates see every steady pair
        held = [Flight(None, places[one.situation], one.seed) for one in judged if one.mutant == BASELINE]
        planned = replace(
            planned,
            baselines=tuple(dict.fromkeys((*planned.baselines, *held, *pool))),
            mutants=(*planned.mutants, *flights),
            canary=None if planned.canary in mutants.values() else planned.canary,
        )
        report = run(study, planned, folder, replace(options, share=share), progress=shown, flyer=flyer)
        known |= {outcome.name: outcome for outcome in report.outcomes}
        spending = report.spending
    return {
        target.subject: tuple(
            margin_of(target.search.scale, tried.get((target.subject, place.key), {}).values(), place.key)
            for place in situations
        )
        for target in targets
    }


def _asked(flights: Sequence[Flight]) -> str:
    """A line for the user: the flights of a round."""
    ids = list(dict.fromkeys(flight.subject.id for flight in flights))
    if not ids:
        return "next: the baselines"
    named = ", ".join(ids[:6]) + (f" and {len(ids) - 6} more" if len(ids) > 6 else "")
    return f"next: {named} ({len(flights)} flight{'s' * (len(flights) != 1)})"
