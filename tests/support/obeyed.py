"""The characters of a text that a terminal obeys or hides, by their Unicode categories: the oracle of `inert`."""

from __future__ import annotations

import unicodedata

SEEN = frozenset("\u0600\u0601\u0602\u0603\u0604\u0605\u06dd\u070f\u0890\u0891\u08e2")
"""Signs of Arabic and Syriac that Unicode counts as formatting and every font draws."""


def obeyed(text: str) -> set[str]:
    """Control and format characters, line separators, lone surrogates, tags; but line breaks and tabs."""
    hidden = {letter for letter in text if unicodedata.category(letter) in {"Cc", "Cf", "Cs", "Zl", "Zp"}}
    return {c for c in hidden - SEEN - {"\n", "\t"} if ord(c) < 0x10000 or 0xE0000 <= ord(c) < 0xE0080}
