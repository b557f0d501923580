"""The command that flies again what no longer counts."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Collection, Sequence

from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.campaign.runs.request import remembered
from scaloft_fi.campaign.store.held import Now, stale_in
from scaloft_fi.campaign.store.store import Flown, Store
from scaloft_fi.hazop.name import cell_of
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID
from scaloft_fi.mutants.catalogue import defaults
from scaloft_fi.sim.grid import ALL
from scaloft_fi.study import Study
from scaloft_fi.views.score.commands import MOST_NAMED, in_campaign
from scaloft_fi.views.stale import Stale


def stale_of(study: Study, store: Store, now: Now, name: str) -> Stale:
    """The flights of a campaign that no longer count and were not flown again, with the command that does it.

    Args:
        study: the study, with the grid of the campaign.
        store: of the campaign, open.
        now: its flights beside the study.
        name: of the campaign.
    """
    found = stale_in(now, store)
    return Stale(found.why, _again(study, store, name, found.flown) if found.flown else "")


def _again(study: Study, store: Store, name: str, stale: Sequence[Flown]) -> str:
    """The `run` that flies these flights; of what it asks for besides, the campaign holds the flights that count."""
    held = store.flights()
    known = {flight.mutant for flight in held}
    asking = stale if _mutants(stale, study.roster) else held  # baselines alone are flown again beside their mutants
    mutants = _mutants(asking, study.roster) or [PLACEBO_ID]
    seeds = {flight.seed for flight in asking if flight.mutant in mutants} or {flight.seed for flight in stale}
    pool = {flight.seed for flight in stale if flight.mutant == BASELINE}
    words = [f"scaloft-fi run{in_campaign(name)}"]
    ids = {mutant.id for mutant in defaults(study.matrix)}
    if len(mutants) <= MOST_NAMED or not (ids.issuperset(mutants) and known.issuperset(ids)):
        words += [f"--mutant {shlex.quote(id_)}" for id_ in mutants]
    words += _situations(study, store, {flight.situation for flight in stale}, {flight.situation for flight in held})
    words += [] if seeds == {0} else [f"--seeds {_range(seeds)}"]
    words += [f"--baseline-seeds {_range(pool)}"] if pool - seeds - set(range(LEAST)) else []
    return " ".join(words)


def _mutants(flights: Sequence[Flown], roster: Roster) -> list[str]:
    """The mutants among `flights`, in the canonical order; a control that was flown once comes with every run."""
    flown = Counter(flight.mutant for flight in flights)
    canaries = {id_ for id_, number in flown.items() if number == 1 and cell_of(id_) in roster.controls}
    return sorted(flown.keys() - canaries - {BASELINE, PLACEBO_ID}, key=roster.rank)


def _situations(study: Study, store: Store, stale: Collection[str], held: Collection[str]) -> list[str]:
    """The options that choose these situations, among others of which the campaign holds flights."""
    grid = study.grid
    if grid.choose == ALL and set(grid.by_key) <= set(held):
        return []
    for one in remembered(store):
        if len(stale) > MOST_NAMED and {key for key, _ in one.draws}.issuperset(stale):
            return [f"--choose {shlex.quote(one.text)}", *([f"--choose-seed {one.seed}"] if one.seed else [])]
    return [f"--situation {shlex.quote(key)}" for key in sorted(stale, key=study.space.rank)]


def _range(seeds: Collection[int]) -> str:
    """The seeds as `--seeds` takes them, with those between."""
    least, most = min(seeds), max(seeds)
    return f"{least}-{most}" if least else str(most + 1)
