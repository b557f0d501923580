"""The deviation matrix: every guideword applied to every parameter; cells, faults, ladders of magnitudes, severities.

The ids of mutants are `GUIDEWORD-parameter[@magnitude][#phase]`; a phase is a time or the name of an event.
SeverityClass orders and groups.  It enters no ratio and no verdict.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Annotated, ClassVar, Literal, TypeVar

from scaloft_fi import marks
from scaloft_fi.document import Item, is_there, load, parse_date
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.model import attributes_of, value_of

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


@dataclass(frozen=True)
class Guideword:
    """One way to deviate from the design intent.

    Attributes:
        id: the word as it stands in a mutant's id, capital letters.
        title: name of the guideword for people.
        meaning: what the guideword asks of a parameter, in a few words.
        extension: whether IEC 61882 does not have the guideword; `reason` says why the study has it.
        reason: why the study has this guideword beside those of IEC 61882; empty for one of them.
    """

    id: marks.Key
    title: Annotated[str, marks.Examples("late")]
    meaning: Annotated[str, marks.Examples("later than intended")]
    extension: bool = False
    reason: str = ""
    CONDITIONS: ClassVar[Mapping[str, object]] = {
        "dependentRequired": {"reason": ["extension"]},
        "if": {"properties": {"extension": {"const": True}}, "required": ["extension"]},
        "then": {"required": ["reason"]},
        "else": {"properties": {"reason": False}},
    }

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse an extension without a reason, and a reason without an extension."""
        if self.extension and not self.reason:
            yield InputError(f"{item.place}: {item.name} lacks the key 'reason': {attributes_of(Guideword)['reason']}")
        elif self.reason and not self.extension:
            place = item.need("reason").place
            yield InputError(
                f"{place}: unknown key 'reason' in {item.name}, which is no extension; allowed: 'extension'"
            )


@dataclass(frozen=True)
class Parameter:
    """One quantity that flows through the stack, with its design intent.

    Attributes:
        id: the name as it stands in a mutant's id, small letters.
        title: name of the parameter for people.
        intent: design intent: what the parameter should be when nothing is wrong.
        node: the part of the drone where the parameter flows.
        unit: unit of the parameter, or what one of its samples is.
    """

    id: marks.Key
    title: Annotated[str, marks.Examples("human detection")]
    intent: str
    node: str
    unit: Annotated[str, marks.Examples("m/s")]


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
        title: name of the class for people.
        meaning: which consequences belong to the class.
    """

    rank: Annotated[int, marks.Given(lambda _item: 0)]
    id: marks.Key
    title: Annotated[str, marks.Examples("a person may be hurt")]
    meaning: str


SEVERITY = "[a-z][a-z0-9_]*"
Classes = Annotated[tuple[SeverityClass, ...], marks.ByName(), marks.Pattern(SEVERITY, "small letters, digits and _")]


def load_severities(path: Path) -> tuple[SeverityClass, ...]:
    """Read the classes, worst first; none where the study has no such file.

    Raises:
        InputError: an id is not in small letters, a key is missing or unknown.
    """
    read = value_of(Classes, load(path)) if is_there(path) else ()
    return tuple(replace(one, rank=rank) for rank, one in enumerate(read))


def worst_first(entries: Iterable[Entry], severity: Callable[[Entry], SeverityClass | None]) -> list[Entry]:
    """The entries by class, the worst first and those without a class last; within a class the order stays.

    >>> worst_first("ba", {"a": SeverityClass(0, "injury", "", "")}.get)
    ['a', 'b']
    """
    return sorted(entries, key=lambda entry: found.rank if (found := severity(entry)) else math.inf)


def class_of(severity: SeverityClass | None) -> str:
    """The id of a class as tables show it; empty where there is none."""
    return severity.id if severity else ""


Value = float | str | bool
Rung = float | str
MOST_ENTRIES = 100
"""Most causes, requirements or faults of a cell, and most magnitudes of a ladder."""
SCALES: Mapping[str, Mapping[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "m": {"m": 1.0, "cm": 0.01, "mm": 1e-3, "km": 1e3},
    "mps": {"mps": 1.0, "cmps": 0.01, "mmps": 1e-3},
    "hz": {"Hz": 1.0, "kHz": 1e3},
    "deg": {"deg": 1.0, "rad": math.degrees(1.0)},
    "rad": {"rad": 1.0, "deg": math.radians(1.0), "mrad": 1e-3},
    "radps": {"radps": 1.0, "degps": math.radians(1.0)},
}
"""By the unit at the end of an argument's name, the units that a magnitude of it may have, each with its scale."""
_UNIT = r"[A-Za-z%][A-Za-z0-9%]*|"
_ANY_NUMBER = marks.Bounds(least=-1e12, most=1e12, infinite=True)
"""A magnitude or an argument; an operator may allow `.inf`, such as a hold that never ends."""
ValueText = Annotated[Value, _ANY_NUMBER, marks.About("a value; an infinite number is the text inf")]
RungText = Annotated[
    Rung, _ANY_NUMBER, marks.Pattern(r"[A-Za-z][A-Za-z0-9_.]*", "a number, or a name of letters, digits, _ and .")
]
_NOTHING = marks.Given(lambda _item: {})


def _places(item: Item) -> dict[str, str]:
    """The places of what a fault names."""
    arguments = item.get("arguments")
    named = {name: item.get(name) for name in ("seam", "operator", "phases")}
    named |= arguments.value if arguments is not None and isinstance(arguments.value, dict) else {}
    return {name: entry.place for name, entry in named.items() if entry is not None}


def written(rung: Rung) -> str:
    """A magnitude without its unit."""
    return rung if isinstance(rung, str) else f"{rung:g}"


PHASE_SHARES = (0.0, 0.25, 0.5, 0.75)
"""Phases of a periodic fault in the catalogue, as shares of its period."""

PERIODS = ("period_s", "at_s")
"""Arguments that a phase is a share of: the period of a fault, or the moment of a fault that happens once [s]."""


class CellStatus(StrEnum):
    """How the study classifies a cell."""

    CREDIBLE = "credible"
    CONTROL = "control"
    NOT_MEANINGFUL = "not_meaningful"
    TO_DO = "to_do"
    """A draft, as of a row of somebody's sheet: it is counted, and never flown."""


class Worse(StrEnum):
    """The direction in which a fault gets worse."""

    LARGER = "larger"
    SMALLER = "smaller"
    UNORDERED = "unordered"
    """No magnitude is more than another: they are names, or places in a list."""


_WORSE = {
    Worse.LARGER: "a larger magnitude is worse",
    Worse.SMALLER: "a smaller magnitude is worse",
    Worse.UNORDERED: "no magnitude is more than another",
}


@dataclass(frozen=True)
class Magnitude:
    """The magnitudes of a fault, in the unit that an engineer would use.

    Attributes:
        argument: the operator's argument that the magnitude sets.
        unit: of the numbers on the ladder, as in a mutant's id; empty for names, or numbers without a unit.
        ladder: the magnitudes in the catalogue, from mild to strong, all numbers or all names.
        default: the magnitude, on the ladder, that the name of the cell alone stands for.
        scale: the argument is scale x magnitude (5 ms: 0.001; 2 EV under-exposed: -1).
        worse: which magnitudes are worse; left out: as the numbers of the ladder run.
        neutral: the magnitude that changes nothing; left out: it follows from unit and order.
        place: file:line.
    """

    argument: Annotated[str, marks.Examples("delay_s")]
    unit: Annotated[
        str, marks.Otherwise(""), marks.Pattern(_UNIT, "a unit of letters, digits and %, as in a mutant's id")
    ]
    ladder: Annotated[tuple[RungText, ...], marks.Size(1, MOST_ENTRIES), marks.Examples((0.5, 1, 3, 5))]
    default: RungText
    scale: Annotated[float, marks.Examples(0.001, 0.01)] = 1.0
    worse: Annotated[str, marks.Choices(_WORSE)] = ""
    neutral: float | None = None
    place: marks.Place = field(default="", compare=False)
    KEYS = ("argument", "unit", "scale", "ladder=rungs", "default=default_rung")

    @property
    def rungs(self) -> tuple[str, ...]:
        """The magnitudes, as in ids."""
        return tuple(map(self.text, self.ladder))

    @property
    def default_rung(self) -> str:
        """The magnitude that the name of the cell stands for, as in ids."""
        return self.text(self.default)

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a ladder of unlike, equal or mixed rungs, a default that is not on it, and what only numbers have."""
        if len({type(rung) for rung in self.ladder}) > 1:
            yield item.need("ladder").error("all numbers or all names")
            return
        named = isinstance(self.ladder[0], str)
        if len(set(self.ladder)) < len(self.ladder):
            yield item.need("ladder").error("different magnitudes")
        elif len(self.ladder) > 1 and not named and worse(self) is Worse.UNORDERED and not self.worse:
            order = f"ladder=[{', '.join(map(written, self.ladder))}] must rise or fall, from mild to strong"
            yield InputError(f"{item.need('ladder').place}: {order}, unless `worse` says larger, smaller or unordered")
        if self.default not in self.ladder:
            yield item.need("default").error(f"on the ladder: {', '.join(map(written, self.ladder))}")
        if named and self.unit:
            yield item.need("unit").error("left out where the ladder holds names")
        if item.get("scale") is not None and (named or self.scale == 0):
            allowed = "left out where the ladder holds names" if named else "a finite number other than 0"
            yield item.need("scale").error(allowed)
        yield from self._misfit(item)
        if named and self.worse not in ("", Worse.UNORDERED):
            yield item.need("worse").error("left out where the ladder holds names")
        if self.neutral is not None and worse(self) is Worse.UNORDERED:
            yield item.need("neutral").error("left out where the ladder has no order")

    def _misfit(self, item: Item) -> Iterator[InputError]:
        """Refuse a unit that is not the argument's, or whose scale is another one."""
        base = self.argument.rpartition("_")[2] if "_" in self.argument else ""
        scales = SCALES.get(base)
        if scales is None or not self.unit:
            return
        of, scale = f"{self.argument} is in {next(iter(scales))}", scales.get(self.unit)
        if scale is None:
            known = ", ".join(
                unit if factor == 1.0 else f"{unit} (scale {factor:g})" for unit, factor in scales.items()
            )
            yield item.need("unit").error(f"one of {known}, because {of}")
        elif not math.isclose(abs(self.scale), scale, rel_tol=1e-4):
            key, needs = ("unit", "beside scale: ") if item.get("scale") is None else ("scale", "")
            yield item.need(key).error(f"{needs}{scale:g}, because {of}")

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
    """The expectation that the fault changes no sample in this grid; a run that shows otherwise says so.

    Attributes:
        reason: why the fault changes nothing.
        magnitudes: the magnitudes of the ladder for which it holds; left out: all.
        status: no sample differs, or the seam carries none.
        place: file:line.
    """

    reason: str
    magnitudes: Annotated[tuple[RungText, ...], marks.Size(1, MOST_ENTRIES)] = ()
    status: Annotated[Literal["not_infected"], marks.Needed()] = "not_infected"
    place: marks.Place = field(default="", compare=False)
    KEYS = ("status", "reason", "magnitudes")


@dataclass(frozen=True)
class Fault:
    """An operator at a seam.

    Attributes:
        seam: the seam whose samples the fault changes; `scaloft-fi seams` lists them.
        operator: the change; `scaloft-fi operators` lists them.
        arguments: fixed arguments of the operator, by name.
        magnitude: the argument that varies, in the unit of an engineer; left out: none varies.
        phases: whether the fault, whose period_s or at_s is known, is also flown shifted by 1/4, 1/2, 3/4 of that time,
            and at events of the flight.
        events: of a fault with phases, by name of an event why it can come in no flight of the study; "" if it can.
        expected: the expectation that the fault changes no sample in this grid.
        message: type of the samples; None where the stack's seams were not at hand.
        place: file:line of the fault.
        places: file:line of `seam`, `operator`, `phases` and each argument.
    """

    seam: Annotated[str, marks.Choices(named="seams"), marks.Examples("person", "velcmd")]
    operator: Annotated[str, marks.Choices(named="operators")]
    arguments: Mapping[str, ValueText] = field(default_factory=dict)
    magnitude: Magnitude | None = None
    phases: bool = False
    events: Annotated[Mapping[str, str], _NOTHING] = field(default_factory=dict, compare=False)
    expected: Expected | None = None
    message: Annotated[type | None, marks.Given(lambda _item: None)] = field(default=None, compare=False)
    place: marks.Place = field(default="", compare=False)
    places: Annotated[Mapping[str, str], marks.Given(_places)] = field(default_factory=dict, compare=False, repr=False)

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse an argument that is set twice, an expectation off the ladder, and phases of what has no period."""
        magnitude = self.magnitude
        if magnitude is not None and magnitude.argument in self.arguments:
            sentence = f"{magnitude.argument!r} is set by the magnitude and cannot be a fixed argument too"
            yield InputError(f"{self.places[magnitude.argument]}: {sentence}")
        for rung in self.expected.magnitudes if self.expected else ():
            if magnitude is None or rung not in magnitude.ladder:
                place = item.need("expected").need("magnitudes").place
                ladder = ", ".join(map(written, magnitude.ladder)) if magnitude else "none, the fault has no magnitude"
                yield InputError(f"{place}: magnitudes: {written(rung)} must be on the ladder: {ladder}")
        varied = (magnitude.argument,) if magnitude else ()
        if self.phases and not any(name in PERIODS for name in (*self.arguments, *varied)):
            allowed = f"must have its {' or '.join(PERIODS)}, of which a phase is a share"
            yield InputError(f"{item.place}: a fault with phases {allowed}")

    def place_of(self, name: str) -> str:
        """Return file:line of `seam`, `operator`, `phases` or an argument; of the fault when there is no such line."""
        if self.magnitude is not None and name == self.magnitude.argument:
            return self.magnitude.place
        return self.places.get(name, self.place)

    @property
    def rungs(self) -> tuple[Rung | None, ...]:
        """The ladder; a single None when the fault has no ladder."""
        return self.magnitude.ladder if self.magnitude else (None,)

    def strikes(self, rung: Rung | None) -> list[tuple[float, str]]:
        """When the catalogue has the fault strike at this magnitude: phase [s] and event, the unshifted one first.

        A phase is a share of the period, or of the moment of a fault that happens once.  Where the magnitude is the
        period, all magnitudes strike at the same occurrences of an event or nearly so: the default does.
        """
        magnitude, values = self.magnitude, dict(self.arguments)
        if magnitude is not None and rung is not None:
            values[magnitude.argument] = magnitude.value(rung)
        period_s = next((float(values[name]) for name in PERIODS if self.phases and name in values), None)
        phases = [(0.0, "")] if period_s is None else [(share * period_s, "") for share in PHASE_SHARES]
        if magnitude is not None and magnitude.argument in PERIODS and rung != magnitude.default:
            return phases
        return phases + [(0.0, name) for name, why_not in self.events.items() if not why_not]

    def expects(self, rung: Rung | None) -> Expected | None:
        """Return the expectation that holds for this magnitude, or None."""
        expected = self.expected
        return expected if expected and (not expected.magnitudes or rung in expected.magnitudes) else None


@dataclass(frozen=True)
class Team:
    """What only people can fill in.

    Attributes:
        safeguards: existing safeguards.
        likelihood: likelihood.
        recommendation: recommendation.
        responsible: responsible.
        due: due date.
        action_status: action status.
    """

    safeguards: str | None = None
    likelihood: str | None = None
    recommendation: str | None = None
    responsible: str | None = None
    due: str | None = None
    action_status: str | None = None

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a due date that no calendar has."""
        if self.due and re.fullmatch(r"\d{4}-\d\d-\d\d", self.due) and parse_date(self.due) is None:
            yield item.need("due").error("a date, as 2027-01-31, or words")


NO_TEAM = Team()


@dataclass(frozen=True)
class Cell:
    """One guideword applied to one parameter.

    Attributes:
        guideword: the guideword.
        parameter: the parameter.
        status: credible, a control, not meaningful, or to do.
        deviation: how the parameter differs from the design intent.  A cell that is not meaningful has no deviation,
            and its attributes below are empty too.
        causes: what could cause the deviation in this stack.
        effect: the local effect, then the effect on the flight.
        requirements: names of the requirements at risk.
        faults: the faults that produce the deviation; the first is the default.
        reason: why the cell is not meaningful (empty otherwise).
        predicted: the effect that the study predicts, free text.
        team: what only people can fill in.
        drafted: of a cell that is to do, the severity in the words of its sheet.
        proposed: of a cell that is to do, faults that its names suggest, which nobody has looked at.
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
    team: Team = NO_TEAM
    drafted: str = ""
    proposed: tuple[Fault, ...] = ()
    place: str = field(default="", compare=False)
    requirements_place: str = field(default="", compare=False)

    @property
    def name(self) -> str:
        """Its name, `GUIDEWORD-parameter`, the stem of its mutants' ids."""
        return f"{self.guideword}-{self.parameter}"

    @property
    def told(self) -> str:
        """The deviation, or the reason why there is none."""
        return self.deviation or self.reason or "to do"

    @property
    def flown(self) -> bool:
        """Whether it has mutants."""
        return self.status in (CellStatus.CREDIBLE, CellStatus.CONTROL)

    @property
    def bare(self) -> bool:
        """Whether it is to do, and nothing else is said of it."""
        return self == Cell(self.guideword, self.parameter, CellStatus.TO_DO)

    @property
    def default_id(self) -> str:
        """Id of the mutant that the cell's bare name stands for."""
        return str(Name(self.guideword, self.parameter, self.default_magnitude))

    @property
    def default_magnitude(self) -> str:
        """The magnitude of the default mutant, as in its id; empty when the default fault has no ladder."""
        magnitude = self.faults[0].magnitude if self.faults else None
        return magnitude.default_rung if magnitude else ""

    def mutant_ids(self, fault: Fault, rung: Rung | None) -> tuple[str, ...]:
        """Return the canonical ids of `fault` at this magnitude, one for each phase of the catalogue: 0, times, events.

        >>> pulse = Fault("collision", "false_flag", {}, Magnitude("period_s", "s", (20.0,), 20.0), phases=True)
        >>> Cell("UNINTENDED", "collision", CellStatus.CREDIBLE).mutant_ids(pulse, 20.0)[:2]
        ('UNINTENDED-collision@20s', 'UNINTENDED-collision@20s#5s')
        """
        magnitude = "" if fault.magnitude is None or rung is None else fault.magnitude.text(rung)
        return tuple(str(Name(self.guideword, self.parameter, magnitude, *when)) for when in fault.strikes(rung))


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


def falls_unsaid(magnitude: Magnitude) -> bool:
    """Whether nothing but the order of the ladder says that a smaller magnitude is worse.

    Of a period it is so, and where the mildest magnitude is below the one that changes nothing.

    >>> delay = falls_unsaid(Magnitude("delay_s", "s", (3.0, 1.0), 1.0))
    >>> delay, falls_unsaid(Magnitude("period_s", "s", (60.0, 5.0), 5.0))
    (True, False)
    """
    if magnitude.worse or worse(magnitude) is not Worse.SMALLER or magnitude.argument in PERIODS:
        return False
    unchanged = neutral(magnitude)
    return unchanged is None or not mild_to_strong(magnitude)[0] < unchanged


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
        if wrong := keys ^ set(self.cells):
            raise ValueError(f"the matrix is not total: {sorted(wrong)}")
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
        for noun, names, known in (
            ("guideword", guidewords, self.guidewords),
            ("parameter", parameters, self.parameters),
        ):
            ids = [one.id for one in known]
            for name in names:
                if name not in ids:
                    raise InputError(f"no {noun} {name!r}{did_you_mean(name, ids)}")
        cells = {(w.id, p.id): self.cells[w.id, p.id] for w in words for p in kept}
        return replace(self, guidewords=words, parameters=kept, cells=cells)
