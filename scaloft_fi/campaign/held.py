"""What a campaign holds: the outcomes that the study still stands for, and how many it has outgrown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.campaign.folder import campaign_folder, existing
from scaloft_fi.campaign.key import Keys
from scaloft_fi.campaign.plan import Flight
from scaloft_fi.errors import InputError
from scaloft_fi.mutants.derive import realise
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.store import Store
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Held:
    """The outcomes of a campaign.

    Attributes:
        folder: of the campaign.
        current: outcomes of flights as the study describes them now, in the store's order.
        stale: how many flights were flown with other data or code; `run` flies them again when they are asked for.
        owed: how many flights were planned as the study describes them now, and have no outcome that counts.
    """

    folder: Path
    current: tuple[Outcome, ...]
    stale: int
    owed: int = 0


def held(study: Study, campaign: str) -> Held:
    """What a campaign holds, read without flying.

    Raises:
        InputError: there is no campaign.
    """
    folder = campaign_folder(study, campaign)
    with Store(existing(folder), create=False) as store:
        return held_in(study, store, folder)


def held_in(study: Study, store: Store, folder: Path) -> Held:
    """The same of an open store."""
    everything = tuple(outcome for outcome in store.outcomes() if not outcome.truncated)
    now = tuple(store.outcomes(_keys(study, ((o.mutant, o.situation, o.seed) for o in everything))))
    planned = store.planned()
    due = {flight.key for flight in planned} & _keys(study, ((p.mutant, p.situation, p.seed) for p in planned))
    return Held(folder, now, len(everything) - len(now), len(due - store.known(due)))


def current(study: Study, campaign: str) -> tuple[Outcome, ...]:
    """The outcomes of a campaign that count.

    Raises:
        InputError: there are none.
    """
    found = held(study, campaign)
    if not found.current:
        reason = (
            f"all {found.stale} flights were flown with other data or code" if found.stale else "it holds no flight"
        )
        raise InputError(f"{found.folder}: nothing to show: {reason}; `scaloft-fi run` flies what is asked for")
    return found.current


def latest(study: Study, campaign: str) -> tuple[Outcome, ...]:
    """One outcome of each flight of a campaign: the current one, else one that the study has outgrown.

    Raises:
        InputError: there is no campaign.
    """
    folder = campaign_folder(study, campaign)
    with Store(existing(folder), create=False) as store:
        found = {outcome.name: outcome for outcome in (*store.outcomes(), *held_in(study, store, folder).current)}
    return tuple(found.values())


def flight_named(study: Study, mutant: str, situation: str, seed: int) -> Flight:
    """The flight of `mutant` (`baseline`, `PLACEBO` or an id) in a situation.

    Raises:
        InputError: one of them is unknown.
    """
    return Flight(_mutant(study, mutant), study.grid.situation(situation), seed)


def _mutant(study: Study, name: str) -> Mutant | None:
    if name == BASELINE:
        return None
    return PLACEBO if name == PLACEBO.id else realise(study.matrix, name)


def _keys(study: Study, flights: Iterable[tuple[str, str, int]]) -> set[str]:
    """The keys that flights (mutant, situation, seed) have now."""
    made = Keys(study)
    keys = set()
    for name, situation, seed in set(flights):
        try:
            keys.add(made.key(flight_named(study, name, situation, seed)))
        except InputError:  # a cell or a situation that the study no longer has
            continue
    return keys
