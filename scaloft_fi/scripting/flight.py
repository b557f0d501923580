"""A flight that was flown in this process, for scripts: log, map, figure; and how arguments are read."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date
from functools import cached_property, wraps
from inspect import Parameter, cleandoc, formatannotation, get_annotations, signature
from numbers import Integral
from os import PathLike
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, cast, get_args, get_origin

import click
from numpy.typing import NDArray

from scaloft_fi.errors import InputError, ScaloftError
from scaloft_fi.judge.status import baseline_status
from scaloft_fi.output import write_named
from scaloft_fi.verbs.options import marked
from scaloft_fi.verbs.replay import LoggedFlight
from scaloft_fi.verbs.signals import signal_list
from scaloft_fi.views.output import Columns, ColumnType
from scaloft_fi.views.picture import png
from scaloft_fi.views.table import Format, Table, html, render

NAMES = {"mutant": "mutants", "situation": "situations", "budget": "budget_s", "output": "path"}
"""Arguments that have another name than the option of the verb."""
_MODULE = re.compile(r"\b(?:\w+\.)+")
_OPTION = re.compile(r"(?<![\w-])--([a-z]+(?:-[a-z]+)*)")


F = TypeVar("F", bound=Callable[..., Any])


@contextmanager
def in_python(**names: str) -> Iterator[None]:
    """In this context an error names arguments of Python, not options of the command line.

    Args:
        names: arguments by option, where they are not those of `NAMES`.
    """
    try:
        yield
    except ScaloftError as error:
        error.args = (python_words(str(error), names),)
        raise


def python_words(sentence: str, names: Mapping[str, str] = NAMES) -> str:
    """A sentence with arguments instead of options; commands, which stand in backticks, keep their options.

    >>> python_words("--baseline-seeds='x' must be N; see `run --mutant ID`; another --mutant")
    "baseline_seeds='x' must be N; see `run --mutant ID`; another mutants"
    """
    known = {**NAMES, **names}
    parts = sentence.split("`")
    parts[::2] = [_OPTION.sub(lambda it: known.get(it[1], it[1].replace("-", "_")), part) for part in parts[::2]]
    return "`".join(parts)


def described(method: F, without: int = 0) -> F:
    """The method with the texts of its options in its docstring under `Args:`, and plain types in its signature.

    When it is called, each argument is held against its declared type, and against the range of its option; errors name
    arguments of Python.

    Args:
        method: what a script calls.
        without: number of parameters behind `self` that the script does not give.
    """
    hints = get_annotations(method, eval_str=True)
    first, *rest = signature(method).parameters.values()
    told, mark, raised = cleandoc(method.__doc__ or "").partition("\n\nRaises:\n")
    args, plain = [], [first.replace(name="self", annotation=Parameter.empty) if without else first]
    for parameter in rest[max(0, without - 1) :]:
        option, otherwise = marked(hints.get(parameter.name))
        if option is not None and f"\n    {parameter.name}: " not in told:
            default = f"; by default {otherwise}" if otherwise else ""
            args.append(python_words(f"    {parameter.name}: {option.about.rstrip('.')}{default}."))
            parameter = parameter.replace(
                annotation=_MODULE.sub("", formatannotation(hints[parameter.name].__origin__))
            )
        plain.append(parameter)
    own = "" if "\nArgs:\n" in told else "\n\nArgs:"
    shape = signature(method).replace(parameters=plain)

    @in_python()
    @wraps(method)
    def call(*args: Any, **named: Any) -> Any:
        try:
            given = shape.bind(*args, **named)
        except TypeError:  # Python says it better
            return method(*args, **named)
        for name, value in given.arguments.items():
            if name in hints:
                given.arguments[name] = argument(name, value, hints[name])
        return method(*given.args, **given.kwargs)

    vars(call)["__signature__"] = shape
    call.__doc__ = told + "\n".join([own, *args] if args else [""]) + mark + raised
    return cast(F, call)


_KINDS = {
    Path: "a path",
    str: "a text",
    int: "a whole number",
    float: "a number",
    bool: "True or False",
    date: "a date",
    range: "a range",
    NoneType: "None",
}


def argument(name: str, value: Any, hint: Any) -> Any:
    """What a script gives for a parameter of a type, which may be that of an option of the command line.

    >>> argument("seed", 1.5, int)
    Traceback (most recent call last):
    scaloft_fi.errors.InputError: seed=1.5 must be a whole number

    Raises:
        InputError: it is of another type, or beyond the range of the option.
    """
    option, _ = marked(hint)
    span = option.type if option is not None and isinstance(option.type, click.IntRange | click.FloatRange) else None
    forms = _forms(hint)
    if isinstance(value, Integral) and not isinstance(value, bool):
        value = int(value)  # also one of numpy
    if any(_is_of(value, form) for form in forms) and (span is None or value is None or _within(value, span)):
        return value
    raise InputError(f"{name}={value!r} must be {_allowed(forms, span, option.metavar or '' if option else '')}")


def _allowed(forms: Sequence[Any], span: Any, metavar: str) -> str:
    """What an argument may be, in words."""
    words = {form: _words(form) for form in forms if not (form is str and Path in forms)}
    if span is not None:
        least = f"{'above' if span.min_open else 'from'} {span.min:.12g}"
        unbounded = ", and finite" * isinstance(span, click.FloatRange)
        words[forms[0]] += f" {least}" + (unbounded if span.max is None else f" to {span.max:.12g}")
    elif str in words and metavar:
        words[str] += f" {metavar.strip('[.]')}"
    *others, last = words.values()
    return f"{', '.join(others)}, or {last}" if others else last


def _forms(hint: Any) -> list[Any]:
    bare = getattr(hint, "__origin__", hint) if hasattr(hint, "__metadata__") else hint
    return list(get_args(bare)) if get_origin(bare) in (Union, UnionType) else [bare]


def _is_of(value: Any, form: Any) -> bool:
    kind = get_origin(form) or form
    if kind is Callable:
        return callable(value)
    if kind is Sequence:  # whatever can be read once
        inner = _forms(get_args(form)[0])
        listed = value if isinstance(value, list | tuple) else ()
        return (
            isinstance(value, Iterable)
            and not isinstance(value, str)
            and all(any(_is_of(one, each) for each in inner) for one in listed)
        )
    if kind is Path:
        return isinstance(value, str | PathLike)
    if kind in (int, float):
        return isinstance(value, int | kind) and not isinstance(value, bool)
    return isinstance(value, kind)


def _within(value: float, span: Any) -> bool:
    least = value > span.min if span.min_open else value >= span.min
    return least and (value < math.inf if span.max is None else value <= span.max)


def _words(form: Any) -> str:
    kind = get_origin(form) or form
    if kind is Sequence:
        return f"a sequence of {_words(_forms(get_args(form)[0])[0]).removeprefix('a ')}s"
    return "a function" if kind is Callable else _KINDS.get(kind, f"a {kind.__name__}")


def number(given: float, name: str, least: float, most: float) -> float:
    """A number from `least` to `most`.

    Raises:
        InputError: it is not.
    """
    if isinstance(given, bool) or not isinstance(given, int | float) or not least <= given <= most:
        raise InputError(f"{name}={given!r} must be a number from {least:g} to {most:g}")
    return given


ENDS = (".svg", ".png")


@dataclass(frozen=True)
class Figure:
    """A picture.

    Attributes:
        title: what it shows.
        svg: the text of an SVG file.
    """

    title: str
    svg: str

    @described
    def save(self, path: Path | str) -> Path:
        """Write the picture; the end of the name decides the format.

        Args:
            path: a name that ends in `.svg` or `.png`.

        Raises:
            InputError: the name ends otherwise, or the file cannot be written.
        """
        file = Path(path)
        end = file.suffix.lower()
        if end not in ENDS:
            raise InputError(f"path={str(path)!r} must end in {' or '.join(ENDS)}")
        write_named(file, png(self.svg) if end == ".png" else self.svg.encode(), "path")
        return file

    def __repr__(self) -> str:
        return f"<figure: {self.title}>"

    def _repr_svg_(self) -> str:
        return self.svg


TIME = "elapsed_s"


class Log(Columns):
    """The log of a flight: arrays (T,) of numbers by name of the signal, sampled at 20 Hz.

    The last sample is the end of the flight.

    Attributes:
        units: unit of each signal; "" for a plain number.
        meanings: meaning of each signal in words.
        beliefs: names of the signals that the stack believed; the others are ground truth.
    """

    units: dict[str, str]
    meanings: dict[str, str]
    beliefs: tuple[str, ...]

    def __init__(
        self,
        title: str,
        signals: Mapping[str, NDArray[Any]],
        units: Mapping[str, str],
        meanings: Mapping[str, str],
        beliefs: tuple[str, ...],
    ) -> None:
        super().__init__(title, {}, ())
        self.update(signals)
        self.types = dict.fromkeys(signals, ColumnType.NUMBER)
        self.rows = len(signals[TIME])
        self.units, self.meanings, self.beliefs = dict(units), dict(meanings), beliefs

    def _table(self, rows: int = 0, columns: int | None = None) -> Table:
        """One row for each signal, because a log has more signals than a page has columns."""
        cells = tuple(
            (name, self.units[name], f"{values.min():.6g}", f"{values.max():.6g}", self.meanings[name])
            for name, values in self.items()
        )
        note = f"{self.rows} samples at 20 Hz, {self.time_s[-1]:.2f} s"
        return Table(self.title, ("signal", "unit", "least", "greatest", "meaning"), cells, (note,))

    @property
    def time_s(self) -> NDArray[Any]:
        """(T,) time of each sample [s from the start]."""
        return self[TIME]

    def __getitem__(self, name: str) -> NDArray[Any]:
        values: NDArray[Any] = super().__getitem__(name)
        return values


class FlownFlight:
    """A flight that was flown in this process.

    Args:
        flown: the flight with its log.
        comparison: how it compares with the same flight of a campaign, in a sentence; "" when nobody asked.
    """

    comparison: str

    def __init__(self, flown: LoggedFlight, comparison: str = "") -> None:
        self._flown, self.comparison = flown, comparison

    @property
    def name(self) -> str:
        """`MUTANT/SITUATION/SEED`, as the verb `replay` takes it."""
        return self._flown.outcome.name

    @property
    def mutant(self) -> str:
        """Id of the mutant, `PLACEBO` or `baseline`."""
        return self._flown.outcome.mutant

    @property
    def situation(self) -> str:
        """Key of the situation."""
        return self._flown.outcome.situation

    @property
    def seed(self) -> int:
        """Seed of the noise."""
        return self._flown.outcome.seed

    @cached_property
    def status(self) -> str:
        """What the flight shows beside its baseline, such as `revealed`; of a baseline `held` or `violated`.

        The first call flies the baseline of the same situation and seed.
        """
        with in_python():
            if self._flown.flight.mutant is None:
                return baseline_status(self._flown.outcome)
            return self._flown.judged.status.value

    @property
    def ending(self) -> str:
        """How the flight ended: `landed`, `struck` or `timed_out`."""
        return self._flown.outcome.ending

    @property
    def struck(self) -> str:
        """Name of the body that ended the flight; "" without one."""
        return self._flown.outcome.struck

    @property
    def duration_s(self) -> float:
        """Duration of the flight [s, simulated]."""
        return self._flown.outcome.duration_s

    @property
    def violated(self) -> Mapping[str, float]:
        """Time of the first violation [s from the start] of each requirement that the flight violates."""
        readings = self._flown.outcome.readings
        return {one.requirement: one.violated_at_s for one in readings if one.violated_at_s is not None}

    @property
    def robustness(self) -> Mapping[str, float]:
        """Robustness of each requirement, in its unit; below 0 it is violated, NaN where it was not put to the test."""
        measured = {reading.requirement: reading.robustness for reading in self._flown.outcome.readings}
        return {name: math.nan if rho is None else rho for name, rho in measured.items()}

    @property
    def altered(self) -> int:
        """Number of samples that the fault changed."""
        return self._flown.outcome.altered

    @property
    def carried(self) -> int:
        """Number of samples that crossed the patched seams."""
        return self._flown.outcome.carried

    @property
    def infected_at_s(self) -> float | None:
        """Time of the first changed sample [s from the start]; None without one."""
        return self._flown.outcome.infected_at_s

    @property
    def digest(self) -> str:
        """Digest of the log's ground truth; two flights with one digest are the same to the bit."""
        return self._flown.outcome.digest

    @cached_property
    def log(self) -> Log:
        """The log."""
        with in_python():
            log = self._flown.log
            known = signal_list(self._flown.study).by_name
            units, meanings = (
                {name: getattr(known.get(name), key, "") for name in log.signals} for key in ("unit", "meaning")
            )
            return Log(f"Log of {self.name}", log.signals, units, meanings, log.beliefs)

    def map(self) -> Figure:
        """The map of the flight, beside its baseline, which the first call flies."""
        with in_python():
            return Figure(f"map of {self.name}", self._flown.map())

    def __str__(self) -> str:
        return render((self._flown.facts(),), Format.TABLE)

    def __repr__(self) -> str:
        return f"<flight {self.name}: {self.ending} after {self.duration_s:.2f} s>"

    def _repr_html_(self) -> str:
        return html((self._flown.facts(),))
