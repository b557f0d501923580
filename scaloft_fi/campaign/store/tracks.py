"""Outcomes with their trajectories, which are read apart because most questions need none."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.campaign.store.key import Keys
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study


def with_tracks(
    study: Study,
    store: Store,
    outcomes: Iterable[Outcome],
    mutants: Collection[str],
    seeds: Collection[int] | None = None,
) -> tuple[Outcome, ...]:
    """The same outcomes, those of `mutants` (`baseline` among the ids) with their trajectories.

    Args:
        study: whose flights they are, as it is now.
        store: where they are.
        outcomes: current ones.
        mutants: ids whose trajectories are wanted.
        seeds: of which they are wanted; None means all.
    """
    wanted, keys = set(mutants), Keys(study)

    def tracked(outcome: Outcome) -> Outcome:
        if outcome.mutant not in wanted or (seeds is not None and outcome.seed not in seeds):
            return outcome
        flight = flight_named(study, outcome.mutant, outcome.situation, outcome.seed)
        return store.get(keys.key(flight)) or outcome

    return tuple(tracked(outcome) for outcome in outcomes)
