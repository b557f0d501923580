"""The search for margins: ask for magnitudes, fly them in all situations at once, ask again until nothing is asked.

What is asked next depends on outcomes alone, and every flight is an ordinary one under an ordinary key; where a
magnitude infects, the baseline pool is flown too.  So a search
that was interrupted goes on where it stopped, and what any other verb has flown is not flown again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from scaloft_fi.analysis.margin import Margin, Scale, margin_of
from scaloft_fi.analysis.scoring.detection import Spending
from scaloft_fi.analysis.scoring.pool import LEAST
from scaloft_fi.analysis.scoring.score import Score, score
from scaloft_fi.analysis.tried import PhasedFault, Tried, phased_fault, tried_in
from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan import choose
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.plan.plan import Plan, plan
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs.bisect import Search
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.campaign.runs.spending import spending_of
from scaloft_fi.campaign.store.folder import STORE_NAME
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.cell import Fault
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.hazop.name import cell_of
from scaloft_fi.hazop.severity import mild_to_severe
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.derive import realise, source_of
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import Study

SHARED_FROM = 2
"""A beginning is shared from this many mutants a situation on: the baseline has to be flown once more for it."""


@dataclass(frozen=True)
class Target:
    """A fault whose margin is asked for."""

    subject: PhasedFault
    fault: Fault
    search: Search

    def id_of(self, magnitude: float) -> str:
        """The mutant at a magnitude."""
        assert self.fault.magnitude is not None
        return self.subject.at(self.fault.magnitude.text(magnitude))


def target(matrix: Matrix, text: str, tolerance: float | None = None) -> Target:
    """The fault that a cell's name or a mutant's id means; the id's magnitude only picks the fault by its unit.

    Raises:
        InputError: there is no such mutant, or its magnitudes have no order.
    """
    mutant = realise(matrix, text)
    fault, _ = source_of(matrix, mutant)
    scale = Scale.of(fault.magnitude) if fault.magnitude else None
    if fault.magnitude is None or scale is None:
        has = "no magnitude" if fault.magnitude is None else "magnitudes without an order"
        raise InputError(f"mutant {text!r} has no margin: {mutant.cell} has {has}; `scaloft-fi run` tells what it does")
    allowed = OPERATORS[fault.operator].arguments[fault.magnitude.argument].allowed
    least, most = sorted(bound / fault.magnitude.scale for bound in (allowed.least, allowed.most))
    subject = phased_fault(mutant.cell, fault, mutant.phase_s)

    def accepted(magnitude: float) -> bool:
        try:
            realise(matrix, subject.at(fault.magnitude.text(magnitude) if fault.magnitude else ""))
        except InputError:
            return False
        return True

    return Target(subject, fault, Search(scale, mild_to_severe(fault.magnitude), accepted, least, most, tolerance))


def find(
    study: Study,
    targets: Sequence[Target],
    situations: Sequence[Situation],
    seeds: Sequence[int],
    folder: Path,
    options: RunOptions | None = None,
    *,
    kind: Kind = Kind.SAFETY,
    progress: Callable[[], Progress],
    flyer: Flyer | None = None,
) -> Mapping[PhasedFault, tuple[Margin, ...]]:
    """The margin of each target in each situation, as finely as is asked; flies what the campaign lacks for it.

    Args:
        study: what is flown.
        targets: the faults.
        situations, seeds: where.
        folder: of the campaign.
        options: how it is flown; what shares a beginning is decided here, round by round.
        kind: of the requirements whose violation kills.
        progress: makes what a person sees of each round.
        flyer: what flies; PyBullet when None.

    Raises:
        GateError, InputError, Interrupted: as `campaign.run.run`; everything flown is saved.
    """
    options = options or RunOptions()
    question = _Question(study, targets, situations, seeds, kind)
    outcomes, spending = _held(study, folder)
    known = {outcome.name: outcome for outcome in outcomes}
    pooled: set[Situation] = set()
    while True:
        scored = question.score(known.values(), spending)
        flights = question.next(known.values(), scored)
        lacking = [situation for situation in question.lacking(scored) if situation not in pooled]
        if not (flights or lacking) and any(outcome.mutant == BASELINE for outcome in known.values()):
            break
        pooled.update(lacking)
        shown = progress()
        shown.line(_asked(flights))
        share = options.share and len(flights) >= SHARED_FROM * len({(f.situation.key, f.seed) for f in flights})
        planned = question.plan(flights, lacking, known.values())
        report = run(study, planned, folder, replace(options, share=share), progress=shown, flyer=flyer)
        known |= {outcome.name: outcome for outcome in report.outcomes}
        spending = report.spending
    return question.margins(known.values(), question.score(known.values(), spending))


def _held(study: Study, folder: Path) -> tuple[tuple[Outcome, ...], Spending]:
    """What the campaign, which need not exist, holds already, and how it spends alpha."""
    if not (folder / STORE_NAME).is_file():
        return (), Spending(study.alpha)
    with Store(folder / STORE_NAME, create=False) as store:
        return current_in(study, store), spending_of(study, store)


@dataclass(frozen=True)
class _Question:
    """Which margins are asked for, where, and by requirements of which kind; all answers follow from outcomes."""

    study: Study
    targets: Sequence[Target]
    situations: Sequence[Situation]
    seeds: Sequence[int]
    kind: Kind

    def score(self, outcomes: Iterable[Outcome], spending: Spending) -> Score:
        """The score of the cells asked about, over every situation and seed that the campaign has."""
        cells = {target.subject.cell for target in self.targets}
        asked = [outcome for outcome in outcomes if outcome.mutant == BASELINE or cell_of(outcome.mutant) in cells]
        return score(asked, self.study.roster, self.study.space, spending)

    def next(self, outcomes: Iterable[Outcome], scored: Score) -> tuple[Flight, ...]:
        """The flights that every target asks for in every situation."""
        tried = self._tried(outcomes, scored)
        asked = [
            (target.id_of(magnitude), situation)
            for target in self.targets
            for situation in self.situations
            for magnitude in target.search.asks(tried.get((target.subject, situation.key), {}))
        ]
        mutants = {id_: realise(self.study.matrix, id_) for id_, _ in asked}
        return tuple(Flight(mutants[id_], situation, seed) for id_, situation in asked for seed in self.seeds)

    def lacking(self, scored: Score) -> list[Situation]:
        """The situations where a fault asked about infects and the campaign has no pool."""
        return [situation for situation in self.situations if situation.key in scored.lacking]

    def plan(self, flights: Sequence[Flight], lacking: Sequence[Situation], outcomes: Iterable[Outcome]) -> Plan:
        """The plan of a round: what every run flies, the flights asked for, and the pool as far as it is known.

        The gates see all baselines that the campaign has of these situations: what is steady in one that this round
        leaves alone is steady all the same.
        """
        planned = plan(self.situations, self.seeds, [], choose.canary(self.study)).with_pool()
        places = {situation.key: situation for situation in self.situations}
        held = [
            Flight(None, places[outcome.situation], outcome.seed)
            for outcome in outcomes
            if outcome.mutant == BASELINE and outcome.situation in places
        ]
        pool = [flight for situation in lacking for flight in planned.pool(situation, LEAST)]
        canary = None if planned.canary in {flight.mutant for flight in flights} else planned.canary
        return replace(
            planned,
            baselines=tuple(dict.fromkeys((*planned.baselines, *held, *pool))),
            mutants=(*planned.mutants, *flights),
            canary=canary,
        )

    def margins(self, outcomes: Iterable[Outcome], scored: Score) -> Mapping[PhasedFault, tuple[Margin, ...]]:
        """The margin of each target in each situation."""
        tried = self._tried(outcomes, scored)
        return {
            target.subject: tuple(
                margin_of(target.search.scale, tried.get((target.subject, place.key), {}).values(), place.key)
                for place in self.situations
            )
            for target in self.targets
        }

    def _tried(
        self, outcomes: Iterable[Outcome], scored: Score
    ) -> Mapping[tuple[PhasedFault, str], dict[float, Tried]]:
        """What counts as tried: flown with every seed asked for."""
        wanted = frozenset(self.seeds)
        return {
            key: {entry.magnitude: entry for entry in entries if entry.seeds >= wanted}
            for key, entries in tried_in(outcomes, scored, self.study.matrix, self.kind).items()
        }


def _asked(flights: Sequence[Flight]) -> str:
    """What a round flies, in a line."""
    ids = list(dict.fromkeys(flight.subject.id for flight in flights))
    if not ids:
        return "next: the baselines"
    named = ", ".join(ids[:6]) + (f" and {len(ids) - 6} more" if len(ids) > 6 else "")
    return f"next: {named} ({len(flights)} flight{'s' * (len(flights) != 1)})"
