"""Flights by rule, and a flyer that needs no physics; a module of its own, so that new interpreters can import it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from scaloft_fi.campaign.flights.fly import Batch, Flight
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.study import Study


def made(
    subject: Subject,
    situation: str,
    seed: int,
    kinds: Mapping[str, Kind],
    violated: Mapping[str, float],
    *,
    rho: tuple[float, float] = (-1.0, 1.0),
    idle: Collection[str] = (),
    place: tuple[float, float, float] = (0.0, 1.0, 1.6),
    struck: str = "",
    **more: Any,
) -> Outcome:
    """A flight that violates these requirements at these times; rho: of what it violates, and of what it holds.

    The requirements of `idle` are not put to the test; what strikes something is cut short, and leaves the others open.
    """
    readings = (
        Reading(
            *(name, kind, rho[name not in violated], violated.get(name), int(name in violated or name not in idle)),
            open=bool(struck) and name not in violated,
        )
        for name, kind in kinds.items()
    )
    end_s = min(violated.values(), default=0.0)
    violations = (
        Violation(name, kinds[name], t_s, *place, struck if t_s == end_s else "") for name, t_s in violated.items()
    )
    made = {"ending": "struck" if struck else "landed", "struck": struck}
    return Outcome(subject, situation, seed, readings=tuple(readings), violations=tuple(violations), **{**made, **more})


class Whole:
    """A flyer that flies each flight whole."""

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        pass

    def share(self, study: Study, batch: Batch, home: Callable[[Outcome], None]) -> None:
        for flight in batch.flights:
            home(self(study, flight))


@dataclass
class Paper(Whole):
    """A flyer whose verdicts are a rule: controls strike the wall, LATE-human is too fast where a person is."""

    tame: bool = False

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        subject, key = flight.subject, flight.situation.key
        control = subject.guideword == "REVERSE"
        late = subject.guideword == "LATE" and key.endswith("H1")
        violated = {"SR1": 5.0} if control and not self.tame else {"SR2": 8.0} if late else {}
        altered = 3 if control or late else 0
        return made(
            *(subject, key, flight.seed, {r.name: r.kind for r in study.requirements}, violated),
            carried=0 if subject.id == BASELINE else 10,
            altered=altered,
            infected_at_s=1.0 if altered else None,
            duration_s=40.0,
            digest=f"{subject.id if altered else ''}{key}{flight.seed}",
            perceived_digest="p",
            realised=tuple((axis.id, True) for axis in study.grid.axes) if subject.id == BASELINE else (),
        )
