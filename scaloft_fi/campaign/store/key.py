"""Keys of flights: a hash of everything that can change the outcome of a flight."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.campaign.store.tables import Planned
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.study import Study


class Keys:
    """The keys of a study's flights; each mutant and each situation is hashed once.

    Args:
        study: the current study; later changes of its files are not noticed.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self._mutants: dict[Mutant, str] = {}
        self._situations: dict[str, tuple[str, str]] = {}

    def origin(self, flight: Flight) -> Origin:
        """The origin of the flight's outcome.

        Values of an axis that the situation does not have, other mutants and comments do not count.
        """
        situation, realised = self._situation(flight)
        inputs = self._study.inputs
        return Origin(
            sim=inputs["sim"],
            requirements=inputs["requirements"],
            code=inputs["code"],
            mutant=self._mutant(flight.mutant) if flight.mutant else "",
            situation=situation,
            realised="" if flight.mutant else realised,
            operator=inputs[f"operator {flight.mutant.operator}"] if flight.mutant else "",
        )

    def key(self, flight: Flight) -> str:
        """The key of a flight."""
        return self.origin(flight).key(flight.seed)

    def planned(self, flight: Flight, *, canary: bool = False) -> Planned:
        """The entry of a flight in the plan of the store."""
        origin = self.origin(flight)
        return Planned(origin.key(flight.seed), flight.subject.id, flight.situation.key, flight.seed, canary, origin)

    def _mutant(self, mutant: Mutant) -> str:
        if mutant not in self._mutants:
            self._mutants[mutant] = digest(mutant.to_json())
        return self._mutants[mutant]

    def _situation(self, flight: Flight) -> tuple[str, str]:
        """Hashes of the values that the situation sets, and of the predicates of its values."""
        key = flight.situation.key
        if key not in self._situations:
            changes, realised = self._study.changes(flight.situation), self._study.realised(flight.situation)
            self._situations[key] = digest([key, changes]), digest(realised)
        return self._situations[key]


def flight_key(study: Study, flight: Flight) -> str:
    """The key of one flight; for many flights `Keys` is faster."""
    return Keys(study).key(flight)


def digest(content: Any) -> str:
    """A hash of plain JSON values, independent of the order of keys."""
    text = json.dumps(content, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()
