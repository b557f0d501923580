"""The fingerprint of a platform; the platforms of a store's flights, and what samples have shown of them.

A mutant may be judged beside a baseline of its own platform only, because a masked flight equals its baseline to the
bit.  So all flights of one pair of situation and seed come from one platform: the store's own, which flew first, or the
platform that a note names.  Flights of another platform in the pair are set apart first; they stay in the store.
"""

from __future__ import annotations

import ctypes
import json
import platform
from collections.abc import Iterable, Mapping
from contextlib import suppress
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

from scaloft_fi.campaign.store.record import Planned
from scaloft_fi.campaign.store.store import NOTE, FlownFlight, Store
from scaloft_fi.defaults import __version__
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.registry import grouped
from scaloft_fi.sources import NUMERIC

BRING_OPENBLAS = ("numpy", "scipy")
"""Packages whose wheels contain an OpenBLAS, in a folder `<package>.libs` beside the package."""
DECIDES = {
    "system": "yes, by its libraries",
    "machine": "yes, by its instructions",
    "processor": "yes: numba compiles for it, and OpenBLAS chooses its kernels by it",
    "libc": "yes: sines, roots and exponentials",
    "python": "yes: sums and mathematical functions",
    "scaloft-fi": "no: the hash of its code is part of each flight's key",
    "numpy": "yes",
    "numba": "yes: the compiled kernels",
    "llvmlite": "yes: the compiled kernels",
    "filterpy": "yes: the covariance of the filter",
    "scipy": "yes",
    "pybullet": "yes: rigid bodies and contacts",
    "numpy kernels": "yes: the order of additions in a product",
    "scipy kernels": "yes: the order of additions in a product",
}
"""Whether each part of a fingerprint decides the bits of a flight."""
CORE_NAMES = tuple(f"{prefix}openblas_get_corename{suffix}" for prefix in ("scipy_", "") for suffix in ("64_", ""))
"""Possible names of OpenBLAS's function for the name of its kernels; the name depends on the build."""


def fingerprint() -> dict[str, str]:
    """Platform and versions, by name."""
    facts = {
        "system": platform.system(),
        "machine": platform.machine(),
        "processor": _processor(),
        "libc": "-".join(platform.libc_ver()),
        "python": platform.python_version(),
        "scaloft-fi": __version__,
    }
    versions = {name: _version(name) for name in NUMERIC}
    return facts | versions | {f"{package} kernels": _kernels(package) for package in BRING_OPENBLAS}


def differences(ours: Mapping[str, str], theirs: Mapping[str, str], words: str = "{} {} here, {} there") -> list[str]:
    """The differences, each as `numpy 2.4.6 here, 1.26.4 there`, or in other `words`."""
    return [
        words.format(name, ours.get(name, "none"), theirs.get(name, "none"))
        for name in sorted(ours.keys() | theirs.keys())
        if ours.get(name) != theirs.get(name)
    ]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


def _kernels(package: str) -> str:
    """The name of OpenBLAS's kernels in this process; "unknown" for another library.

    Kernels differ in the order of additions, which decides the last bit of a product.  This function loads the library
    without importing the package, because the import would dominate the time of a verb that only reads.
    """
    spec = find_spec(package)
    folders = [Path(place).with_name(f"{package}.libs") for place in (spec and spec.submodule_search_locations) or ()]
    with suppress(OSError, StopIteration):
        library = ctypes.CDLL(str(next(path for folder in folders for path in sorted(folder.glob("*openblas*.so*")))))
        for name in CORE_NAMES:
            with suppress(AttributeError):
                function = getattr(library, name)
                function.restype = ctypes.c_char_p
                return bytes(function()).decode()
    return "unknown"


def _processor() -> str:
    """The model of the processor, which decides the compiled instructions."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next(
        (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.processor()
    )


Pair = tuple[str, int]
"""Key of a situation, and a seed."""
F = TypeVar("F", FlownFlight, Outcome)
Platform = Mapping[str, str]
"""The fingerprint of a platform; empty for the platform of a store without flights."""
BITS, FACTS = "sample agrees", "sample agrees in facts"
"""What the sample of one platform's flights showed on another: equal digests; other digests and the same facts."""
_PAIR, _PLATFORM = "platform of ", "platform "
"""Beginnings of the names of notes: `platform of SITUATION/SEED` has a hash, `platform HASH` has the fingerprint."""


class Platforms:
    """The platforms of a store at one moment.

    Args:
        store: the store; it is read once.

    Attributes:
        own: platform of the flights of every pair without a note; empty in a new store.

    Raises:
        InputError: a note about a pair names no platform.
    """

    def __init__(self, store: Store) -> None:
        self.own: Platform = store.meta()
        self._notes = store.notes()
        self._own = _hash(self.own)
        self._pairs: dict[Pair, str] = {}
        self._platforms: dict[str, Platform] = {self._own: self.own}
        for name, hash_ in self._notes.items():
            if not is_pair_note(name):
                continue
            try:
                situation, _, seed = name.removeprefix(_PAIR).rpartition("/")
                self._pairs[situation, int(seed)] = hash_
                if hash_ not in self._platforms:
                    entries = json.loads(self._notes[_PLATFORM + hash_])
                    self._platforms[hash_] = {str(part): str(value) for part, value in entries.items()}
            except (ValueError, KeyError, AttributeError) as error:
                raise InputError(f"{store.path}: the note {name!r}={hash_!r} does not name a platform") from error

    def of(self, pair: Pair) -> Platform:
        """The platform of the flights of a pair."""
        return self._platforms[self._pairs.get(pair, self._own)]

    @property
    def several(self) -> bool:
        """Whether the flights of the store may come from more than one platform."""
        return bool(self._pairs)

    def only(self, ours: Platform) -> bool:
        """Whether every flight of the store has the bits of the platform `ours`."""
        return not self._pairs and self.equal(self.own, ours)

    def by_platform(self, flights: Iterable[F]) -> list[tuple[Platform, list[F]]]:
        """The flights of each platform; the platform with most flights is first."""
        listed = list(flights)
        if not self._pairs:  # the store has one platform
            return [(self.own, listed)] if listed else []
        groups = grouped(listed, lambda flight: self._pairs.get(pair_of(flight), self._own))
        most_first = sorted(groups.items(), key=lambda group: (-len(group[1]), group[0]))
        return [(self._platforms[hash_], group) for hash_, group in most_first]

    def equal(self, first: Platform, second: Platform) -> bool:
        """Whether the flights of two platforms have the same bits, as far as is known."""
        return not first or first == second or self.shown(BITS, first, second)

    def shown(self, what: str, first: Platform, second: Platform) -> bool:
        """Whether a sample showed `what` (`BITS` or `FACTS`) of two platforms."""
        return _shown(what, first, second) in self._notes or _shown(what, second, first) in self._notes

    def unproved(self, ours: Platform, flights: Iterable[F], *, only_bits: bool = False) -> list[str]:
        """The differences of each platform of `flights` from `ours`, without those of which a sample agreed on `ours`.

        Args:
            ours: a platform.
            flights: flights of the store, or their outcomes.
            only_bits: whether a sample must have had equal digests.
        """
        return [
            ", ".join(differences(ours, theirs))
            for theirs, _ in self.by_platform(flights)
            if not (self.equal(theirs, ours) or (not only_bits and self.shown(FACTS, theirs, ours)))
        ]

    def mixture(self, flights: Iterable[F]) -> str:
        """A sentence about flights that come from several platforms; empty for one platform."""
        groups = self.by_platform(flights)
        if len(groups) < 2:
            return ""
        (first, most), *rest = groups
        others = [
            f"{len(own)} of another ({', '.join(differences(other, first, '{} {}, not {}'))})" for other, own in rest
        ]
        return (
            f"{len(most)} flights of one platform and {' and '.join(others)}: "
            "each mutant is judged beside a baseline of its own platform"
        )


def warning_for(known: Platforms, flights: Iterable[F]) -> str:
    """The warning about the platforms of flights for verbs that only read; empty without one."""
    listed = list(flights)
    changed = "; ".join(known.unproved(fingerprint(), listed))
    unsampled = f"flown on another platform, and no sample was flown again on this one: {changed}" if changed else ""
    return "; ".join(filter(None, (known.mixture(listed), unsampled)))


def remember(store: Store, what: str, theirs: Platform, ours: Platform) -> None:
    """Record what a sample of flights of the platform `theirs` showed on the platform `ours`.

    Args:
        store: the store.
        what: `BITS` or `FACTS`.
        theirs, ours: the platforms.

    Raises:
        InputError: the store cannot be written.
    """
    store.set_notes({_shown(what, theirs, ours): json.dumps(dict(ours), sort_keys=True)})


def claim(store: Store, pairs: Iterable[Pair], ours: Platform) -> None:
    """Make `ours` the platform of `pairs`, and set the flights of another platform in these pairs apart as stale.

    The flights stay in the store under other keys, so nothing is lost.

    Raises:
        InputError: the store cannot be written.
    """
    notes = {_PLATFORM + _hash(ours): json.dumps(dict(ours), sort_keys=True)}
    with store.transaction() as connection:
        known, origins = Platforms(store), store.origins()
        for pair in set(pairs):
            theirs = known.of(pair)
            notes["{}{}/{}".format(_PAIR, *pair)] = _hash(ours)
            stored = "SELECT key, origin FROM outcomes WHERE situation = ? AND seed = ?"
            for key, number in connection.execute(stored, pair).fetchall() if theirs != ours else ():
                origin = origins.get(number)
                if origin is not None and origin.platform:  # it was set apart before
                    continue
                if origin is not None:
                    number = store.origin(origin._replace(platform=", ".join(differences(ours, theirs))))
                apart = sha256(f"{_digest(theirs)}\n{key}".encode()).hexdigest()  # a key that no request has
                # a flight that was set apart before for the same reason has the same bits: one is enough
                moved = "UPDATE OR REPLACE outcomes SET key = ?, origin = ? WHERE key = ?"
                connection.execute(moved, (apart, number, key))
        connection.executemany(
            "INSERT OR REPLACE INTO meta VALUES (?, ?)", [(NOTE + name, text) for name, text in notes.items()]
        )


def set_apart(store: Store) -> list[Planned]:
    """The flights that were set apart, as entries of a plan, which carry their origins into another store."""
    origins = {number: origin for number, origin in store.origins().items() if origin.platform}
    return [
        Planned(flight.key, flight.mutant, flight.situation, flight.seed, origin=origins[flight.origin])
        for flight in store.flights()
        if flight.origin in origins
    ]


def pair_of(flown: FlownFlight | Outcome) -> Pair:
    """The pair of a flight."""
    return flown.situation, flown.seed


def is_pair_note(name: str) -> bool:
    """Whether a note says which platform flew a pair, so that it holds in its own store only."""
    return name.startswith(_PAIR)


def _shown(what: str, theirs: Platform, ours: Platform) -> str:
    """The name of the note about a sample of `theirs` on `ours`."""
    return f"{what}: {_hash(theirs)} {_hash(ours)}"


def _hash(platform: Platform) -> str:
    """A short name of a platform."""
    return _digest(platform)[:16]


def _digest(platform: Platform) -> str:
    return sha256(json.dumps(dict(platform), sort_keys=True).encode()).hexdigest()
