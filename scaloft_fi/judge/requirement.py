"""Requirements: formulas over the flight log, read from the study; each gives one reading per flight.

A requirement is `always( ... )` over the present and the past, so a violation is final and its time is exact.  No
formula may refer to the future: an obligation that is pending when a flight is cut short would count as violated.

What a formula can yield in any flight follows from caps and ranges of the signals that it reads.  Beyond its cap a
signal is constant.  A comparison with a threshold there is true in every flight, or false in every flight, or equals
the comparison with the cap: `person_sight_m < 8` equals `person_sight_m < 6`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

from scaloft_fi.document import Item, load
from scaloft_fi.errors import Faults, InputError
from scaloft_fi.judge import stl
from scaloft_fi.judge.stl import parse, tokenize
from scaloft_fi.marks import Called, Choices, Examples, Given, Key, Pattern, Reads, Size
from scaloft_fi.model import Schema, read, schema
from scaloft_fi.sim.log import CLEARANCE_CAP_M, FAR_M, SIGNALS, truth_signals
from scaloft_fi.sim.world import ROLES, World
from scaloft_fi.stack.declaration import TICK_S, unit_of

if TYPE_CHECKING:
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.stack.declaration import Belief


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
        trigger: condition under which it applies, without one always; a flight in which it never holds is vacuous.
        definitions: name and formula of each definition that the formula or the trigger uses, in order.
        unit: unit of the robustness.
        title: the requirement in a sentence.
        source: where the requirement comes from.
        proposed_from: mutant for whose flights `scaloft-fi propose` chose it; verdicts by it are selected.
    """

    name: Key
    kind: Annotated[Kind, Choices(KINDS)]
    text: Annotated[str, Called("formula"), Examples("always(clearance_m > 0)")]
    trigger: Annotated[str, Examples("elapsed_s / 2 >= 1 and historically[0:2](near)")] = ""
    definitions: Annotated[tuple[tuple[str, str], ...], Given(lambda _item: ())] = ()
    unit: Annotated[str, Examples("m")] = ""
    title: Annotated[str, Examples("The drone touches nothing.")] = ""
    source: str = ""
    proposed_from: Annotated[str, Examples("LATE-velcmd@0.5s")] = ""

    @property
    def selected(self) -> bool:
        """Whether it decides though flights that it decides about chose it."""
        return bool(self.proposed_from) and self.kind is not Kind.REPORTED


@dataclass(frozen=True, slots=True)
class Reading:
    """The result of a requirement in a flight.

    Attributes:
        requirement: name of the requirement.
        kind: of the requirement.
        rho: robustness of the flight in the requirement's unit; below 0 the flight violates the requirement.
        violated_at_s: first violation [s from take-off]; null: it is not violated.
        triggered: number of episodes in which the trigger was true; 1 for a requirement without a trigger.
        open: whether the flight was cut short without a violation.
    """

    KEYS = ("requirement", "kind", "compliance", "robustness", "violated_at_s")
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

    @property
    def robustness(self) -> float | None:
        """Distance to a violation, in the requirement's own unit; below 0 it is violated; null: not put to the test.

        Without a trigger and without a violation `rho` measures the distance to the trigger, or the cap of a signal,
        in another unit.  This holds for vacuous readings, and for `open` readings of a flight that was cut short before
        its first trigger.
        """
        return self.rho if self.triggered or self.violated else None


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


def judge_signals(requirement: Requirement, signals: stl.Signals, *, cut_short: bool) -> Judgement:
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
    except (ZeroDivisionError, stl.RootError) as error:
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

Check = Callable[[str, Collection[str]], stl.Formula]
"""`Formula.parse`, or an extension of it."""


_DEFINITION = {"type": "string", "minLength": 1, "maxLength": stl.LONGEST, "examples": ["person_sight_m / 3 <= 1"]}


@dataclass(frozen=True)
class RequirementsModel:
    """The requirements of a flight in signal temporal logic over the flight log (20 Hz).

    Attributes:
        requirements: the requirements by name, at least one of kind safety.
        definitions: formulas by name over the present and the past, which the requirements and later definitions use.
    """

    requirements: Annotated[
        Mapping[str, Annotated[Item, Reads(lambda item: item, _requirement_schema)]],
        Size(0, MOST),
        Pattern(r"[\w.-]{1,100}", "letters, digits, -, _ and ."),
    ]
    definitions: Annotated[
        Mapping[str, Annotated[Item, Reads(lambda item: item, lambda _: _DEFINITION)]], Size(0, MOST)
    ] = field(default_factory=dict)


def load_requirements(
    path: Path, signals: Collection[str], check: Check = stl.Formula.parse
) -> tuple[Requirement, ...]:
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
    if name in names or name in stl.WORDS or name == TRIGGER:
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
        InputError: a key is missing or unknown, the kind is unknown, a formula is wrong, the unit is not its signals'.
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
    made = replace(model, definitions=_needed(definitions, [body, model.trigger]))
    if made.unit:
        _check_unit(made, body, item)
    return made


def _check_unit(requirement: Requirement, body: str, item: Item) -> None:
    """Refuse another unit than that of the robustness, where this is one that the names of its signals end in."""
    known: dict[str, Mapping[str, str]] = {}
    for name, text in (*requirement.definitions, (TRIGGER, requirement.trigger), ("", body)):
        known[name] = _units(parse(tokenize(text)), known) if text else {}
    units = known[""]
    (unit, signal) = next(iter(units.items()), ("", ""))
    if len(units) == 1 and unit not in ("", requirement.unit):
        raise item.need("unit").error(f"{unit}, the unit of {signal}")


def _units(node: stl.Node, known: Mapping[str, Mapping[str, str]]) -> Mapping[str, str]:
    """The units that the robustness of a part may have, each with a signal in it; "" is one that nothing is known of.

    Args:
        node: the part.
        known: the same of each definition.
    """
    if isinstance(node, stl.Signal):
        return known.get(node.name, {unit_of(node.name): node.name})
    units = {unit: signal for part in reversed(stl.parts(node)) for unit, signal in _units(part, known).items()}
    scaled = isinstance(node, stl.Infix) and node.operator in ("*", "/")
    return {"": ""} if units and (scaled or (isinstance(node, stl.Prefix) and node.word == "sqrt")) else units


def _inside(item: Item) -> str:
    """What a formula says always holds."""
    try:
        body = stl.inside_always(item.text())
    except stl.FormulaError as error:
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
        future = [token for token in tokenize(text) if token in stl.FUTURE]
        if future:
            raise stl.FormulaError(f"refers to the future with {future[0]!r}; use historically, once or since")
        check(text, names)
    except stl.FormulaError as error:
        raise InputError(f"{item.place}: {item.name} {error}") from error


_Parsed = tuple[stl.Formula, tuple[tuple[str, stl.Formula], ...], stl.Formula | None]
_PARSED: dict[tuple[Requirement, frozenset[str]], _Parsed] = {}


def _parsed(requirement: Requirement, signals: frozenset[str]) -> _Parsed:
    """Parse the formulas of a requirement, once per process."""
    key = (requirement, signals)
    if key not in _PARSED:
        names = set(signals)
        definitions = []
        for name, text in requirement.definitions:
            definitions.append((name, stl.Formula.parse(text, names)))
            names.add(name)
        trigger = stl.Formula.parse(requirement.trigger, names) if requirement.trigger else None
        if trigger:
            names.add(TRIGGER)
        body = stl.inside_always(requirement.text)
        if body is None:
            raise stl.FormulaError("must be always( ... )")
        _PARSED[key] = (stl.Formula.parse(body, names), tuple(definitions), trigger)
    return _PARSED[key]


SIGHT_M = 6.0
"""Greatest distance of a person in sight [m]; equals `SIGHT_M` of `sim/observer.py`, which imports the compiler."""


@dataclass(frozen=True)
class Cap:
    """The cap of a signal.

    Attributes:
        most_m: greatest measured value [m].
        beyond: the value beyond the cap, in words.
        itself: whether a threshold may equal `most_m`.
    """

    most_m: float
    beyond: str
    itself: bool = False


_CLEARANCE = re.compile(r"clearance_(\w+_)?m")
_CLEAR = Cap(CLEARANCE_CAP_M, f"{CLEARANCE_CAP_M:g} m beyond")
_NOBODY = Cap(FAR_M, f"{FAR_M:g} m without a person")
NO_BELIEFS: Mapping[str, float] = MappingProxyType({})
_CAPS: Mapping[str, Cap] = {
    "waypoint_wall_m": _CLEAR,
    "person_sight_m": Cap(SIGHT_M, f"{FAR_M:g} m beyond", itself=True),
    "person_range_m": _NOBODY,
}


def cap_of(signal: str, beliefs: Mapping[str, float] = NO_BELIEFS) -> Cap | None:
    """The cap of a signal; None for a signal without a cap.

    Args:
        signal: name of the signal.
        beliefs: cap of each belief that has one (`stack.belief.Belief.most`).

    >>> cap_of("clearance_wall_m").most_m
    1.0
    """
    if signal in beliefs:
        return Cap(beliefs[signal], f"{beliefs[signal]:g} m beyond")
    return _CLEAR if _CLEARANCE.fullmatch(signal) else _CAPS.get(signal)


def within_caps(check: Check, beliefs: Mapping[str, float] = NO_BELIEFS) -> Check:
    """Extend `check`: first compare the thresholds of the text with the caps of its signals."""

    def checked(text: str, signals: Collection[str]) -> stl.Formula:
        check_caps(text, beliefs)
        return check(text, signals)

    return checked


def check_caps(text: str, beliefs: Mapping[str, float] = NO_BELIEFS) -> None:
    """Check each comparison of a signal with a number against the cap of the signal.

    Other comparisons pass, and so do words that are no formula, which `Formula.parse` refuses.

    Raises:
        FormulaError: a threshold lies beyond the cap, or a character belongs to no word.
    """
    tokens = tokenize(text)
    try:
        tree = parse(tokens)
    except stl.FormulaError:
        return
    for shown, signal, _, threshold in comparisons(tree):
        cap = cap_of(signal, beliefs)
        if cap and (threshold > cap.most_m or (threshold == cap.most_m and not cap.itself)):
            allowed = f"{'at most' if cap.itself else 'less than'} {cap.most_m:g} m"
            raise stl.FormulaError(
                f"compares {signal} with {threshold:g} m in '{shown}', but it is measured up to {cap.most_m:g} m and"
                f" reads {cap.beyond}; it must be compared with {allowed}"
            )


def comparisons(tree: stl.Node) -> Iterator[tuple[str, str, str, float]]:
    """Yield each comparison of one signal with a number: its text, and as in `a <= 3.0`, in the signal's unit.

    >>> list(comparisons(parse(tokenize("always(a / 3 <= 1 and 2 > b - 0.5)"))))
    [('a / 3 <= 1', 'a', '<=', 3.0), ('2 > b - 0.5', 'b', '<', 2.5)]
    """
    if isinstance(tree, stl.Infix) and tree.operator in stl.COMPARATORS:
        line = _line(stl.Infix("-", tree.left, tree.right)) or {}
        factors = [(name, factor) for name, factor in line.items() if name and factor]
        if len(factors) == 1:
            ((name, factor),) = factors
            for operator in ("<=", ">=") if tree.operator == "==" else (tree.operator,):
                sense = operator if factor > 0 else operator.translate(_TURNED)
                yield stl.written(tree), name, sense, round(-line.get("", 0.0) / factor, 9) + 0.0  # never -0.0
    for part in stl.parts(tree):
        yield from comparisons(part)


_TURNED = str.maketrans("<>", "><")


def _line(node: stl.Node) -> Mapping[str, float] | None:
    """A part as a linear expression, factor by signal, with its constant under ""; None for any other part."""
    if isinstance(node, stl.Signal):
        return {node.name: 1.0}
    if isinstance(node, stl.Number):
        return {"": node.value}
    left, right = (_line(node.left), _line(node.right)) if isinstance(node, stl.Infix) else (None, None)
    if not isinstance(node, stl.Infix) or left is None or right is None:
        return None
    if node.operator in ("+", "-"):
        sign = 1.0 if node.operator == "+" else -1.0
        return {name: left.get(name, 0.0) + sign * right.get(name, 0.0) for name in {**left, **right}}
    if node.operator == "*" and left.keys() == {""}:
        left, right = right, left
    if node.operator not in ("*", "/") or right.keys() != {""} or (node.operator == "/" and not right[""]):
        return None
    scale = right[""] if node.operator == "*" else 1.0 / right[""]
    return {name: scale * factor for name, factor in left.items()}


Span = tuple[float, float]
"""Least and greatest number, either may be infinite."""
Ranges = Mapping[str, tuple[Span, ...]]
"""By name of a signal the spans that hold everything that it can read, in order."""

ANY: tuple[Span, ...] = ((-math.inf, math.inf),)
NEVER_BELOW_0: tuple[Span, ...] = ((0.0, math.inf),)
SHARE: tuple[Span, ...] = ((0.0, 1.0),)
CLEARANCE: tuple[Span, ...] = ((-math.inf, CLEARANCE_CAP_M),)
TRUTH: Ranges = {
    "elapsed_s": NEVER_BELOW_0,
    "remaining_s": ((-TICK_S, math.inf),),
    **dict.fromkeys(("qx", "qy", "qz", "qw"), ((-1.0, 1.0),)),
    "yaw_rad": ((-math.pi, math.pi),),
    "speed_mps": NEVER_BELOW_0,
    "clearance_m": CLEARANCE,
    "person_range_m": ((0.0, FAR_M),),
    "person_sight_m": ((0.0, SIGHT_M), (FAR_M, FAR_M)),
    "waypoints_left": NEVER_BELOW_0,
    "home_m": NEVER_BELOW_0,
    "landed": ((0.0, 0.0), (1.0, 1.0)),
    "light": SHARE,
    "obstacle_pixels": NEVER_BELOW_0,
    "waypoint_wall_m": (*CLEARANCE, (FAR_M, FAR_M)),
    "mass_kg": NEVER_BELOW_0,
    "takeoff_charge": SHARE,
    "haze_per_m": NEVER_BELOW_0,
}
"""The signals of the package that something bounds in every study; a flight may outlast its limit by part of a tick."""
_NO_PERSON: tuple[Span, ...] = ((FAR_M, FAR_M),)


def ranges_of(world: World, beliefs: Iterable[Belief], names: Iterable[str]) -> Ranges:
    """What the signals of a study can read.

    Args:
        world: the study's world.
        beliefs: of the stack.
        names: names of the signals; those of which nothing is known can read any number.
    """
    known = {signal.name: CLEARANCE for signal in truth_signals(world.surfaces) if signal.name.startswith("clearance_")}
    known |= {signal.name: ((-math.inf, signal.most),) for signal in SIGNALS.values()}
    known |= TRUTH
    for belief in beliefs:
        marks = belief.mark.values if belief.mark else ()
        known[belief.name] = ((0.0, len(marks) - 1.0),) if marks else ((-math.inf, belief.most),)
    return {name: known.get(name, ANY) for name in names}


def without(world: World) -> Ranges:
    """What signals read in a study that has nobody, and no obstacle, that they could measure."""
    roles = [ROLES[body.role] for body in world.bodies.values()]
    empty: dict[str, tuple[Span, ...]] = {}
    if not any(role.is_person for role in roles):
        empty |= {"person_range_m": _NO_PERSON, "person_sight_m": _NO_PERSON}
    if not any(role.is_obstacle for role in roles):
        empty["obstacle_pixels"] = ((0.0, 0.0),)
    return empty


def within_rock(world: World) -> Ranges:
    """Where the centre of a vehicle can be in the mine [m]."""
    corners = world.mine.wall.vertices, world.mine.ground.vertices
    low = [min(float(part[:, axis].min()) for part in corners) for axis in range(3)]
    high = [max(float(part[:, axis].max()) for part in corners) for axis in range(3)]
    return {name: ((low[axis], high[axis]),) for axis, name in enumerate(("x_m", "y_m", "z_m"))}


MOST_SPANS = 32
"""With more spans, one span stands for all of them."""
Spans = tuple[Span, ...]


def verdict(spans: Spans) -> bool | None:
    """Whether a formula with this robustness holds in every flight (True) or in none (False); None = it depends."""
    if all(low >= 0.0 for low, _ in spans):
        return True
    return False if all(high < 0.0 for _, high in spans) else None


def bounds_of(formula: stl.Formula, ranges: Ranges) -> Spans:
    """What the robustness of a formula can be at a sample; wider than it is where one signal occurs twice.

    Args:
        formula: the formula.
        ranges: by name what each signal, and the robustness of each definition in it, can be.
    """
    return _bounds(formula.tree, ranges)


def constants(formula: stl.Formula, ranges: Ranges) -> Iterator[tuple[str, bool]]:
    """The comparisons in a formula that are true, or false, at every sample of every flight."""
    waiting = [formula.tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, stl.Infix) and node.operator in stl.COMPARATORS:
            always = verdict(_bounds(node, ranges))
            if always is not None:
                yield stl.written(node), always
        else:
            waiting += reversed(stl.parts(node))


def _bounds(node: stl.Node, ranges: Ranges) -> Spans:
    if isinstance(node, stl.Signal):
        return ranges.get(node.name, ANY)
    if isinstance(node, stl.Number):
        return ((node.value, node.value),)
    if isinstance(node, stl.Prefix):
        of = _bounds(node.of, ranges)
        if node.word in stl.CHANGES:
            low, high = of[0][0], max(high for _, high in of)
            return ((min(low, -high), high if node.word == "rise" else -low),)
        if node.word in stl.EXTREMES:
            first = node.interval.first if node.interval is not None else 0
            return _window(node.word, of, first, ranges.get("elapsed_s", ANY)[-1][1])
        if node.word == stl.MEAN:
            return ((min(low for low, _ in of), max(high for _, high in of)),)
        return _few([_FUNCTION[node.word](span) for span in of])
    if node.operator in stl.COMPARATORS:
        sides = (node.right, node.left) if node.operator in ("<", "<=") else (node.left, node.right)
        spans = _bounds(stl.Infix("-", *sides), ranges)
        return spans if node.operator != "==" else _few([_against(span) for span in spans])
    line = _line(node)
    if line is not None:  # each signal once, however often it is written
        spans = ((line.get("", 0.0),) * 2,)
        for name in (name for name, factor in line.items() if name and factor):
            scaled = [_times((line[name],) * 2, span) for span in ranges.get(name, ANY)]
            spans = _few([_JOIN["+"](one, other) for one, other in product(spans, scaled)])
        return spans
    right = _bounds(node.right, ranges)
    if node.operator in ("since", "until"):
        return ((-math.inf, max(high for _, high in right)),)
    return _few([_JOIN[node.operator](one, other) for one, other in product(_bounds(node.left, ranges), right)])


def _window(word: str, spans: Spans, first: int, longest_s: float) -> Spans:
    """An extreme of what stands inside; a window that begins later may be empty, or is, in every flight."""
    low, high = min(low for low, _ in spans), max(high for _, high in spans)
    late = first > 0
    if first * TICK_S > longest_s:
        low, high = math.inf, -math.inf
    if word in ("historically", "always"):
        return ((low, math.inf if late else high),)
    return ((-math.inf if late else low, high),)


def _few(spans: list[Span]) -> Spans:
    ordered = sorted(spans)
    return tuple(ordered) if len(ordered) <= MOST_SPANS else ((ordered[0][0], max(high for _, high in ordered)),)


def _minus(one: Span, other: Span) -> Span:
    return _span(one[0] - other[1], one[1] - other[0])


def _span(low: float, high: float) -> Span:
    """The span; nothing is known of an end that is infinity - infinity."""
    return (-math.inf if math.isnan(low) else low, math.inf if math.isnan(high) else high)


def _times(one: Span, other: Span) -> Span:
    ends = [0.0 if 0.0 in (a, b) else a * b for a, b in product(one, other)]
    return min(ends), max(ends)


def _over(one: Span, other: Span) -> Span:
    if other[0] <= 0.0 <= other[1]:
        return -math.inf, math.inf
    ends = [_quotient(a, b) for a, b in product(one, other)]
    return min(ends), max(ends)


def _quotient(a: float, b: float) -> float:
    if math.isinf(b):
        return 0.0 if math.isfinite(a) else math.copysign(math.inf, a * b)
    return a / b


def _absolute(span: Span) -> Span:
    return (0.0 if span[0] <= 0.0 <= span[1] else min(map(abs, span))), max(map(abs, span))


def _against(span: Span) -> Span:
    """How far a difference in this span can be from none, as a robustness."""
    low, high = _absolute(span)
    return -high, -low


_FUNCTION: Mapping[str, Callable[[Span], Span]] = {
    "not": lambda span: (-span[1], -span[0]),
    "abs": _absolute,
    "sqrt": lambda span: (math.sqrt(max(span[0], 0.0)), math.sqrt(max(span[1], 0.0))),
}
_JOIN: Mapping[str, Callable[[Span, Span], Span]] = {
    "+": lambda one, other: _span(one[0] + other[0], one[1] + other[1]),
    "-": _minus,
    "*": _times,
    "/": _over,
    "and": lambda one, other: (min(one[0], other[0]), min(one[1], other[1])),
    "or": lambda one, other: (max(one[0], other[0]), max(one[1], other[1])),
    "implies": lambda one, other: (max(-one[1], other[0]), max(-one[0], other[1])),
    "iff": lambda one, other: _against(_minus(one, other)),
}
