"""Where an outcome comes from: content hashes of everything that can change it, part by part, and its key from them."""

from __future__ import annotations

import hashlib
from typing import NamedTuple


class Origin(NamedTuple):
    """Content hashes; empty where the part does not enter the flight.

    Attributes:
        sim: the documents of `sim/` that enter every flight.
        requirements: what flights are judged by.
        code: the sources that fly and judge.
        mutant: what is patched in; empty for the baseline.
        situation: what the situation changes in the world.
        realised: for a baseline, by which formulas the situation's values come true.
        platform: of a flight whose bits an earlier platform made: how that platform differs; empty while it counts.
    """

    sim: str
    requirements: str
    code: str
    mutant: str
    situation: str
    realised: str = ""
    platform: str = ""

    def key(self, seed: int) -> str:
        """The content hash of the flight with this seed."""
        parts = [f"{name}={value}" for name, value in zip(self._fields, self, strict=True) if value]
        return hashlib.sha256("\n".join([*parts, f"seed={seed}"]).encode()).hexdigest()

    def changed(self, now: Origin) -> tuple[str, ...]:
        """Names of the parts that are others in `now`."""
        return tuple(name for name in self._fields if getattr(self, name) != getattr(now, name))
