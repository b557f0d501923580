"""A sequential run: looks after 3, 5 and 10 seeds; only what a look leaves undecided flies on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.campaign.flights.fly import Flyer
from scaloft_fi.campaign.held.held import current_in
from scaloft_fi.campaign.plan.plan import Flight, Plan, canary_flight, plan
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs.baseline_pool import joined
from scaloft_fi.campaign.runs.crew import Crew, hired
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import Report, write_log
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.scoring.decision import LOOKS, Decision, decisions
from scaloft_fi.results.telling.table import Table
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation

Pair = tuple[Mutant, "Situation"]


@dataclass(frozen=True)
class Look:
    """One look.

    Attributes:
        seeds: how many seeds it looks at.
        pairs: mutants in situations that were flown for it.
        flights: of theirs that it planned.
        decided: how many of the pairs have each decision; those without an eligible flight have none.
    """

    seeds: int
    pairs: int
    flights: int
    decided: Counter[Decision]


def run_looks(
    study: Study,
    question: Plan,
    folder: Path,
    options: RunOptions | None = None,
    *,
    others: Sequence[Outcome] = (),
    progress: Progress,
    flyer: Flyer | None = None,
) -> tuple[Report, tuple[Look, ...]]:
    """Fly whole rounds: all flights of a look are home and decided before the next one is planned.

    The pool of baselines, of all the seeds that looks may need and of `question.pool`, is flown with the first look, so
    that every look compares with the same one.  What is flown thus follows from the outcomes alone: neither the order
    in which they come home nor an interruption changes it.

    Args:
        study: what is flown.
        question: which mutants, in which situations; its seeds are not used.
        folder: of the campaign; made when it does not exist.
        options: how; one process when None.
        others: baselines of another campaign, to decide by.
        progress: what a person sees meanwhile.
        flyer: what flies; PyBullet when None.

    Returns:
        All flights' outcomes; the looks.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped it.
    """
    options = options or RunOptions()
    situations = list(dict.fromkeys(flight.situation for flight in question.baselines))
    mutants = list(dict.fromkeys(f.mutant for f in question.mutants if f.mutant is not None and f.mutant != PLACEBO))
    first = plan(situations, range(LOOKS[0]), mutants, question.canary)
    pool = dict.fromkeys((*plan(situations, range(LOOKS[-1]), [], None).baselines, *question.pool))
    start = (*pool, *first.mutants)
    with hired(study, folder, options, progress=progress, flyer=flyer, first=start) as crew:
        rounds = _Rounds(crew, tuple(pool), others)
        looks = tuple(rounds.looks([(mutant, situation) for mutant in mutants for situation in situations]))
        canary = canary_flight(first, crew.outcomes(first.baselines))
        if canary is not None:
            crew.plan([canary], canary=True)
            crew.fly([canary])
        crew.repeat(first.baselines)
        crew.lookout.close()
        write_log(study, folder, current_in(study, crew.store))
        outcomes = crew.outcomes([*rounds.flights, *([canary] if canary else [])])
        crew.go_on(f"{len(outcomes)} flights are")
        crew.hold_gates(question, outcomes)
    return Report(outcomes, crew.flown), looks


class _Rounds:
    """What was asked for so far.

    Attributes:
        flights: the pool, and those of each look.
    """

    def __init__(self, crew: Crew, pool: Sequence[Flight], others: Sequence[Outcome]) -> None:
        self._crew, self._others = crew, others
        self.flights = list(pool)
        crew.plan(pool)

    def looks(self, pairs: list[Pair]) -> list[Look]:
        """Look by look, until all is decided or the user stops it."""
        found: list[Look] = []
        for number, (before, seeds) in enumerate(zip((0, *LOOKS), LOOKS, strict=False), start=1):
            if not pairs or self._crew.stopped():
                break
            self._crew.lookout.progress.stage = f"look {number} of {len(LOOKS)}"
            situations = dict.fromkeys(situation for _, situation in pairs)
            due = [
                Flight(mutant, situation, seed)
                for mutant, situation in (*((PLACEBO, situation) for situation in situations), *pairs)
                for seed in range(before, seeds)
            ]
            self._crew.plan(due)
            self.flights += due
            self._crew.fly(self.flights)
            outcomes = self._crew.outcomes(self.flights)
            decided = decisions(outcomes, joined(outcomes, self._others))
            said = {pair: decided.get((pair[0].id, pair[1].key)) for pair in pairs}
            counts = Counter(entry.decision for entry in said.values() if entry is not None)
            found.append(Look(seeds, len(pairs), len(due) - len(situations) * (seeds - before), counts))
            pairs = [pair for pair, entry in said.items() if entry and entry.decision is Decision.UNDECIDED]
        return found


def look_table(looks: Sequence[Look]) -> Table:
    """How the looks went."""
    rows = tuple(
        (
            look.seeds,
            look.pairs,
            look.flights,
            *(look.decided[decision] for decision in Decision),
            look.pairs - look.decided.total(),
        )
        for look in looks
    )
    headers = ("seeds", "pairs", "flights", *(decision.value for decision in Decision), "not tested")
    notes = (
        "Pairs: mutants in situations.  Only the undecided fly on; not tested: without an eligible flight.",
        "Flights: of mutants, planned for the look; PLACEBO and baselines fly beside them.",
    )
    return Table("Looks", headers, rows, notes)
