"""What a verb answers: JSON of a declared shape, and the same as CSV tables and typed columns.

A record in a record gives columns `outer_inner`, a list of plain values is one cell, a list of records in a record is a
table of its own, `table_key`, whose first column says whose a record is.

A record is closed: it has each of its keys, and no others.  What may be missing is null (`optional`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from enum import Enum, StrEnum
from functools import cache, cached_property
from inspect import get_annotations
from operator import attrgetter
from pathlib import Path
from types import MappingProxyType, NoneType, UnionType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, NoReturn, Union, get_args, get_origin

from scaloft_fi.errors import InputError, did_you_mean, needed
from scaloft_fi.marks import About, Bounds, ByName, Choices, Listed
from scaloft_fi.model import fields_of, is_model, summary_of
from scaloft_fi.output import json_text
from scaloft_fi.views.table import Format, Table, TableCell, csv_text, html, render

if TYPE_CHECKING:
    from numpy.typing import NDArray


SHOWN, ACROSS = 10, 8
"""Rows and, in a text, columns that are shown."""


class ColumnType(StrEnum):
    """The type of a column."""

    WHOLE = "int64"
    """Whole numbers; there is always a value."""
    NUMBER = "float64"
    """Numbers; NaN where there is no value."""
    TRUTH = "bool"
    """True or false."""
    TEXT = "text"
    """Texts (an array of objects); "" where there is nothing to say."""
    TEXTS = "texts"
    """Lists of texts."""
    NUMBERS = "numbers"
    """Lists of numbers."""
    WHOLES = "wholes"
    """Lists of whole numbers."""


class Columns(dict[str, Any]):
    """Columns of equal length by name: an array (rows,) each, or a list of lists.

    It is a dict, because pandas makes a data frame of no other mapping.  The arrays cannot be written, since data
    frames may share their memory.  A text column is an array of `str`.  A column of lists is a list, because polars
    cannot read arrays of lists; its type there follows from the values, so that of empty lists is `List(Null)`, and
    `arrow` has the exact types.

    Args:
        title: what the rows are, for a reader.
        types: type of each column, in their order.
        rows: the rows; None where a number has no value.

    Attributes:
        title: what the rows are.
        types: type of each column.
        rows: number of rows.
    """

    title: str
    types: dict[str, ColumnType]
    rows: int

    def __init__(self, title: str, types: Mapping[str, ColumnType], rows: Iterable[Mapping[str, Any]]) -> None:
        listed = list(rows)
        super().__init__({name: _column(kind, [row[name] for row in listed]) for name, kind in types.items()})
        self.title, self.types, self.rows = title, dict(types), len(listed)

    def __missing__(self, name: object) -> NoReturn:
        raise KeyError(f"no column {name!r}{did_you_mean(str(name), self)}")

    def arrow(self) -> Any:
        """The same as a `pyarrow.Table`, where numbers without a value are null.

        Raises:
            InputError: pyarrow is not installed.
        """
        pyarrow = needed_pyarrow()
        types = {kind: pyarrow.type_for_alias(name) for kind, name in _ARROW.items()}
        types |= {kind: pyarrow.list_(types[each]) for kind, each in _EACH.items()}
        columns = [pyarrow.array(self[name], types[kind], from_pandas=True) for name, kind in self.types.items()]
        return pyarrow.Table.from_arrays(columns, names=list(self.types))

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The Arrow PyCapsule protocol, which `pandas.DataFrame.from_arrow` reads.

        Raises:
            InputError: pyarrow is not installed.
        """
        return self.arrow().__arrow_c_stream__(requested_schema)

    def _table(self, rows: int, columns: int | None = None) -> Table:
        """The first `rows` rows and `columns` columns (None: all) as a table of texts."""
        names = list(self)[:columns]
        shown = min(rows, self.rows)
        cells = tuple(tuple(_cell(self[name][row]) for name in names) for row in range(shown))
        more = {"rows": self.rows - shown, "columns": len(self) - len(names)}
        note = " and ".join(f"{count} more {what}" for what, count in more.items() if count)
        return Table(self.title, tuple(names), cells, (f"... {note}",) if note else ())

    def __str__(self) -> str:
        return render((self._table(SHOWN, ACROSS),), Format.TABLE)

    def __repr__(self) -> str:
        return f"<{self.title}: {self.rows} rows of {', '.join(self)}>"

    def _repr_html_(self) -> str:
        return html((self._table(SHOWN),))


def needed_pyarrow() -> Any:
    """The module pyarrow.

    Raises:
        InputError: it is not installed.
    """
    return needed("pyarrow", "Arrow data needs pyarrow", "parquet")


_ARROW = {ColumnType.WHOLE: "int64", ColumnType.TRUTH: "bool", ColumnType.NUMBER: "float64", ColumnType.TEXT: "string"}
_EACH = {ColumnType.TEXTS: ColumnType.TEXT, ColumnType.NUMBERS: ColumnType.NUMBER, ColumnType.WHOLES: ColumnType.WHOLE}
_DTYPES = {ColumnType.WHOLE: "int64", ColumnType.TRUTH: "bool", ColumnType.NUMBER: "float64", ColumnType.TEXT: "object"}


def _column(kind: ColumnType, values: Sequence[Any]) -> NDArray[Any] | list[Any]:
    import numpy as np

    told = [_utf8(value) for value in values]
    if kind not in _DTYPES:
        return told
    array: NDArray[Any] = np.array(told, dtype=_DTYPES[kind])  # None as a float is NaN
    array.setflags(write=False)
    return array


def _utf8(value: Any) -> Any:
    """A text or a list of texts in which lone surrogates, which UTF-8 cannot hold, are spelled out."""
    if isinstance(value, list):
        return [_utf8(entry) for entry in value]
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value


def _cell(value: Any) -> TableCell:
    if isinstance(value, list):
        return ", ".join(map(str, value))
    if isinstance(value, str):
        return value
    if value.dtype == bool:
        return "yes" if value else "no"
    return "" if value != value else f"{value:g}"  # NaN is the one number that differs from itself


Shape = Mapping[str, Any]
"""A JSON Schema."""


def record(about: str, keys: Mapping[str, Shape]) -> Shape:
    """An object with exactly these keys."""
    return {
        "type": "object",
        "description": about,
        "properties": dict(keys),
        "required": list(keys),
        "additionalProperties": False,
    }


def listing(about: str, each: Shape) -> Shape:
    """A list of values of one shape."""
    return {"type": "array", "description": about, "items": each}


def inner(shape: Shape) -> Shape:
    """The shape of a value that is not null."""
    alternatives = shape.get("anyOf")
    return alternatives[0] if alternatives else shape


class Printed(NamedTuple):
    """What an answer has of a record: the name in the code, the key, the type, what it is."""

    name: str
    key: str
    hint: Any
    about: str


@cache
def printed_of(cls: type) -> tuple[Printed, ...]:
    """What an answer has of a record: its fields, or what its class lists in `KEYS`.

    An entry of `KEYS` is the name of a field or property, or that of one in it: `subject.id`.  Its last name is the
    key, unless another one stands before: `firm=firmness`.  `*` stands for all fields, `subject.*` for all keys there.
    """
    return tuple(one for entry in getattr(cls, "KEYS", ("*",)) for one in _entry(cls, entry))


def _entry(cls: type, entry: str) -> Iterator[Printed]:
    key, _, path = entry.rpartition("=")
    name, _, below = path.partition(".")
    fields = {one.name: Printed(one.name, one.key, one.hint, one.about.removesuffix(".")) for one in fields_of(cls)}
    if name == "*":
        yield from fields.values()
        return
    if name not in fields:
        told = getattr(cls, name)
        getter: Any = told.fget if isinstance(told, property) else told.func
        hint = get_annotations(getter, eval_str=True)["return"]
        fields[name] = Printed(name, name, hint, _phrase(summary_of(getter)))
    one = fields[name]
    if not below:
        yield one._replace(key=key or one.key)
        return
    inside = kind_of(one.hint).bare
    for each in printed_of(inside) if below == "*" else _entry(inside, f"{key}={below}"):
        yield each._replace(name=f"{name}.{each.name}")


def _phrase(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:].removesuffix(".")


class Kind(NamedTuple):
    """A type taken apart.

    Attributes:
        bare: the type without marks and without null.
        about: what a mark says that it is.
        null: whether it may be null.
        infinite: whether it may be an infinite number, which JSON has not: it is then the text `inf` or `-inf`.
        by_name: types of the keys and values of a mapping, or of a tuple of pairs.
        texts: the only texts that it can be.
        listed: of a mapping: the key of the names, where it is a list of records.
    """

    bare: Any
    about: str = ""
    null: bool = False
    infinite: bool = False
    by_name: tuple[Any, ...] = ()
    texts: tuple[str, ...] = ()
    listed: Listed | None = None


@cache
def kind_of(hint: Any) -> Kind:
    """A type of an answer, taken apart."""
    marks = getattr(hint, "__metadata__", ())
    if marks:
        inner = kind_of(hint.__origin__)
        about = next((mark.text for mark in marks if isinstance(mark, About)), inner.about)
        infinite = inner.infinite or any(isinstance(mark, Bounds) and mark.infinite for mark in marks)
        pairs = get_args(get_args(inner.bare)[0]) if any(isinstance(mark, ByName) for mark in marks) else inner.by_name
        texts = next((tuple(map(str, mark.among({}))) for mark in marks if isinstance(mark, Choices)), inner.texts)
        listed = next((mark for mark in marks if isinstance(mark, Listed)), inner.listed)
        return inner._replace(about=about, infinite=infinite, by_name=pairs, texts=texts, listed=listed)
    origin, args = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        value, *others = (one for one in args if one is not NoneType)
        return (Kind(Any) if others else kind_of(value))._replace(null=NoneType in args)
    if origin is Literal:
        return Kind(str, texts=args)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return Kind(str, texts=tuple(one.value for one in hint))
    return Kind(hint, by_name=args if origin is Mapping else ())


_SCALARS: Mapping[Any, Mapping[str, Any]] = {
    str: {"type": "string"},
    float: {"type": "number"},
    int: {"type": "integer", "minimum": 0},
    bool: {"type": "boolean"},
    date: {"type": "string"},
    Path: {"type": "string"},
    Any: {},
}

_PLAIN: Mapping[Any, Callable[[Any], Any]] = {str: str, Path: str, date: date.isoformat}


@cache
def shape_of(hint: Any, about: str = "") -> Shape:
    """The JSON Schema of a type: of a record (a dataclass or named tuple), or of what stands in one.

    Args:
        hint: the type.
        about: what it is, and behind `; null: ` what null means where the name does not say it.
    """
    kind = kind_of(hint)
    about, _, missing = (kind.about or about).partition("; null: ")
    shape = _shape(kind, about)
    if not kind.null:
        return shape
    told = {"description": f"{shape['description']}; null: {missing}" if missing else shape["description"]}
    return {"anyOf": [{**shape, **told}, {"type": "null"}], **told}


def _shape(kind: Kind, about: str) -> Shape:
    told = {"description": about} if about else {}
    if is_model(kind.bare):
        keys = {one.key: shape_of(one.hint, one.about) for one in printed_of(kind.bare)}
        return record(about or _phrase(summary_of(kind.bare)), keys)
    if kind.bare is float and kind.infinite:
        told = {"description": f"{about}; the text inf where it is infinite"}
        return {"type": ["number", "string"], "pattern": "^-?inf$", **told}
    if kind.bare in _SCALARS:
        allowed = {"enum": list(kind.texts)} if kind.texts else {}
        return {**_SCALARS[kind.bare], **told, **allowed, **({"format": "date"} if kind.bare is date else {})}
    if not kind.by_name:
        return {"type": "array", **told, "items": shape_of(get_args(kind.bare)[0])}
    name, each = kind.by_name
    if kind.listed:
        shape = shape_of(each)
        named = {kind.listed.key: shape_of(name, kind.listed.about), **shape["properties"]}
        return listing(about, record(shape["description"], named))
    if names := kind_of(name).texts:
        shape = shape_of(each)  # with {} where the name stands in its description
        return record(about, {one: {**shape, "description": shape["description"].format(one)} for one in names})
    return {"type": "object", **told, "additionalProperties": shape_of(each)}


@cache
def writer_of(hint: Any) -> Callable[[Any], Any]:
    """Makes plain JSON values of the values of a type."""
    kind = kind_of(hint)
    write = _writer(kind)
    return (lambda value: None if value is None else write(value)) if kind.null and write is not _same else write


def _same(value: Any) -> Any:
    return value


def _writer(kind: Kind) -> Callable[[Any], Any]:
    if is_model(kind.bare):
        keys = [(one.key, attrgetter(one.name), writer_of(one.hint)) for one in printed_of(kind.bare)]
        return lambda value: {key: of(value) if write is _same else write(of(value)) for key, of, write in keys}
    if kind.infinite:
        return lambda value: f"{value:g}" if isinstance(value, float) and not math.isfinite(value) else value
    if kind.bare in _SCALARS:
        return _PLAIN.get(kind.bare, _same)
    if not kind.by_name:
        each, ordered = writer_of(get_args(kind.bare)[0]), sorted if get_origin(kind.bare) is frozenset else iter
        return lambda value: [each(one) for one in ordered(value)]
    each = writer_of(kind.by_name[1])
    if listed := kind.listed:
        return lambda value: [{listed.key: str(key), **each(one)} for key, one in value.items()]
    return lambda value: {str(key): each(one) for key, one in dict(value).items()}


def plain(value: Any) -> Any:
    """Plain JSON values of records, and of lists and mappings that have some.

    >>> from scaloft_fi.analysis.roster import Ratio
    >>> plain({"tested": Ratio(8, 15), "mutants": ("LATE-human@3s",)})
    {'tested': {'part': 8, 'whole': 15}, 'mutants': ['LATE-human@3s']}
    """
    kind: Any = type(value)
    if is_model(kind):
        return writer_of(kind)(value)
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    return [plain(one) for one in value] if isinstance(value, Collection) and not isinstance(value, str) else value


def by_field(value: Any, *names: str) -> dict[str, Any]:
    """Fields and properties of a record as plain JSON values, by name."""
    return {name: plain(getattr(value, name)) for name in names}


DIALECT = "https://json-schema.org/draft/2020-12/schema"
VERSION = "of this form: the first number changes when a key goes or changes its meaning, the second when one is added"


@dataclass(frozen=True)
class Output:
    """A form of JSON.

    Attributes:
        verb: whose answer it is.
        version: of the form: MAJOR.MINOR, as `VERSION` says.
        answer: the record that is answered.
        rows: name of the list that `--format csv` prints.
        about: what it says, in half a sentence; empty: what its record is.
    """

    verb: str
    version: str
    answer: type
    rows: str
    about: str = ""

    @cached_property
    def keys(self) -> Mapping[str, Shape]:
        """The shape of each value, by its name."""
        keys: Mapping[str, Shape] = shape_of(self.answer)["properties"]
        return keys

    @property
    def says(self) -> str:
        """What it says, in half a sentence."""
        return self.about or str(shape_of(self.answer)["description"])

    @property
    def head(self) -> dict[str, Any]:
        """How its JSON Schema begins."""
        return {"$schema": DIALECT, "$id": f"urn:scaloft-fi:output:{self.verb}:{self.version}", "title": self.verb}

    @property
    def schema(self) -> dict[str, Any]:
        """The JSON Schema (draft 2020-12) that every answer of the verb satisfies."""
        version = {"type": "string", "description": VERSION, "const": self.version}
        return {**self.head, **record(self.says, {"version": version, **self.keys})}

    def json(self, answer: Any) -> str:
        """The JSON text of `record`."""
        return json_text(self.record(answer), indent=2) + "\n"

    def record(self, answer: Any) -> dict[str, Any]:
        """The whole as plain JSON values, its version first."""
        return {"version": self.version, **writer_of(self.answer)(answer)}


@dataclass(frozen=True)
class Rows(Output):
    """A form that is a bare list of rows, without a version in it: what `export` prints.

    Attributes:
        named: the beginning of the names of further columns, one for each requirement of the study, and their shape.
    """

    named: tuple[str, Shape] = ("", {})

    @property
    def schema(self) -> dict[str, Any]:
        """The JSON Schema of the list."""
        beginning, shape = self.named
        row = {**shape_of(self.answer, "a flight"), "patternProperties": {f"^{beginning}": shape}}
        return {**self.head, **listing(self.says, row)}


SUMMARY = "summary"
"""The table of what stands in no list: one row."""


@dataclass(frozen=True)
class Flat:
    """A table of plain values.

    Attributes:
        about: what a row is.
        columns: the fields by the name of their column.
        rows: the values, those of a row in the order of the columns; None where there is none.
    """

    about: str
    columns: Mapping[str, Field]
    rows: Sequence[Sequence[Any]]


class Field(NamedTuple):
    """A column, or a list of records.

    Attributes:
        name: of the column.
        path: the keys that lead to it.
        shape: of its values.
        lacking: whether a value may be missing.
    """

    name: str
    path: tuple[str, ...]
    shape: Shape
    lacking: bool = False

    @property
    def records(self) -> Shape | None:
        """The shape of the records in its list; None for a column."""
        items = inner(inner(self.shape).get("items", {}))
        return items if "properties" in items else None

    def of(self, value: Any) -> Any:
        """What stands there; None where the way ends before."""
        for key in self.path:
            value = value.get(key) if value is not None else None
        return value


ITSELF = Field("", (), {})
"""A value itself."""


def flat_tables(output: Output, values: Mapping[str, Any]) -> dict[str, Flat]:
    """Each table by its name, the summary last.

    Args:
        output: the form of the values.
        values: plain JSON values of this form; None for a list that has no entries.
    """
    made: dict[str, Flat] = {}
    fields = list(_fields({"properties": output.keys}, [values], ITSELF))
    for field in fields:
        if field.records:
            made |= _tables(field, field.records, None, [(None, one) for one in field.of(values) or ()])
    if single := {field.name: field for field in fields if not field.records}:
        made[SUMMARY] = Flat(output.says, single, [[field.of(values) for field in single.values()]])
    return made


def _tables(
    listed: Field, shape: Shape, owner: Field | None, owned: Sequence[tuple[Any, Mapping[str, Any]]]
) -> dict[str, Flat]:
    """The table of records of one shape, and those of the records in them.

    Args:
        listed: the list; its name is that of the table.
        shape: of its records.
        owner: the column that says whose a record is; None where it is nobody's.
        owned: whose each record is, and the record.
    """
    fields = list(_fields(shape, [one for _, one in owned], ITSELF))
    columns = {field.name: field for field in fields if not field.records}
    rows = [[*([whose] if owner else []), *(field.of(one) for field in columns.values())] for whose, one in owned]
    about = inner(listed.shape)["description"]
    made = {listed.name: Flat(about, {owner.name: owner, **columns} if owner else columns, rows)}
    label, labelled = next(iter(shape["properties"].items()))
    for field in fields:
        if field.records:
            below = [(one[label], each) for _, one in owned for each in field.of(one) or ()]
            whose = Field(f"of_{label}", (), labelled)
            made |= _tables(field._replace(name=f"{listed.name}_{field.name}"), field.records, whose, below)
    return made


def _fields(shape: Shape, values: Sequence[Any], field: Field) -> Iterator[Field]:
    """The fields of values of one shape; names of the study come in the order of their first appearance."""
    bare, known = inner(shape), [value for value in values if value is not None]
    lacking, named = field.lacking or bare is not shape, bare.get("additionalProperties")
    if "properties" in bare:
        keys = dict(bare["properties"])
    elif isinstance(named, Mapping):
        keys, lacking = {key: named for value in known for key in value}, True
    else:
        yield Field(field.name, field.path, shape, lacking)
        return
    for key, each in keys.items():
        below = [value[key] for value in known if key in value]
        name = f"{field.name}_{key}" if field.name else key
        yield from _fields(each, below, Field(name, (*field.path, key), each, lacking))


def cell(value: Any) -> Any:
    """A plain JSON value as one cell.

    >>> cell([["a", "b"], True])
    'a;b;true'
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ";".join([entry if isinstance(entry, str) else str(cell(entry)) for entry in value])
    return value


_TYPES = {"integer": ColumnType.WHOLE, "number": ColumnType.NUMBER, "boolean": ColumnType.TRUTH}


def type_of(field: Field) -> ColumnType:
    """The type of a column; whole numbers and truth values of which one may be missing are numbers (true is 1)."""
    shape = inner(field.shape)
    if "items" in shape:
        return ColumnType.NUMBERS if _bare(inner(shape["items"])) in _TYPES else ColumnType.TEXTS
    kind = _TYPES.get(_bare(shape), ColumnType.TEXT)
    return ColumnType.NUMBER if field.lacking and kind is not ColumnType.TEXT else kind


def _bare(shape: Shape) -> str:
    """The type of JSON values; a number that may be the text `inf` is a number."""
    named: str | Sequence[str] = shape.get("type", "")
    return named if isinstance(named, str) else named[0]


def _columns(name: str, flat: Flat) -> Columns:
    types = {column: type_of(field) for column, field in flat.columns.items()}

    def typed(kind: ColumnType, value: Any) -> Any:
        if kind in (ColumnType.TEXTS, ColumnType.NUMBERS):
            return [float(one) if kind is ColumnType.NUMBERS else str(cell(one)) for one in value or ()]
        if kind is ColumnType.TEXT:
            return "" if value is None else str(cell(value))
        return float(value) if kind is ColumnType.NUMBER and value is not None else value

    rows = ({name: typed(types[name], value) for name, value in zip(types, row, strict=True)} for row in flat.rows)
    return Columns(f"{name}: {flat.about}", types, rows)


class Answer(Mapping[str, Columns]):
    """What a verb answers: a mapping with columns for each table that the verb writes with `--tables`, by its name.

    It is a picture of the moment at which it was asked for, and nothing changes it.

    Args:
        form: the form of its JSON.
        values: makes the plain JSON values of the form.
        tables: makes the tables for people.
        told: makes the text for people, where it is not that of the tables.
        rows: name of the table that `csv` prints; by default the one of the form.
        warnings: what a reader must know beside it, in sentences.
        errors: what could not be answered, in sentences.

    Attributes:
        warnings: what a reader must know beside it, in sentences; often nothing.
        errors: what could not be answered, in sentences; the command line ends with exit code 2 after them.
    """

    warnings: tuple[str, ...]
    errors: tuple[str, ...]

    def __init__(
        self,
        form: Output,
        values: Callable[[], Any],
        tables: Callable[[], Sequence[Table]] = tuple,
        *,
        told: Callable[[Format], str] | None = None,
        rows: str = "",
        warnings: Sequence[str] = (),
        errors: Sequence[str] = (),
    ) -> None:
        self.errors = tuple(errors)
        self._form, self._make, self._tables, self.warnings = form, values, tables, tuple(warnings)
        self._rows = rows or form.rows
        self._told = told or (lambda how: render(tables(), how))

    @cached_property
    def summary(self) -> Mapping[str, Any]:
        """What stands in no table: single values by name, a list as a tuple; None where there is no value."""
        flat = self._flat.get(SUMMARY)
        single = zip(flat.columns, *flat.rows, strict=True) if flat else ()
        return MappingProxyType({name: tuple(one) if isinstance(one, list) else one for name, one in single})

    def record(self) -> dict[str, Any]:
        """The whole as plain JSON values: what the verb prints with `--format json`."""
        return {**self._values}

    def text(self, style: str = "table") -> str:
        """What the verb prints.

        Args:
            style: `table`, `markdown`, `latex`, `json`, or `csv` for the one table that the verb prints.

        Raises:
            InputError: there is no such style.
        """
        if style not in list(Format):
            raise InputError(f"style={style!r} must be one of {', '.join(Format)}{did_you_mean(style, list(Format))}")
        how = Format(style)
        if how is Format.JSON:
            return json_text(self.record(), indent=2) + "\n"
        return self.csv()[self._rows] if how is Format.CSV else self._told(how)

    def csv(self) -> dict[str, str]:
        """The text of a CSV file for each table by its name: what the verb writes with `--tables`."""
        texts = {}
        for name, flat in self._flat.items():
            rows = [[cell(value) for value in row] for row in flat.rows]
            summary = name == SUMMARY  # a line for each value
            columns = ("what", "value") if summary else flat.columns
            texts[name] = csv_text(columns, zip(flat.columns, *rows, strict=True) if summary else rows)
        return texts

    @cached_property
    def _values(self) -> Mapping[str, Any]:
        return self._form.record(self._make())

    @cached_property
    def _flat(self) -> Mapping[str, Flat]:
        return flat_tables(self._form, self._values)

    @cached_property
    def _columns(self) -> Mapping[str, Columns]:
        return {name: _columns(name, flat) for name, flat in self._flat.items() if name != SUMMARY}

    def __getitem__(self, name: str) -> Columns:
        if name not in self._columns:
            raise KeyError(f"{self._form.verb} has no table {name!r}{did_you_mean(str(name), self._columns)}")
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        rows = ", ".join(f"{name} ({columns.rows})" for name, columns in self.items())
        return f"<{self._form.verb}: {rows or ', '.join(self.summary)}>"

    def _repr_html_(self) -> str:
        return html(self._tables())
