"""Compare flights of mutants with their baselines, and group outcomes for that."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import INVALID, Baseline, Ruling, Status, counting, rule


@dataclass(frozen=True, slots=True)
class JudgedFlight:
    """A mutant's flight, compared with its baseline.

    Attributes:
        outcome: outcome of the flight.
        baseline: baseline of the same situation and seed; None without a valid one.
        ruling: result of the comparison.
    """

    outcome: Outcome
    baseline: Outcome | None
    ruling: Ruling

    @property
    def status(self) -> Status:
        """Highest rung that the fault reached."""
        return self.ruling.status

    @property
    def revealed(self) -> tuple[str, ...]:
        """Safety requirements that the flight violates and the baseline held until then, earliest first."""
        return self.ruling.revealed

    @property
    def operability_revealed(self) -> tuple[str, ...]:
        """Operability requirements that the flight violates and the baseline held until then, earliest first."""
        return self.ruling.operability_revealed


def flight_of(outcome: Outcome, baseline: Outcome | None) -> JudgedFlight:
    """Compare a mutant's flight with the baseline of its situation and seed; invalid without a valid baseline."""
    return _beside(outcome, counting(baseline))


def flights_of(outcomes: Iterable[Outcome]) -> list[JudgedFlight]:
    """Compare every flight of a mutant (PLACEBO included) with its baseline, in the given order."""
    baselines, flown = apart(outcomes)
    known = {(baseline.situation, baseline.seed): counting(baseline) for baseline in baselines}
    return [_beside(outcome, known.get((outcome.situation, outcome.seed))) for outcome in flown]


def _beside(outcome: Outcome, baseline: Baseline | None) -> JudgedFlight:
    ruling = rule(outcome, baseline)
    return JudgedFlight(outcome, None if baseline is None or ruling is INVALID else baseline.outcome, ruling)


def baselines_of(outcomes: Iterable[Outcome]) -> dict[tuple[str, int], Outcome]:
    """The baselines by situation and seed."""
    return {(outcome.situation, outcome.seed): outcome for outcome in outcomes if outcome.subject.id == BASELINE}


def apart(outcomes: Iterable[Outcome]) -> tuple[list[Outcome], list[Outcome]]:
    """Split outcomes into baselines and flights of mutants (PLACEBO included), each in the given order."""
    clean: list[Outcome] = []
    flown: list[Outcome] = []
    for outcome in outcomes:
        (clean if outcome.subject.id == BASELINE else flown).append(outcome)
    return clean, flown
