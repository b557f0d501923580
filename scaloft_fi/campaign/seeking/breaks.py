"""The search for situations that break the unmutated drone, each in a way of its own.

Each safety requirement has turns, in which its robustness guides TPE.  What is found repels the search: a situation
with a known signature counts as far from breaking.  Half of each generation is drawn at random, because what is new
need not lie where the robustness is small.  All else is as in the search for mutants: everything follows from the seed
and the outcomes, and a budget decides only how far it goes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.analysis.seeking import REJECTED, WORST, Breach, Signature, breaking, shrunk
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.flights.fly import Flyer
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.run import Run, opened, write_log
from scaloft_fi.campaign.seeking.finds import (
    SEEN_ON,
    Allowance,
    Recall,
    Recalls,
    SearchFlights,
    SeekReport,
    SpentError,
    recalled,
    words_of,
)
from scaloft_fi.campaign.seeking.proposals import OPENING, Flyable, Proposal, Proposals, draws
from scaloft_fi.campaign.seeking.seek import GENERATION
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.judge.outcome import BASELINE, Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.sim.found import Break
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation


IDLE = 20
"""Turns without a new situation, after which a search without a budget ends."""

ALIKE = 3
"""Of the flights with fresh seeds at least so many must have the signature of a find."""


def seek_breaks(
    study: Study,
    folder: Path,
    options: RunOptions | None = None,
    *,
    seed: int,
    allowance: Allowance,
    progress: Progress,
    save: Callable[[Sequence[Break]], None],
    flyer: Flyer | None = None,
    recall: Recall | None = None,
) -> SeekReport:
    """Search for situations in which the unmutated drone violates a safety requirement, each in another way.

    Args:
        study: the study, with the grid that is searched.
        folder: folder of the campaign that holds the flights of the search.
        options: options of the run; one process when None.
        seed: seed of the search.
        allowance: the budget.
        progress: progress display.
        save: called with all that was found after each find.
        flyer: flies; PyBullet when None.
        recall: flies a flight again and tells how it violates the requirements; in PyBullet when None.

    Raises:
        InputError: Optuna is missing, the folder or the store cannot be written, or the study cannot be flown.
        Interrupted: the user stopped the search; all outcomes and finds are saved.
        ScaloftError: a claim of the stack fails.
    """
    possible = Flyable(study)
    safety = [one.name for one in study.requirements if one.kind is Kind.SAFETY]
    proposals = {name: Proposals(study.grid, possible, seed, f"{BASELINE} {name}") for name in safety}
    drawn = draws(study.grid, seed, possible)
    first = list(islice(drawn, OPENING))
    begun = [Flight(None, one.situation, SEEN_ON[0]) for one in first[:1]]
    with opened(study, folder, options or RunOptions(), progress=progress, flyer=flyer, first=begun) as campaign:
        search = _Search(
            campaign, proposals, Recalls(campaign, recall or recalled), seed, SearchFlights(campaign, allowance), save
        )
        spent = False
        try:
            search.begin(first)
            search.turns(drawn)
        except SpentError:
            spent = True
        finally:
            campaign.reporter.close()
            write_log(study, folder, current_in(study, campaign.store))
        return search.report(spent=spent)


class _Search:
    """A search so far."""

    def __init__(
        self,
        campaign: Run,
        proposals: Mapping[str, Proposals],
        recalls: Recalls,
        seed: int,
        flights: SearchFlights,
        save: Callable[[Sequence[Break]], None],
    ) -> None:
        self._campaign, self._grid = campaign, campaign.study.grid
        self._proposals, self._recalls, self._flights = proposals, recalls, flights
        self._seed, self._save = seed, save
        self._breaks: dict[Signature, Break] = {}
        self._rejected: set[tuple[Situation, Signature]] = set()
        self._turn = self._candidates = 0

    def begin(self, first: Sequence[Proposal]) -> None:
        """Fly the first situations.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        for begin in range(0, len(first), GENERATION):
            self._tell_stage()
            self._generation(first[begin : begin + GENERATION])

    def turns(self, drawn: Iterator[Proposal]) -> None:
        """Give each requirement a generation, again and again, until none brings a new situation.

        Half of each generation is drawn: a way that no robustness leads to is found by chance.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        idle = 0
        while idle < IDLE:
            self._turn += 1
            before = self._flights.used
            for guide in self._proposals.values():
                self._tell_stage()
                half = GENERATION // 2
                asked = {one.situation: one for one in (*islice(drawn, half), *guide.ask(half))}
                self._generation(tuple(asked.values()))
            idle = idle + 1 if self._flights.used == before else 0

    def report(self, *, spent: bool) -> SeekReport:
        """What the search came to."""
        situations = next(iter(self._proposals.values())).situations  # each guide is told of all
        return SeekReport(
            breaks=tuple(self._breaks.values()),
            situations=len(situations),
            broken=sum(bool(self._violations(one)) for one in situations),
            candidates=self._candidates,
            used=self._flights.used,
            flown=self._campaign.flown,
            again=self._recalls.count,
            spent=spent,
        )

    def _tell_stage(self) -> None:
        breaks = f"{len(self._breaks)} {'break' if len(self._breaks) == 1 else 'breaks'}"
        self._campaign.reporter.progress.stage = f"turn {self._turn}: {breaks}"

    def _generation(self, proposed: Sequence[Proposal]) -> None:
        """Fly situations, and pursue each violation that is new."""
        situations = [one.situation for one in proposed]
        self._flights.fly(Flight(None, one, SEEN_ON[0]) for one in situations)
        broken = [one for one in situations if self._violations(one)]
        self._look(broken)
        for situation in broken:
            for breach in self._told(situation):
                if breach.signature not in self._breaks and (situation, breach.signature) not in self._rejected:
                    self._pursue(situation, breach.signature)
        for requirement, guide in self._proposals.items():
            guide.tell([(one, self._distance(one.situation, requirement)) for one in proposed])

    def _distance(self, situation: Situation, requirement: str) -> float:
        """How far a flown situation is from breaking a requirement in a new way."""
        if requirement not in self._violated(situation, SEEN_ON[0]):
            return breaking(self._outcome(situation, SEEN_ON[0]), requirement)
        told = [breach.signature for breach in self._told(situation) if requirement in breach.requirements]
        return WORST if any(one in self._breaks for one in told) else REJECTED

    def _pursue(self, situation: Situation, signature: Signature) -> None:
        """Record the situation, shrunk if that is confirmed too; reject it where nothing is confirmed."""

        def shows(asked: Sequence[Situation], every: bool) -> list[bool]:
            return self._shows(asked, signature, every=every)

        found = None
        if all(shows([situation], True)):
            for one in dict.fromkeys((shrunk(situation, self._grid, shows), situation)):
                found = found or self._confirmed(one, signature)
        if found is None:
            self._rejected.add((situation, signature))
            return
        self._breaks[signature] = found
        self._save(tuple(self._breaks.values()))
        self._tell_stage()
        words = ", ".join(found.words) or "the benign situation"
        self._campaign.reporter.progress.line(f"found: {found.name}: {found.situation} ({words})")

    def _shows(self, asked: Sequence[Situation], signature: Signature, *, every: bool) -> list[bool]:
        """Whether the first flight in each situation violates the requirement and strikes what the signature says.

        With `every` seed of the search all flights must violate the requirement; the first must have the signature.
        """
        seeds = SEEN_ON if every else SEEN_ON[:1]
        self._flights.fly(Flight(None, one, seed) for one in asked for seed in seeds)
        near = [
            self._strikes(one, SEEN_ON[0], signature)
            and all(signature.requirement in self._violated(one, seed) for seed in seeds)
            for one in asked
        ]
        if not every:
            return near
        self._look([one for one, good in zip(asked, near, strict=True) if good])
        return [
            good and self._breach(one, SEEN_ON[0], signature) is not None for one, good in zip(asked, near, strict=True)
        ]

    def _confirmed(self, situation: Situation, signature: Signature) -> Break | None:
        """The situation with what fresh seeds say of it.

        None where most of them do not violate the requirement, or fewer than `ALIKE` have the signature.
        """
        self._candidates += 1
        self._flights.fly(Flight(None, situation, seed) for seed in range(LEAST))
        outcomes = [self._outcome(situation, seed) for seed in range(LEAST)]
        flights = sum(outcome is not None and not outcome.invalid for outcome in outcomes)
        violated = sum(signature.requirement in self._violated(situation, seed) for seed in range(LEAST))
        strike = [seed for seed in range(LEAST) if self._strikes(situation, seed, signature)]
        if flights < LEAST or 2 * violated <= flights or len(strike) < ALIKE:
            return None
        self._look([situation], strike)
        alike = [(seed, breach) for seed in strike if (breach := self._breach(situation, seed, signature))]
        return self._break(situation, *alike[0], (violated, flights, len(alike))) if len(alike) >= ALIKE else None

    def _break(self, situation: Situation, flight: int, breach: Breach, counts: tuple[int, int, int]) -> Break:
        signature = breach.signature
        violated, flights, alike = counts
        return Break(
            name=signature.name,
            situation=situation.key,
            words=words_of(situation, self._grid),
            requirement=signature.requirement,
            struck=signature.struck,
            leg=signature.leg,
            near=signature.near,
            belief=signature.belief,
            error=breach.error,
            unit=breach.unit,
            violated=violated,
            flights=flights,
            alike=alike,
            flight=flight,
            t_s=breach.t_s,
            place=breach.place,
            seed=self._seed,
        )

    def _look(self, situations: Sequence[Situation], seeds: Sequence[int] = SEEN_ON[:1]) -> None:
        """Fly flights that violate a safety requirement again, to see what the drone believed.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        violations = {Flight(None, one, seed): self._violations(one, seed) for one in situations for seed in seeds}
        self._flights.spend(len(self._recalls.unknown(tuple(violations))))
        self._recalls.look(violations)
        self._flights.raise_if_stopped()

    def _told(self, situation: Situation, seed: int = SEEN_ON[0]) -> tuple[Breach, ...]:
        return self._recalls.of(Flight(None, situation, seed))

    def _breach(self, situation: Situation, seed: int, signature: Signature) -> Breach | None:
        """The violation with this signature; None without one."""
        return next((one for one in self._told(situation, seed) if one.signature == signature), None)

    def _outcome(self, situation: Situation, seed: int) -> Outcome | None:
        return self._flights.outcome(Flight(None, situation, seed))

    def _violations(self, situation: Situation, seed: int = SEEN_ON[0]) -> tuple[Violation, ...]:
        """How a flight violates the safety requirements."""
        outcome = self._outcome(situation, seed)
        violations = outcome.violations if outcome is not None else ()
        return tuple(violation for violation in violations if violation.kind is Kind.SAFETY)

    def _violated(self, situation: Situation, seed: int) -> Mapping[str, str]:
        """What a flight strikes when it violates a safety requirement, by requirement."""
        return {violation.requirement: violation.struck for violation in self._violations(situation, seed)}

    def _strikes(self, situation: Situation, seed: int, signature: Signature) -> bool:
        """Whether a flight violates the requirement of a signature and strikes the same then."""
        return self._violated(situation, seed).get(signature.requirement) == signature.struck
