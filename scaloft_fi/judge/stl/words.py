"""Names, numbers, marks and words of a formula's text."""

from __future__ import annotations

import re

PAST = frozenset({"historically", "once", "since"})
FUTURE = frozenset({"always", "eventually", "until"})
LOGIC = frozenset({"not", "and", "or", "implies", "iff"})
ARITHMETIC = frozenset({"abs", "sqrt"})
WORDS = PAST | FUTURE | LOGIC | ARITHMETIC
"""The words of a formula; every other name is a signal or a definition."""

LONGEST, DEEPEST = 2_000, 20
"""Most characters of a formula and deepest brackets."""

_TOKEN = re.compile(
    r"\s*(?:(?P<name>[A-Za-z_]\w*)|(?P<number>[0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]+)?|\.[0-9]+)|"
    r"(?P<mark>->|<=|>=|[-+*/()<>\[\]:]))"
)


class FormulaError(ValueError):
    """The text is not a formula of the language; the message continues `file:line: name ...`."""


def tokenize(text: str) -> list[str]:
    """Split `text` into names, numbers and marks.

    >>> tokenize("always(a/3<=1)")
    ['always', '(', 'a', '/', '3', '<=', '1', ')']

    Raises:
        FormulaError: a character belongs to no name, number or mark, or the text is too long or too deep.
    """
    tokens: list[str] = []
    at = depth = 0
    text = text.strip()
    if len(text) > LONGEST:
        raise FormulaError(f"must have at most {LONGEST:,} characters; name parts of it in definitions")
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            near = text[at : at + 12].strip()
            raise FormulaError(
                f"has {near!r}; allowed: names, numbers, {', '.join(sorted(WORDS))}, -> < <= > >= + - * /"
            )
        tokens.append(match.group().strip())
        at = match.end()
        depth += (tokens[-1] == "(") - (tokens[-1] == ")")
        if depth > DEEPEST:
            raise FormulaError(f"has brackets more than {DEEPEST} deep; name parts of it in definitions")
    return tokens


def inside_always(text: str) -> str | None:
    """The text in the brackets of `always( ... )`; None if the text has another form.

    >>> inside_always("always((a > 0) and (b > 0))")
    '( a > 0 ) and ( b > 0 )'
    >>> inside_always("always(a > 0) and (b > 0)")
    """
    tokens = tokenize(text)
    if tokens[:2] != ["always", "("] or tokens[-1] != ")":
        return None
    depth = 0
    for position, token in enumerate(tokens):
        depth += (token == "(") - (token == ")")
        if depth == 0 and position > 0 and position < len(tokens) - 1:
            return None
    return " ".join(tokens[2:-1])


def is_name(token: str) -> bool:
    """Whether a token is the name of a signal or a definition."""
    return (token[:1].isalpha() or token[:1] == "_") and token not in WORDS


def is_number(token: str) -> bool:
    """Whether a token is a number."""
    return bool(token) and token[0] in ".0123456789"
