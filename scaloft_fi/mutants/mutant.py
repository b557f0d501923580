"""Mutants as pure data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from scaloft_fi.errors import InputError, shown
from scaloft_fi.hazop.matrix import Name, ValueText


@dataclass(frozen=True)
class Mutant:
    """One fault, ready to be patched in.

    Attributes:
        id: canonical id.
        guideword: of the cell that it realises.
        parameter: of the cell that it realises.
        magnitude: as in the id, with its unit; empty where the fault has no ladder.
        phase_s: shift of a periodic fault [s].
        seam: name of the seam where it is patched in; `every` for PLACEBO.
        operator: name of the operator, which alters the samples.
        arguments: of the operator, checked; one that is missing has the operator's default.
        event: name of the event of the flight at which it strikes; empty when it strikes at times.
    """

    id: str
    guideword: str
    parameter: str
    magnitude: str
    phase_s: float
    seam: str
    operator: str
    arguments: Mapping[str, ValueText] = field(default_factory=dict, hash=False)
    event: str = ""

    @property
    def name(self) -> Name:
        """The parts of the id."""
        return Name(self.guideword, self.parameter, self.magnitude, self.phase_s, self.event)

    @property
    def cell(self) -> str:
        """Name of the cell that it realises."""
        return self.name.cell

    def to_json(self) -> dict[str, Any]:
        """Plain data that JSON can hold; an infinite argument is the text `inf`, an empty event is left out."""
        arguments = {name: "inf" if value == math.inf else value for name, value in self.arguments.items()}
        names = (name for name in self.__dataclass_fields__ if name != "event" or self.event)
        return {name: getattr(self, name) for name in names} | {"arguments": arguments}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Mutant:
        """Read what `to_json` wrote.

        Raises:
            InputError: a key is missing or unknown.
        """
        expected = set(cls.__dataclass_fields__)
        if wrong := expected ^ {*data, "event"}:
            key = sorted(wrong)[0]
            raise InputError(f"key {shown(key)} is {'missing' if key in expected else 'unknown'}")
        arguments = {name: math.inf if value == "inf" else value for name, value in data["arguments"].items()}
        return cls(**{**data, "arguments": arguments})


EVERY_SEAM = "every"
PLACEBO = Mutant("PLACEBO", "", "", "", 0.0, EVERY_SEAM, "identity")
"""The identity on every seam at once: it must fly as the baseline does, bit for bit."""
