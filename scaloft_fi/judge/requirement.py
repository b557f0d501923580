"""Requirements: formulas over the flight log, read from the study; each gives one reading per flight.

A requirement is `always( ... )` over the present and the past, so a violation is final and its time is exact.  No
formula may refer to the future: an obligation that is pending when a flight is cut short would count as violated.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from scaloft_fi.document import Item, load
from scaloft_fi.errors import Faults, InputError
from scaloft_fi.judge.stl import (
    FUTURE,
    LONGEST,
    WORDS,
    Formula,
    FormulaError,
    RootError,
    Signals,
    inside_always,
    tokenize,
)
from scaloft_fi.marks import Called, Choices, Examples, Given, Key, Reads, Size
from scaloft_fi.model import Schema, read, schema

if TYPE_CHECKING:
    from scaloft_fi.sim.log import FlightLog


def measured_rho(reading: Reading) -> float | None:
    """The robustness of a reading in the requirement's unit; None where the flight did not test the requirement.

    Without a trigger and without a violation the number measures the distance to the trigger, or the cap of a signal,
    in another unit.  This holds for vacuous readings, and for `open` readings of a flight that was cut short before its
    first trigger.
    """
    return reading.rho if reading.triggered or reading.violated else None


def rho_text(rho: float | None) -> str:
    """Format a robustness for tables.

    >>> rho_text(0.25), rho_text(None)
    ('0.250', 'n/a')
    """
    return "n/a" if rho is None else f"{rho:.3f}"


TRIGGER = "trigger"
"""The name of its own trigger in a formula."""


class Kind(StrEnum):
    """The meaning of a violation of the requirement."""

    SAFETY = "safety"
    OPERABILITY = "operability"
    REPORTED = "reported"


KINDS: Mapping[str, str] = {
    Kind.SAFETY: "a violation can kill a mutant",
    Kind.OPERABILITY: "a violation counts in a score of its own",
    Kind.REPORTED: "a violation is shown and decides nothing",
}


class Compliance(StrEnum):
    """What a flight says about a requirement."""

    VIOLATED = "violated"
    OPEN = "open"
    """Not violated, but the flight was cut short."""
    VACUOUS = "vacuous"
    """The trigger never came true, so the flight did not test the requirement."""
    HELD = "held"


@dataclass(frozen=True)
class Requirement:
    """A requirement, judged from the log of every flight.

    Attributes:
        name: such as `SR1`.
        kind: what a violation means.
        text: always( ... ), inside it a formula over the present and the past: historically, once, since, mean, not,
            and, or, implies, iff, comparisons, + - * /; `scaloft-fi signals` lists the signals.
        trigger: condition under which it applies; a flight without it is vacuous.
        definitions: name and formula of each definition that the formula or the trigger uses, in order.
        unit: unit of the robustness.
        title: the requirement in a sentence.
        source: where the requirement comes from.
    """

    name: Key
    kind: Annotated[Kind, Choices(KINDS)]
    text: Annotated[str, Called("formula"), Examples("always(clearance_m > 0)")]
    trigger: Annotated[str, Examples("elapsed_s / 2 >= 1 and historically[0:2](near)")] = ""
    definitions: Annotated[tuple[tuple[str, str], ...], Given(lambda _item: ())] = ()
    unit: Annotated[str, Examples("m")] = ""
    title: Annotated[str, Examples("The drone touches nothing.")] = ""
    source: str = ""


@dataclass(frozen=True, slots=True)
class Reading:
    """The result of a requirement in a flight.

    Attributes:
        requirement, kind: name and kind of the requirement.
        rho: robustness of the flight in the requirement's unit; below 0 the flight violates the requirement.
        violated_at_s: time of the first violation [s from take-off]; None without one.
        triggered: number of episodes in which the trigger was true; 1 for a requirement without a trigger.
        open: whether the flight was cut short without a violation.
    """

    requirement: str
    kind: Kind
    rho: float
    violated_at_s: float | None
    triggered: int
    open: bool

    @property
    def violated(self) -> bool:
        """Whether the flight violates the requirement."""
        return self.violated_at_s is not None

    @property
    def compliance(self) -> Compliance:
        """What the flight says about the requirement, in a word."""
        if self.violated:
            return Compliance.VIOLATED
        if self.open:
            return Compliance.OPEN
        return Compliance.HELD if self.triggered else Compliance.VACUOUS


@dataclass(frozen=True)
class Judgement:
    """A reading, and the index of the first violated sample (None without one)."""

    reading: Reading
    sample: int | None


def judge(requirement: Requirement, log: FlightLog) -> Reading:
    """Judge one flight.

    Raises:
        ValueError: a signal of the log is not finite.
    """
    return judge_signals(requirement, log.signals, cut_short=log.ending.cut_short).reading


def judge_signals(requirement: Requirement, signals: Signals, *, cut_short: bool) -> Judgement:
    """Judge recorded signals, (T,) each at 20 Hz, `elapsed_s` included.

    Raises:
        ValueError: a signal is not finite.
        InputError: a divisor is 0, or a root is of a negative number.
    """
    body, definitions, trigger = _parsed(requirement, frozenset(signals))
    known: dict[str, Any] = dict(signals)
    triggered = 1
    try:
        for name, formula in definitions:
            known[name] = formula.robustness(known)
        if trigger is not None:
            known[TRIGGER] = trigger.robustness(known)
            triggered = episodes(known[TRIGGER])
        robustness = body.robustness(known)
    except (ZeroDivisionError, RootError) as error:
        raise InputError(f"requirement {requirement.name} cannot be judged: {error}") from error
    least = min(robustness)
    first = next(sample for sample, value in enumerate(robustness) if value < 0) if least < 0 else None
    at_s = None if first is None else float(signals["elapsed_s"][first])
    reading = Reading(requirement.name, requirement.kind, least, at_s, triggered, open=cut_short and first is None)
    return Judgement(reading, first)


def episodes(robustness: Sequence[float]) -> int:
    """Count the episodes of a condition: samples at or above 0 whose predecessor is below 0.

    >>> episodes([-1, 0, 2, -1, 3])
    2
    """
    holds = bytes(map((0.0).__le__, robustness))  # a search in bytes is faster than comparing numbers in pairs
    return holds.startswith(b"\1") + holds.count(b"\0\1")


MOST = 100
"""Most requirements, and most definitions, of a study."""

Check = Callable[[str, Collection[str]], Formula]
"""`Formula.parse`, or an extension of it."""


_DEFINITION = {"type": "string", "minLength": 1, "maxLength": LONGEST, "examples": ["person_sight_m / 3 <= 1"]}


@dataclass(frozen=True)
class RequirementsModel:
    """The requirements of a flight in signal temporal logic over the flight log (20 Hz).

    Attributes:
        requirements: the requirements by name, at least one of kind safety.
        definitions: formulas by name over the present and the past, which the requirements and later definitions use.
    """

    requirements: Annotated[Mapping[str, Annotated[Item, Reads(lambda item: item, _requirement_schema)]], Size(0, MOST)]
    definitions: Annotated[
        Mapping[str, Annotated[Item, Reads(lambda item: item, lambda _: _DEFINITION)]], Size(0, MOST)
    ] = field(default_factory=dict)


def load_requirements(path: Path, signals: Collection[str], check: Check = Formula.parse) -> tuple[Requirement, ...]:
    """Read the study's requirements, and check them against the names of the log's signals.

    Args:
        path: the file.
        signals: names of the log's signals.
        check: check of each formula.

    Raises:
        InputError: the file is not YAML, a key or signal is unknown, a formula is wrong, no requirement is of kind
            safety; the message names file and line.
    """
    document, faults, requirements = load(path), Faults(), list[Requirement]()
    model = read(RequirementsModel, document)
    names, texts = set(signals), dict[str, str]()
    for key, item in model.definitions.items():
        with faults.collecting():
            texts[key] = read_definition(key, item, names, check)
        names.add(key)
    for item in model.requirements.values():
        with faults.collecting():
            requirements.append(read_requirement(item, texts, names, check))
    faults.end()
    if not any(requirement.kind is Kind.SAFETY for requirement in requirements):
        raise InputError(f"{document.need('requirements').place}: requirements must have at least one of kind safety")
    return tuple(requirements)


def _requirement_schema(_names: object) -> Schema:
    made = schema(Requirement)
    made["properties"]["formula"]["pattern"] = r"^\s*always\s*\("
    return made


def read_definition(name: str, item: Item, names: Collection[str], check: Check) -> str:
    """The formula of a definition.

    Args:
        name: its name.
        item: its entry.
        names: the signals, and the definitions before it.
        check: check of the formula.

    Raises:
        InputError: the name is taken, or the formula is wrong.
    """
    if name in names or name in WORDS or name == TRIGGER:
        raise InputError(f"{item.place}: definition {name!r} must not be named like a signal or a word of formulas")
    _check(item, item.text(), names, check)
    return item.text()


def read_requirement(item: Item, definitions: Mapping[str, str], names: Collection[str], check: Check) -> Requirement:
    """Read one requirement.

    Args:
        item: its entry.
        definitions: formula of each definition.
        names: names of the signals and of the definitions.
        check: check of each formula.

    Raises:
        InputError: a key is missing or unknown, the kind is unknown, a formula is wrong.
    """
    faults, model = Faults(), None
    with faults.collecting():
        model = read(Requirement, item)
    formula, trigger = item.get("formula"), item.get("trigger")
    body = None
    if trigger:
        with faults.collecting():
            _check(trigger, trigger.text(), names, check)
        names = {*names, TRIGGER}
    if formula:
        with faults.collecting():
            body = _inside(formula)
            _check(formula, body, names, check)
    faults.end()
    assert model is not None
    assert body is not None
    return replace(model, definitions=_needed(definitions, [body, model.trigger]))


def _inside(item: Item) -> str:
    """What a formula says always holds."""
    try:
        body = inside_always(item.text())
    except FormulaError as error:
        raise InputError(f"{item.place}: {item.name} {error}") from error
    if body is None:
        raise InputError(f"{item.place}: formula must be always( ... ), so that the moment of a violation is final")
    return body


def _needed(definitions: Mapping[str, str], texts: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """The definitions that the texts use, directly or through other definitions, in the order of the file."""
    used: set[str] = set()
    waiting = list(texts)
    while waiting:
        words = set(tokenize(waiting.pop()))
        fresh = words & definitions.keys() - used
        used |= fresh
        waiting += [definitions[name] for name in fresh]
    return tuple((name, text) for name, text in definitions.items() if name in used)


def _check(item: Item, text: str, names: Collection[str], check: Check) -> None:
    """Refuse a `text` that is no formula over the present and the past."""
    try:
        future = [token for token in tokenize(text) if token in FUTURE]
        if future:
            raise FormulaError(f"refers to the future with {future[0]!r}; use historically, once or since")
        check(text, names)
    except FormulaError as error:
        raise InputError(f"{item.place}: {item.name} {error}") from error


_Parsed = tuple[Formula, tuple[tuple[str, Formula], ...], Formula | None]
_PARSED: dict[tuple[Requirement, frozenset[str]], _Parsed] = {}


def _parsed(requirement: Requirement, signals: frozenset[str]) -> _Parsed:
    """Parse the formulas of a requirement, once per process."""
    key = (requirement, signals)
    if key not in _PARSED:
        names = set(signals)
        definitions = []
        for name, text in requirement.definitions:
            definitions.append((name, Formula.parse(text, names)))
            names.add(name)
        trigger = Formula.parse(requirement.trigger, names) if requirement.trigger else None
        if trigger:
            names.add(TRIGGER)
        body = inside_always(requirement.text)
        if body is None:
            raise FormulaError("must be always( ... )")
        _PARSED[key] = (Formula.parse(body, names), tuple(definitions), trigger)
    return _PARSED[key]
