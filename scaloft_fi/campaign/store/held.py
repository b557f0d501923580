"""The current and the stale outcomes of a campaign, by the keys of their flights.

An outcome is current if its flight has the same key in the study as it is now; otherwise it is stale, for a reason.

Before it flies, each run records its mutants and seeds, and the situations that it chose.  A mutant with more than one
record is judged by looks.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.store.record import Origin, Planned
from scaloft_fi.campaign.store.store import FlownFlight, Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, TRACK_EVERY, Outcome, track_values
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.output import in_campaign
from scaloft_fi.sim.log import SAMPLE_HZ
from scaloft_fi.study import Study, value_digest

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation


class Keys:
    """The keys of a study's flights; each mutant and each situation is hashed once.

    Args:
        study: the current study; later changes of its files are not noticed.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self._mutant = cache(lambda mutant: value_digest(mutant.to_json()) if mutant else "")
        self._situation = cache(self._hashed)

    def _hashed(self, situation: Situation) -> tuple[str, str]:
        """Hashes of the values that a situation sets, and of the predicates of its values."""
        return value_digest([situation.key, self._study.changes(situation)]), value_digest(
            self._study.realised(situation)
        )

    def origin(self, flight: Flight) -> Origin:
        """The origin of the flight's outcome.

        Values of an axis that the situation does not have, other mutants and comments do not count.
        """
        mutant, inputs = flight.mutant, self._study.inputs
        changed, predicates = self._situation(flight.situation)
        return Origin(
            sim=inputs["sim"],
            requirements=inputs["requirements"],
            code=inputs["code"],
            mutant=self._mutant(mutant),
            situation=changed,
            realised="" if mutant else predicates,
            operator=inputs[f"operator {mutant.operator}"] if mutant else "",
        )

    def key(self, flight: Flight) -> str:
        """The key of a flight."""
        return self.origin(flight).key(flight.seed)

    def planned(self, flight: Flight, *, canary: bool = False) -> Planned:
        """The entry of a flight in the plan of the store."""
        origin = self.origin(flight)
        return Planned(origin.key(flight.seed), flight.subject.id, flight.situation.key, flight.seed, canary, origin)


@dataclass(frozen=True)
class Held:
    """What a campaign holds beside its current outcomes.

    Attributes:
        folder: folder of the campaign.
        why: number of stale outcomes by reason; the commonest reason is first.
        owed: number of planned, current flights without a valid outcome.
        flown_again: number of stale outcomes of flights that have a current one too.
    """

    folder: Path
    why: Mapping[str, int] = field(default_factory=dict)
    owed: int = 0
    flown_again: int = 0

    @property
    def stale(self) -> int:
        """Number of stale flights; `run` flies a stale flight again when it is requested."""
        return sum(self.why.values())


@dataclass(frozen=True)
class StaleFlights:
    """The flights of a campaign with a stale outcome and no current one.

    Attributes:
        why: number of them by reason; the commonest reason is first.
        flown: those that the study still has, so that they can be flown again.
    """

    why: Mapping[str, int] = field(default_factory=dict)
    flown: tuple[FlownFlight, ...] = ()


def held_in(now: Now, folder: Path) -> Held:
    """Read what an open store holds."""
    with now.store.snapshot():
        unflown = now.store.planned(unflown=True)
        return Held(
            folder=folder,
            why=_counted(map(now.why, now.stale)),
            owed=sum(now.origin(flight.mutant, flight.situation) == flight.origin for flight in unflown),
            flown_again=len(now.stale) - len(now.lost),
        )


def stale_in(now: Now) -> StaleFlights:
    """The flights of an open store that no longer count and were not flown again."""
    lost = {flight[1:4]: flight for flight in now.lost}.values()
    flown = [flight for flight in lost if not isinstance(now.origin(flight.mutant, flight.situation), str)]
    return StaleFlights(_counted(map(now.why, lost)), tuple(flown))


def _counted(reasons: Iterable[str]) -> Mapping[str, int]:
    return dict(Counter(reasons).most_common())


def current_in(study: Study, store: Store) -> tuple[Outcome, ...]:
    """The current outcomes of an open store; there may be none."""
    with store.snapshot():
        return store.standing(Now(study, store).stands)


def counting_flights(study: Study, store: Store) -> list[FlownFlight]:
    """The flights of an open store with a current, valid outcome, ordered by key."""
    with store.snapshot():
        now = Now(study, store)
        standing = {flight.key: flight for flight in store.flights() if now.stands(flight)}
        return [standing[key] for key in sorted(store.known(standing))]


def nothing_to_show(study: Study, store: Store, folder: Path) -> NoReturn:
    """Raise the error for a campaign without a current outcome."""
    flights = store.flights()
    named = in_campaign(folder.name if folder.parent.name == "campaigns" else str(folder))
    if not flights:
        raise InputError(f"{folder}: nothing to show: the campaign has no flight; start with `scaloft-fi run{named}`")
    what, makes = ("runs", "runs") if study.tests_of else ("flights", "flies")
    stale = f"all {len(flights)} {what} are stale (`scaloft-fi status{named}`)"
    raise InputError(f"{folder}: nothing to show: {stale}; `{study.again}{named}` {makes} again")


def latest_in(study: Study, store: Store) -> tuple[Outcome, ...]:
    """One outcome for each flight of an open store: the current one, else a stale one."""
    with store.snapshot():
        stand_last = sorted(store.flights(), key=Now(study, store).stands)
        chosen = {(flight.mutant, flight.situation, flight.seed): flight.key for flight in stand_last}
        return tuple(store.outcomes(chosen.values()))


def flight_named(study: Study, mutant: str, situation: str, seed: int) -> Flight:
    """The flight of `mutant` (`baseline`, `PLACEBO` or an id) in a situation.

    Raises:
        InputError: the mutant or the situation is unknown.
    """
    return Flight(_mutant(study, mutant), study.grid.situation(situation), seed)


def _mutant(study: Study, name: str) -> Mutant | None:
    if name == BASELINE:
        return None
    return PLACEBO if name == PLACEBO.id else realise(study.matrix, name)


class Now:
    """The origins of flights in the study as it is now; each mutant and each situation is looked up once.

    Attributes:
        study: as it is now.
        store: the open store whose flights are asked about; its list of flights is read once.
        origin: of the id of a subject and the key of a situation the origin of such a flight in the current study, or
            the reason why it no longer exists.
    """

    def __init__(self, study: Study, store: Store) -> None:
        self.study, self.store = study, store
        self._keys, self._then = Keys(study), store.origins()
        # the grid is read here, so that an error in the grid itself is raised
        self._mutant, self._situation = cache(partial(_mutant, study)), cache(study.grid.situation)
        self.origin, self._why = cache(self._origin), cache(self._reason)
        self._same = cache(lambda mutant, situation, number: self.origin(mutant, situation) == self._then.get(number))

    def stands(self, flight: FlownFlight) -> bool:
        """Whether an outcome is current."""
        key, mutant, situation, seed, number = flight
        if number is None:
            now = self.origin(mutant, situation)
            return not isinstance(now, str) and now.key(seed) == key
        return self._same(mutant, situation, number)  # origin and seed determine the key

    def whole(self, outcome: Outcome) -> Outcome:
        """A stored outcome with its track, if the store has one."""
        flight = flight_named(self.study, outcome.mutant, outcome.situation, outcome.seed)
        return self.store.get(self._keys.key(flight)) or outcome

    @cached_property
    def flights(self) -> list[FlownFlight]:
        """The flights of the store with an outcome, ordered by mutant, situation, seed."""
        return self.store.flights()

    @cached_property
    def broken(self) -> Mapping[FlownFlight, str]:
        """The current flights that are invalid, each with the reason."""
        return {flight: why for flight, why in self.store.broken().items() if self.stands(flight)}

    @cached_property
    def one_each(self) -> list[FlownFlight]:
        """One flight for each mutant, situation and origin."""
        return self.store.flights(one_each=True)

    @cached_property
    def stale(self) -> list[FlownFlight]:
        """The stale outcomes of the store."""
        if all(flight.origin is not None and self.stands(flight) for flight in self.one_each):
            return []
        return [flight for flight in self.flights if not self.stands(flight)]

    @cached_property
    def lost(self) -> list[FlownFlight]:
        """The stale outcomes of flights without a current one."""
        names = {flight[1:4] for flight in self.stale}
        again = (
            {flight[1:4] for flight in self.flights if flight[1:4] in names and self.stands(flight)} if names else ()
        )
        return [flight for flight in self.stale if flight[1:4] not in again]

    def why(self, flight: FlownFlight) -> str:
        """Why an outcome is stale."""
        return self._why(flight.mutant, flight.situation, flight.origin)

    def _reason(self, mutant: str, situation: str, number: int | None) -> str:
        now = self.origin(mutant, situation)
        if isinstance(now, str):
            return now
        then = None if number is None else self._then.get(number)
        if then is None:
            return "flown for reasons that were not kept"
        if then.platform:
            return f"flown on a platform with other digests: {then.platform}"
        realised = self._mutant(mutant)
        words = {**_PARTS, "mutant": f"mutant {mutant}", "operator": f"operator {realised and realised.operator}"}
        return f"{' and '.join(words[part] for part in then.changed(now))} changed"

    def _origin(self, mutant: str, situation: str) -> Origin | str:
        try:
            place = self._situation(situation)
        except InputError:
            return "the situation is not in the grid any more"
        try:
            realised = self._mutant(mutant)
        except InputError:
            return f"mutant {mutant} is not in the matrix any more"
        return self._keys.origin(Flight(realised, place, 0))


_PARTS = {
    "sim": "sim/",
    "requirements": "the requirements",
    "code": "the code that flies and judges",
    "situation": "what the situation sets",
    "realised": "how the situation's values come true",
}
"""Names of the parts of an origin for messages; a mutant and an operator have names of their own."""


def with_tracks(
    study: Study,
    store: Store,
    outcomes: Iterable[Outcome],
    wanted: Callable[[Outcome], bool] | None = None,
) -> tuple[Outcome, ...]:
    """Add tracks to the outcomes that are `wanted`.

    Args:
        study: the current study.
        store: an open store.
        outcomes: current outcomes.
        wanted: whether an outcome gets its track; None: each does.

    Raises:
        InputError: a track is damaged, or longer than a flight in its situation.
    """
    keys, most = Keys(study), dict[str, int]()

    def tracked(outcome: Outcome) -> Outcome:
        if wanted is not None and not wanted(outcome):
            return outcome
        flight = flight_named(study, outcome.mutant, outcome.situation, outcome.seed)
        found = store.get(keys.key(flight))
        if found is None or not found.track:
            return outcome
        if outcome.situation not in most:
            # one row for every `TRACK_EVERY` samples, the first and the last
            limit_s = (study.command and study.command.mission_s) or study.limit_s(flight.situation)
            most[outcome.situation] = math.ceil(limit_s * SAMPLE_HZ / TRACK_EVERY) + 3
        try:
            track_values(found.track, most[outcome.situation])
        except ValueError as error:
            raise InputError(f"{store.path}: table tracks: the track of {outcome.name} is {error}") from error
        return replace(outcome, track=found.track)

    return tuple(tracked(outcome) for outcome in outcomes)


ASKED, CHOICE, DIFFERED, ALLOWED, SOUGHT = "asked", "choice", "differed", "allowed", "sought"
"""Prefixes of the names of the notes that runs leave: mutants with seeds, choices of situations, repeated flights, the
share of invalid flights that is allowed, and that a search flew."""

MOST_INVALID = 0.1
"""Greatest share of invalid flights where a run says nothing else; a campaign with more gives no valid score."""

NOT_REPEATED = "a repeated flight differs from the first"
"""What is said of a campaign with such a flight."""


def remember_seeds(store: Store, mutants: Iterable[str], seeds: Iterable[int]) -> None:
    """Record mutants and seeds of a run; a mutant is skipped if an earlier record has all of these seeds.

    Raises:
        InputError: the store cannot be written.
    """
    wanted, known = frozenset(seeds), _asked(store)
    news = sorted({mutant for mutant in mutants if not any(wanted <= before for before in known.get(mutant, ()))})
    if news:
        store.remember(ASKED, {"seeds": sorted(wanted), "mutants": news})


def grown_in(store: Store) -> frozenset[str]:
    """The mutants that runs asked to fly with more than one set of seeds."""
    return frozenset(mutant for mutant, seeds in _asked(store).items() if len(seeds) > 1)


def remember_differed(store: Store, key: str, outcome: Outcome) -> None:
    """Record that the repetition of the flight with this key had other bits.

    Raises:
        InputError: the store cannot be written.
    """
    content = {"key": key, "mutant": outcome.mutant, "situation": outcome.situation, "seed": outcome.seed}
    store.remember(DIFFERED, content, key)


def differed_in(now: Now) -> tuple[str, ...]:
    """Names of the flights that count although their repetition had other bits: no score with them is valid.

    Raises:
        InputError: a record is none of a flight.
    """

    def read(one: Any) -> FlownFlight:
        return FlownFlight(str(one["key"]), str(one["mutant"]), str(one["situation"]), int(one["seed"]), None)

    flights = now.store.records(DIFFERED, read)
    if now.store.is_record:  # its flights have the keys of the study now, and its notes those of then
        there = {flight[1:4] for flight in now.flights}
        flights = [flight for flight in flights if flight[1:4] in there]
    else:
        flights = [flight for flight in flights if now.stands(flight)]
    return tuple(f"{flight.mutant}/{flight.situation}/{flight.seed}" for flight in flights)


def remember_search(store: Store) -> None:
    """Record that a search flies in the campaign.

    Raises:
        InputError: the store cannot be written.
    """
    store.remember(SOUGHT, True, "flown")


def searched(store: Store) -> bool:
    """Whether a search flew in the campaign.

    Raises:
        InputError: a record is damaged.
    """
    return bool(store.records(SOUGHT, bool))


def remember_allowed(store: Store, max_invalid: float) -> None:
    """Record the greatest share 0..1 of invalid flights that a run allows, where it is not that of the run before.

    Raises:
        InputError: the store cannot be written.
    """
    number, before = _allowed(store)
    if max_invalid != before:
        store.remember(ALLOWED, [number + 1, max_invalid])


def allowed_in(store: Store) -> float:
    """The greatest share 0..1 of invalid flights that the last run allowed.

    Raises:
        InputError: a record is none of a share.
    """
    return _allowed(store)[1]


def _allowed(store: Store) -> tuple[int, float]:
    """How often it was changed, and the last value."""
    return max(store.records(ALLOWED, lambda one: (int(one[0]), float(one[1]))), default=(0, MOST_INVALID))


def _asked(store: Store) -> dict[str, set[frozenset[int]]]:
    """The recorded sets of seeds by mutant."""
    asked: dict[str, set[frozenset[int]]] = {}
    for mutants, seeds in store.records(ASKED, lambda one: (list(map(str, one["mutants"])), one["seeds"])):
        for mutant in mutants:
            asked.setdefault(mutant, set()).add(frozenset(map(int, seeds)))
    return asked


class TestCase(NamedTuple):
    """One test case.

    Attributes:
        situation: key of the situation.
        seed: seed of the flight.
    """

    situation: str
    seed: int


@dataclass(frozen=True)
class Remembered:
    """One choice.

    Attributes:
        text: value of --choose, such as `draws:40`.
        seed: value of --choose-seed.
        pool: situations to choose from.
        draws: the test cases, in the order of the choice.
    """

    KEYS = ("choose=text", "seed", "pool", "draws")
    text: str
    seed: int
    pool: int
    draws: tuple[TestCase, ...]


def remembered(store: Store) -> tuple[Remembered, ...]:
    """The recorded choices of a campaign.

    Raises:
        InputError: a record is no choice.
    """
    return tuple(sorted(store.records(CHOICE, _read), key=lambda one: (one.text, one.seed)))


def _read(content: Any) -> Remembered:
    draws = tuple(TestCase(str(key), int(number)) for key, number in content["draws"])
    return Remembered(str(content["choose"]), int(content["seed"]), int(content["pool"]), draws)
