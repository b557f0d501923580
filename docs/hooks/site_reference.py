"""The reference pages, made from the code that they describe."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import click

import scaloft_fi
import scaloft_fi.mutants.reference
from scaloft_fi import api
from scaloft_fi.cli import command_of
from scaloft_fi.errors import ExitCode
from scaloft_fi.mutants.operator import Need
from scaloft_fi.study import Study
from scaloft_fi.verbs import GROUPS
from scaloft_fi.verbs.export.dossier import EXPORT, FORMATS, HEAD
from scaloft_fi.verbs.listing import Listing, operator_list, seam_list, shown
from scaloft_fi.verbs.options import Verb
from scaloft_fi.verbs.schema import ANSWERS, DOCUMENTS, answer_form, declared_names
from scaloft_fi.verbs.signals import signal_list
from scaloft_fi.views.output import SUMMARY
from scaloft_fi.views.table import TERMS, Format, term

_ACTIVE = re.compile(r"([\\*_\[\]<>|])")
_MARKS = re.compile(r"\||\[(?!`)")
PYTHON = """\
`help(scaloft_fi.open)` tells in a session of Python what a name takes, what it gives and what it raises, with units.
What this page does not list may change.
"""
SCRIPTS = "For scripts and notebooks; [Scripts and notebooks](../api.md) shows how."
PLUGINS = "For plugins; the pages under [Your study](../operator.md) and [Your drone](../stack.md) show how."
HEADS = ("where", "what it is", "every key, in a terminal", "JSON Schema")
RULES = f"""\
`--format json` prints one object.  Its `version` is that of the form, not of scaloft-fi: `MAJOR.MINOR`, where MAJOR
changes when a key goes or changes its meaning, and MINOR when one is added.  Numbers are numbers, in the unit that
stands in brackets; a ratio is `{{"part": 8, "whole": 15}}`; what is not known or does not apply is `null`; every key
is always there.  A verb that refuses its input prints nothing on standard output, one sentence on standard error, and
ends with the exit code of the table below; a gate that fails leaves standard output empty or whole.

`--format csv` prints one table, and `--tables DIR` writes every table of the JSON as a CSV file of its own.  A record
in a record gives columns `outer_inner`, a list of plain values one cell with `;` between, and a list of records in a
record a file of its own, whose first column `of_...` says whose it is.  What stands in no list is in `{SUMMARY}.csv`.
"""
KEYS = """\
A study is a folder of YAML documents.  A terminal shows their keys, with range, unit, default and meaning, those of
installed plugins included.  Numbers are finite and within 1e9 of zero where nothing else is said.
"""
EDITOR = """\
An editor with a language server for YAML, such as Visual Studio Code with the extension YAML of Red Hat, completes
these keys and shows their texts.  `scaloft-fi schema --write schemas` in the folder of the study writes the JSON
Schemas, and the first line of a document names its own:

```yaml
# yaml-language-server: $schema=../schemas/world.json
```

Or the settings of the editor name them for all documents at once:

```json
"""
MADE = "*This page is made from the code.*\n"


def reference_pages() -> dict[str, str]:
    """The pages by their place in the site."""
    study = Study.open(None)
    pages = {
        "glossary.md": _glossary(),
        "reference/verbs.md": _verbs(),
        "reference/yaml_keys.md": _yaml_keys(),
        "reference/signals.md": _list("Signals", signal_list(study)),
        "reference/seams.md": _list("Seams", seam_list(study)),
        "reference/operators.md": _list("Operators", operator_list(study)),
        "reference/columns.md": _columns(),
        "reference/outputs.md": _outputs(),
        "reference/python.md": _python(),
    }
    return {path: f"{text}\n{MADE}" for path, text in pages.items()}


def _verbs() -> str:
    parts = ["# Verbs\n", "`scaloft-fi VERB --help` tells the same in a terminal, with examples.\n"]
    for heading, verbs in GROUPS.items():
        parts += [f"## {heading}\n", *map(_verb, verbs)]
    return "\n".join(parts)


def _verb(name: str) -> str:
    command = command_of(name)
    assert isinstance(command, Verb)
    context = click.Context(command, info_name=f"scaloft-fi {name}", help_option_names=["-h", "--help"])
    parts = [f"### `scaloft-fi {name}`\n", *(f"{_plain(text)}\n" for text in (command.help or "").split("\n\n"))]
    for _, rows in command.sections(context):
        parts += [f"- `{names}`: {_plain(meaning)}" for names, meaning in rows if "--help" not in names]
    return "\n".join(parts) + "\n"


def _plain(text: str) -> str:
    r"""A text on one line; outside of backticks Markdown shows it as it is.

    >>> print(_plain("NAME, or `a*`, or a*"))
    NAME, or `a*`, or a\*
    """
    pieces = " ".join(text.split()).split("`")
    return "`".join(_ACTIVE.sub(r"\\\1", piece) if at % 2 == 0 else piece for at, piece in enumerate(pieces))


def _yaml_keys() -> str:
    declared = declared_names(own=True)
    settings = {"yaml.schemas": {f"./schemas/{one.name}.json": one.files for one in DOCUMENTS.values()}}
    rows = (
        (
            f"`{one.files}`",
            one.schema(declared)["description"],
            f"`scaloft-fi schema {one.name}`",
            _schema("study", name),
        )
        for name, one in DOCUMENTS.items()
    )
    return f"# YAML keys\n\n{KEYS}\n{_table(HEADS, rows)}\n{EDITOR}{json.dumps(settings, indent=2)}\n```\n"


def _outputs() -> str:
    codes = _table(("code", "means"), ((code.value, code.meaning) for code in ExitCode))
    forms = map(answer_form, ANSWERS)
    rows = (
        (f"`{one.verb}`", one.says, f"`scaloft-fi schema {one.verb} --answer`", _schema("output", one.verb))
        for one in forms
    )
    return f"# Output for programs\n\n{RULES}\n{_table(HEADS, rows)}\n## Exit codes\n\n{codes}"


def _schema(folder: str, name: str) -> str:
    return f"[`{name}.json`](../schemas/{folder}/{name}.json)"


def _glossary() -> str:
    entries = [
        f'<span id="{_anchor(one.name)}"></span>\n**{one.name}**{_also(one.also)}\n:   {one.meaning}\n' for one in TERMS
    ]
    return "# Glossary\n\nEvery word of the screens, tables, files and the report.\n\n" + "\n".join(entries)


def _also(forms: Sequence[str]) -> str:
    return f" ({', '.join(f'`{form}`' for form in forms)})" if forms else ""


def _anchor(name: str) -> str:
    return re.sub(r"\W+", "-", name.casefold()).strip("-")


def _table(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "".join(f"| {' | '.join(_cell(cell) for cell in line)} |\n" for line in lines)


def _cell(value: Any) -> str:
    """A text on one line; what would end a cell or begin a link is escaped."""
    return _MARKS.sub(r"\\\g<0>", " ".join(str(value).split()))


def _list(title: str, listing: Listing[Any]) -> str:
    """An overview of what the reference study has."""
    verb = title.lower()
    overview = _code(shown(listing, Format.MARKDOWN, whole=False)).replace("### ", "## ", 1)
    return (
        f"# {title}\n\n`scaloft-fi {verb}` lists what your study has, `scaloft-fi {verb} NAME` one whole.\n\n{overview}"
    )


def _code(text: str) -> str:
    r"""The text of a table with code where it has escaped backticks.

    >>> _code(r"Let \`hold\_s\` pass a\_b.")
    'Let `hold_s` pass a\\_b.'
    """
    return re.sub(r"\\`.+?\\`", lambda code: code[0].replace("\\", ""), text)


def _columns() -> str:
    parts = [
        "# Exported columns\n",
        "`scaloft-fi export` writes a row for each flight: JSON a list of objects with these ",
    ]
    parts[1] += (
        "keys, CSV the same columns, with `;` between the members of a list and nothing where there is no value.\n"
    )
    rho = (
        "`rho_` and a requirement",
        "The robustness of the requirement in its unit; empty where the flight did not put it to the test.",
    )
    rows = [(f"`{name}`", _meaning(name)) for name in EXPORT.keys]
    rows.insert(len(HEAD), rho)
    parts.append(_table(("column", "meaning"), rows))
    parts += ["## Formats\n", "`scaloft-fi export --format NAME`:\n"]
    parts.append(_table(("format", "what it is"), ((f"`{name}`", FORMATS[name].summary) for name in FORMATS)))
    return "\n".join(parts)


def _meaning(name: str) -> str:
    known = term(name)
    if known is None:
        raise LookupError(f"the glossary has no {name!r}")
    return known.meaning


def _python() -> str:
    parts = ["# Python names\n", f"{PYTHON}\n"]
    for module, says in ((scaloft_fi, SCRIPTS), (api, PLUGINS)):
        rows = [row for name in sorted(module.__all__, key=str.casefold) for row in _names(name, getattr(module, name))]
        parts += [f"## `{module.__name__}`\n", f"{says}\n", _table(("name", "what it is"), rows)]
    return "\n".join(parts)


def _names(name: str, value: Any) -> Iterator[tuple[str, str]]:
    """A row for a name, and one for each method of a class that is no plain data."""
    if isinstance(value, Need):
        yield f"`{name}`", f"The need for {value.words}."
    elif not (inspect.isclass(value) or inspect.isroutine(value) or inspect.ismodule(value)):
        yield f"`{name}`", f"`{str(value).replace('typing.', '')}`"
    else:
        yield f"`{name}`", _first(value)
        for method, each in vars(value).items() if inspect.isclass(value) else ():
            if inspect.isroutine(each) and not method.startswith("_"):
                yield f"`{name}.{method}`", _first(each)


def _first(value: Any) -> str:
    """The first sentence of what a name says of itself."""
    return " ".join((inspect.getdoc(value) or "").partition("\n\n")[0].split()).partition(".  ")[0]
