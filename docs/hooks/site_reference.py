"""The reference pages, made from the code that they describe."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterable, Sequence
from enum import StrEnum
from types import ModuleType
from typing import Any

import scaloft_fi
import scaloft_fi.mutants.reference
from scaloft_fi import api
from scaloft_fi.analysis.comparison import Change
from scaloft_fi.analysis.detection import Firmness, Verdict
from scaloft_fi.analysis.pool import State
from scaloft_fi.analysis.score import By
from scaloft_fi.analysis.survivor import Reaction, Standing
from scaloft_fi.checks.finding import Severity
from scaloft_fi.errors import ExitCode
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.judge.requirement import Compliance, Kind
from scaloft_fi.judge.status import Status
from scaloft_fi.mutants.operator import Need
from scaloft_fi.outside.records import Lost
from scaloft_fi.outside.suite import Colour
from scaloft_fi.scripting.study import OpenCampaign
from scaloft_fi.sim.log import Ending
from scaloft_fi.study import Study
from scaloft_fi.verbs import GROUPS
from scaloft_fi.verbs.export.dossier import EXPORT, FORMATS, HEAD
from scaloft_fi.verbs.hazop import RowState
from scaloft_fi.verbs.judge import RecordVerdict
from scaloft_fi.verbs.listing import Listing, operator_list, seam_list, shown
from scaloft_fi.verbs.report.analyses import Sign
from scaloft_fi.verbs.schema import ANSWERS, DOCUMENTS, answer_form, declared_names
from scaloft_fi.verbs.signals import signal_list
from scaloft_fi.verbs.verdict import Next, Stage
from scaloft_fi.views.output import SUMMARY
from scaloft_fi.views.table import TERMS, Format, term

_MARKS = re.compile(r"\||\[(?!`)")
SCRIPTS = "What `import scaloft_fi` offers to scripts and notebooks; [Scripts and notebooks](../api.md) shows how."
PLUGINS = "What `scaloft_fi.api` offers to plugins.  What neither page lists may change."
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
VALUES: tuple[tuple[str, str, type[StrEnum]], ...] = (
    (
        "Status of a flight",
        "One flight of a mutant beside the baseline of its situation and seed: how far the fault got.",
        Status,
    ),
    ("Verdict on a mutant", "All flights of a mutant together, beside the baseline pools.", Verdict),
    ("Two campaigns", "What they say of a mutant, held against each other: `compare`.", Change),
    ("Firmness of a detected mutant", "What remains of the verdict when any one seed is left out.", Firmness),
    ("Where a survivor stopped", "The stage that its fault did not pass.", Stage),
    ("What to do next about a survivor", "The change that could show it.", Next),
    (
        "State of a pair",
        "A situation with a requirement, by the flights of the unmutated drone there; the first that fits.",
        State,
    ),
    ("What a flight says of a requirement", "One reading.", Compliance),
    ("Kind of a requirement", "What a violation counts for.", Kind),
    ("Ending of a flight", "It is no verdict.", Ending),
    ("Status of a cell", "In the deviation matrix.", CellStatus),
    ("A magnitude in a situation", "In the search for a margin.", Reaction),
    ("A cell of the kill matrix", "In the report: a mutant in a situation.", Sign),
    ("Parts of a score", "What `score --by` divides it by.", By),
    ("A finding of check", "Only an error fails.", Severity),
    ("Standing of a survivor", "Beside the dispositions of the study.", Standing),
    ("What a record says", "Of a requirement: `judge`.", RecordVerdict),
    ("What a record lost", "Told beside the readings of `judge`.", Lost),
    ("A row of a sheet", "What `hazop import` did with it.", RowState),
    ("Runs of tests", "What a run of one of your own tests says (`suite`).", Colour),
)
"""The enumerations whose values are printed: title, what they tell."""


def reference_pages() -> dict[str, str]:
    """The pages by their place in the site."""
    study = Study.open(None)
    pages = {
        "glossary.md": _glossary(),
        "reference/verbs.md": _verbs(),
        "reference/yaml_keys.md": _yaml_keys(),
        "reference/signals.md": _list("Signals", signal_list(study), whole=False),
        "reference/seams.md": _list("Seams", seam_list(study), whole=True),
        "reference/operators.md": _list("Operators", operator_list(study), whole=True),
        "reference/columns.md": _columns(),
        "reference/statuses.md": _statuses(),
        "reference/outputs.md": _outputs(),
        "reference/scripts.md": _python("Python names for scripts", SCRIPTS, scaloft_fi),
        "reference/plugins.md": _python("Python names for plugins", PLUGINS, api),
    }
    return {path: f"{text}\n{MADE}" for path, text in pages.items()}


def _verbs() -> str:
    parts = ["# Verbs\n", "`scaloft-fi VERB --help` has every option, with its default and three or more examples.\n"]
    for heading, verbs in GROUPS.items():
        parts += [f"## {heading}\n", _table(("verb", "what it does"), ((f"`{verb}`", verbs[verb]) for verb in verbs))]
    return "\n".join(parts)


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
    return f"[schema](../schemas/{folder}/{name}.json)"


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


def _list(title: str, listing: Listing[Any], *, whole: bool) -> str:
    """An overview of what the reference study has, and where asked for each entry whole."""
    every = _code(shown(listing, Format.MARKDOWN, whole=True)) if whole else ""
    overview = _code(shown(listing, Format.MARKDOWN, whole=False)).replace("### ", "## ", 1)
    return f"# {title}\n\n`scaloft-fi {title.lower()}` lists what your study has.\n\n{overview}\n{every}"


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


def _statuses() -> str:
    parts = ["# Statuses and verdicts\n", "Every value that a table or a file can show.\n"]
    for title, says, values in VALUES:
        parts += [f"## {title}\n", f"{says}\n"]
        parts.append(_table(("value", "meaning"), ((f"`{value}`", _meaning(value)) for value in values)))
    return "\n".join(parts)


def _python(title: str, says: str, module: ModuleType) -> str:
    """Every public name of a module; mkdocstrings writes what it finds at the place of its definition."""
    parts = [f"# {title}\n", f"{says}\n"]
    for name in sorted(module.__all__, key=str.casefold):
        value = getattr(module, name)
        if inspect.isclass(value) or inspect.isfunction(value):
            seen = "    options: {force_inspection: true}\n" if value is OpenCampaign else ""  # methods that code makes
            parts.append(f"::: {value.__module__}.{value.__qualname__}\n{seen}")
        else:
            parts.append(f"## `{name}`\n\n{_says(name, value)}\n")
    return "\n".join(parts)


def _says(name: str, value: Any) -> str:
    """What is no class and no function: a module, a need, a constant, a type."""
    if isinstance(value, Need):
        return f"The need for {value.words}."
    if inspect.ismodule(value):
        return f"The module `{value.__name__}`: {inspect.cleandoc(value.__doc__ or '')}"
    return f"`{name} = {str(value).replace('typing.', '')}`"
