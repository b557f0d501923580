"""The glossary: every term of the screens, tables, files and the report; `glossary.txt` says what each means."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Term:
    """A word of the output.

    Attributes:
        name: as it is printed.
        meaning: in one or a few sentences.
        also: other forms that are printed, such as the plural, the head of a column, or the value in a file.
    """

    name: str
    meaning: str
    also: tuple[str, ...] = ()


def _terms(text: str) -> tuple[Term, ...]:
    r"""The terms of a text: `name | other form: meaning` on a line, its further lines indented.

    >>> _terms("kill | kills: Most flights\n  violate.\n")
    (Term(name='kill', meaning='Most flights violate.', also=('kills',)),)
    """
    entries = text.replace("\n  ", " ").strip().splitlines()
    parts = (entry.partition(": ") for entry in entries)
    return tuple(
        Term(*(name, meaning), tuple(also)) for names, _, meaning in parts for name, *also in [names.split(" | ")]
    )


TERMS = _terms(Path(__file__).with_suffix(".txt").read_text(encoding="utf-8"))
"""Every term, in alphabetical order."""

_BY_FORM = {form.casefold(): term for term in TERMS for form in (*term.also, term.name)}


def term(text: str) -> Term | None:
    """The term that has this name or other form, whatever its capitals; None when the glossary has none.

    >>> term("Kills").name
    'kill'
    """
    return _BY_FORM.get(text.casefold())
