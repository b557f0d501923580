"""The JSON of a verb as flat tables: each list of records is a table, and what stands in no list is one row.

A record in a record gives columns `outer_inner`, a list of plain values is one cell, a list of records in a record is a
table of its own, `table_key`, whose first column says whose a record is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import Shape, inner

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
        made[SUMMARY] = Flat(output.about, single, [[field.of(values) for field in single.values()]])
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
