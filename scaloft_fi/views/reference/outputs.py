"""The reference page of what verbs print for programs: every key of every JSON, the CSV tables, the exit codes."""

from __future__ import annotations

from collections.abc import Iterator

from scaloft_fi.errors import ExitCode
from scaloft_fi.views.outputs.csv_tables import table_names
from scaloft_fi.views.outputs.flat import SUMMARY
from scaloft_fi.views.outputs.listed import outputs
from scaloft_fi.views.outputs.output import Output, Rows
from scaloft_fi.views.outputs.shape import Shape, inner

RATIO = "ratio"
ONE_CSV = {"matrix", "mutants", "worksheet", "signals", "seams", "operators", "axes"}
"""Verbs whose CSV is a sheet for people, of one table."""
_RULES = f"""\
`--format json` prints one object.  Its `version` is that of the form, not of scaloft-fi: `MAJOR.MINOR`, where MAJOR
changes when a key goes or changes its meaning, and MINOR when one is added.  Numbers are numbers, in the unit that
stands in brackets; a ratio is `{{"part": 8, "whole": 15}}`; what is not known or does not apply is `null`; every key is
always there.  Behind `[]` stands a key of each entry of a list, behind `*` one of each name of the study.  A verb that
refuses its input prints nothing on standard output, one sentence on standard error, and ends with the exit code of the
table below; a gate that fails leaves standard output empty or whole.

`--format csv` prints one table, and `--tables DIR` writes every table of the JSON as a CSV file of its own.  A record
in a record gives columns `outer_inner`, a list of plain values one cell with `;` between, and a list of records in a
record a file of its own, whose first column `of_...` says whose it is.  What stands in no list is in `{SUMMARY}.csv`.
"""


def outputs_page() -> str:
    """The page, in Markdown."""
    return "\n".join(
        ["# Output for programs", "", _RULES, *_exit_codes(), *(line for one in outputs() for line in _form(one))]
    )


def _exit_codes() -> Iterator[str]:
    yield from ("## Exit codes", "", "| code | means |", "|---|---|")
    yield from (f"| {code.value} | {code.meaning} |" for code in ExitCode)
    yield ""


def _form(output: Output) -> Iterator[str]:
    yield from (f"## `{output.verb} --format json`", "")
    yield f"{output.about[:1].upper()}{output.about[1:]}.  Version {output.version}."
    if isinstance(output, Rows):
        yield "A bare list, without a version in it; `--format csv` has the same columns."
    elif output.verb not in ONE_CSV:
        tables = ", ".join(f"`{name}`" for name in table_names(output))
        yield f"`--format csv` prints `{output.rows}`; all tables: {tables}."
    yield from ("", "| key | type | says |", "|---|---|---|")
    yield from _rows("", output.schema)
    yield ""


def _rows(name: str, shape: Shape) -> Iterator[str]:
    """A row for each key below a value, `[]` for each entry of a list, `*` for each name of the study."""
    bare = inner(shape)
    for key, each in bare.get("properties", {}).items():
        yield from _row(f"{name}.{key}" if name else key, each)
    for beginning, each in bare.get("patternProperties", {}).items():
        yield from _row(f"{name}.{beginning.removeprefix('^')}*", each)
    if isinstance(named := bare.get("additionalProperties"), dict):
        yield from _row(f"{name}.*", named)
    if "items" in bare:
        yield from _rows(f"{name}[]", bare["items"])


def _row(name: str, shape: Shape) -> Iterator[str]:
    yield f"| `{name}` | {_type(shape)} | {_said(shape).replace('|', chr(92) + '|')} |"
    if _type(shape) != RATIO:
        yield from _rows(name, shape)


def _type(shape: Shape) -> str:
    bare = inner(shape)
    named = bare.get("type", "any")
    if bare.get("properties", {}).keys() == {"part", "whole"}:
        named = RATIO
    elif "items" in bare:
        named = f"list of {bare['items'].get('type', 'any')}s"
    return f"{named} or null" if bare is not shape else named


def _said(shape: Shape) -> str:
    bare = inner(shape)
    allowed = ", ".join(bare.get("enum", ()))
    return f"{bare.get('description', '')}{f': {allowed}' if allowed else ''}"
