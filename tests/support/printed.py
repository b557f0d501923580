"""What verbs print: how they end, the form of their answers, what a terminal obeys, words of tables."""

from __future__ import annotations

import csv
import importlib
import io
import itertools
import json
import pkgutil
import re
import unicodedata
from collections.abc import Callable, Iterator
from enum import StrEnum
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result
from jsonschema import Draft202012Validator

import scaloft_fi
from scaloft_fi.cli import main
from scaloft_fi.verbs.schema import answer_form
from scaloft_fi.views.table import term

STUDY = Path(__file__).parents[2]
"""The root of this checkout, which is the reference study."""
Call = Callable[..., Result]
"""Calls a verb: its words, then keywords for study and campaign."""


def sentence(result: Result) -> str:
    """The one sentence of a refusal: exit code 2, nothing else printed."""
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("error: ")
    assert "Traceback" not in line
    return line


def invoked(*words: str | Path) -> Result:
    """What comes of the command with these words, called in this process."""
    return CliRunner().invoke(main, [*map(str, words)], catch_exceptions=False)


def told_by(done: Result) -> str:
    """What a verb printed that has ended well."""
    assert done.exit_code == 0, done.output
    return done.stdout


def run(*words: str | Path) -> int:
    """The exit code of the command, called in this process, with the streams of the test."""
    with pytest.raises(SystemExit) as left:
        main([*map(str, words)])
    assert isinstance(left.value.code, int)
    return left.value.code


def commands(text: str) -> tuple[tuple[str, ...], ...]:
    """The words of each command of a text, in which a semicolon stands between two."""
    return tuple(tuple(one.split()) for one in text.split(";"))


READERS = commands(
    "matrix; matrix --grid; matrix --cell LATE-human; matrix --margins --parameter human; "
    "mutants --cell LATE-human; mutants --check; signals; signals speed_mps; seams; operators; axes; "
    "axes --grid search; status; score; kills; kills --show suite --situation T0O0W0D0H?; "
    "kills --show subsumption; coverage; dispositions; worksheet; compare CAMPAIGN CAMPAIGN; "
    "compare CAMPAIGN CAMPAIGN --flights; doctor --no-flight"
)
"""Verbs that print tables and fly nothing, on a campaign."""


def of_form(verb: str, text: str) -> dict[str, Any]:
    """The JSON that a verb printed, which has the verb's form."""
    told = json.loads(text)
    Draft202012Validator(answer_form(verb).schema, format_checker=Draft202012Validator.FORMAT_CHECKER).validate(told)
    assert isinstance(told, dict)
    return told


def one_table(text: str) -> list[dict[str, str]]:
    """The rows of a CSV text that is one table: every row as long as the line of names."""
    names, *rows = list(csv.reader(io.StringIO(text, newline="")))
    assert {len(row) for row in rows} <= {len(names)}
    assert len(set(names)) == len(names)
    return [dict(zip(names, row, strict=True)) for row in rows]


SEEN = frozenset("\u0600\u0601\u0602\u0603\u0604\u0605\u06dd\u070f\u0890\u0891\u08e2")
"""Signs of Arabic and Syriac that Unicode counts as formatting and every font draws."""


def obeyed(text: str) -> set[str]:
    """Control and format characters, line separators, lone surrogates, tags; but line breaks and tabs."""
    hidden = {letter for letter in text if unicodedata.category(letter) in {"Cc", "Cf", "Cs", "Zl", "Zp"}}
    return {c for c in hidden - SEEN - {"\n", "\t"} if ord(c) < 0x10000 or 0xE0000 <= ord(c) < 0xE0080}


FOLDERS = {"analysis", "campaign", "hazop", "judge", "sim", "verbs", "views"}
NOT_PRINTED = {
    "ColumnType": "types of columns for scripts",
    "Format": "a choice of an option",
    "Keep": "a key of YAML",
    "Likeness": "values of JSON, which the reference has",
    "Shape": "a key of YAML",
    "Side": "an order of signals",
    "Style": "codes of a terminal",
    "Worse": "an order of magnitudes",
    "scaloft_fi.stack.messages.Kind": "kinds of fields of messages",
}
"""The others, by name or by module and name, each with what it is."""


def printed_enumerations() -> list[type[StrEnum]]:
    """Every enumeration of texts in the package but those of `NOT_PRINTED`."""
    for module in pkgutil.walk_packages(scaloft_fi.__path__, "scaloft_fi."):
        if module.name.split(".")[1] in FOLDERS:
            importlib.import_module(module.name)
    ours = (one for one in StrEnum.__subclasses__() if one.__module__.startswith("scaloft_fi."))
    return [one for one in ours if not {one.__name__, f"{one.__module__}.{one.__name__}"} & set(NOT_PRINTED)]


def headings(markdown: str) -> Iterator[str]:
    """The headings of the tables of a page in Markdown."""
    lines = markdown.splitlines()
    for line, rule in itertools.pairwise(lines):
        if re.fullmatch(r"\|[-:| ]+\|", rule):
            yield from (re.sub(r"\\(.)", r"\1", cell.strip()) for cell in re.split(r"(?<!\\)\|", line)[1:-1])


def no_terms(markdown: str) -> list[str]:
    """The headings that no term of the glossary explains."""
    return [head for head in headings(markdown) if head and term(head) is None]
