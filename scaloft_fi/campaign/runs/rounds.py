"""In which order situations are flown when it is only asked whether a mutant is killed: the likeliest to kill first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from scaloft_fi.campaign.plan.plan import Flight
from scaloft_fi.results.flights import flights_of
from scaloft_fi.results.outcome import BASELINE, PLACEBO, Outcome
from scaloft_fi.results.requirement import Kind, Verdict
from scaloft_fi.results.status import Status, held_to_end

Draw = tuple[str, int]
"""A situation's key and a seed."""


def ordered(baselines: Sequence[Flight], known: Iterable[Outcome]) -> tuple[Flight, ...]:
    """The draws of `baselines`, seed by seed, in each the situations that are likeliest to kill first.

    What the campaign knows comes first: the share of its whole, eligible mutant flights in a situation that are killed,
    drawn towards the mean of all situations by as much as one flight weighs.  Where that leaves a tie, and that is
    everywhere in a new campaign, the baselines decide (see `promise`); then the order of the grid.

    Args:
        baselines: one for each draw, in the order of the grid.
        known: whole outcomes of the campaign, those of `baselines` among them.
    """
    listed = list(known)
    rates = kill_rates(listed)
    promises = promise(listed)
    mean = rates.pop("", 0.0)

    def rank(flight: Flight) -> tuple[int, float, tuple[int, int, float]]:
        key = flight.situation.key
        return flight.seed, -rates.get(key, mean), promises.get((key, flight.seed), (0, 0, 0.0))

    return tuple(sorted(baselines, key=rank))


def kill_rates(outcomes: Iterable[Outcome]) -> dict[str, float]:
    """Per situation the smoothed share of eligible flights that are killed; under "" that of all situations."""
    kills, flown = Counter[str](), Counter[str]()
    for flight in flights_of(outcomes):
        if flight.eligible and flight.outcome.mutant != PLACEBO and not flight.outcome.truncated:
            flown[flight.outcome.situation] += 1
            kills[flight.outcome.situation] += flight.status is Status.KILLED
    if not flown:
        return {}
    mean = kills.total() / flown.total()
    return {"": mean} | {key: (kills[key] + mean) / (count + 1) for key, count in flown.items()}


def promise(outcomes: Iterable[Outcome]) -> Mapping[Draw, tuple[int, int, float]]:
    """How likely a situation is to kill, judged by its baseline alone; the least is the likeliest.

    First come those whose baseline holds more safety requirements to its end, for only what is held can be broken; then
    those where more of them were put to the test, for a requirement that was never triggered lets most faults pass;
    then those with the least robustness to lose.
    """
    found = {}
    for outcome in outcomes:
        if outcome.mutant == BASELINE and not outcome.invalid:
            held = [r for r in outcome.readings if r.kind is Kind.SAFETY and not (r.violated or r.open)]
            tested = [reading for reading in held if reading.verdict is not Verdict.VACUOUS]
            least = min((reading.rho for reading in tested), default=0.0)
            found[outcome.situation, outcome.seed] = (-len(held), -len(tested), least)
    return found


def can_kill(outcome: Outcome) -> bool:
    """Whether a mutant can be killed beside this baseline: it holds a safety requirement to its end."""
    return not outcome.invalid and held_to_end(outcome, Kind.SAFETY)
