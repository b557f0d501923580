"""What a campaign holds: the outcomes that the study still stands for, and what it has outgrown, with the reasons."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.store.key import Keys
from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.campaign.store.selection import Flown
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.mutants.derive import realise
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation


@dataclass(frozen=True)
class Held:
    """The outcomes of a campaign.

    Attributes:
        folder: of the campaign.
        current: outcomes of flights as the study describes them now, ordered by mutant, situation, seed.
        why: for what is stale, the reason and of how many flights, the commonest first.
        owed: how many flights were planned as the study describes them now, and have no outcome that counts.
    """

    folder: Path
    current: tuple[Outcome, ...]
    why: Mapping[str, int] = field(default_factory=dict)
    owed: int = 0

    @property
    def stale(self) -> int:
        """How many flights were flown with other data or code; `run` flies them again when they are asked for."""
        return sum(self.why.values())


def held_in(study: Study, store: Store, folder: Path) -> Held:
    """What an open store holds."""
    with store.snapshot():
        now = _Now(study, store)
        flights = store.flights()
        planned = store.planned()
        due = {flight.key for flight in planned if now.origin(flight.mutant, flight.situation) == flight.origin}
        return Held(
            folder=folder,
            current=store.standing(now.stands),
            why=dict(Counter(now.why(flight) for flight in flights if not now.stands(flight)).most_common()),
            owed=len(due - store.known(due)),
        )


def current_in(study: Study, store: Store) -> tuple[Outcome, ...]:
    """The outcomes of an open store that count; there may be none."""
    with store.snapshot():
        return store.standing(_Now(study, store).stands)


def counting_flights(study: Study, store: Store) -> list[Flown]:
    """The flights of an open store whose outcomes count, the invalid ones left out, ordered by their keys."""
    with store.snapshot():
        now = _Now(study, store)
        standing = {flight.key: flight for flight in store.flights() if now.stands(flight)}
        return [standing[key] for key in sorted(store.known(standing))]


def nothing_to_show(store: Store, folder: Path) -> NoReturn:
    """Say why a campaign has nothing that counts."""
    flights = store.flights()
    if not flights:
        raise InputError(f"{folder}: nothing to show: it holds no flight; `scaloft-fi run` flies what is asked for")
    stale = f"all {len(flights)} flights are stale (`scaloft-fi status`)"
    raise InputError(f"{folder}: nothing to show: {stale}; `scaloft-fi run` flies again")


def latest_in(study: Study, store: Store) -> tuple[Outcome, ...]:
    """One outcome of each flight of an open store: the current one, else one that the study has outgrown."""
    with store.snapshot():
        stand_last = sorted(store.flights(), key=_Now(study, store).stands)
        chosen = {(flight.mutant, flight.situation, flight.seed): flight.key for flight in stand_last}
        return tuple(store.outcomes(chosen.values()))


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


class _Now:
    """What the keys of flights are as the study describes them now; each mutant and situation is looked up once."""

    def __init__(self, study: Study, store: Store) -> None:
        self._study, self._keys, self._then = study, Keys(study), store.origins()
        self._grid = study.grid  # which says itself what is wrong with it
        self._mutants: dict[str, Mutant | None] = {}
        self._situations: dict[str, Situation] = {}
        self._origins: dict[tuple[str, str], Origin | str] = {}
        self._stand: dict[tuple[str, str, int], bool] = {}

    def origin(self, mutant: str, situation: str) -> Origin | str:
        """What enters the flight now, else why there is no such flight any more."""
        name = mutant, situation
        if name not in self._origins:
            self._origins[name] = self._origin(*name)
        return self._origins[name]

    def stands(self, flight: Flown) -> bool:
        """Whether an outcome is of the flight as it is described now."""
        key, mutant, situation, seed, number = flight
        if number is None:
            now = self.origin(mutant, situation)
            return not isinstance(now, str) and now.key(seed) == key
        what = mutant, situation, number
        known = self._stand.get(what)
        if known is None:  # the seed apart, the key says no more than what entered it
            known = self._stand[what] = self.origin(mutant, situation) == self._then[number]
        return known

    def why(self, flight: Flown) -> str:
        """Why an outcome does not stand."""
        now = self.origin(flight.mutant, flight.situation)
        if isinstance(now, str):
            return now
        if flight.origin is None:
            return "flown for reasons that were not kept"
        then = self._then[flight.origin]
        if then.platform:
            return f"flown on a platform with other digests: {then.platform}"
        words = {**_PARTS, "mutant": f"mutant {flight.mutant}"}
        return f"{' and '.join(words[part] for part in then.changed(now))} changed"

    def _origin(self, mutant: str, situation: str) -> Origin | str:
        if situation not in self._situations:
            try:
                self._situations[situation] = self._grid.situation(situation)
            except InputError:
                return "the situation is not in the grid any more"
        if mutant not in self._mutants:
            try:
                self._mutants[mutant] = _mutant(self._study, mutant)
            except InputError:
                return f"mutant {mutant} is not in the matrix any more"
        return self._keys.origin(Flight(self._mutants[mutant], self._situations[situation], 0))


_PARTS = {
    "sim": "sim/",
    "requirements": "the requirements",
    "code": "the code that flies and judges",
    "situation": "what the situation sets",
    "realised": "how the situation's values come true",
}
"""The parts of an origin in words; a mutant is named."""
