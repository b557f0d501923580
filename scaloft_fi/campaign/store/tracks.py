"""Read outcomes with their tracks; tracks are read separately, because most verbs need none."""

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
    """Add tracks to the outcomes of `mutants`; `baseline` is a valid id.

    Args:
        study: the current study.
        store: an open store.
        outcomes: current outcomes.
        mutants: ids whose outcomes get their tracks.
        seeds: seeds whose outcomes get their tracks; None = all.
    """
    wanted, keys = set(mutants), Keys(study)

    def tracked(outcome: Outcome) -> Outcome:
        if outcome.mutant not in wanted or (seeds is not None and outcome.seed not in seeds):
            return outcome
        flight = flight_named(study, outcome.mutant, outcome.situation, outcome.seed)
        return store.get(keys.key(flight)) or outcome

    return tuple(tracked(outcome) for outcome in outcomes)
