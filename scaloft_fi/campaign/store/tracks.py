"""Read outcomes with their tracks; tracks are read separately, because most verbs need none."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import replace

from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.campaign.store.key import Keys
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import TRACK_EVERY, Outcome, track_values
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

    Raises:
        InputError: a track is damaged, or longer than a flight in its situation.
    """
    wanted, keys, most = set(mutants), Keys(study), dict[str, int]()

    def tracked(outcome: Outcome) -> Outcome:
        if outcome.mutant not in wanted or (seeds is not None and outcome.seed not in seeds):
            return outcome
        flight = flight_named(study, outcome.mutant, outcome.situation, outcome.seed)
        found = store.get(keys.key(flight))
        if found is None or not found.track:
            return outcome
        if outcome.situation not in most:
            most[outcome.situation] = _most_rows(study.limit_s(flight.situation))
        try:
            track_values(found.track, most[outcome.situation])
        except ValueError as error:
            raise InputError(f"{store.path}: table tracks: the track of {outcome.name} is {error}") from error
        return replace(outcome, track=found.track)

    return tuple(tracked(outcome) for outcome in outcomes)


def _most_rows(limit_s: float) -> int:
    """The greatest number of rows of a flight's track: one for every `TRACK_EVERY` samples, the first and the last."""
    from scaloft_fi.sim.log import SAMPLE_HZ  # most verbs read no track

    return math.ceil(limit_s * SAMPLE_HZ / TRACK_EVERY) + 3
