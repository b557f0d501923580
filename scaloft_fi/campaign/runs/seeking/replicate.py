"""Fly finds again, on seeds that nothing before used.

Each replication has a block of seeds of its own, which its campaign remembers: finds that fail once and are replicated
again get other seeds.  An interrupted replication goes on with the seeds that it began with.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scaloft_fi.analysis.seeking import POOL, SEEDS, Place, Replica, replicas
from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs.campaign import opened
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import write_log
from scaloft_fi.campaign.runs.seeking.flights import Allowance, SearchFlights
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.sim.found import Find
from scaloft_fi.study import Study

FRESH, BLOCK = 100_000, 100
"""First seed of the first replication, and how far the next ones are apart."""
BEGUN, ENDED = "replication begun", "replication ended"
"""Prefixes of the names of the notes."""

Ask = Mapping[str, Sequence[str]]
"""The mutants that are replicated, by name of the find."""


@dataclass(frozen=True)
class ReplicationReport:
    """The result of a replication.

    Attributes:
        replicas: each pair of find and mutant.
        first: first seed.
        used: different flights that it asked for; flown: flights that this run flew.
        alpha: the study's.
        anyhow: whether a pair may hold where the unmutated drone does not do its mission.
    """

    replicas: tuple[Replica, ...]
    first: int
    used: int
    flown: int
    alpha: float
    anyhow: bool


def replicate(
    study: Study,
    finds: Sequence[Find],
    ask: Ask,
    folder: Path,
    options: RunOptions | None = None,
    *,
    progress: Progress,
    flyer: Flyer | None = None,
    anyhow: bool = False,
) -> ReplicationReport:
    """Fly pairs of find and mutant on fresh seeds.

    Args:
        study: the study, with the grid that was searched.
        finds: all finds of the study.
        ask: the pairs that are replicated.
        folder: folder of the campaign that holds the flights.
        options: options of the run; one process when None.
        progress: progress display.
        flyer: flies; PyBullet when None.
        anyhow: whether a pair may hold where the unmutated drone does not do its mission.

    Raises:
        InputError: the folder or the store cannot be written, a find does not fit the study, or it cannot be flown.
        Interrupted: the user stopped the replication; all outcomes are saved.
    """
    asked = [find for find in finds if ask.get(find.name)]
    situations = {find.name: study.grid.situation(find.situation) for find in asked}
    mutants = {mutant: realise(study.matrix, mutant) for find in asked for mutant in ask[find.name]}
    begun = [Flight(None, situation, FRESH) for situation in situations.values()]
    with opened(study, folder, options or RunOptions(), progress=progress, flyer=flyer, first=begun[:1]) as campaign:
        number = _begin(campaign.store, {find.name: list(ask[find.name]) for find in asked}, _block(finds))
        first = FRESH + BLOCK * number
        flights = SearchFlights(campaign, Allowance(), anyhow=anyhow)
        progress.stage = f"{sum(map(len, ask.values()))} pairs of find and mutant, seeds from {first}"
        pools = {
            situation: [Flight(None, situation, first + seed) for seed in range(POOL)]
            for situation in situations.values()
        }
        pairs: dict[Place, list[Flight]] = {
            (find.name, mutant): [Flight(mutants[mutant], situations[find.name], first + seed) for seed in range(SEEDS)]
            for find in asked
            for mutant in ask[find.name]
        }
        try:
            flights.fly([flight for some in (*pools.values(), *pairs.values()) for flight in some])
        finally:
            campaign.reporter.close()
            write_log(study, folder, current_in(study, campaign.store))
        campaign.store.set_notes({f"{ENDED} {number}": json.dumps(number)})

        def outcomes(wanted: Sequence[Flight]) -> list[Outcome]:
            return [outcome for flight in wanted if (outcome := flights.outcome(flight)) is not None]

        told = replicas(
            asked,
            {place: outcomes(some) for place, some in pairs.items()},
            {situation.key: outcomes(some) for situation, some in pools.items()},
            first,
            study.alpha,
            anyhow=anyhow,
        )
        return ReplicationReport(told, first, flights.used, campaign.flown, study.alpha, anyhow)


def _block(finds: Sequence[Find]) -> int:
    """The first block of seeds that no replication of these finds used."""
    used = (evidence.again.seed for find in finds for evidence in find.shows.values() if evidence.again)
    return max(((seed - FRESH) // BLOCK + 1 for seed in used), default=0)


def _begin(store: Store, ask: Ask, least: int) -> int:
    """The number of the replication: that of the last one if it did not end and asked for the same, else a new one."""
    begun: list[tuple[int, Any]] = sorted(
        store.records(BEGUN, lambda one: (int(one["number"]), one["ask"])), key=_first
    )
    ended = set(store.records(ENDED, int))
    if begun and begun[-1][0] not in ended and begun[-1][1] == ask:
        return begun[-1][0]
    number = max([least, *(one + 1 for one, _ in begun)])
    store.set_notes({f"{BEGUN} {number}": json.dumps({"number": number, "ask": ask})})
    return number


def _first(record: tuple[int, Any]) -> int:
    return record[0]
