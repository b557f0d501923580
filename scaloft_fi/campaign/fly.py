"""One planned flight to one outcome.  What the harness does wrong is `invalid`; what the drone does is judged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from scaloft_fi.campaign.plan import Flight
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.study import Study

Flyer = Callable[[Study, Flight], Outcome]
"""Flies and judges one flight."""


def fly_once(study: Study, flight: Flight) -> Outcome:
    """Fly and judge one flight; whatever goes wrong on the way is raised."""
    from scaloft_fi.mutants.wire import contexts, wire_for
    from scaloft_fi.results.outcome import outcome_of
    from scaloft_fi.sim.flight import fly

    situation, mutant = flight.situation, flight.mutant
    facts = study.sim.facts(situation)
    context = contexts(flight.subject.id, situation.key, flight.seed, situation.nominal_s, facts)
    log = fly(study.sim, situation, flight.seed, wire_for(mutant, context))
    return outcome_of(
        log,
        flight.subject,
        situation.key,
        flight.seed,
        requirements=study.requirements,
        realisation=study.realisation if mutant is None else None,
    )


class Worker:
    """The work of one process: a callable that never raises over a flight.

    Args:
        study: opened in the parent; a forked worker shares it.
        flyer: what flies, `fly_once` but for tests.
    """

    def __init__(self, study: Study, flyer: Flyer = fly_once) -> None:
        self.study, self.flyer = study, flyer

    def __call__(self, flight: Flight) -> Outcome:
        """The outcome of `flight`, tried once more when the harness failed."""
        outcome = self._try(flight)
        return self._try(flight) if outcome.invalid else outcome

    def _try(self, flight: Flight) -> Outcome:
        try:
            return self.flyer(self.study, flight)
        except Exception as error:  # noqa: BLE001 - any failure of the harness is a fact to be told, never a verdict
            return invalid(flight, f"{type(error).__name__}: {' '.join(str(error).split())}")


def invalid(flight: Flight, reason: str) -> Outcome:
    """The outcome of a flight that the harness could not fly."""
    return replace(Outcome(flight.subject, flight.situation.key, flight.seed), invalid=reason)


def lost(flight: Flight) -> Outcome:
    """The outcome of a flight that took its worker with it."""
    return invalid(flight, "its worker process died every time it was flown")
