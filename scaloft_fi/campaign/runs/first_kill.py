"""Killed or not, with the least flying: rounds of all mutants that are not killed yet, each flight cut at its kill."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from scaloft_fi.campaign.flights.fly import Flyer
from scaloft_fi.campaign.held.held import current_in
from scaloft_fi.campaign.plan.plan import Flight, Plan, canary_flight, subject_of
from scaloft_fi.campaign.plan.task import Task
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs.crew import Crew, hired
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.rounds import Draw, can_kill, ordered
from scaloft_fi.campaign.runs.run import write_log
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.results.flights import baselines_of, flight_of
from scaloft_fi.results.outcome import FIRST_KILL, Outcome
from scaloft_fi.results.scoring.first_kills import Answer, FirstKills, answer
from scaloft_fi.study import Study


def first_kills(
    study: Study,
    planned: Plan,
    folder: Path,
    options: RunOptions | None = None,
    *,
    progress: Progress,
    flyer: Flyer | None = None,
) -> FirstKills:
    """Which mutants of `planned` are killed by a flight whose baseline held a safety requirement to its end.

    The baselines, one PLACEBO and the canary are flown whole and saved as those of any run.  Then comes one round for
    each draw, the likeliest to kill first: all mutants that are not killed yet fly in it, from where they leave its
    baseline to their first kill.  A whole flight in the store answers without flying.  Which flights are flown follows
    from what is in the store and from the outcomes of whole rounds, never from the order in which flights come home.

    Args:
        study: what is flown.
        planned: which flights a whole campaign would have.
        folder: of the campaign; made when it does not exist.
        options: how; one process when None.
        progress: what a person sees meanwhile.
        flyer: what flies; PyBullet when None.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped it.
    """
    options = options or RunOptions()
    with hired(study, folder, options, progress=progress, flyer=flyer, first=planned.baselines) as crew:
        hunt = _Hunt(planned, crew)
        hunt.prepare()
        for number, draw in enumerate(hunt.draws, start=1):
            progress.stage = f"round {number} of {len(hunt.draws)}"
            hunt.fly(draw)
        crew.repeat(planned.baselines)
        crew.lookout.close()
        write_log(study, folder, current_in(study, crew.store))
        found = hunt.found()
        crew.go_on(f"{found.flown} flights are")
        crew.hold_gates(planned, hunt.outcomes)
    return found


class _Hunt:
    """The state of a run between its rounds.

    Attributes:
        draws: in the order of the rounds, once prepared.
    """

    def __init__(self, planned: Plan, crew: Crew) -> None:
        self._planned, self._crew = planned, crew
        listed = dict.fromkeys(flight.mutant for flight in planned.mutants)
        self._mutants = [mutant for mutant in listed if mutant is not None and mutant != PLACEBO]
        self._baselines: dict[Draw, Outcome] = {}
        self._home: dict[str, dict[Draw, Outcome]] = {mutant.id: {} for mutant in self._mutants}
        self._proof: list[Outcome] = []
        self.draws: tuple[Flight, ...] = ()

    def prepare(self) -> None:
        """Fly what is needed anyhow, look up what is known, and decide the order."""
        planned, crew = self._planned, self._crew
        crew.plan(planned.baselines)
        crew.fly(planned.baselines)
        clean = crew.outcomes(planned.baselines)
        self._baselines = baselines_of(clean)
        whole = crew.outcomes(planned.mutants)
        for outcome in whole:
            if outcome.mutant in self._home and not outcome.invalid:
                self._home[outcome.mutant][outcome.situation, outcome.seed] = outcome
        self.draws = ordered(planned.baselines, (*clean, *whole))
        canary = canary_flight(planned, clean)
        for draw in self.draws[:1]:
            self._prove(Flight(PLACEBO, draw.situation, draw.seed), canary=False)
        if canary is not None:
            self._prove(canary, canary=True)
        crew.lookout.expect(flight for draw in self.draws for flight in self._due(draw))

    def fly(self, draw: Flight) -> None:
        """One round: all mutants that are not killed yet and that the draw can tell something about."""
        crew, place, due = self._crew, _place(draw), self._due(draw)
        if not due or crew.stopped():
            return
        baseline = self._baselines[place]

        def cut(flights: Sequence[Flight]) -> list[Task]:
            return [replace(task, baseline=baseline) for task in crew.arrange(flights)]

        crew.plan(due, truncated=FIRST_KILL)
        crew.fly(due, cut, truncated=FIRST_KILL)
        for outcome in crew.outcomes(due, truncated=FIRST_KILL):
            self._home[outcome.mutant][place] = outcome
        killed = [flight.mutant for flight in due if flight.mutant and self._answer(flight.mutant).killed]
        spared = [Flight(mutant, at.situation, at.seed) for mutant in killed for at in self.draws]
        crew.lookout.drop([*due, *spared])

    @property
    def outcomes(self) -> list[Outcome]:
        """All that the gates look at."""
        mutants = [outcome for home in self._home.values() for outcome in home.values()]
        return [*self._baselines.values(), *self._proof, *mutants]

    def found(self) -> FirstKills:
        """What is known now, in the canonical order."""
        rank = self._crew.study.roster.rank
        return FirstKills(
            answers=tuple(self._answer(mutant) for mutant in sorted(self._mutants, key=lambda m: rank(m.id))),
            draws=tuple(map(_place, self.draws)),
            idle=tuple(place for place in map(_place, self.draws) if not self._can_kill(place)),
        )

    def _prove(self, flight: Flight, *, canary: bool) -> None:
        """Fly what the gates ask for, whole."""
        self._crew.plan([flight], canary=canary)
        self._crew.fly([flight])
        self._proof += self._crew.outcomes([flight])

    def _due(self, draw: Flight) -> list[Flight]:
        place = _place(draw)
        return [
            Flight(mutant, draw.situation, draw.seed)
            for mutant in self._mutants
            if self._can_tell(mutant, place) and place not in self._home[mutant.id] and not self._answer(mutant).killed
        ]

    def _answer(self, mutant: Mutant) -> Answer:
        home = self._home[mutant.id]
        places = [place for place in map(_place, self.draws) if self._can_tell(mutant, place)]
        flights = [flight_of(home[place], self._baselines[place]) for place in places if place in home]
        return answer(subject_of(mutant), flights, len(places), control=self._is_control(mutant))

    def _can_tell(self, mutant: Mutant, place: Draw) -> bool:
        """Whether a flight there counts: a control must only show itself, whatever the baseline violates."""
        return self._can_kill(place) or (self._is_control(mutant) and place in self._baselines)

    def _can_kill(self, place: Draw) -> bool:
        return place in self._baselines and can_kill(self._baselines[place])

    def _is_control(self, mutant: Mutant) -> bool:
        return self._crew.study.roster.is_control(subject_of(mutant))


def _place(draw: Flight) -> Draw:
    return draw.situation.key, draw.seed
