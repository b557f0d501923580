"""How wide the columns of a text table are on a terminal, and which columns it has room for."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from functools import cache, lru_cache
from itertools import accumulate

from scaloft_fi.console import kept_together

GAP = 2
"""Between two columns [characters]."""


def limits(headers: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> list[int] | None:
    """The widths of the columns of a table that is at most `width` wide; None where a word would have to be broken.

    First to give way is the column that costs the fewest lines.  The first column names its row and keeps its width.
    """
    columns: list[tuple[str, ...]] = list(zip(*rows, strict=True)) if rows else [()] * len(headers)
    least = [max(map(_longest_word, (header, *column))) for header, column in zip(headers, columns, strict=True)]
    natural = [max(map(len, (header, *column))) for header, column in zip(headers, columns, strict=True)]
    least[0] = natural[0]
    if sum(least) + GAP * (len(least) - 1) > width:
        return None
    start = [max(low, min(wanted, width)) for low, wanted in zip(least, natural, strict=True)]
    return _narrowed(start, least, [(header, *column) for header, column in zip(headers, columns, strict=True)], width)


def height(rows: Sequence[Sequence[str]], widths: Sequence[int]) -> int:
    """Lines that rows take in columns of these widths."""
    return sum(max(map(_lines, row, widths), default=1) for row in rows)


def _longest_word(cell: str) -> int:
    return _words(cell)[1]


def _narrowed(widths: list[int], least: Sequence[int], columns: Sequence[Sequence[str]], width: int) -> list[int]:
    """`widths` taken in, a character at a time, until the table is `width` wide."""
    narrowed = list(widths)

    @cache
    def lines(column: int, width: int) -> list[int]:
        return [1 if len(cell) <= width else _lines(cell, width) for cell in columns[column]]

    def cost(column: int) -> int:
        """Lines that the table gains when this column is narrower by one."""
        narrower = lines(column, narrowed[column] - 1)
        return sum(now - height for now, height in zip(narrower, heights, strict=True) if now > height)

    while sum(narrowed) + GAP * (len(narrowed) - 1) > width:
        able = [column for column, now in enumerate(narrowed) if now > least[column]]
        heights = [max(row) for row in zip(*map(lines, range(len(narrowed)), narrowed), strict=True)]
        narrowed[min(able, key=lambda able: (cost(able), -narrowed[able], -able))] -= 1
    return narrowed


@lru_cache(maxsize=100_000)
def _lines(cell: str, width: int) -> int:
    """Lines that a cell takes, wrapped between its words."""
    ends, _ = _words(cell)
    lines = begin = 0
    while begin < len(ends):
        # a blank stands behind each word, but for the last one of a line; a word that is too long has its own line
        begin = max(bisect_right(ends, (ends[begin - 1] if begin else 0) + width + 1, begin), begin + 1)
        lines += 1
    return max(lines, 1)


@lru_cache(maxsize=100_000)
def _words(cell: str) -> tuple[tuple[int, ...], int]:
    """Where each word of a cell ends, with the blank behind it, and the length of the longest one."""
    lengths = list(map(len, kept_together(cell).split()))
    return tuple(accumulate(length + 1 for length in lengths)), max(lengths, default=0)
