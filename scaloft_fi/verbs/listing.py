"""Lists of what a study has, an overview or some entries whole: `scaloft-fi seams`, `operators`, `mutants`."""

from __future__ import annotations

import fnmatch
import inspect
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import CodeType
from typing import Annotated, Any, ClassVar, Generic, TypeVar, get_args, get_origin

import click
import numpy as np

from scaloft_fi.errors import InputError, did_you_mean, refused
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants import catalogue
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operator import Argument, Operator, TapError
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.output import say, tell, tell_line, width
from scaloft_fi.registry import plugins
from scaloft_fi.stack import messages
from scaloft_fi.stack.declaration import Seam, unit_of
from scaloft_fi.study import Study
from scaloft_fi.verbs import names
from scaloft_fi.verbs.names import operators, seams
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, check_own, verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Format, Table, TableCell, body_text, render, tabulated


@dataclass(frozen=True)
class Entry:
    """An entry of a list.

    Attributes:
        name: its name.
    """

    name: str

    def sheet(self) -> Sequence[tuple[str, str]]:
        """The entry whole, as pairs of a heading and a text; what is empty is left out."""
        raise NotImplementedError


E = TypeVar("E", bound=Entry)


@dataclass(frozen=True)
class Listing(Generic[E]):
    """A list of what a study has.

    Attributes:
        noun: what an entry is, such as "signal".
        title: of the overview.
        overview: column of the overview -> attribute of the entry.
        entries: they.
        form: the form of the list as JSON, whose one key has the entries.
        notes: under the overview.
    """

    noun: str
    title: str
    overview: Mapping[str, str]
    entries: tuple[E, ...]
    form: Output
    notes: tuple[str, ...] = ()

    @property
    def by_name(self) -> dict[str, E]:
        """The entries by name."""
        return {entry.name: entry for entry in self.entries}

    def chosen(self, patterns: Sequence[str]) -> Listing[E]:
        """The entries that have one of these names, or match one of these patterns with `*`, `?` or `[`.

        Raises:
            InputError: a name or pattern fits nothing; the message names the nearest name.
        """
        wanted: set[str] = set()
        for pattern in patterns:
            fits = [pattern] if pattern in self.by_name else fnmatch.filter(self.by_name, pattern)
            if not fits:
                raise InputError(f"no {self.noun} {pattern!r}{did_you_mean(pattern, self.by_name)}")
            wanted.update(fits)
        return replace(self, entries=tuple(entry for entry in self.entries if entry.name in wanted))

    def answer(self, patterns: Sequence[str] = ()) -> Answer:
        """An overview, or the entries that are named, whole.

        Raises:
            InputError: as for `chosen`.
        """
        chosen = self.chosen(patterns) if patterns else self
        told = partial(shown, chosen, whole=bool(patterns))
        return Answer(self.form, lambda: self.form.answer(chosen.entries), told=told)


def shown(listing: Listing[Any], how: Format, *, whole: bool) -> str:
    """The list as a text for people that ends in a line break: the overview, or each entry whole."""
    if whole:
        return render([Table(one.name, ("what", ""), _rows(one.sheet())) for one in listing.entries], how)
    rows = tuple(tuple(plain(getattr(one, key)) for key in listing.overview.values()) for one in listing.entries)
    return render((Table(listing.title, tuple(listing.overview), rows, listing.notes),), how)


def plain(value: Any) -> TableCell:
    """A value as the cell of a table.

    >>> plain(("a", "b")), plain(True)
    ('a; b', 'yes')
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "; ".join(map(str, value)) if isinstance(value, tuple) else value


def number_range(least: float | None, most: float | None) -> str:
    """A range in words.

    >>> number_range(0.0, 1.0), number_range(0.0, None), number_range(None, None)
    ('0 to 1', 'from 0', '')
    """
    if least is None or most is None:
        return f"from {least:g}" if least is not None else f"up to {most:g}" if most is not None else ""
    return f"{least:.4g} to {most:.4g}"


def _rows(pairs: Sequence[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """Without what is empty; a heading stands once."""
    rows: list[tuple[str, str]] = []
    last = ""
    for heading, text in pairs:
        if text:
            rows.append(("" if heading == last else heading, text))
            last = heading
    return tuple(rows)


POINT = "3 numbers x, y, z"
_PLAIN: Mapping[Any, str] = {float: "number", int: "whole number", str: "text", bool: "true or false"}


@dataclass(frozen=True)
class MessageField:
    """A field.

    Attributes:
        name: its name.
        kind: what it is.
        unit: its unit; empty for none.
    """

    name: str
    kind: str
    unit: str

    def __str__(self) -> str:
        return f"{self.name}: {self.kind}" + (f" [{self.unit}]" if self.unit else "")


def fields_of(seam: Seam) -> tuple[MessageField, ...]:
    """The fields of a seam's message."""
    names = messages.field_names(seam.message)
    units = {**seam.number_units, **dict.fromkeys(messages.stamp_fields(seam.message), "s")}
    return tuple(MessageField(name, kind_of(seam.message, name), units.get(name, "")) for name in names)


def kind_of(message: type, name: str) -> str:
    """The kind of a field in words.

    >>> from scaloft_fi.stack.messages import Detections, Imu
    >>> kind_of(Imu, "rate"), kind_of(Imu, "stamp_s")
    ('3 numbers x, y, z', 'time stamp')
    >>> kind_of(Detections, "persons")
    'Person, any number of: label text, score number, bearing_rad number [rad], range_m number [m]'
    """
    if name in messages.stamp_fields(message):
        return "time stamp"
    if name in messages.image_fields(message):
        return "image"
    hint = messages.field_type(message, name)
    if hint == messages.Point or name in messages.vector_fields(message):
        return POINT
    return _kind_said(hint)


def _kind_said(hint: Any) -> str:
    if hint in _PLAIN:
        return _PLAIN[hint]
    if get_origin(hint) is tuple:
        first, *rest = get_args(hint)
        if rest != [Ellipsis]:
            return f"{len(rest) + 1} values"
        if messages.field_names(first):
            return f"{first.__name__}, any number of: {_whole(first)}"
        return f"{POINT if first == messages.Point else _kind_said(first)}, any number of"
    if messages.field_names(hint):
        return f"{hint.__name__}: {_whole(hint)}"
    return "numbers" if "float" in str(hint) else "true or false, any number of" if "bool" in str(hint) else "values"


def _whole(message: type) -> str:
    def one(name: str) -> str:
        unit = unit_of(name)
        return f"{name} {kind_of(message, name)}" + (f" [{unit}]" if unit else "")

    return ", ".join(map(one, messages.field_names(message)))


SEAM_OVERVIEW = {
    "seam": "name",
    "message": "message",
    "Hz": "rate_hz",
    "edge": "edge",
    "cells": "used_by",
    "operators": "fitting",
}
EVERYTHING = "all of the sample"


@dataclass(frozen=True)
class ListedSeam(Entry):
    """A seam.

    Attributes:
        message: type of its samples.
        about: what the message says of itself.
        edge: who sends, and who receives.
        rate_hz: how often it is polled [Hz].
        fields: the fields of a sample.
        acts_on: what of a sample the consumer acts on; it is altered only where this differs.
        canary: whether `run --mutant` flies a control here.
        carried: who alters the samples where a command flies; empty where our simulator flies.
        operators: the operators that fit.
        cells: the cells that have a fault here.
    """

    message: str
    about: str
    edge: str
    rate_hz: float
    fields: tuple[MessageField, ...]
    acts_on: tuple[str, ...]
    canary: bool
    carried: str
    operators: tuple[str, ...]
    cells: tuple[str, ...]
    KEYS: ClassVar = ("*", "used_by", "fitting")

    @property
    def used_by(self) -> int:
        """How many cells."""
        return len(self.cells)

    @property
    def fitting(self) -> int:
        """How many operators."""
        return len(self.operators)

    def sheet(self) -> Sequence[tuple[str, str]]:
        """The seam whole."""
        every = self.acts_on == tuple(field.name for field in self.fields)
        return [
            ("edge", self.edge),
            ("rate", f"{self.rate_hz:g} Hz"),
            ("message", f"{self.message}: {self.about}"),
            *(("fields", str(field)) for field in self.fields),
            ("its consumer acts on", EVERYTHING if every else ", ".join(self.acts_on)),
            ("altered by", self.carried),
            ("canary", "yes: `run --mutant` flies a control here" if self.canary else ""),
            ("operators that fit", ", ".join(self.operators)),
            ("cells", ", ".join(self.cells) or "none"),
        ]


@dataclass(frozen=True)
class Seams:
    """The seams of the study's stack, where faults can be patched in.

    Attributes:
        seams: the seams.
    """

    seams: tuple[ListedSeam, ...]


SEAMS = Output("seams", "1.0", Seams, rows="seams")


def seam_list(study: Study) -> Listing[ListedSeam]:
    """Every seam of the study's stack.

    Raises:
        InputError: a part of the study cannot be read.
    """
    stack, matrix = study.stack, study.matrix
    listed = tuple(
        ListedSeam(
            name=seam.name,
            message=seam.message.__name__,
            about=" ".join((seam.message.__doc__ or "").split()),
            edge=seam.edge,
            rate_hz=seam.rate_hz,
            fields=fields_of(seam),
            acts_on=acted_on(seam),
            canary=seam.name in stack.canaries,
            carried=_carried(study, seam.name),
            operators=tuple(name for name in sorted(OPERATORS) if OPERATORS[name].need.met_by(seam.message)),
            cells=tuple(cell.name for cell in matrix if any(fault.seam == seam.name for fault in cell.faults)),
        )
        for seam in stack.seams
    )
    notes = (
        "edge: who sends, and who receives.  cells: how many cells of the matrix have a fault here.",
        "operators: how many fit its message.  `scaloft-fi seams NAME` shows one whole.",
    )
    return Listing("seam", f"Seams of the stack {stack.name}: {len(listed)}", SEAM_OVERVIEW, listed, SEAMS, notes)


def acted_on(seam: Seam) -> tuple[str, ...]:
    """What of a sample its consumer acts on, fields or properties; a sample is altered only where these differ.

    A declared effect is a function of the sample; it acts on what its code names.
    """
    fields = messages.field_names(seam.message)
    if seam.effect is Seam.__dataclass_fields__["effect"].default:
        return tuple(fields)
    named = set(_names_in(seam.effect))
    properties = [name for name, one in vars(seam.message).items() if isinstance(one, property)]
    return tuple(name for name in (*fields, *properties) if name in named)


def _names_in(function: Callable[..., Any]) -> Iterator[str]:
    waiting = [function.__code__] if hasattr(function, "__code__") else []
    while waiting:
        code = waiting.pop()
        yield from code.co_names
        waiting += [inner for inner in code.co_consts if isinstance(inner, CodeType)]


def _carried(study: Study, seam: str) -> str:
    """Who alters the samples of a faulty seam where a command flies; "" where our wire does."""
    if study.command is None:
        return ""
    if (relay := study.command.relays.get(seam)) is None:
        return "the command: it gets the fault in {fault} and injects it itself"
    return f"our relay from {relay.source} to {relay.to} over {relay.border}"


@verb("seams")
def seams_command(
    study: Study, names: Annotated[tuple[str, ...], Option("", "", metavar="[NAME]...", complete=seams)] = ()
) -> Answer:
    """List the seams of the study's stack, where faults can be patched in.

    Without a NAME an overview.  Names, and patterns with *, ? or [, show these whole: fields with units, what
    the consumer acts on, and the operators and cells.

    Examples:
        List all seams: `scaloft-fi seams`
        Show one whole, with the operators that fit: `scaloft-fi seams velcmd`
        Write them all as JSON: `scaloft-fi seams --format json`
    """
    return seam_list(study).answer(names)


OWN = "scaloft-fi"


def package_of(made: Callable[..., Any] | str) -> str:
    """The package that declares what a function makes: a distribution with a plugin, else the module's first name.

    Args:
        made: the function, or the name of its module.
    """
    module = made if isinstance(made, str) else made.__module__
    first = module.partition(".")[0]
    if first == __name__.partition(".")[0]:
        return OWN
    distribution = {plugin.module.partition(".")[0]: plugin.dist for plugin in plugins()}.get(first)
    return distribution.name if distribution else first


NOTHING = "nothing"
MOST_NUMBERS = 8
"""Arrays with more numbers are told by their shape and the first row."""


def sample_text(sample: Any) -> str:
    """A sample by its fields; `nothing` where none is sent.

    >>> from scaloft_fi.mutants.sample import Reading
    >>> sample_text(Reading(0.05, 1.0)), sample_text(None)
    ('stamp_s=0.05, value=1', 'nothing')
    """
    if sample is None:
        return NOTHING
    return ", ".join(f"{name}={_value(value)}" for name, value in zip(sample._fields, sample, strict=True))


def _value(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, int | float | np.number):
        return f"{float(value) + 0.0:.4g}"  # -0.0 + 0.0 is 0.0
    if isinstance(value, np.ndarray):
        if value.size <= MOST_NUMBERS:
            return f"[{', '.join(map(_value, value.tolist()))}]"
        first = f"[{', '.join(map(_value, np.atleast_2d(value)[0].tolist()[:MOST_NUMBERS]))}]"
        return f"{' x '.join(map(str, value.shape))}, first row {first}"
    if hasattr(value, "_fields"):
        return f"({sample_text(value)})"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return str(value)


OPERATOR_OVERVIEW = {
    "operator": "name",
    "arguments": "signature",
    "needs": "needs",
    "seams": "fits",
    "what it does": "summary",
}


@dataclass(frozen=True)
class ListedArgument:
    """An argument.

    Attributes:
        name: its name.
        kind: what it is.
        unit: its unit; empty for none.
        range: what is allowed, in words.
        least: least number; null: nothing bounds it, or it is no number.
        above: every number is above this; null: nothing bounds it, or it is no number.
        most: greatest number; null: nothing bounds it, or it is no number.
        choices: the allowed texts; empty for any.
        required: whether a fault must give it.
        default: its value when it is left out; null where it is required.
    """

    name: str
    kind: str
    unit: str
    range: str
    least: float | None
    above: float | None
    most: float | None
    choices: tuple[str, ...]
    required: bool
    default: Any

    def __str__(self) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        default = "" if self.required else f", {_said(self.default) or 'nothing'} when left out"
        return f"{self.name}: {self.range or self.kind}{unit}{default}"


@dataclass(frozen=True)
class GivenArgument:
    """An argument.

    Attributes:
        name: its name.
        value: its value.
    """

    name: str
    value: Any

    def __str__(self) -> str:
        return f"{self.name}={_said(self.value)}"


@dataclass(frozen=True)
class Poll:
    """A poll.

    Attributes:
        t_s: time [s].
        sent: the sample that is sent.
        arrives: the sample that arrives.
    """

    t_s: float
    sent: str
    arrives: str

    def __str__(self) -> str:
        same = self.arrives == self.sent != NOTHING
        return f"{self.t_s:g} s: {self.sent} -> {'the same' if same else self.arrives}"


@dataclass(frozen=True)
class ListedOperator(Entry):
    """An operator.

    Attributes:
        summary: what it does, in a sentence.
        about: all that it says of itself.
        arguments: its arguments.
        needs: what it needs of a message.
        seams: the seams of this study that it fits.
        cells: the cells that use it.
        at_events: whether it can strike at events of the flight.
        package: the installed package that declares it.
        message: type of the samples of its example.
        rate_hz: how often the seam of its example is polled [Hz].
        given: the arguments of its example.
        polls: its example; of a random operator one draw.
        fault: why there are no polls; empty for a sound operator.
    """

    summary: str
    about: str
    arguments: tuple[ListedArgument, ...]
    needs: str
    seams: tuple[str, ...]
    cells: tuple[str, ...]
    at_events: bool
    package: str
    message: str
    rate_hz: float
    given: tuple[GivenArgument, ...]
    polls: tuple[Poll, ...]
    fault: str
    KEYS: ClassVar = ("*", "signature", "fits")

    @property
    def signature(self) -> str:
        """Names of the arguments, in brackets those that may be left out."""
        return ", ".join(one.name if one.required else f"[{one.name}]" for one in self.arguments)

    @property
    def fits(self) -> int:
        """How many seams."""
        return len(self.seams)

    def sheet(self) -> Sequence[tuple[str, str]]:
        """The operator whole."""
        return [
            ("does", self.about),
            *(("arguments", str(argument)) for argument in self.arguments),
            ("needs", self.needs),
            ("fits the seams", ", ".join(self.seams) or "none of this study"),
            ("cells", ", ".join(self.cells)),
            ("at events", "yes: a phase such as #waypoint is allowed" if self.at_events else ""),
            ("declared by", self.package),
            ("example", f"{self.message} at {self.rate_hz:g} Hz, {', '.join(map(str, self.given)) or 'no arguments'}"),
            *(("polls", str(poll)) for poll in self.polls),
            ("fault", self.fault),
        ]


@dataclass(frozen=True)
class Operators:
    """The operators that faults can use.

    Attributes:
        operators: the operators.
    """

    operators: tuple[ListedOperator, ...]


LISTED_OPERATORS = Output("operators", "1.1", Operators, rows="operators")
_KINDS = {**_PLAIN, object: "number, text, true or false"}
_OF_FIELD = ("amount", "sigma", "value")
"""Arguments in the unit of the field that the argument `field` names."""


def operator_list(study: Study) -> Listing[ListedOperator]:
    """Every operator that the installed packages and the study's stack declare.

    Raises:
        InputError: a part of the study cannot be read.
    """
    matrix, stack = study.matrix, study.stack  # reading the stack declares its own operators
    listed = tuple(
        ListedOperator(
            name=name,
            summary=one.summary,
            about=" ".join(inspect.cleandoc(one.make.__doc__ or "").split()),
            arguments=tuple(map(argument_facts, one.arguments.values())),
            needs=one.need.words,
            seams=tuple(seam.name for seam in stack.seams if one.need.met_by(seam.message)),
            cells=tuple(cell.name for cell in matrix if any(fault.operator == name for fault in cell.faults)),
            at_events=one.awaits_events,
            package=package_of(one.make),
            message=one.example.message.__name__,
            rate_hz=one.example.rate_hz,
            given=tuple(GivenArgument(*each) for each in one.example.arguments.items()),
            polls=polls,
            fault=fault,
        )
        for name in sorted(OPERATORS)
        for one in [OPERATORS[name]]
        for polls, fault in [_polls(one)]
    )
    notes = (
        f"seams: how many of the stack {stack.name} it fits.",
        "`scaloft-fi operators NAME` shows one whole, with an example.",
        *(f"Of the package {one.package}: {one.fault}." for one in listed if one.fault),
    )
    return Listing("operator", f"Operators: {len(listed)}", OPERATOR_OVERVIEW, listed, LISTED_OPERATORS, notes)


def _polls(operator: Operator) -> tuple[tuple[Poll, ...], str]:
    """The polls of its example, and why there are none."""
    example = operator.example
    try:
        pairs = zip(example.before, operator.arrived(), strict=True)
    except TapError as error:
        return (), str(error)
    return tuple(
        Poll(round(place / example.rate_hz, 6), sample_text(sent), sample_text(arrives))
        for place, (sent, arrives) in enumerate(pairs)
    ), ""


def argument_facts(argument: Argument) -> ListedArgument:
    """What is told of an argument of an operator."""
    allowed = argument.allowed
    bounds = (allowed.least, allowed.above, allowed.most) if argument.kind in (float, int) else (math.inf,) * 3
    least, above, most = (bound if math.isfinite(bound) else None for bound in bounds)
    words = number_range(least, most)
    if above is not None:
        words = f"above {above:g}" + (f", up to {most:g}" if most is not None else "")
    if argument.field is not None:
        words = "a field of numbers, or all" if argument.field.number else "a field, or all"
    elif argument.choices:
        words = "one of " + ", ".join(choice or '""' for choice in argument.choices)
    return ListedArgument(
        name=argument.name,
        kind=_KINDS[argument.kind],
        unit=_unit(argument),
        range=words,
        least=least,
        above=above,
        most=most,
        choices=tuple(argument.choices),
        required=argument.required,
        default=None if argument.required else argument.default,
    )


def _unit(argument: Argument) -> str:
    if argument.of_field or argument.name in _OF_FIELD:
        return "of the field"
    return unit_of(argument.name) if argument.kind in (float, int) else ""


def _said(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, int | float) else str(value)


@verb("operators")
def operators_command(
    study: Study, names: Annotated[tuple[str, ...], Option("", "", metavar="[NAME]...", complete=operators)] = ()
) -> Answer:
    """List the operators that faults can use.

    Without a NAME an overview.  Names, and patterns with *, ? or [, show these whole: arguments with units and
    ranges, fitting seams, package, and samples before and after.

    Examples:
        List all operators: `scaloft-fi operators`
        Show one whole, with its example: `scaloft-fi operators delay`
        Write those that begin with `drop` as JSON: `scaloft-fi operators 'drop*' --format json`
    """
    return operator_list(study).answer(names)


@dataclass(frozen=True)
class Catalogue:
    """The written catalogue.

    Attributes:
        path: its file.
        current: whether it is what the matrix gives.
        written: whether this call has written it.
        mutants: mutants that the matrix gives.
        cells: cells that have mutants.
    """

    path: str
    current: bool
    written: bool
    mutants: int
    cells: int


@dataclass(frozen=True)
class ListedMutant:
    """A mutant.

    Attributes:
        mutant: itself.
        default: whether the name of its cell stands for it.
    """

    mutant: Mutant
    default: bool
    KEYS = ("mutant.*", "default")


@dataclass(frozen=True)
class MutantList:
    """The mutants that the deviation matrix gives.

    Attributes:
        catalogue: the written catalogue.
        mutants: the mutants asked for; with --write and --check all of them.
    """

    catalogue: Catalogue
    mutants: tuple[ListedMutant, ...]


MUTANTS = Output("mutants", "1.0", MutantList, rows="mutants")
_COLUMNS = ("id", "default", "parameter", "guideword", "seam", "operator", "arguments")
_IN_TERMINAL = ("id", "default", "seam", "operator", "arguments")
"""Guideword and parameter are read from the id."""


@verb("mutants")
def mutants_command(
    *,
    patterns: Annotated[tuple[str, ...], Option("", "", metavar="[PATTERN]...", complete=names.mutants)] = (),
    write: Annotated[bool, Option("Derive the catalogue from the matrix and write it.")],
    check: Annotated[bool, Option("Prove that the written catalogue is what the matrix gives.")],
    cells: Annotated[
        tuple[str, ...],
        Option("All mutants of this cell (repeatable).", "--cell", metavar="CELL", complete=names.cells),
    ],
    only_defaults: Annotated[bool, Option("One mutant a cell: its default.", "--defaults")],
    style: TableFormat,
    study_folder: StudyFolder,
) -> None:
    """List, derive, or prove current the catalogue of mutants.

    PATTERN is a cell's name (its default mutant), an id, or a pattern with *, ? or [ over names and ids:
    `LATE-human*` is the whole ladder, `*-human` the default of every cell of `human`.

    Examples:
        List the ladder of one cell: `scaloft-fi mutants 'LATE-human*'`
        Derive the catalogue again after an edit of the matrix: `scaloft-fi mutants --write`
        Fail where the catalogue is stale, as in CI: `scaloft-fi mutants --check`
    """
    if write and check:
        raise click.UsageError("--write and --check exclude each other")
    if (write or check) and (patterns or cells or only_defaults):
        raise click.UsageError("--write and --check are about the whole catalogue; give no pattern with them")

    study = Study.open(study_folder)
    folder = study.folder / "mutants"
    if write:
        check_own(study, study_folder, folder / catalogue.CATALOGUE)
    matrix = study.matrix
    derived = catalogue.check_catalogue(folder, matrix) if check else catalogue.derive(matrix)
    default_ids = {mutant.id for mutant in catalogue.defaults(matrix)}
    path = catalogue.write_catalogue(folder, derived) if write else folder / catalogue.CATALOGUE
    current = write or check or _is_current(folder, matrix)
    chosen = derived if write or check else _chosen(derived, matrix, patterns, cells, only_defaults=only_defaults)
    if style == Format.JSON:
        told = Catalogue(str(path), current, write, len(derived), len(default_ids))
        tell(MUTANTS.json(MutantList(told, tuple(ListedMutant(one, one.id in default_ids) for one in chosen))))
    elif write or (check and style != Format.CSV):
        tell_line(f"{path}: {'' if write else 'current, '}{len(derived)} mutants of {len(default_ids)} cells")
    else:
        tell(f"{_table(chosen, default_ids, style)}\n")


def _is_current(folder: Path, matrix: Matrix) -> bool:
    """Whether the written catalogue is what the matrix gives; a warning says why it is not."""
    if error := refused(catalogue.check_catalogue, folder, matrix):
        say(f"warning: {error}")
    return not error


def _chosen(
    derived: Sequence[Mutant], matrix: Matrix, patterns: Sequence[str], cells: Sequence[str], *, only_defaults: bool
) -> Sequence[Mutant]:
    """What the user asks for; without a word the whole catalogue."""
    for name in cells:
        catalogue.default_of(matrix.cell(name))  # refuses a cell without mutants, with its reason
    chosen = list(catalogue.select(patterns, matrix, derived))
    known = {mutant.id for mutant in chosen}
    if cells or not patterns:
        chosen += [m for m in derived if (not cells or m.cell in cells) and m.id not in known]
    kept = {mutant.id for mutant in catalogue.defaults(matrix)}
    return [mutant for mutant in chosen if mutant.id in kept or not only_defaults]


def _table(mutants: Sequence[Mutant], default_ids: Collection[str], style: str) -> str:
    rows = [_row(mutant, mutant.id in default_ids) for mutant in mutants]
    if style == "table":
        short = [[row[name] for name in _IN_TERMINAL] for row in rows]
        return body_text(_IN_TERMINAL, short, width(), ("operator", "seam"), marked=False)
    return tabulated(_COLUMNS, [list(row.values()) for row in rows], Format(style))


def _row(mutant: Mutant, default: bool) -> dict[str, Any]:
    said = {name: f"{value:g}" if isinstance(value, float) else value for name, value in mutant.arguments.items()}
    arguments = ", ".join(f"{name}={value}" for name, value in said.items())
    values = (mutant.id, "*" * default, mutant.parameter, mutant.guideword, mutant.seam, mutant.operator, arguments)
    return dict(zip(_COLUMNS, values, strict=True))
