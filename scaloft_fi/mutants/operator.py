"""Operators: declared factories of taps, which turn the samples of one seam into faulty samples.

An operator declares its arguments by annotation, what it needs of a message, and an example that is its test.  It may
know numbers of the study, never the state of the flight.  A window says when a fault is active: it opens at times, or
whenever an event of the flight occurs.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import cycle
from types import MappingProxyType
from typing import Annotated, Any, Literal, cast, get_args, get_origin, get_type_hints

import numpy as np

from scaloft_fi.aside import foreign
from scaloft_fi.errors import DeclaredError, InputError, did_you_mean
from scaloft_fi.hazop.matrix import Value
from scaloft_fi.registry import Registry, in_one_line
from scaloft_fi.stack.declaration import TICK_HZ
from scaloft_fi.stack.messages import (
    field_names,
    field_type,
    image_fields,
    misshapen,
    number_fields,
    sealed,
    stamp_fields,
    vector_fields,
)


@dataclass(frozen=True)
class Facts:
    """Facts of the situation, the vehicle and the sensors.  The defaults serve examples and tests.

    Attributes:
        duration_s: nominal mission time of the situation [s].
        sighting_s: when the nominal flight first sees a person [s]; None when it sees none.
        home_x_m, home_y_m: where the mission starts and ends [m, world].
        cruise_mps, slow_mps: cruise speed, and the speed after a person was seen [m/s].
        bearing_rad: direction of the first leg, along the wall on its right where there is one, from x [rad, world].
        wall_m: point of the wall on the right of the first leg, nearest to its middle [m, world]; None without a wall.
        inward: unit normal of the wall there, into the open space; zero without a wall.
        half_width_m: half of the hull's width [m].
        view_rad: width of the camera's view [rad].
        gyro_sigma_radps, accel_sigma_mps2: white noise of the inertial sensor per sample [rad/s, m/s2]; by default a
            Bosch BMI088 at 120 Hz bandwidth (data sheet: 0.014 deg/s/sqrt(Hz), 175 ug/sqrt(Hz)).
        settings: of the stack, as in `sim/stack.yaml`, for the stack's own operators.
    """

    duration_s: float = 60.0
    sighting_s: float | None = None
    home_x_m: float = 0.0
    home_y_m: float = 0.0
    cruise_mps: float = 0.5
    slow_mps: float = 0.2
    bearing_rad: float = math.pi / 2
    wall_m: tuple[float, float] | None = (1.5, 3.5)
    inward: tuple[float, float] = (-1.0, 0.0)
    half_width_m: float = 0.235
    view_rad: float = math.radians(59.0)
    gyro_sigma_radps: float = 0.0027
    accel_sigma_mps2: float = 0.019
    settings: Mapping[str, Any] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Need:
    """A requirement of an operator on a message.

    Attributes:
        words: the need in words, which follow "needs" in a sentence.
        met_by: whether a message type meets the need.
    """

    words: str
    met_by: Callable[[type], bool]


ANYTHING = Need("any message", lambda _message: True)
NUMBERS = Need("a field of numbers", lambda message: bool(number_fields(message)))
STAMP = Need("a time stamp", lambda message: bool(stamp_fields(message)))
IMAGE = Need("an image", lambda message: bool(image_fields(message)))


def the(message: type) -> Need:
    """The need for a message of type `message`, or of a type derived from it.

    >>> from scaloft_fi.stack.messages import Battery, Imu
    >>> the(Imu).met_by(Imu), the(Imu).met_by(Battery), the(Imu).words
    (True, False, 'the message Imu')
    """
    return Need(f"the message {message.__name__}", lambda candidate: issubclass(candidate, message))


ALL = "all"
"""Field name that stands for every number of the sample."""


@dataclass(frozen=True)
class Range:
    """Allowed numbers: `least` <= value <= `most`, and value > `above`."""

    least: float = -math.inf
    most: float = math.inf
    above: float = -math.inf

    def __contains__(self, value: float) -> bool:
        return self.least <= value <= self.most and value > self.above

    def __str__(self) -> str:
        bounds = [f">= {self.least:g}"] * (self.least > -math.inf) + [f"> {self.above:g}"] * (self.above > -math.inf)
        bounds += [f"<= {self.most:g}"] * (self.most < math.inf)
        return " and ".join(bounds) or "a finite number"


@dataclass(frozen=True)
class FieldName:
    """Marks an argument that names a field of the sample; `number`: the field must be numeric, or `all`."""

    number: bool = True


@dataclass(frozen=True)
class FieldValue:
    """Marks an argument that becomes the value of the field that the argument `field` names."""


Number = Annotated[float, Range(least=-1e12, most=1e12)]
Seconds = Annotated[float, Range(least=0.0, most=1e6)]
Hold = Annotated[float, Range(least=0.0)]
Period = Annotated[float, Range(above=0.0, most=1e6)]
Share = Annotated[float, Range(least=0.0, most=1.0)]
Factor = Annotated[float, Range(least=0.0, most=1e6)]
Metres = Annotated[float, Range(least=0.0, most=1e3)]
Degrees = Annotated[float, Range(least=-360.0, most=360.0)]
Place = Annotated[int, Range(least=0.0, most=1e3)]
NumericField = Annotated[str, FieldName()]
AnyField = Annotated[str, FieldName(number=False)]
ValueOfField = Annotated[Value, FieldValue()]
Axis = Literal["x", "y", "z"]
Component = Literal["", "x", "y", "z"]


@dataclass(frozen=True)
class Argument:
    """One argument of an operator.

    Attributes:
        name: in the operator's signature; it ends in the unit.
        kind: float, int, str, bool, or object (any of float, str, bool).
        allowed: bounds of a number.
        choices: allowed texts; empty when every text is allowed.
        field: how the text names a field of the sample; None for other texts.
        of_field: whether the value becomes the value of a field.
        default: inspect.Parameter.empty when the argument is required.
    """

    name: str
    kind: type
    allowed: Range
    choices: tuple[str, ...]
    field: FieldName | None
    of_field: bool
    default: Any

    @property
    def required(self) -> bool:
        """Whether the argument has no default."""
        return self.default is inspect.Parameter.empty

    def check(self, value: Any, message: type) -> Value:
        """`value`, converted to the argument's type.

        Raises:
            InputError: wrong type, out of range, or not one of the allowed texts.
        """
        if self.kind in (float, int) or (self.kind is object and not isinstance(value, str | bool)):
            return self._number(value)
        if self.kind is object:
            return cast(Value, value)
        if self.kind is bool:
            if not isinstance(value, bool):
                raise InputError(f"{self.name}={value!r} must be true or false")
            return value
        if not isinstance(value, str):
            raise InputError(f"{self.name}={value!r} must be a text")
        if self.choices and value not in self.choices:
            raise InputError(f"{self.name}={value!r} is not known{did_you_mean(value, self.choices)}")
        if self.field is not None:
            known = number_fields(message) if self.field.number else field_names(message)
            if value not in (*known, ALL):
                kind = "numeric field" if self.field.number else "field"
                raise InputError(
                    f"{self.name}={value!r} is no {kind} of {message.__name__}{did_you_mean(value, known)}"
                )
        return value

    def _number(self, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
            raise InputError(f"{self.name}={value!r} must be a number")
        if value not in self.allowed:
            raise InputError(f"{self.name}={value:g} must be {self.allowed}")
        if self.kind is int and value % 1:
            raise InputError(f"{self.name}={value:g} must be a whole number")
        return int(value) if self.kind is int else float(value)


def arguments_of(factory: Callable[..., Any]) -> Mapping[str, Argument]:
    """The keyword-only arguments of an operator's factory, by name, read from its annotations."""
    hints = get_type_hints(factory, include_extras=True)
    parameters = inspect.signature(factory).parameters.values()
    keywords = (p for p in parameters if p.kind is inspect.Parameter.KEYWORD_ONLY)
    return MappingProxyType({p.name: _argument(p.name, hints[p.name], p.default) for p in keywords})


def _argument(name: str, hint: Any, default: Any) -> Argument:
    hint, *rest = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    marks = {type(mark): mark for mark in rest}
    choices = get_args(hint) if get_origin(hint) is Literal else ()
    kind = str if choices else hint if isinstance(hint, type) else object
    return Argument(name, kind, marks.get(Range, Range()), choices, marks.get(FieldName), FieldValue in marks, default)


def check_against_field(message: type, field: str, value: Value) -> Value:
    """`value`, converted to the type of the field `field` of `message`.

    Raises:
        InputError: the field holds another type.
    """
    if field == ALL:
        if not isinstance(value, str | bool):
            return value
        raise InputError(f"value={value!r} must be a number")
    hint: Any = field_type(message, field)
    fits = {float: "a number", int: "a whole number", str: "a text", bool: "true or false"}
    if hint not in fits:
        raise InputError(f"field={field!r} of {message.__name__} holds no single value")
    kinds = int | float if hint in (float, int) else hint
    whole = hint is not int or isinstance(value, str) or value % 1 == 0
    if not isinstance(value, kinds) or isinstance(value, bool) != (hint is bool) or not whole:
        raise InputError(f"value={value!r} must be {fits[hint]}, as {message.__name__}.{field} is")
    made: Value = hint(value)
    return made


TOLERANCE_S = 1e-6
"""Poll times are k/20 or k/240 in floating point; with this tolerance windows open and close at the intended poll."""


@dataclass(frozen=True)
class Times:
    """Openings at `first_s` + `period_s` * k [s], k = 0, 1, ..."""

    first_s: float
    period_s: float = math.inf

    def latest(self, t_s: float) -> tuple[int, float] | None:
        """Number of the latest opening at `t_s` [s], counted from 0, and the time since then [s]; None before any."""
        since_s = t_s - self.first_s + TOLERANCE_S
        if since_s < 0:
            return None
        count = math.floor(since_s / self.period_s)
        return count, since_s - self.period_s * count if count else since_s


@dataclass(eq=False)
class _Occurred:
    """Openings at the occurrences of an event that come at least `apart_s` [s] after the opening before."""

    apart_s: float
    number: int = -1
    at_s: float = -math.inf

    def occur(self, t_s: float) -> None:
        if self.number < 0 or t_s - self.at_s >= self.apart_s - TOLERANCE_S:
            self.number, self.at_s = self.number + 1, t_s

    def latest(self, t_s: float) -> tuple[int, float] | None:
        return None if self.number < 0 else (self.number, t_s - self.at_s + TOLERANCE_S)


Openings = Times | _Occurred
"""What opens windows."""


class Occurrences:
    """The occurrences of an event in one flight: the flight loop tells of each as it comes, openings follow them."""

    def __init__(self) -> None:
        self._openings: list[_Occurred] = []

    @property
    def awaited(self) -> bool:
        """Whether anything opens at them."""
        return bool(self._openings)

    def openings(self, apart_s: float) -> Openings:
        """An opening at each occurrence that comes `apart_s` [s] or more after the one before; inf: at the first."""
        self._openings.append(_Occurred(apart_s))
        return self._openings[-1]

    def occur(self, t_s: float) -> None:
        """Learn of an occurrence at `t_s` [s]."""
        for openings in self._openings:
            openings.occur(t_s)


@dataclass(frozen=True)
class Windows:
    """Windows of `length_s` [s] each; an opening during a window begins the next window."""

    openings: Openings
    length_s: float

    @classmethod
    def periodic(cls, period_s: float, phase_s: float, length_s: float) -> Windows:
        """Windows at `period_s`, 2 `period_s`, ..., each `phase_s` later [s].

        >>> windows = Windows.periodic(period_s=20.0, phase_s=5.0, length_s=2.0)
        >>> [t for t in (4.95, 5.0, 24.95, 25.0, 26.95, 27.0, 45.0) if windows.open(t)]
        [25.0, 26.95, 45.0]
        """
        return cls(Times(period_s + phase_s, period_s), length_s)

    @classmethod
    def since(cls, at_s: float) -> Windows:
        """One window that opens at `at_s` [s] and never closes."""
        return cls(Times(at_s), math.inf)

    def open(self, t_s: float) -> bool:
        """Whether a window is open at `t_s` [s]."""
        return self.number(t_s) is not None

    def number(self, t_s: float) -> int | None:
        """Number of the window that is open at `t_s` [s], counted from 0; None between windows."""
        opening = self.openings.latest(t_s)
        return opening[0] if opening is not None and opening[1] < self.length_s else None


Tap = Callable[[float, Any | None], Any | None]
"""(time [s], sample, or None when nothing is sent at this poll) -> sample that arrives, or None.

A tap keeps its memory in its own attributes, so that a copy of the tap is independent, and never writes into a sample.
"""

Samples = tuple[Any, ...]


@dataclass(frozen=True)
class TapContext:
    """What a tap may know of the flight that it is patched into.

    Attributes:
        period_s: time between two polls of the seam [s].
        rng: random numbers of the mutant in this flight; nothing else draws from them.
        facts: of situation, vehicle and sensors.
        event: the occurrences of the event at which the fault strikes; None for a fault that strikes at times.
    """

    period_s: float
    rng: np.random.Generator
    facts: Facts = field(default_factory=Facts)
    event: Occurrences | None = None

    def windows(self, period_s: float, phase_s: float, length_s: float) -> Windows:
        """Windows of `length_s` [s] each of a fault that recurs.

        They open each `period_s` [s], shifted by `phase_s` [s].  If the fault strikes at an event, they open at each
        occurrence instead, but none sooner than `period_s` after the one before: an event that the fault itself
        brings about does not make it permanent.
        """
        if self.event is None:
            return Windows.periodic(period_s, phase_s, length_s)
        return Windows(self.event.openings(apart_s=period_s), length_s)

    def window(self, at_s: float, length_s: float) -> Windows:
        """The window of a fault that happens once: at `at_s` [s], or at the first occurrence of the event."""
        return Windows(Times(at_s) if self.event is None else self.event.openings(apart_s=math.inf), length_s)


@dataclass(frozen=True)
class Example:
    """A few samples before and after an operator, one for each poll from t = 0; it documents and tests the operator.

    Attributes:
        message: type of the samples.
        arguments: of the operator.
        before: samples that are sent, as copies whose arrays cannot be written to.
        after: samples that arrive; for a random operator a predicate that (before, after) must satisfy.
        facts: of the tap's context.
        rate_hz: how often the seam is polled [Hz].
    """

    message: type
    arguments: Mapping[str, Value]
    before: Samples
    after: Samples | Callable[[Samples, Samples], bool]
    facts: Facts = field(default_factory=Facts)
    rate_hz: float = TICK_HZ

    def __post_init__(self) -> None:
        object.__setattr__(self, "before", tuple(map(sealed, self.before)))

    def context(self, seed: int = 0) -> TapContext:
        """The context of the example's tap."""
        rng = np.random.Generator(np.random.Philox(seed))
        return TapContext(1.0 / self.rate_hz, rng, self.facts)


class OperatorError(InputError):
    """An operator does not fit a seam, or an argument is wrong.

    The sentence names no file; the caller knows the place of `about` and puts it first.

    Attributes:
        about: "seam", "operator" or the argument's name.
    """

    def __init__(self, about: str, sentence: str) -> None:
        super().__init__(sentence)
        self.about = about


class TapError(DeclaredError):
    """An operator or a tap of it failed: a failure of the harness, not of the stack under test."""


@dataclass(frozen=True)
class Operator:
    """One declared operator.

    Attributes:
        name: unique name, as in the study's YAML.
        need: what it requires of a seam's message.
        make: (context, **arguments) -> a fresh tap.
        arguments: its arguments by name.
        example: samples before and after it.
    """

    name: str
    need: Need
    make: Callable[..., Tap]
    arguments: Mapping[str, Argument]
    example: Example

    @property
    def summary(self) -> str:
        """First sentence of the operator's docstring."""
        return " ".join((self.make.__doc__ or "").split("\n\n")[0].split())

    @property
    def awaits_events(self) -> bool:
        """Whether its windows open at an event of its context: those that `phase_s` shifts must (`check_operator`)."""
        return "phase_s" in self.arguments

    def check(self, seam: str, message: type, arguments: Mapping[str, Any]) -> dict[str, Value]:
        """`arguments`, converted to the types that the operator takes; defaults are not filled in.

        Args:
            seam: name of the seam.
            message: type of the seam's samples.
            arguments: as in the study.

        Raises:
            OperatorError: the message does not meet the operator's need; an argument is unknown, missing, of another
                type or out of range.
        """
        about, own = "seam", f"operator {self.name!r}"
        if not self.need.met_by(message):
            raise OperatorError(about, f"{own} needs {self.need.words}, but seam {seam!r} carries {message.__name__}")
        checked: dict[str, Value] = {}
        try:
            for about, value in arguments.items():
                if about not in self.arguments:
                    raise OperatorError(about, f"{own} has no argument {about!r}{did_you_mean(about, self.arguments)}")
                checked[about] = self.arguments[about].check(value, message)
            missing = [name for name, argument in self.arguments.items() if argument.required and name not in checked]
            if missing:
                raise OperatorError("operator", f"{own} lacks the argument {missing[0]!r}")
            field = str(checked.get("field", ALL))
            about = "component"
            if checked.get(about) and "field" in self.arguments and field not in vector_fields(message):
                raise InputError(f"field={field!r} has no components x, y, z")
            for about, argument in self.arguments.items():
                if argument.of_field:
                    checked[about] = check_against_field(message, field, checked[about])
        except OperatorError:
            raise
        except InputError as error:
            raise OperatorError(about, f"{own}: {error}") from None
        return checked

    def tap(self, context: TapContext, arguments: Mapping[str, Value]) -> Tap:
        """A fresh tap with checked `arguments`.

        Raises:
            TapError: the operator raises, or what it returns is no tap.
        """
        try:
            made = self.make(context, **arguments)
        except foreign() as error:
            raise self._failed(f"raises when it is built: {in_one_line(error)}") from error
        if not callable(made):
            raise self._failed(f"must return a tap, and returns {made!r}")
        return made

    def arrived(self, lasting_s: float = 0.0) -> Samples:
        """What arrives where the samples of its example are sent, each once, or again and again for `lasting_s` [s].

        Raises:
            TapError: as `tap`, or the tap raises, writes into a sample, or returns another message or other shapes.
        """
        example, found = self.example, list[Any]()
        count = len(example.before)
        tap = self.tap(example.context(), example.arguments)
        for poll, sample in zip(range(max(count, round(lasting_s * example.rate_hz))), cycle(example.before)):
            t_s = poll / example.rate_hz
            where = f"at sample {poll % count} of its example" + f", sent again at {t_s:g} s" * (poll >= count)
            try:
                found.append(tap(t_s, sample))
            except foreign() as error:
                raise self._failed(f"raises {where}: {in_one_line(error)}") from error
            if not isinstance(found[-1], example.message | None):
                raise self._failed(f"returns {found[-1]!r} {where}, no {example.message.__name__}")
            if wrong := misshapen(sample, found[-1]):
                raise self._failed(f"returns {where} a sample whose {wrong}")
        return tuple(found)

    def _failed(self, what: str) -> TapError:
        return TapError(f"operator {self.name!r} {what}", self.make.__module__)


OPERATORS = Registry[Operator]("operator", "scaloft-fi operators")


def operator(
    name: str, *, example: Example, need: Need = ANYTHING
) -> Callable[[Callable[..., Tap]], Callable[..., Tap]]:
    """Declare the decorated factory (context, *, arguments) -> tap as operator `name`.

    Raises:
        ValueError: the name is taken, or the example's message does not meet `need`.
    """
    if not need.met_by(example.message):
        raise ValueError(f"operator {name!r} needs {need.words}, which its example's message lacks")

    def declare(make: Callable[..., Tap]) -> Callable[..., Tap]:
        OPERATORS.declare(name, Operator(name, need, make, arguments_of(make), example))
        return make

    return declare


def on(
    message: type,
    name: str,
    arguments: Mapping[str, Value],
    before: Samples,
    after: Samples | Callable[[Samples, Samples], bool],
    *,
    need: Need | None = None,
    **context: Any,
) -> Callable[[Callable[..., Tap]], Callable[..., Tap]]:
    """Declare the decorated factory as operator `name` with its `Example`; it needs that message, or less by `need`."""
    return operator(name, need=need or the(message), example=Example(message, arguments, before, after, **context))
