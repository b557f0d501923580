"""The grammar of mutants' ids: `GUIDEWORD-parameter[@magnitude][#phase]`; a phase is a time or the name of an event."""

from __future__ import annotations

import re
from dataclasses import dataclass

from scaloft_fi.errors import InputError

_CELL = re.compile(r"(?P<guideword>[A-Z][A-Z0-9]*)-(?P<parameter>[a-z][a-z0-9_]*)")
_ID = re.compile(
    rf"{_CELL.pattern}"
    r"(@(?P<magnitude>[A-Za-z0-9_.%+-]+))?(#((?P<phase>[0-9]+(\.[0-9]+)?|\.[0-9]+)s|(?P<event>[a-z][a-z0-9_]*)))?"
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
        event: name of the event of the flight at which the fault strikes; empty when it strikes at times.
    """

    guideword: str
    parameter: str
    magnitude: str = ""
    phase_s: float = 0.0
    event: str = ""

    @property
    def cell(self) -> str:
        """Name of the cell."""
        return f"{self.guideword}-{self.parameter}"

    @property
    def phase(self) -> str:
        """The phase as in an id, such as `#5s` or `#waypoint`; empty for a fault that is not shifted."""
        return f"#{self.event}" if self.event else f"#{self.phase_s:g}s" * bool(self.phase_s)

    def __str__(self) -> str:
        """The canonical spelling.

        >>> str(parse("UNINTENDED-human@20s#05.0s")), str(parse("NO-depth@3s#waypoint"))
        ('UNINTENDED-human@20s#5s', 'NO-depth@3s#waypoint')
        """
        return self.cell + f"@{self.magnitude}" * bool(self.magnitude) + self.phase


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
    magnitude, phase_s, event = match["magnitude"] or "", float(match["phase"] or 0.0), match["event"] or ""
    return Name(match["guideword"], match["parameter"], magnitude, phase_s, event)


def names_event(text: str) -> bool:
    """Whether an id can hold the text as the name of an event."""
    return bool((match := _ID.fullmatch(f"NO-x#{text}")) and match["event"])


def split_magnitude(text: str) -> tuple[float | str, str]:
    """A magnitude's number and unit; a magnitude that is a word has no unit.

    >>> split_magnitude("2.50s"), split_magnitude("2EV"), split_magnitude("yaw"), split_magnitude("infs")
    ((2.5, 's'), (2.0, 'EV'), ('yaw', ''), (inf, 's'))
    """
    match = _NUMBER.fullmatch(text)
    # six significant digits, as `Magnitude.text` writes them
    return (float(f"{float(match['number']):g}"), match["unit"]) if match else (text, "")


def cell_of(mutant: str) -> str:
    """The cell's name, with which a mutant's id begins; what is no id, such as `baseline`, stands for itself.

    >>> cell_of("UNINTENDED-collision@20s#5s"), cell_of("baseline")
    ('UNINTENDED-collision', 'baseline')
    """
    found = _CELL.match(mutant)
    return found[0] if found else mutant
