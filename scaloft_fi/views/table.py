"""A table as data, and how it is printed: text as wide as a terminal, Markdown, CSV, JSON, LaTeX, HTML.

First the columns are made narrower between words; then those are left out that the table can spare, which a note names;
at last each row becomes a record, a line for each of its values.  Ids, paths and commands are never broken.
"""

from __future__ import annotations

import csv
import io
import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache, lru_cache, partial
from html import escape
from itertools import accumulate, groupby, islice
from pathlib import Path

from scaloft_fi import output
from scaloft_fi.output import PROSE, Marked, Style, broken, coloured, json_text, line, printable, styled, wrapped

_MARKDOWN = re.compile(r"([\\`*_\[\]<>&|~$#])")
_LATEX = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"{\char34}",  # in every font encoding
    "-": "{-}",  # two of them would become a dash
    "`": "{`}",
    "'": "{'}",
    **{mark: f"\\{mark}" for mark in "{}$&%#_"},
}
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")  # noqa: RUF001 - those, too, begin a formula
"""What makes a spreadsheet take a text for a formula (OWASP, CSV injection)."""


def markdown(text: str) -> str:
    r"""The text as a cell of a Markdown table.

    >>> markdown("<b> a|b")
    '\\<b\\> a\\|b'
    """
    return _MARKDOWN.sub(r"\\\1", line(text))


def code(text: str) -> str:
    r"""The text as code in a line of Markdown, in a fence longer than any within it.

    >>> code("a `b`"), code("a")
    ('`` a `b` ``', '`a`')
    """
    shown = line(text)
    runs = [len(run) for run in re.findall("`+", shown)]
    fence = "`" * (max(runs, default=0) + 1)
    return f"{fence} {shown} {fence}" if runs else f"{fence}{shown}{fence}"


def latex(text: str) -> str:
    r"""The text in LaTeX; letters that are not Latin need a Unicode engine.

    >>> latex("5 % & x_y")
    '5 \\% \\& x\\_y'
    """
    return "".join(_LATEX.get(letter, letter) for letter in line(text))


def xml(text: str) -> str:
    r"""The text on one line as the content of an element or an attribute of XML.

    >>> xml("<a>\x1b & \n b")
    '&lt;a&gt;\\x1b &amp; b'
    """
    return escape(line(text))


def spreadsheet_text(text: str) -> str:
    r"""The text as a cell of a CSV that a spreadsheet opens: what would be a formula there gets OWASP's leading `'`.

    So does a text that would look like one with it: who reads the file back takes one `'` away from each cell that
    matches `'+[=+@-]` or the like (see `FORMULA`).

    >>> spreadsheet_text("=1+1"), spreadsheet_text("1+1"), spreadsheet_text("'=1")
    ("'=1+1", '1+1', "''=1")
    """
    shown = printable(text)
    return f"'{shown}" if shown.lstrip("'").startswith(FORMULA) else shown


_DOUBT = ("undecided", "not tested", "unsteady", "vacuous", "open", "stale", "untested")
_STYLES = {
    **dict.fromkeys(("detected", "held", "steady", "accepted"), Style.GOOD),
    **dict.fromkeys(("not detected", "violated", "red", "invalid", "expired", "uncovered"), Style.BAD),
    **dict.fromkeys(_DOUBT, Style.DOUBT),
}
_FIRST = re.compile(rf"({'|'.join(sorted(_STYLES, key=len, reverse=True))})(?=$|[,;:]| at | in )", re.IGNORECASE)


def style_of(text: str) -> Style | None:
    """The style of a text that is, or begins with, a word with a meaning; None for any other text.

    >>> style_of("Not detected"), style_of("violated at 8.10 s"), style_of("redrawn")
    (<Style.BAD: '31'>, <Style.BAD: '31'>, None)
    """
    found = _FIRST.match(text)
    return _STYLES[found[1].lower()] if found else None


def commands(text: str, *, marked: bool) -> str:
    """The text with its commands, which stand between backticks, marked if wanted."""
    return output.COMMAND.sub(lambda command: styled(command[0], Style.COMMAND), text) if marked else text


GAP = 2
"""Between two columns [characters]."""


def limits(headers: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> list[int] | None:
    """The widths of the columns of a table that is at most `width` wide; None where a word would have to be broken.

    First to give way is the column that costs the fewest lines.  The first column names its row and keeps its width.
    """
    columns: list[tuple[str, ...]] = list(zip(*rows, strict=True)) if rows else [()] * len(headers)
    whole = [(header, *column) for header, column in zip(headers, columns, strict=True)]
    least, natural = ([max(map(of, cells)) for cells in whole] for of in (lambda cell: _words(cell)[1], len))
    least[0] = natural[0]
    if sum(least) + GAP * (len(least) - 1) > width:
        return None
    start = [max(low, min(wanted, width)) for low, wanted in zip(least, natural, strict=True)]
    return _narrowed(start, least, whole, width)


def height(rows: Sequence[Sequence[str]], widths: Sequence[int]) -> int:
    """Lines that rows take in columns of these widths."""
    return sum(max(map(_lines, row, widths), default=1) for row in rows)


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
    lengths = list(map(len, output.kept_together(cell).split()))
    return tuple(accumulate(length + 1 for length in lengths)), max(lengths, default=0)


INDENT = "  "
Cells = Sequence[Sequence[str]]


def body_text(headers: Sequence[str], rows: Cells, width: int, spare: Sequence[str] = (), *, marked: bool) -> str:
    """Headers and rows as text without a line break at its end.

    Args:
        headers: of the columns, printable.
        rows: printable, a line each.
        width: of the terminal [characters].
        spare: headers of the columns that the table can spare, in the order in which they are left out.
        marked: whether words with a meaning get colours.
    """
    most = sum(1 + len(row) for row in rows)  # lines of the records
    gone: list[str] = []
    while True:
        kept = [at for at, header in enumerate(headers) if header not in gone]
        names, cells = [headers[at] for at in kept], [[row[at] for at in kept] for row in rows]
        widths = limits(names, cells, width)
        if widths is not None and height([names, *cells], widths) <= 1 + most:
            shown = [
                [_cell(cell, width, marked=marked and bool(at)) for cell, width in zip(row, widths, strict=True)]
                for at, row in enumerate([names, *cells])
            ]
            body = _tabulate(shown[1:], shown[0], "simple")
            text = f"Left out for want of room: {', '.join(gone)}; `--format csv` has every column."
            return f"{body}\n{note(text, width, marked=marked)}" if gone else body
        if len(gone) == len(spare):
            return "\n\n".join(_record(headers, row, width, marked=marked) for row in rows)
        gone.append(spare[len(gone)])


def heading(title: str, width: int, *, marked: bool) -> str:
    """The title of a table; a word with a meaning before a colon gives it its colour."""
    text = wrapped(title, width)
    if not marked:
        return text
    meaning = style_of(title.partition(":")[0])
    strong = "\n".join(styled(line, Style.STRONG) for line in text.split("\n"))
    return styled(strong, meaning) if meaning else strong


def note(text: str, width: int, *, marked: bool) -> str:
    """A sentence under a table."""
    return commands(wrapped(text, min(width, PROSE)), marked=marked)


def _tabulate(rows: Cells, headers: Sequence[str], style: str) -> str:
    import tabulate

    tabulate.MIN_PADDING = 0  # a header needs no more room than its letters
    return tabulate.tabulate(rows, headers, style, disable_numparse=True)


def _cell(cell: str, width: int, *, marked: bool) -> str:
    lines = [cell] if len(cell) <= width else broken(cell, width)
    meaning = style_of(cell) if marked else None
    return "\n".join(styled(line, meaning) if meaning else line for line in lines)


def _record(headers: Sequence[str], row: Sequence[str], width: int, *, marked: bool) -> str:
    """A row as lines: what names it, then below it each other value behind its header."""
    label = max(map(len, headers[1:]), default=0) + len(INDENT)
    name = wrapped(row[0], width)
    lines = ["\n".join(styled(each, Style.STRONG) for each in name.split("\n")) if marked else name]
    for header, value in zip(headers[1:], row[1:], strict=True):
        if value:
            meaning = style_of(value) if marked else None
            text = wrapped(value, width, f"{INDENT}{header.ljust(label)}", INDENT + " " * label)
            head = len(INDENT) + label
            lines.append(text[:head] + styled(text[head:], meaning) if meaning else text)
    return "\n".join(lines)


def html(tables: Sequence[Table]) -> str:
    """The tables with their titles and notes; every text of a study is escaped."""
    left, parts = 'style="text-align: left"', []
    for table in tables:
        head = "".join(f"<th>{xml(name)}</th>" for name in table.headers)
        rows = ("".join(f"<td {left}>{xml(cell)}</td>" for cell in row) for row in _cells(table.rows, str))
        body = "\n".join(f"<tr>{row}</tr>" for row in rows)
        notes = "".join(f"<div>{xml(note)}</div>" for note in table.notes)
        top = f"<table><caption {left}>{xml(table.title)}</caption>\n<thead><tr>{head}</tr></thead>"
        parts.append(f"{top}\n<tbody>\n{body}\n</tbody></table>\n{notes}")
    return "\n".join(parts)


def counted(count: int, noun: str) -> str:
    """A number of things.

    >>> counted(1, "seed"), counted(0, "seed")
    ('1 seed', '0 seeds')
    """
    return f"{count} {noun}{'s' * (count != 1)}"


def ranges(numbers: Iterable[int]) -> str:
    """Whole numbers in a sentence.

    >>> ranges([4, 0, 1, 2, 7])
    '0-2, 4, 7'
    """
    # within a run, number and place rise alike
    runs = (
        [number for _, number in run] for _, run in groupby(enumerate(sorted(numbers)), lambda one: one[1] - one[0])
    )
    return ", ".join(str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs)


TableCell = str | int | float | None


class Format(StrEnum):
    """How tables are printed."""

    TABLE = "table"
    MARKDOWN = "markdown"
    CSV = "csv"
    JSON = "json"
    LATEX = "latex"


_HARMLESS = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|-", re.ASCII)


@dataclass(frozen=True)
class Table:
    """A titled table.

    Attributes:
        title: of the table.
        headers: of the columns.
        rows: the values, those of a row in the order of the headers.
        notes: sentences under the table.
        spare: headers of the columns that a narrow terminal does without, in the order in which they are left out.
    """

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[TableCell, ...], ...]
    notes: tuple[str, ...] = ()
    spare: tuple[str, ...] = ()

    def records(self) -> list[dict[str, TableCell]]:
        """The rows as plain JSON values, by header."""
        return [dict(zip(self.headers, row, strict=True)) for row in self.rows]


def render(tables: Sequence[Table], how: Format, *, width: int | None = None, marked: bool | None = None) -> str:
    """The tables as one text, ending in a line break.

    Args:
        tables: to render.
        how: the format.
        width: of the terminal, for text [characters]; that of standard output when None.
        marked: whether text has colours; as standard output has them when None.
    """
    if how is Format.JSON:
        told = [{"title": table.title, "rows": table.records(), "notes": list(table.notes)} for table in tables]
        return json_text(told, indent=2) + "\n"
    if how is Format.TABLE:
        columns = output.width() if width is None else width
        colours = coloured() if marked is None else marked
        text = "\n".join(_text(table, columns, marked=colours) for table in tables)
        return Marked(text) if colours else text
    return "\n".join(_rendered(table, how) for table in tables)


def csv_text(headers: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A line of headers and a line for each row, without a formula; nothing stands where there is no value."""
    parts, listed = list[str](), iter(rows)
    lines: list[Iterable[object]] = [headers]
    while lines:  # one buffer for all would take four bytes a letter
        text = io.StringIO()
        shown = ([_in_csv(cell) if isinstance(cell, str) else cell for cell in row] for row in lines)
        csv.writer(text, lineterminator="\n").writerows(shown)
        parts.append(text.getvalue())
        lines = list(islice(listed, LINES))
    return "".join(parts)


LINES = 2000
"""Lines of CSV that are made at once."""


LATEX_NOTE = (
    r"% needs \usepackage{array,booktabs,longtable}; letters that are not Latin need XeLaTeX or LuaLaTeX with a font"
)
FITS = 65
"""A LaTeX table of at most so many characters has columns as wide as their texts, another the width of the page."""
LONG_CELL, BETWEEN = 30, 3
"""A longer text asks for no wider column; the room between two columns of LaTeX [characters]."""


def long_table(headers: Sequence[str], rows: Sequence[Sequence[str]], widths: Sequence[float], caption: str) -> str:
    """A `longtable` of LaTeX, whose header stands on every page.

    Args:
        headers: of the columns.
        rows: of texts.
        widths: the parts that the columns have of a line; without any each column is as wide as its texts.
        caption: above it; "" for none.
    """
    # without \\hspace TeX would not hyphenate a cell's first word
    spec = "".join(
        f">{{\\raggedright\\arraybackslash\\hspace{{0pt}}}}"
        f"p{{\\dimexpr {width / sum(widths):.5f}\\linewidth-2\\tabcolsep\\relax}}"
        for width in widths
    )
    begin = [f"\\begin{{longtable}}{{{spec or 'l' * len(headers)}}}"]
    begin += [f"\\caption{{{latex(caption)}}}\\\\"] if caption else []
    head = ["\\toprule", _latex_row(headers), "\\midrule", "\\endhead", "\\bottomrule", "\\endfoot"]
    lines = [_latex_row(row) + r"\addlinespace[2pt]" * bool(spec) for row in rows]
    return "\n".join([*begin, *head, *lines, "\\end{longtable}"])


def _latex_row(cells: Sequence[str]) -> str:
    # an empty group, so that a text that begins with [ or * is no option of the line before
    return "{}" + " & ".join(map(latex, cells)) + r" \\"


def longest_word(texts: Iterable[str]) -> float:
    """The length of the longest word, whose capitals are half as wide again; a line may end behind a hyphen."""
    words = " ".join(texts).replace("-", "- ").split()
    return max((len(word) + sum(letter.isupper() for letter in word) / 2 for word in words), default=1.0)


def _latex_table(headers: Sequence[str], rows: Sequence[Sequence[str]], caption: str) -> str:
    """A table that fits the width of a page, in small letters."""
    columns = [[header, *(row[place] for row in rows)] for place, header in enumerate(headers)]
    longest = [max(map(len, texts)) for texts in columns]
    parts = [
        BETWEEN + max(min(LONG_CELL, most), longest_word(texts)) for most, texts in zip(longest, columns, strict=True)
    ]
    body = long_table(headers, rows, parts if sum(longest) > FITS else (), caption)
    return f"{LATEX_NOTE}\n{{\\footnotesize\\setlength{{\\tabcolsep}}{{3pt}}\n{body}}}"


def tabulated(headers: Sequence[str], rows: Iterable[Sequence[TableCell]], how: Format, caption: str = "") -> str:
    """Headers and rows without a line break at the end, every cell a text of one line that the format takes literally.

    Args:
        headers: of the columns.
        rows: of the table; nothing stands where there is no value.
        how: CSV, Markdown or LaTeX.
        caption: of a LaTeX table.
    """
    if how is Format.CSV:
        return csv_text(headers, rows).rstrip("\n")
    if how is Format.LATEX:
        return _latex_table(headers, _cells(rows, str), caption)
    return _tabulate(_cells(rows, markdown), list(map(markdown, headers)), "github")


def _cells(rows: Iterable[Sequence[TableCell]], literal: Callable[[str], str]) -> list[list[str]]:
    return [["" if cell is None else literal(str(cell)) for cell in row] for row in rows]


def _text(table: Table, width: int, *, marked: bool) -> str:
    """The table for a terminal, with a blank line between its title and its body."""
    headers, rows = list(map(line, table.headers)), _cells(table.rows, line)
    body = body_text(headers, rows, width, table.spare, marked=marked) if rows else "none"
    notes = (note(line(each), width, marked=marked) for each in table.notes)
    return "\n".join([heading(line(table.title), width, marked=marked), "", body, *notes, ""])


def _rendered(table: Table, how: Format) -> str:
    title, notes = line(table.title), list(map(line, table.notes))
    if how is Format.CSV:
        return csv_text([f"# {title}"], ()) + csv_text(table.headers, table.rows)
    body = tabulated(table.headers, table.rows, how, title)
    if how is Format.LATEX:
        return f"{body}\n" + "".join(f"% {note}\n" for note in notes)
    return f"### {markdown(title)}\n\n{body}\n" + "".join(f"\n{note}\n" for note in notes)


def _in_csv(value: str) -> str:
    """A text that a spreadsheet takes for a number, and the sign `-` alone, are no formulas."""
    if value[:1].isalnum() and value.isprintable():
        return value  # nearly every cell, without a search
    return value if _HARMLESS.fullmatch(value) else spreadsheet_text(value)


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


TERMS = _terms(Path(__file__).with_name("glossary.txt").read_text(encoding="utf-8"))
"""Every term, in alphabetical order."""


@cache
def of_tests_words() -> dict[str, str]:
    """The words of a campaign of tests by those of a campaign of flights: `said of flights => said of tests` a line.

    A name, a path or a command has none of them.
    """
    lines = Path(__file__).with_name("tests.txt").read_text(encoding="utf-8").splitlines()
    pairs = [(own, other.strip()) for own, _, other in (line.partition(" => ") for line in lines)]
    return dict(pairs) | {own[:1].upper() + own[1:]: other[:1].upper() + other[1:] for own, other in pairs}


@cache
def _flights_said() -> re.Pattern[str]:
    """What is said otherwise of tests, the longest first, and commands, which stay."""
    words = "|".join(map(re.escape, sorted(of_tests_words(), key=len, reverse=True)))
    return re.compile(rf"`[^`]*`|(?<![\w:./@-])(?:{words})(?![\w/@-]|[:.]\S)")


def said(table: Table, *, of_tests: bool) -> Table:
    """The table in the words of a campaign of tests, if it is one.

    >>> said(Table("Situations", ("seed",), ((3, "flight.py::test"),), ("No flight.",)), of_tests=True).notes
    ('No run.',)
    """
    if not of_tests:
        return table
    own = partial(said_text, of_tests=True)
    rows = tuple(tuple(own(one) if isinstance(one, str) else one for one in row) for row in table.rows)
    title, headers, notes = own(table.title), tuple(map(own, table.headers)), tuple(map(own, table.notes))
    return replace(table, title=title, headers=headers, rows=rows, notes=notes)


def said_text(text: str, *, of_tests: bool) -> str:
    """The text in the words of a campaign of tests, if it is one; commands stay as they are."""
    return _flights_said().sub(lambda found: of_tests_words().get(found[0], found[0]), text) if of_tests else text


_BY_FORM = {form.casefold(): term for term in TERMS for form in (*term.also, term.name)}


def term(text: str) -> Term | None:
    """The term that has this name or other form, whatever its capitals; None when the glossary has none.

    >>> term("Kills").name
    'kill'
    """
    return _BY_FORM.get(text.casefold())
