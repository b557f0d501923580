"""A flyer that needs no physics; a module of its own, so that new interpreters can import it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.judge.outcome import BASELINE, Outcome, Violation
from scaloft_fi.judge.requirement import Reading
from scaloft_fi.study import Study


@dataclass
class Paper:
    """A flyer whose verdicts are a rule: controls strike the wall, LATE-human is too fast where a person is."""

    tame: bool = False

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        pass

    def share(self, study: Study, batch: Batch, home: Callable[[Outcome], None]) -> None:
        for flight in batch.flights:
            home(self(study, flight))

    def __call__(self, study: Study, flight: Flight, baseline: Outcome | None = None) -> Outcome:
        subject, key = flight.subject, flight.situation.key
        control = subject.guideword == "REVERSE"
        late = subject.guideword == "LATE" and key.endswith("H1")
        violated = {"SR1": 5.0} if control and not self.tame else {"SR2": 8.0} if late else {}
        altered = 3 if control or late else 0
        readings = tuple(
            Reading(r.name, r.kind, -1.0 if r.name in violated else 1.0, violated.get(r.name), 1, open=False)
            for r in study.requirements
        )
        kinds = {r.name: r.kind for r in study.requirements}
        return Outcome(
            subject,
            key,
            flight.seed,
            ending="landed",
            readings=readings,
            violations=tuple(Violation(name, kinds[name], t, 0.0, 1.0, 1.6, "") for name, t in violated.items()),
            carried=0 if subject.id == BASELINE else 10,
            altered=altered,
            infected_at_s=1.0 if altered else None,
            duration_s=40.0,
            digest=f"{subject.id if altered else ''}{key}{flight.seed}",
            perceived_digest="p",
            realised=tuple((axis.id, True) for axis in study.grid.axes) if subject.id == BASELINE else (),
        )
