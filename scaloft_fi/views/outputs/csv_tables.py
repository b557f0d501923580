"""The JSON of a verb as CSV: each list of records is a table; what stands in no list is one of names and values.

A record in a record gives columns `outer_inner`, a list of plain values one cell with `;` between, a list of records in
a record a table of its own, `table_key`, whose first column says whose it is.  Nothing stands where JSON has null.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import Shape, inner
from scaloft_fi.views.tables.table import csv_text

SUMMARY = "summary"
"""The table of what stands in no list."""


class _Field(NamedTuple):
    """A column, or a table of its own: its name, the keys that lead to it, and the shape of the records in a table."""

    name: str
    path: tuple[str, ...]
    items: Shape | None

    def of(self, value: Any) -> Any:
        """What stands there; None where the way ends before."""
        for key in self.path:
            value = value.get(key) if value is not None else None
        return value


def csv_tables(output: Output, values: Mapping[str, Any]) -> dict[str, str]:
    """The CSV text of each table by its name."""
    made: dict[str, str] = {}
    single = []
    for field in _fields({"properties": output.keys}, [values]):
        if field.items is None:
            single.append((field.name, _cell(field.of(values))))
        else:
            made |= _tables(field.name, field.items, "", [("", one) for one in field.of(values) or ()])
    if single:
        made[SUMMARY] = csv_text(("what", "value"), single)
    return made


def table_names(output: Output) -> list[str]:
    """The names of its tables."""
    return list(csv_tables(output, dict.fromkeys(output.keys)))


def _tables(name: str, shape: Shape, owner: str, owned: Sequence[tuple[str, Mapping[str, Any]]]) -> dict[str, str]:
    """The table of records of one shape, and those of the records in them.

    Args:
        name: of the table.
        shape: of its records.
        owner: name of the column that says whose a record is; empty where it is nobody's.
        owned: whose each record is, and the record.
    """
    fields = list(_fields(shape, [one for _, one in owned]))
    columns = [field for field in fields if field.items is None]
    headers = [*([owner] if owner else []), *(field.name for field in columns)]
    rows = ([*([whose] if owner else []), *(_cell(field.of(one)) for field in columns)] for whose, one in owned)
    made = {name: csv_text(headers, rows)}
    label = next(iter(shape["properties"]))
    for field in fields:
        if field.items is not None:
            below = [(one[label], each) for _, one in owned for each in field.of(one) or ()]
            made |= _tables(f"{name}_{field.name}", field.items, f"of_{label}", below)
    return made


def _fields(shape: Shape, values: Sequence[Any], name: str = "", path: tuple[str, ...] = ()) -> Iterator[_Field]:
    """The fields of values of one shape; names of the study come in the order of their first appearance."""
    shape, known = inner(shape), [value for value in values if value is not None]
    named = shape.get("additionalProperties")
    if "properties" in shape:
        keys = dict(shape["properties"])
    elif isinstance(named, Mapping):
        keys = {key: named for value in known for key in value}
    else:
        items = inner(shape.get("items", {}))
        yield _Field(name, path, items if "properties" in items else None)
        return
    for key, each in keys.items():
        below = [value[key] for value in known if key in value]
        yield from _fields(each, below, f"{name}_{key}" if name else key, (*path, key))


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ";".join(str(_cell(entry)) for entry in value)
    return value
