"""Tables as HTML, for notebooks."""

from __future__ import annotations

from collections.abc import Sequence

from scaloft_fi.views.tables.literal import xml
from scaloft_fi.views.tables.table import Table


def html(tables: Sequence[Table]) -> str:
    """The tables with their titles and notes; every text of a study is escaped."""
    return "\n".join(map(_one, tables))


def _one(table: Table) -> str:
    head = "".join(f"<th>{xml(name)}</th>" for name in table.headers)
    rows = "\n".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in table.rows)
    notes = "".join(f"<div>{xml(note)}</div>" for note in table.notes)
    caption = f'<caption style="text-align: left">{xml(table.title)}</caption>'
    return f"<table>{caption}\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody></table>\n{notes}"


def _cell(value: object) -> str:
    return f'<td style="text-align: left">{"" if value is None else xml(str(value))}</td>'
