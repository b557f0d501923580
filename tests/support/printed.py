"""What tables, screens, files of results or the report print: values of enumerations, headings."""

from __future__ import annotations

import importlib
import itertools
import pkgutil
import re
from collections.abc import Iterator
from enum import StrEnum

import scaloft_fi
from scaloft_fi.views.glossary import term

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
