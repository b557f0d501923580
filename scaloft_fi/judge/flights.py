"""Mutants' flights beside their baselines, and outcomes sorted for that."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import INVALID, Baseline, Ruling, Status, counting, rule


@dataclass(frozen=True, slots=True)
class JudgedFlight:
    """A flight beside its baseline.

    Attributes:
        outcome: the flight.
        baseline: of the same situation and seed; None when there is none that counts.
        ruling: what it comes to.
    """

    outcome: Outcome
    baseline: Outcome | None
    ruling: Ruling

    @property
    def status(self) -> Status:
        """Where the fault stopped."""
        return self.ruling.status

    @property
    def revealed(self) -> tuple[str, ...]:
        """Safety requirements that it violates and its baseline held up to that moment, earliest first."""
        return self.ruling.revealed

    @property
    def operability_revealed(self) -> tuple[str, ...]:
        """The same of operability requirements."""
        return self.ruling.operability_revealed


def flight_of(outcome: Outcome, baseline: Outcome | None) -> JudgedFlight:
    """Judge a mutant's flight by the baseline of the same situation and seed; without one that counts it is invalid."""
    return _beside(outcome, counting(baseline))


def flights_of(outcomes: Iterable[Outcome]) -> list[JudgedFlight]:
    """Every flight of a mutant (PLACEBO among them) beside its baseline, in the order given."""
    baselines, flown = apart(outcomes)
    known = {(baseline.situation, baseline.seed): counting(baseline) for baseline in baselines}
    return [_beside(outcome, known.get((outcome.situation, outcome.seed))) for outcome in flown]


def _beside(outcome: Outcome, baseline: Baseline | None) -> JudgedFlight:
    ruling = rule(outcome, baseline)
    return JudgedFlight(outcome, None if baseline is None or ruling is INVALID else baseline.outcome, ruling)


def baselines_of(outcomes: Iterable[Outcome]) -> dict[tuple[str, int], Outcome]:
    """The baseline of each situation and seed."""
    return {(outcome.situation, outcome.seed): outcome for outcome in outcomes if outcome.subject.id == BASELINE}


def apart(outcomes: Iterable[Outcome]) -> tuple[list[Outcome], list[Outcome]]:
    """The baselines and the flights of mutants (PLACEBO among them), each in the order given."""
    clean: list[Outcome] = []
    flown: list[Outcome] = []
    for outcome in outcomes:
        (clean if outcome.subject.id == BASELINE else flown).append(outcome)
    return clean, flown
