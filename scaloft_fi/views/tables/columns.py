"""How wide the columns of a text table are, where it does not fit the terminal as it is."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from functools import cache, lru_cache
from itertools import accumulate
from textwrap import wrap


def limits(headers: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> list[int | None]:
    """What each column may take of a terminal `width` wide, None for all that it wants.

    First to give way is the column that costs the fewest lines.  The first column names its row and gives way last;
    words are broken only when nothing else helps.
    """
    columns = list(zip(*rows, strict=True))
    least = [len(header) for header in headers]
    words = [max(low, max(map(_longest_word, column))) for low, column in zip(least, columns, strict=True)]
    natural = [max(low, *map(len, column)) for low, column in zip(least, columns, strict=True)]
    words[0] = natural[0]
    widths = _narrowed(_narrowed(natural, words, rows, width), least, rows, width)
    return [limit if limit < wanted else None for limit, wanted in zip(widths, natural, strict=True)]


def _longest_word(cell: str) -> int:
    return _words(cell)[1]


def _narrowed(widths: Sequence[int], least: Sequence[int], rows: Sequence[Sequence[str]], width: int) -> list[int]:
    """`widths` taken in until the table is `width` wide or every column is at its `least`."""
    narrowed = list(widths)
    columns = list(zip(*rows, strict=True))

    @cache
    def lines(column: int, width: int) -> list[int]:
        return [1 if len(cell) <= width else _lines(cell, width) for cell in columns[column]]

    def cost(column: int) -> int:
        """Lines that the table gains when this column is narrower by one."""
        narrower = lines(column, narrowed[column] - 1)
        return sum(now - height for now, height in zip(narrower, heights, strict=True) if now > height)

    while sum(narrowed) + 2 * (len(narrowed) - 1) > width:
        able = [column for column, now in enumerate(narrowed) if now > least[column]]
        if not able:
            break
        heights = [max(row) for row in zip(*map(lines, range(len(narrowed)), narrowed), strict=True)]
        narrowed[min(able, key=lambda able: (cost(able), -narrowed[able], -able))] -= 1
    return narrowed


@lru_cache(maxsize=100_000)
def _lines(cell: str, width: int) -> int:
    """Lines that a cell takes, wrapped between its words, and within those that are longer."""
    ends, longest = _words(cell)
    if longest > width:
        return len(wrap(cell, width, break_on_hyphens=False))
    lines = begin = 0
    while begin < len(ends):
        # a blank stands behind each word, but for the last one of a line
        begin = bisect_right(ends, (ends[begin - 1] if begin else 0) + width + 1, begin)
        lines += 1
    return max(lines, 1)


@lru_cache(maxsize=100_000)
def _words(cell: str) -> tuple[tuple[int, ...], int]:
    """Where each word of a cell ends, with the blank behind it, and the length of the longest one."""
    lengths = list(map(len, cell.split()))
    return tuple(accumulate(length + 1 for length in lengths)), max(lengths, default=0)
