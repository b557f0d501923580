"""The pages of the reference, made from what the code declares: verbs, JSON and CSV that they print, YAML keys."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from importlib import import_module
from inspect import cleandoc
from typing import Any

import click

from scaloft_fi.cli import GROUPS, MODULES, VERBS, command_of
from scaloft_fi.errors import ExitCode
from scaloft_fi.model import Names, Schema
from scaloft_fi.verbs.options import Verb
from scaloft_fi.verbs.schema import DOCUMENTS, Document, declared_names
from scaloft_fi.views.output import SUMMARY, Output, Rows, flat_tables
from scaloft_fi.views.table import markdown

_ELSEWHERE = {**MODULES, "matrix": "margin", "run": "score", "export": "export.dossier"}
"""The module that has a verb's form, where it is not that of the verb."""
OUTPUTS = tuple(verb for verb in VERBS if verb not in ("schema", "completion"))
"""Verbs that print JSON of a declared form."""


def output_of(verb: str) -> Output:
    """The form of a verb's JSON.

    Raises:
        KeyError: the verb has none.
    """
    module = import_module(f"scaloft_fi.verbs.{_ELSEWHERE.get(verb, verb)}")
    return {one.verb: one for one in vars(module).values() if isinstance(one, Output)}[verb]


def schema_texts() -> dict[str, str]:
    """The published JSON Schemas: the text of each file by its name."""
    return {f"{one.verb}.json": json.dumps(one.schema, indent=2, ensure_ascii=False) + "\n" for one in outputs()}


def outputs() -> tuple[Output, ...]:
    """Every form."""
    return tuple(map(output_of, OUTPUTS))


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
    yield f"{output.says[:1].upper()}{output.says[1:]}.  Version {output.version}."
    if isinstance(output, Rows):
        yield "A bare list, without a version in it; `--format csv` has the same columns."
    elif output.verb not in ONE_CSV:
        tables = ", ".join(f"`{name}`" for name in flat_tables(output, dict.fromkeys(output.keys)))
        yield f"`--format csv` prints `{output.rows}`; all tables: {tables}."
    yield from ("", *_keys_table(output.schema))


_KEY_RULES = """\
A study is a folder of YAML documents.  `?` behind a key says that it may be left out.  `*` stands for a name that the
study chooses, `[]` for each entry of a list.  Where a mapping has one of several forms, a key with one fixed value
tells which; what only one form has stands under it.  Numbers are finite and within 1e9 of zero where nothing else is
said.

An editor with a language server for YAML, such as Visual Studio Code with the extension YAML of Red Hat, completes
these keys and shows their texts.  `scaloft-fi schema --write schemas` in the folder of the study writes the JSON
Schemas, those of installed plugins included, and the first line of a document names its own:

```yaml
# yaml-language-server: $schema=../schemas/world.json
```

Or the settings of the editor name them for all documents at once:

```json
"""


MOST_FORMS = 10
"""More names than these are counted, and listed elsewhere."""


def yaml_keys_page() -> str:
    """The page, in Markdown, made from the JSON Schemas of what the package itself declares."""
    declared = declared_names(own=True)
    settings = {"yaml.schemas": {f"./schemas/{one.name}.json": one.files for one in DOCUMENTS.values()}}
    parts = ["# YAML keys", "", f"{_KEY_RULES}{json.dumps(settings, indent=2)}\n```", ""]
    for one in DOCUMENTS.values():
        parts += _document(one, declared)
    return "\n".join(parts)


def _document(one: Document, declared: Names) -> Iterator[str]:
    schema = one.schema(declared)
    yield from (f"## `{one.files}`", "", _prose(schema["description"]), "")
    yield from _keys_table(schema)


def _keys_table(schema: Schema) -> Iterator[str]:
    yield from ("| key | value | meaning |", "|---|---|---|")
    yield from dict.fromkeys(_keys("", schema))  # forms share keys
    yield ""


def _keys(name: str, schema: Schema) -> Iterator[str]:
    """A row for each key below a value."""
    for key, each in schema.get("properties", {}).items():
        optional = "" if key in schema.get("required", ()) else "?"
        yield from _key_row(f"{name}.{key}{optional}" if name else f"{key}{optional}", each)
    for beginning, each in schema.get("patternProperties", {}).items():
        begins = beginning[1:] if re.fullmatch(r"\^\w+", beginning) else ""
        yield from _key_row(f"{name}.{begins}*" if name else f"{begins}*", each)
    if isinstance(each := schema.get("additionalProperties"), dict):
        yield from _key_row(f"{name}.*" if name else "*", each)
    if isinstance(schema.get("items"), dict):
        yield from _keys(f"{name}[]", schema["items"])
    for word in ("oneOf", "anyOf"):
        for each in schema.get(word, ()):
            yield from _keys(name, each)


def _key_row(name: str, schema: Schema) -> Iterator[str]:
    about = " ".join(schema.get("description", "").replace("\n- ", "; ").split())
    examples = ", ".join(f"`{_key_said(one)}`" for one in schema.get("examples", ()))
    meaning = _prose(about) + (f"  Such as {examples.replace('|', chr(92) + '|')}." if examples else "")
    yield f"| `{name}` | {markdown(_value(schema))} | {meaning} |"
    if not _kind(schema).startswith(RATIO):
        yield from _keys(name, schema)


def _literal(text: str) -> str:
    """The text with its marks escaped, and the blanks at its ends."""
    stripped = text.strip()
    return text.replace(stripped, markdown(stripped)) if stripped else text


def _prose(text: str) -> str:
    """The text as Markdown shows it in a table, with what stands between backticks as code."""
    pieces = text.split("`")
    if len(pieces) % 2 == 0:
        return markdown(text)
    return "`".join(piece.replace("|", "\\|") if place % 2 else _literal(piece) for place, piece in enumerate(pieces))


def _value(schema: Schema) -> str:
    """Type, range and default of a value in words."""
    words = _kind(schema)
    if "default" in schema:
        words += f"; left out: {_key_said(schema['default'])}"
    return words


def _kind(schema: Schema) -> str:
    if "const" in schema:
        return _key_said(schema["const"])
    if "enum" in schema:
        return "one of " + ", ".join(map(_key_said, schema["enum"]))
    if "oneOf" in schema or "anyOf" in schema:
        forms = tuple(dict.fromkeys(map(_kind, (*schema.get("oneOf", ()), *schema.get("anyOf", ())))))
        return " or ".join(forms) if len(forms) <= MOST_FORMS else f"one of {len(forms)} names"
    if schema.get("properties", {}).keys() == {"part", "whole"}:
        return RATIO
    kind = schema.get("type", "any value")
    if isinstance(kind, list):
        return " or ".join(map(_TYPES.__getitem__, kind))
    if kind == "array":
        return _list(schema)
    bounds = (("minimum", "from"), ("exclusiveMinimum", "above"), ("maximum", "to"))
    limits = " ".join(f"{word} {schema[key]:g}" for key, word in bounds if key in schema)
    return f"{_TYPES.get(kind, kind)} {limits}".rstrip()


_TYPES = {
    "string": "text",
    "number": "number",
    "integer": "whole number",
    "boolean": "true or false",
    "object": "mapping",
}


def _list(schema: Schema) -> str:
    least, most = schema.get("minItems"), schema.get("maxItems")
    size = f"{least} " if least == most and least else ""
    each = _kind(schema["items"]) if isinstance(schema.get("items"), dict) else "values"
    return f"list of {size}{each}" if size or least is None else f"list of {least} or more: {each}"


def _key_said(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | dict):
        return json.dumps(value)
    return f"{value:g}" if isinstance(value, float) else str(value)


_ACTIVE = re.compile(r"([\\*_\[\]<>|])")
PROGRAM = "scaloft-fi"


def command_reference() -> str:
    """A heading of level 2 for each group of verbs, and below it for each verb its usage, help, options and examples.

    Every verb's file is imported.
    """
    parts = []
    for heading, verbs in GROUPS.items():
        parts += [f"## {heading}", *(_page(verb) for verb in verbs)]
    return "\n\n".join(parts) + "\n"


def _page(name: str) -> str:
    command = command_of(name)
    assert isinstance(command, Verb)
    context = click.Context(command, info_name=f"{PROGRAM} {name}", help_option_names=["-h", "--help"])
    usage = " ".join([PROGRAM, name, *command.collect_usage_pieces(context)])
    parts = [f"### `{PROGRAM} {name}`", f"```\n{usage}\n```", *_paragraphs(command.help or "")]
    for heading, rows in command.sections(context):
        listed = "\n".join(f"- `{names}`: {_escaped(' '.join(meaning.split()))}" for names, meaning in rows)
        parts += [f"**{heading}**", listed]
    parts.append("**Examples**")
    parts += [f"{_escaped(example.does)}:\n\n```\n{example.command}\n```" for example in command.examples]
    return "\n\n".join(parts)


def _paragraphs(text: str) -> list[str]:
    return [_escaped(" ".join(paragraph.split())) for paragraph in cleandoc(text).split("\n\n")]


def _escaped(text: str) -> str:
    """The text outside of backticks as Markdown shows it unchanged."""
    pieces = text.split("`")
    return "`".join(_ACTIVE.sub(r"\\\1", piece) if at % 2 == 0 else piece for at, piece in enumerate(pieces))
