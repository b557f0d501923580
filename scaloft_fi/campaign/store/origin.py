"""The origin of an outcome: hashes of everything that can change it, part by part, from which its key follows."""

from __future__ import annotations

import hashlib
from typing import NamedTuple


class Origin(NamedTuple):
    """Hashes of the parts; empty for a part that does not affect the flight.

    Attributes:
        sim: the documents of `sim/` that decide every flight.
        requirements: the requirements.
        code: the modules that fly and judge every flight.
        mutant: the mutant; empty for the baseline.
        situation: the values that the situation sets in the world.
        realised: for a baseline, the predicates of the situation's values.
        operator: for a mutant, the modules that only its operator needs.
        platform: not a hash: differences of an earlier platform that made a stale flight; empty for other flights.
    """

    sim: str
    requirements: str
    code: str
    mutant: str
    situation: str
    realised: str = ""
    operator: str = ""
    platform: str = ""

    def key(self, seed: int) -> str:
        """The key of the flight with this seed."""
        parts = [f"{name}={value}" for name, value in zip(self._fields, self, strict=True) if value]
        return hashlib.sha256("\n".join([*parts, f"seed={seed}"]).encode()).hexdigest()

    def changed(self, now: Origin) -> tuple[str, ...]:
        """Names of the parts that differ in `now`."""
        return tuple(name for name in self._fields if getattr(self, name) != getattr(now, name))
