"""The search for situations that break the unmutated drone, each in a way of its own.

Each safety requirement has turns, in which its robustness guides TPE.  What is found repels the search: a situation
with a known signature counts as far from breaking.  Half of each generation is drawn at random, because what is new
need not lie where the robustness is small.  All else is as in the search for mutants: everything follows from the seed
and the outcomes, and a budget decides only how far it goes.

Outcomes do not keep what a stack believed; so a flight whose signature is asked for is flown once more and listened to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from scaloft_fi.analysis.detection import LEAST
from scaloft_fi.analysis.seeking import REJECTED, WORST, Breach, Signature, breaches, breaking, shrunk
from scaloft_fi.campaign.flights.fly import Flight, Flyer
from scaloft_fi.campaign.processes import ProcessPool
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import ONE_PROCESS, RunOptions
from scaloft_fi.campaign.runs.run import Run
from scaloft_fi.campaign.seeking import finds
from scaloft_fi.campaign.seeking.seek import GENERATION, OPENING, Proposal, Proposals, draws, flyable
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import BASELINE, Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.sim.grid import Break
from scaloft_fi.sim.stacks import claims_of
from scaloft_fi.stack.declaration import TICK_HZ, PlainWire
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation


ALIKE = 3
"""Of the flights with fresh seeds at least so many must have the signature of a find."""


S = TypeVar("S")

Told = tuple[Breach, ...]
Recall = Callable[["Study", Flight, Sequence[Violation]], Told]
"""Flies a baseline again, and tells what its violations of safety requirements say."""
_Task = tuple[Flight, Sequence[Violation]]


class ListeningWire(PlainWire):
    """Delivers every sample unchanged, and keeps those of some seams.

    Attributes:
        kept: time [s] and sample of each delivery, by seam.
    """

    def __init__(self, seams: Iterable[str]) -> None:
        self.kept: dict[str, list[tuple[float, Any]]] = {seam: [] for seam in seams}

    def listens(self, seam: str) -> bool:
        """Whether the samples of `seam` are kept."""
        return seam in self.kept

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample`."""
        if sample is not None and seam in self.kept:
            self.kept[seam].append((t_s, sample))
        return sample


def recalled(study: Study, flown: Flight, violations: Sequence[Violation]) -> Told:
    """What the violations of a baseline say, the earliest first; it is flown up to the last of them.

    Raises:
        ScaloftError: the flight cannot be flown, or a claim of the stack fails.
    """
    from scaloft_fi.sim import build, flight

    claims = claims_of(study.stack, study.signals)
    wire = ListeningWire(claim.seam for claim in claims if claim.seam)
    scenario = study.scenario(flown.situation)
    ticks = round(TICK_HZ * max(violation.t_s for violation in violations))
    with build.physics_server() as client:
        loop = flight.FlightLoop(client, study.sim, scenario, flown.seed, wire)
        while loop.ticks <= ticks and loop.tick():
            loop.advance()
        return breaches(loop.log(), violations, study.requirements, scenario.world, claims, wire.kept)


def _recall(study: Study, recall: Recall, task: _Task, report: Callable[[tuple[str, Told]], None]) -> None:
    """The work of a process: raises what is the user's to mend, never for a failure of the harness."""
    flight, violations = task
    try:
        told = recall(study, flight, violations)
    except ScaloftError:
        raise
    except Exception:  # noqa: BLE001 - as for a flight that is invalid: it says nothing
        told = ()
    report((flight.name, told))


def seek_breaks(
    study: Study,
    folder: Path,
    options: RunOptions = ONE_PROCESS,
    *,
    seed: int,
    allowance: finds.Allowance,
    progress: Progress,
    save: Callable[[Sequence[Break]], None],
    flyer: Flyer | None = None,
    recall: Recall | None = None,
) -> finds.SeekReport:
    """Search for situations in which the unmutated drone violates a safety requirement, each in another way.

    Args:
        study: the study, with the grid that is searched.
        folder: folder of the campaign that holds the flights of the search.
        options: options of the run.
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
    possible = partial(flyable, study)
    safety = [one.name for one in study.requirements if one.kind is Kind.SAFETY]
    proposals = {name: Proposals(study.grid, possible, seed, f"{BASELINE} {name}") for name in safety}
    drawn = draws(study.grid, seed, possible)
    first = list(islice(drawn, OPENING))
    begun = [Flight(None, one.situation, finds.SEEN_ON[0]) for one in first[:1]]
    with finds.searching(study, folder, options, progress=progress, flyer=flyer, first=begun) as campaign:
        flights, spent = finds.SearchFlights(campaign, allowance), False
        search = _Search(campaign, proposals, recall or recalled, seed, flights, save)
        try:
            search.begin(first)
            search.turns(drawn)
        except finds.SpentError:
            spent = True
        return search.report(spent=spent)


@dataclass
class _Search:
    """A search so far.

    Attributes:
        campaign, proposals, recall, seed, flights, save: what it searches with.
        told: how flights that were flown again violate the safety requirements; nothing where the harness failed.
        breaks: what was found.
        rejected: what fresh seeds did not confirm.
        turn, candidates: how many so far.
    """

    campaign: Run
    proposals: Mapping[str, Proposals]
    recall: Recall
    seed: int
    flights: finds.SearchFlights
    save: Callable[[Sequence[Break]], None]
    breaks: dict[Signature, Break] = field(default_factory=dict)
    rejected: set[tuple[Situation, Signature]] = field(default_factory=set)
    told: dict[str, Told] = field(default_factory=dict)
    turn: int = 0
    candidates: int = 0

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

        def turn(number: int) -> None:
            self.turn = number
            for guide in self.proposals.values():
                self._tell_stage()
                half = GENERATION // 2
                asked = {one.situation: one for one in (*islice(drawn, half), *guide.ask(half))}
                self._generation(tuple(asked.values()))

        self.flights.take_turns(turn)

    def report(self, *, spent: bool) -> finds.SeekReport:
        """What the search came to."""
        situations = next(iter(self.proposals.values())).situations  # each guide is told of all
        return finds.SeekReport(
            breaks=tuple(self.breaks.values()),
            situations=len(situations),
            broken=sum(bool(self._violations(one)) for one in situations),
            candidates=self.candidates,
            used=self.flights.used,
            flown=self.campaign.flown,
            again=len(self.told),
            spent=spent,
            needed=self.flights.needed,
        )

    def _tell_stage(self) -> None:
        breaks = f"{len(self.breaks)} {'break' if len(self.breaks) == 1 else 'breaks'}"
        self.campaign.reporter.progress.stage = f"turn {self.turn}: {breaks}"

    def _generation(self, proposed: Sequence[Proposal]) -> None:
        """Fly situations, and pursue each violation that is new."""
        situations = [one.situation for one in proposed]
        self.flights.fly(Flight(None, one, finds.SEEN_ON[0]) for one in situations)
        broken = [one for one in situations if self._violations(one)]
        self._look(broken)
        for situation in broken:
            for breach in self._told(situation):
                if breach.signature not in self.breaks and (situation, breach.signature) not in self.rejected:
                    self._pursue(situation, breach.signature)
        for requirement, guide in self.proposals.items():
            guide.tell([(one, self._distance(one.situation, requirement)) for one in proposed])

    def _distance(self, situation: Situation, requirement: str) -> float:
        """How far a flown situation is from breaking a requirement in a new way."""
        if requirement not in self._violated(situation, finds.SEEN_ON[0]):
            return breaking(self._outcome(situation, finds.SEEN_ON[0]), requirement)
        told = [breach.signature for breach in self._told(situation) if requirement in breach.requirements]
        return WORST if any(one in self.breaks for one in told) else REJECTED

    def _pursue(self, situation: Situation, signature: Signature) -> None:
        """Record the situation, shrunk if that is confirmed too; reject it where nothing is confirmed."""

        def shows(asked: Sequence[Situation], every: bool) -> list[bool]:
            return self._shows(asked, signature, every=every)

        found = None
        if all(shows([situation], True)):
            for one in dict.fromkeys((shrunk(situation, self.campaign.study.grid, shows), situation)):
                found = found or self._confirmed(one, signature)
        if found is None:
            self.rejected.add((situation, signature))
            return
        self.breaks[signature] = found
        self.save(tuple(self.breaks.values()))
        self._tell_stage()
        words = ", ".join(found.words) or "the benign situation"
        self.campaign.reporter.progress.line(f"found: {found.name}: {found.situation} ({words})")

    def _shows(self, asked: Sequence[Situation], signature: Signature, *, every: bool) -> list[bool]:
        """Whether the first flight in each situation violates the requirement and strikes what the signature says.

        With `every` seed of the search all flights must violate the requirement; the first must have the signature.
        """
        seeds = finds.SEEN_ON if every else finds.SEEN_ON[:1]
        self.flights.fly(Flight(None, one, seed) for one in asked for seed in seeds)
        near = [
            self._strikes(one, finds.SEEN_ON[0], signature)
            and all(signature.requirement in self._violated(one, seed) for seed in seeds)
            for one in asked
        ]
        if not every:
            return near
        self._look([one for one, good in zip(asked, near, strict=True) if good])
        return [
            good and self._breach(one, finds.SEEN_ON[0], signature) is not None
            for one, good in zip(asked, near, strict=True)
        ]

    def _confirmed(self, situation: Situation, signature: Signature) -> Break | None:
        """The situation with what fresh seeds say of it.

        None where most of them do not violate the requirement, or fewer than `ALIKE` have the signature.
        """
        self.flights.fly(Flight(None, situation, seed) for seed in range(LEAST))
        self.candidates += 1
        outcomes = [self._outcome(situation, seed) for seed in range(LEAST)]
        flights = sum(outcome is not None and not outcome.invalid for outcome in outcomes)
        violated = sum(signature.requirement in self._violated(situation, seed) for seed in range(LEAST))
        strike = [seed for seed in range(LEAST) if self._strikes(situation, seed, signature)]
        if flights < LEAST or 2 * violated <= flights or len(strike) < ALIKE:
            return None
        self._look([situation], strike)
        alike = [(seed, breach) for seed in strike if (breach := self._breach(situation, seed, signature))]
        if len(alike) < ALIKE:
            return None
        flight, breach = alike[0]
        return Break(
            name=signature.name,
            situation=situation.key,
            words=finds.words_of(situation, self.campaign.study.grid),
            **asdict(signature),
            error=breach.error,
            unit=breach.unit,
            violated=violated,
            flights=flights,
            alike=len(alike),
            flight=flight,
            t_s=breach.t_s,
            place=breach.place,
            seed=self.seed,
        )

    def _look(self, situations: Sequence[Situation], seeds: Sequence[int] = finds.SEEN_ON[:1]) -> None:
        """Fly flights that violate a safety requirement again, to see what the drone believed.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        flights = {Flight(None, one, seed): self._violations(one, seed) for one in situations for seed in seeds}
        new = [(flight, violations) for flight, violations in flights.items() if flight.name not in self.told]
        self.flights.spend(len(new))
        if new:
            self.campaign.prepare()
            # the processes end here: if they lived on, they would hold on to the ends of others, and others to theirs
            with ProcessPool(
                partial(_recall, self.campaign.study, self.recall),
                min(self.campaign.options.jobs, len(new)),
                left=lambda task, _: task,
                lost=lambda task, _: [(task[0].name, ())],
                stop=self.campaign.stopped,
                patient=False,
            ) as pool:
                self.told |= dict(pool.map(new))
        self.flights.raise_if_stopped()

    def _told(self, situation: Situation, seed: int = finds.SEEN_ON[0]) -> tuple[Breach, ...]:
        return self.told.get(Flight(None, situation, seed).name, ())

    def _breach(self, situation: Situation, seed: int, signature: Signature) -> Breach | None:
        """The violation with this signature; None without one."""
        return next((one for one in self._told(situation, seed) if one.signature == signature), None)

    def _outcome(self, situation: Situation, seed: int) -> Outcome | None:
        return self.flights.outcome(Flight(None, situation, seed))

    def _violations(self, situation: Situation, seed: int = finds.SEEN_ON[0]) -> tuple[Violation, ...]:
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
