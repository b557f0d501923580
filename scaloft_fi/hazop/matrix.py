"""The deviation matrix: every guideword applied to every parameter; cells, faults, ladders of magnitudes, severities.

SeverityClass orders and groups.  It enters no ratio and no verdict.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

from scaloft_fi.document import Item, is_there, load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.name import Name


@dataclass(frozen=True)
class Guideword:
    """One way to deviate from the design intent.

    Attributes:
        id: the word as it stands in a mutant's id, capital letters.
        title: the word as people write it.
        meaning: which deviation it stands for.
        extension: True when it is not one of IEC 61882.
        reason: why an extension is needed, else empty.
    """

    id: str
    title: str
    meaning: str
    extension: bool = False
    reason: str = ""


@dataclass(frozen=True)
class Parameter:
    """One quantity that flows through the stack, with its design intent.

    Attributes:
        id: the name as it stands in a mutant's id, small letters.
        title: the name as it is spoken.
        intent: the design intent every deviation is a deviation from.
        node: the stages of the stack between which it flows.
        unit: what it is measured in.
    """

    id: str
    title: str
    intent: str
    node: str
    unit: str


SEVERITIES = "severities.yaml"
"""File of the classes in `hazop/`; a study without it has no severity."""
UNCLASSED = "no class"
"""Heading of what has no class; no class can have this id."""

Entry = TypeVar("Entry")


@dataclass(frozen=True)
class SeverityClass:
    """A class of severity.

    Attributes:
        rank: its place in the study's list; 0 is the worst.
        id: name of the class, small letters.
        title: the class as people call it.
        meaning: which consequences belong to it.
    """

    rank: int
    id: str
    title: str
    meaning: str


def load_severities(path: Path) -> tuple[SeverityClass, ...]:
    """Read the classes, worst first; none where the study has no such file.

    Raises:
        InputError: an id is not in small letters, a key is missing or unknown.
    """
    classes = []
    for rank, (name, item) in enumerate(load(path).mapping().items() if is_there(path) else ()):
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
            raise InputError(f"{item.place}: name {name!r} must be small letters, digits and _")
        classes.append(SeverityClass(rank, name, item.need("title").text(), item.need("meaning").text()))
        item.close()
    return tuple(classes)


def read_severity(cell: Item, classes: Iterable[SeverityClass]) -> SeverityClass | None:
    """Read the class of a cell; None where the cell has none.

    Args:
        cell: entry of the cell in the file of a parameter.
        classes: of the study.

    Raises:
        InputError: the class is unknown, the study has no classes, or the cell is not credible.
    """
    entry = cell.get("severity")
    if entry is None:
        return None
    if cell.need("status").value != CellStatus.CREDIBLE:
        raise entry.error("left out where the cell is not credible")
    by_id = {one.id: one for one in classes}
    if not by_id:
        raise entry.error(f"left out in a study without classes: hazop/{SEVERITIES} lists them")
    return by_id[entry.choice(tuple(by_id))]


def worst_first(entries: Iterable[Entry], severity: Callable[[Entry], SeverityClass | None]) -> list[Entry]:
    """The entries by class, the worst first and those without a class last; within a class the order stays.

    >>> worst_first("ba", {"a": SeverityClass(0, "injury", "", "")}.get)
    ['a', 'b']
    """

    def place(entry: Entry) -> tuple[bool, int]:
        found = severity(entry)
        return found is None, found.rank if found else 0

    return sorted(entries, key=place)


def class_of(severity: SeverityClass | None) -> str:
    """The id of a class as tables show it; empty where there is none."""
    return severity.id if severity else ""


Value = float | str | bool
Rung = float | str

PHASE_SHARES = (0.0, 0.25, 0.5, 0.75)
"""Phases of a periodic fault in the catalogue, as shares of its period."""

PERIODS = ("period_s", "at_s")
"""Arguments that a phase is a share of: the period of a fault, or the moment of a fault that happens once [s]."""


class CellStatus(StrEnum):
    """How the study classifies a cell."""

    CREDIBLE = "credible"
    CONTROL = "control"
    NOT_MEANINGFUL = "not_meaningful"


@dataclass(frozen=True)
class Magnitude:
    """The magnitudes of a fault, in the unit that an engineer would use.

    Attributes:
        argument: the operator's argument that the magnitude sets.
        unit: of the ladder's numbers, as in a mutant's id; empty when the ladder has names or numbers without a unit.
        ladder: the magnitudes in the catalogue, in the order of the study.
        default: the magnitude that the name of the cell alone stands for.
        scale: the operator's argument is scale x magnitude (5 ms: 0.001; 2 EV under-exposed: -1).
        worse: which magnitudes are worse: `larger`, `smaller` or `unordered`; empty when the ladder's order shows it.
        neutral: the magnitude that changes nothing; None when it follows from the unit.
        place: file:line.
    """

    argument: str
    unit: str
    ladder: tuple[Rung, ...]
    default: Rung
    scale: float = 1.0
    worse: str = ""
    neutral: float | None = None
    place: str = field(default="", compare=False)

    def text(self, rung: Rung) -> str:
        """Write the magnitude as it stands in a mutant's id.

        >>> Magnitude("delay_s", "ms", (5.0, 20.0), 20.0, 0.001).text(20.0)
        '20ms'
        """
        return rung if isinstance(rung, str) else f"{rung:g}{self.unit}"

    def value(self, rung: Rung) -> Rung:
        """Return what the operator's argument becomes; twelve digits, so that 70 % is 0.7.

        >>> Magnitude("share", "%", (70.0,), 70.0, 0.01).value(70.0)
        0.7
        """
        return rung if isinstance(rung, str) else float(f"{rung * self.scale:.12g}")


@dataclass(frozen=True)
class Expected:
    """The expectation that a fault alters nothing in the reference grid.

    Attributes:
        reason: why the fault alters nothing.
        magnitudes: for which the expectation holds; empty means all.
        status: the expected status, always `not_infected` (which includes a seam that carries nothing).
        place: file:line.
    """

    reason: str
    magnitudes: tuple[Rung, ...] = ()
    status: str = "not_infected"
    place: str = field(default="", compare=False)

    def holds_for(self, rung: Rung | None) -> bool:
        """Whether the expectation holds for this magnitude (None when the fault has no ladder)."""
        return not self.magnitudes or rung in self.magnitudes


@dataclass(frozen=True)
class Fault:
    """A fault that produces a deviation: an operator at a seam.

    Attributes:
        seam: where the operator is patched in.
        operator: the declared function that alters the samples.
        message: type of the samples; None where the stack's seams were not at hand.
        arguments: the operator's fixed arguments.
        magnitude: the argument that varies, or None.
        phases: True for a fault that the catalogue also has at later phases of its period, and at events of the flight.
        events: of a fault with phases, by name of an event why it can come in no flight of the study; "" if it can.
        expected: the expectation about its status, or None.
        place: file:line of the fault.
        places: file:line of `seam`, `operator`, `phases` and each argument.
    """

    seam: str
    operator: str
    arguments: Mapping[str, Value] = field(default_factory=dict)
    magnitude: Magnitude | None = None
    phases: bool = False
    events: Mapping[str, str] = field(default_factory=dict, compare=False)
    expected: Expected | None = None
    message: type | None = field(default=None, compare=False)
    place: str = field(default="", compare=False)
    places: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    def place_of(self, name: str) -> str:
        """Return file:line of `seam`, `operator`, `phases` or an argument; of the fault when there is no such line."""
        if self.magnitude is not None and name == self.magnitude.argument:
            return self.magnitude.place
        return self.places.get(name, self.place)

    @property
    def rungs(self) -> tuple[Rung | None, ...]:
        """The ladder; a single None when the fault has no ladder."""
        return self.magnitude.ladder if self.magnitude else (None,)

    def phases_s(self, rung: Rung | None) -> tuple[float, ...]:
        """The catalogue's phases at this magnitude [s], 0 first; only 0 for a fault without phases."""
        period_s = self.period_s(rung)
        return (0.0,) if period_s is None else tuple(share * period_s for share in PHASE_SHARES)

    def events_of(self, rung: Rung | None) -> tuple[str, ...]:
        """The events at which the catalogue has the fault at this magnitude.

        Where the magnitude is the period, all magnitudes strike at the same occurrences or nearly so: the default does.
        """
        magnitude = self.magnitude
        if magnitude is not None and magnitude.argument in PERIODS and rung != magnitude.default:
            return ()
        return tuple(name for name, why_not in self.events.items() if not why_not)

    def period_s(self, rung: Rung | None) -> float | None:
        """Return the period of the fault, or the moment of a fault that happens once [s]; None without phases."""
        if not self.phases:
            return None
        values = dict(self.arguments)
        if self.magnitude is not None and rung is not None:
            values[self.magnitude.argument] = self.magnitude.value(rung)
        return next((float(values[name]) for name in PERIODS if name in values), None)

    def expects(self, rung: Rung | None) -> Expected | None:
        """Return the expectation that holds for this magnitude, or None."""
        return self.expected if self.expected is not None and self.expected.holds_for(rung) else None


@dataclass(frozen=True)
class Cell:
    """One guideword applied to one parameter.

    Attributes:
        guideword, parameter: their ids.
        status: credible, a control, or not meaningful.
        deviation: how the parameter differs from the design intent.  A cell that is not meaningful has no deviation,
            and its attributes below are empty too.
        causes: what could cause the deviation in this stack.
        effect: the local effect, then the effect on the flight.
        requirements: names of the requirements at risk.
        faults: the faults that produce the deviation; the first is the default.
        reason: why the cell is not meaningful (empty otherwise).
        predicted: the effect that the study predicts, free text.
        place: file:line of the cell.
        requirements_place: file:line of the requirements.
    """

    guideword: str
    parameter: str
    status: CellStatus
    deviation: str = ""
    causes: tuple[str, ...] = ()
    effect: str = ""
    requirements: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()
    reason: str = ""
    predicted: str = ""
    place: str = field(default="", compare=False)
    requirements_place: str = field(default="", compare=False)

    @property
    def name(self) -> str:
        """`GUIDEWORD-parameter`, the stem of its mutants' ids."""
        return f"{self.guideword}-{self.parameter}"

    @property
    def told(self) -> str:
        """The deviation, or the reason why there is none."""
        return self.deviation or self.reason

    @property
    def default_id(self) -> str:
        """Id of the mutant that the cell's bare name stands for."""
        return str(Name(self.guideword, self.parameter, self.default_magnitude))

    @property
    def default_magnitude(self) -> str:
        """The magnitude of the default mutant, as in its id; empty when the default fault has no ladder."""
        magnitude = self.faults[0].magnitude if self.faults else None
        return magnitude.text(magnitude.default) if magnitude else ""

    def mutant_ids(self, fault: Fault, rung: Rung | None) -> tuple[str, ...]:
        """Return the canonical ids of `fault` at this magnitude, one for each phase of the catalogue: 0, times, events.

        >>> pulse = Fault("collision", "false_flag", {}, Magnitude("period_s", "s", (20.0,), 20.0), phases=True)
        >>> Cell("UNINTENDED", "collision", CellStatus.CREDIBLE).mutant_ids(pulse, 20.0)[:2]
        ('UNINTENDED-collision@20s', 'UNINTENDED-collision@20s#5s')
        """
        magnitude = "" if fault.magnitude is None or rung is None else fault.magnitude.text(rung)
        phases = [(phase_s, "") for phase_s in fault.phases_s(rung)] + [(0.0, name) for name in fault.events_of(rung)]
        return tuple(str(Name(self.guideword, self.parameter, magnitude, *phase)) for phase in phases)


class Worse(StrEnum):
    """The direction in which a fault gets worse."""

    LARGER = "larger"
    SMALLER = "smaller"
    UNORDERED = "unordered"
    """No magnitude is more than another: they are names, or places in a list."""


def worse(magnitude: Magnitude) -> Worse:
    """The direction that the study declares; without one, the direction of the ladder, which runs from mild to strong.

    >>> worse(Magnitude("delay_s", "s", (0.5, 1.0), 1.0)), worse(Magnitude("axis", "", ("x", "y"), "x"))
    (<Worse.LARGER: 'larger'>, <Worse.UNORDERED: 'unordered'>)
    """
    if magnitude.worse:
        return Worse(magnitude.worse)
    numbers = [rung for rung in magnitude.ladder if not isinstance(rung, str)]
    if len(numbers) < 2 or len(numbers) < len(magnitude.ladder):
        return Worse.UNORDERED
    if all(milder < stronger for milder, stronger in pairwise(numbers)):
        return Worse.LARGER
    return Worse.SMALLER if all(milder > stronger for milder, stronger in pairwise(numbers)) else Worse.UNORDERED


def neutral(magnitude: Magnitude) -> float | None:
    """The magnitude that changes nothing and need not be flown; None when there is no such magnitude.

    It is the one that the study declares; without one, 1 for a factor (unit x), 0 for a magnitude that gets worse as it
    grows, and 100 % for a share that gets worse as it shrinks.

    >>> neutral(Magnitude("delay_s", "s", (0.5, 1.0), 1.0)), neutral(Magnitude("factor", "x", (0.9, 0.5), 0.5))
    (0.0, 1.0)
    >>> neutral(Magnitude("share", "%", (90.0, 50.0), 50.0)), neutral(Magnitude("period_s", "s", (60.0, 5.0), 5.0))
    (100.0, None)
    """
    if magnitude.neutral is not None:
        return magnitude.neutral
    direction = worse(magnitude)
    if direction is Worse.UNORDERED:
        return None
    if magnitude.unit == "x":
        return 1.0
    if direction is Worse.LARGER:
        return 0.0
    return 100.0 if magnitude.unit == "%" else None


def mild_to_strong(magnitude: Magnitude) -> tuple[float, ...]:
    """The ladder from mild to strong; empty when the ladder has no order."""
    direction = worse(magnitude)
    numbers = (rung for rung in magnitude.ladder if not isinstance(rung, str))
    return () if direction is Worse.UNORDERED else tuple(sorted(numbers, reverse=direction is Worse.SMALLER))


@dataclass(frozen=True)
class Matrix:
    """A total map guideword x parameter -> cell.

    Iterates over its cells, parameter by parameter, in the order of the study.

    Attributes:
        guidewords: in the order of the study.
        parameters: in the order of the study.
        cells: by (guideword id, parameter id).
        classes: of severity, worst first; empty in a study without them.
        severities: class of each cell that has one, by the cell's name.

    Raises:
        ValueError: a cell is missing, or one stands under a name that is not its own.
    """

    guidewords: tuple[Guideword, ...]
    parameters: tuple[Parameter, ...]
    cells: Mapping[tuple[str, str], Cell]
    classes: tuple[SeverityClass, ...] = ()
    severities: Mapping[str, SeverityClass] = field(default_factory=dict)

    def __post_init__(self) -> None:
        keys = {(word.id, parameter.id) for word in self.guidewords for parameter in self.parameters}
        if keys != set(self.cells):
            raise ValueError(f"the matrix is not total: {sorted(keys ^ set(self.cells))}")
        for key, cell in self.cells.items():
            if key != (cell.guideword, cell.parameter):
                raise ValueError(f"{cell.name} stands under {key}")

    def __iter__(self) -> Iterator[Cell]:
        return (self.cells[word.id, parameter.id] for parameter in self.parameters for word in self.guidewords)

    def __len__(self) -> int:
        return len(self.cells)

    def __contains__(self, name: object) -> bool:
        return name in self._by_name

    @cached_property
    def _by_name(self) -> Mapping[str, Cell]:
        return {cell.name: cell for cell in self}

    def cell(self, name: str) -> Cell:
        """Find the cell called `GUIDEWORD-parameter`.

        Raises:
            InputError: there is none; it says which is the nearest.
        """
        if name in self._by_name:
            return self._by_name[name]
        names = {known.casefold(): known for known in self._by_name}
        hint = did_you_mean(names.get(name.casefold(), name), names.values())
        raise InputError(f"no cell {name!r}{hint}")

    def counts(self) -> dict[CellStatus, int]:
        """Count the cells of each status."""
        return {status: sum(cell.status is status for cell in self) for status in CellStatus}

    def only(self, guidewords: Collection[str] = (), parameters: Collection[str] = ()) -> Matrix:
        """Keep the part of the matrix under these guidewords and parameters; an argument that is not given means all.

        Raises:
            InputError: a name is not in the matrix.
        """
        words = tuple(word for word in self.guidewords if word.id in guidewords or not guidewords)
        kept = tuple(parameter for parameter in self.parameters if parameter.id in parameters or not parameters)
        _all_known("guideword", guidewords, [word.id for word in self.guidewords])
        _all_known("parameter", parameters, [parameter.id for parameter in self.parameters])
        cells = {(w.id, p.id): self.cells[w.id, p.id] for w in words for p in kept}
        return replace(self, guidewords=words, parameters=kept, cells=cells)


def _all_known(noun: str, names: Collection[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise InputError(f"no {noun} {name!r}{did_you_mean(name, known)}")
