"""Borrow the baselines of another campaign, flown on the same platform with the same data and code."""

from __future__ import annotations

from collections.abc import Iterable

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.store.fingerprint import fingerprint
from scaloft_fi.campaign.store.flown_grid import with_grid
from scaloft_fi.campaign.store.folder import campaign_folder, existing
from scaloft_fi.campaign.store.key import Keys
from scaloft_fi.campaign.store.platforms import Platforms
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.study import Study


def borrowed(study: Study, campaign: str, situations: Iterable[str]) -> tuple[Outcome, ...]:
    """The baselines of `situations` in a campaign, which stays unchanged.

    Raises:
        InputError: there is no such campaign, it was flown on another platform, some of its baselines were flown with
            other data or code, or a situation has no baseline.
    """
    folder = campaign_folder(study, campaign)
    place, keys = f"--baseline-from={campaign!r}", Keys(study)
    with Store(existing(folder), create=False) as store:
        theirs = with_grid(study, store).grid
        if theirs.name != study.grid.name:
            raise InputError(f"{place} was flown over grid {theirs.name!r}, not over grid {study.grid.name!r}")
        wanted = dict.fromkeys(situations)
        flown = {f.key: f for f in store.flights() if f.mutant == BASELINE and f.situation in wanted}
        flights = {
            (f.situation, f.seed): Flight(None, study.grid.situation(f.situation), f.seed) for f in flown.values()
        }
        now = {keys.key(flight): flight for flight in flights.values()}
        lent = tuple(outcome for outcome in store.outcomes(now) if not outcome.invalid)
        changed = Platforms(store).unproved(fingerprint(), lent, only_bits=True)
    if changed:
        raise InputError(f"{place} was flown on another platform, its digests may differ: {'; '.join(changed)}")
    stale = [flight for key, flight in now.items() if key not in flown]
    if stale:
        raise InputError(f"{place}: {stale[0].name} was flown with other data or code; fly it again there")
    missing = [situation for situation in wanted if situation not in {outcome.situation for outcome in lent}]
    if missing:
        raise InputError(f"{place} has no baseline of {missing[0]}; fly it there with `run --baseline-seeds`")
    return lent
