"""Mutants as pure data, and the grammar of their ids: `GUIDEWORD-parameter[@magnitude][#phase]`."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.cell import Rung, Value

_ID = re.compile(
    r"(?P<cell>(?P<guideword>[A-Z][A-Z0-9]*)-(?P<parameter>[a-z][a-z0-9_]*))"
    r"(@(?P<magnitude>[A-Za-z0-9_.%+-]+))?(#(?P<phase>[0-9]+(\.[0-9]+)?|\.[0-9]+)s)?"
)
_NUMBER = re.compile(
    r"(?P<number>[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|inf)(?P<unit>([A-Za-z%][A-Za-z0-9%]*)?)"
)


@dataclass(frozen=True)
class Name:
    """The parts of an id, as they were written.

    Attributes:
        guideword, parameter: of the cell.
        magnitude: as written, empty when there is none.
        phase_s: shift of a periodic fault [s], 0 when there is none.
    """

    guideword: str
    parameter: str
    magnitude: str = ""
    phase_s: float = 0.0

    @property
    def cell(self) -> str:
        """Name of the cell."""
        return f"{self.guideword}-{self.parameter}"

    def __str__(self) -> str:
        """The canonical spelling.

        >>> str(parse("UNINTENDED-human@20s#05.0s"))
        'UNINTENDED-human@20s#5s'
        """
        return self.cell + f"@{self.magnitude}" * bool(self.magnitude) + f"#{self.phase_s:g}s" * bool(self.phase_s)


def parse(text: str) -> Name:
    """Split an id into its parts.

    Raises:
        InputError: it is not of the form GUIDEWORD-parameter[@magnitude][#phase].
    """
    match = _ID.fullmatch(text)
    if match is None:
        raise InputError(
            f"mutant {text!r} must be of the form GUIDEWORD-parameter[@magnitude][#phase], as LATE-human@3s"
        )
    return Name(match["guideword"], match["parameter"], match["magnitude"] or "", float(match["phase"] or 0.0))


def split_magnitude(text: str) -> tuple[Rung, str]:
    """A magnitude's number and unit; a magnitude that is a word has no unit.

    >>> split_magnitude("2.50s"), split_magnitude("2EV"), split_magnitude("yaw"), split_magnitude("infs")
    ((2.5, 's'), (2.0, 'EV'), ('yaw', ''), (inf, 's'))
    """
    match = _NUMBER.fullmatch(text)
    # six significant digits, as `Magnitude.text` writes them
    return (float(f"{float(match['number']):g}"), match["unit"]) if match else (text, "")


@dataclass(frozen=True)
class Mutant:
    """One fault, ready to be patched in.

    Attributes:
        id: canonical id.
        guideword, parameter: of the cell that it realises.
        magnitude: as in the id, with its unit; empty where the fault has no ladder.
        phase_s: shift of a periodic fault [s].
        seam: name of the seam; `EVERY_SEAM` for PLACEBO.
        operator: name of the operator.
        arguments: of the operator, checked; an argument that is missing has the operator's default.
    """

    id: str
    guideword: str
    parameter: str
    magnitude: str
    phase_s: float
    seam: str
    operator: str
    arguments: Mapping[str, Value] = field(default_factory=dict, hash=False)

    @property
    def name(self) -> Name:
        """The parts of the id."""
        return Name(self.guideword, self.parameter, self.magnitude, self.phase_s)

    @property
    def cell(self) -> str:
        """Name of the cell that it realises."""
        return self.name.cell

    def to_json(self) -> dict[str, Any]:
        """Plain data that JSON can hold; an infinite argument is written as the text `inf`."""
        arguments = {name: "inf" if value == math.inf else value for name, value in self.arguments.items()}
        return asdict(self) | {"arguments": arguments}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Mutant:
        """Read what `to_json` wrote.

        Raises:
            InputError: a key is missing or unknown.
        """
        expected = set(cls.__dataclass_fields__)
        if set(data) != expected:
            key = sorted(expected ^ set(data))[0]
            raise InputError(f"key {key!r} is {'missing' if key in expected else 'unknown'}")
        arguments = {name: math.inf if value == "inf" else value for name, value in data["arguments"].items()}
        return cls(**{**data, "arguments": arguments})


EVERY_SEAM = "every"
PLACEBO = Mutant("PLACEBO", "", "", "", 0.0, EVERY_SEAM, "identity")
"""The identity on every seam at once: it must fly as the baseline does, bit for bit."""
