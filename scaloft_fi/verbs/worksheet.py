"""`scaloft-fi worksheet`: the HAZOP worksheet filled back with what the flights say.

The columns are those of the classic sheet (`method.md`, section 1.3), the tool's findings, and columns that only people
can fill.  It never invents a risk matrix: severity is what the study says, and likelihood stays empty.

openpyxl writes it.  Every text is written as a text, with the mark that keeps it one when somebody edits the cell: a
study's `=1+1` is never a formula.  The same sheet gives the same bytes: the file carries no clock.
"""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any

import click

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.survivor import Disposition, Standing, judge
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.errors import InputError, needed
from scaloft_fi.hazop.matrix import Cell, CellStatus, Matrix, Parameter, SeverityClass, Team, worst_first
from scaloft_fi.hazop.render import ladder
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Status
from scaloft_fi.marks import About
from scaloft_fi.mutants.catalogue import default_of
from scaloft_fi.output import PIPED, printable, write_named
from scaloft_fi.study import NO_FINDS, KnownFinds, Study
from scaloft_fi.verbs import options
from scaloft_fi.verbs.export.dossier import unzipped, zipped
from scaloft_fi.verbs.margin import UNKNOWN, CellMargin, ToldCell, cell_margins
from scaloft_fi.verbs.options import Option, answer, check_writable, tell_warnings, verb
from scaloft_fi.verbs.snapshot import Stale, snapshot
from scaloft_fi.verbs.verdict import NO_POOL, acceptance, effect, flies, next_find, sentence, words, would_decide
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import FORMULA, Format, Table, csv_text, latex, long_table, longest_word, markdown, render

SheetValue = str | int | float | None


@dataclass(frozen=True)
class Column:
    """A column of the sheet.

    Attributes:
        key: as in JSON and CSV.
        title: as people read it.
        about: what stands in it.
        short: whether it is among those that fit a page.
        width: of a spreadsheet [characters].
    """

    key: str
    title: str
    about: str
    short: bool = False
    width: int = 14


STUDY = (
    Column("cell", "Deviation id", "guideword and parameter", short=True, width=20),
    Column("node", "Study node", "the stages between which the parameter flows", width=24),
    Column("parameter", "Parameter", "what the guideword is asked of", width=18),
    Column("design_intent", "Design intent", "what every deviation deviates from", width=36),
    Column("guideword", "Guideword", "of IEC 61882, or a declared extension", width=14),
    Column("deviation", "Deviation", "what differs from the design intent", short=True, width=36),
    Column("status", "Status", "credible, control, not meaningful, or to do", width=14),
    Column("rationale", "Rationale", "why it is not meaningful, or what the study predicts", width=36),
    Column("causes", "Possible causes", "what could bring it about", width=40),
    Column("effect", "Consequence", "what it does locally, then to the flight", width=40),
    Column("severity", "Severity", "class by the study's own list; else for the team", short=True, width=10),
    Column("requirements", "Requirements", "those at risk", short=True, width=14),
    Column("operators", "Faults", "how it is made, with the ladder of magnitudes", width=36),
    Column("mutant", "Default mutant", "the one that the findings speak of", width=24),
)
FINDINGS = (
    Column("situations_flown", "Situations flown", "with a flight that counts", width=11),
    Column("reached", "Reached", "situations where the fault's seam carried a sample", width=11),
    Column("infected", "Infected", "situations where it changed a sample", width=11),
    Column("verdict", "Verdict", "by safety requirements", short=True, width=14),
    Column("firm", "Firm", "whether it stays detected when any one seed is left out", short=True, width=14),
    Column("operability", "Operability", "verdict by operability requirements", short=True, width=14),
    Column("p", "p", "chance of as many violations if the mutant did nothing (Holm), per requirement", width=18),
    Column("needed", "Would decide", "what would decide an undecided mutant, if what was seen goes on", width=22),
    Column("kill_rate", "Kills", "situations with a kill, of those that test the mutant", short=True, width=10),
    Column("killed_by", "Killed by", "requirements, with situations killed in / tested in", width=18),
    Column("margin", "Margin", "smallest magnitude that is killed in any situation", short=True, width=14),
    Column(
        "where",
        "Where",
        "shortest condition for the situations with a kill; without one, for those where a violation was seen",
        short=True,
        width=30,
    ),
    Column("killing", "Situations with a kill", "their keys", width=30),
    Column("stopped_at", "Stopped at", "stage reached in situations without a kill, with situations", width=26),
    Column("disposition", "Disposition", "of a survivor that somebody accepted", short=True, width=30),
    Column("find", "Find", "a situation that a search found, which shows the survivor", short=True, width=30),
    Column("flies_find", "Flies it", "the command that flies the find", short=True, width=40),
)
FOUND = ("find", "flies_find")
"""The columns of a survivor's find."""
SPARE = ("severity", *FOUND)
"""The columns that a page leaves out where no row has a value."""
TEAM = (
    Column("safeguards", "Existing safeguards", "for the team", width=24),
    Column("likelihood", "Likelihood", "for the team, by its own matrix", width=10),
    Column("recommendation", "Recommendation", "for the team", short=True, width=30),
    Column("responsible", "Responsible", "for the team", short=True, width=16),
    Column("due", "Due date", "for the team", width=12),
    Column("action_status", "Action status", "for the team", width=14),
)
COLUMNS = (*STUDY, *FINDINGS, *TEAM)


@dataclass(frozen=True)
class Results:
    """What the flights of the default mutant say.

    Attributes:
        score: what they say together.
        where: shortest condition for the situations with a kill, else for those with a violation seen.
        decides: what would decide an undecided mutant, in words; empty for any other.
    """

    score: MutantScore
    where: str
    decides: str
    KEYS = (
        *("situations_flown", "reached", "infected", "where", "score.status", "score.verdict", "firm=score.firmness"),
        *("operability", "p", "score.safety.needed", "score.safety.anew", "score.kill_rate", "score.kill_rate_flown"),
        *("score.requirements", "score.killing", "stopped_at"),
    )

    @property
    def situations_flown(self) -> int:
        """Situations with a flight that counts."""
        return len(self.score.results)

    @property
    def reached(self) -> int:
        """Situations where the fault's seam carried a sample."""
        return sum(result.reached for result in self.score.results)

    @property
    def infected(self) -> int:
        """Situations where it changed a sample."""
        return sum(result.infected for result in self.score.results)

    @property
    def operability(self) -> Verdict:
        """By operability requirements."""
        return self.score.operability.verdict

    @property
    def p(self) -> Mapping[str, Annotated[float, About("p (0..1)")]]:
        """By requirement, the chance of as many violations if the fault did nothing; nothing of what was not tested."""
        return self.score.safety.p if self.score.tested else {}

    @property
    def stopped_at(self) -> Mapping[Status, Annotated[int, About("situations with {}")]]:
        """Situations without a kill, by the stage that flights reached."""
        stopped = Counter(result.status for result in self.score.results if not result.kills)
        return {status: stopped[status] for status in Status}

    @property
    def values(self) -> Mapping[str, SheetValue]:
        """In the columns of `FINDINGS`."""
        score, stages = self.score, sorted(Status, key=lambda status: status.stage, reverse=True)
        return {
            "situations_flown": self.situations_flown,
            "reached": self.reached,
            "infected": self.infected,
            "verdict": score.verdict.words,
            "firm": score.firmness.words if score.firmness else "",
            "operability": self.operability.words,
            "p": ", ".join(f"{name} {p:.2g}" for name, p in self.p.items()) or None,
            "needed": self.decides or None,
            "kill_rate": f"{score.kill_rate.part} of {score.kill_rate.whole}" if score.tested else None,
            "killed_by": ", ".join(f"{name} {ratio.short}" for name, ratio in score.requirements),
            "where": self.where,
            "killing": " ".join(score.killing),
            "stopped_at": ", ".join(f"{stage} {self.stopped_at[stage]}" for stage in stages if self.stopped_at[stage]),
        }


@dataclass(frozen=True)
class Accepted:
    """Of a survivor that somebody accepted.

    Attributes:
        of: the disposition.
        state: how it stands; null: it is not held against a campaign.
    """

    of: Disposition
    state: Standing | None = None
    KEYS = ("of.owner", "of.reason", "of.expires", "of.situations", "state")

    def __str__(self) -> str:
        """Who accepted it, until when and why; before that how it stands, where it does not stand as accepted."""
        held = self.state in (None, Standing.ACCEPTED)
        return acceptance(self.of) if held else f"{self.state}: {acceptance(self.of)}"


@dataclass(frozen=True)
class SheetRow:
    """A deviation: one cell of the matrix as the sheet has it.

    Attributes:
        cell: of the matrix.
        parameter: what the guideword is asked of.
        severity: class of the cell; None where it has none.
        mutant: id of the default mutant; None where it has none.
        margins: of its faults.
        results: what the flights of the default mutant say; null: not flown.
        disposition: of a survivor that somebody accepted; null: nobody has accepted it.
        find: a situation that a search found, which shows the survivor, in words; null: there is none.
        flies_find: the command that flies it; null: there is none.
    """

    cell: Cell
    parameter: Parameter
    severity: SeverityClass | None = None
    mutant: str | None = None
    margins: tuple[CellMargin, ...] = ()
    results: Results | None = None
    disposition: Accepted | None = None
    find: str | None = None
    flies_find: str | None = None
    KEYS = (
        *("told.*", "parameter.node", "design_intent=parameter.intent", "find", "flies_find", "margins", "results"),
        *("disposition", "team"),
    )

    @property
    def told(self) -> ToldCell:
        """The cell."""
        return ToldCell.of(self.cell, self.severity)

    @property
    def team(self) -> Team:
        """What only people can fill in."""
        return self.cell.team

    @property
    def survives(self) -> bool:
        """Whether the default mutant of a credible cell was flown and is not detected."""
        return self.cell.status is CellStatus.CREDIBLE and self.results is not None and not self.results.score.detected

    @cached_property
    def values(self) -> Mapping[str, SheetValue]:
        """By the column's key."""
        cell = self.cell
        faults = (f"{fault.operator} at {fault.seam} {ladder(fault)}".strip() for fault in cell.faults)
        return {
            **dict.fromkeys(column.key for column in COLUMNS),
            "cell": cell.name,
            "node": self.parameter.node,
            "parameter": self.parameter.title,
            "design_intent": self.parameter.intent,
            "guideword": cell.guideword,
            "deviation": cell.deviation,
            "status": cell.status.replace("_", " "),
            "rationale": cell.reason or cell.predicted,
            "causes": "; ".join(" ".join(cause.split()) for cause in cell.causes),
            "effect": cell.effect,
            "severity": self.severity.id if self.severity else cell.drafted or None,
            "requirements": ", ".join(cell.requirements),
            "operators": "; ".join(faults),
            "mutant": self.mutant,
            "margin": "; ".join(one.text for one in self.margins if one.text != UNKNOWN) or None,
            "disposition": str(self.disposition) if self.disposition else None,
            "find": self.find,
            "flies_find": self.flies_find,
            **vars(cell.team),
            **(self.results.values if self.results else {}),
        }


def bare_rows(matrix: Matrix, dispositions: Sequence[Disposition] = ()) -> tuple[SheetRow, ...]:
    """The sheet without findings: what the study says, in the order of the matrix."""
    accepted = {disposition.mutant: Accepted(disposition) for disposition in dispositions}
    parameters = {parameter.id: parameter for parameter in matrix.parameters}

    def of(cell: Cell) -> SheetRow:
        mutant = default_of(cell).id if cell.flown else None
        row = SheetRow(cell, parameters[cell.parameter], matrix.severities.get(cell.name), mutant)
        return replace(row, disposition=accepted.get(mutant)) if mutant else row

    return tuple(map(of, matrix))


def sheet_rows(
    matrix: Matrix,
    scored: Score,
    space: Space,
    dispositions: Sequence[Disposition] = (),
    finds: KnownFinds = NO_FINDS,
    campaign: str = CAMPAIGN,
    today: date | None = None,
) -> tuple[SheetRow, ...]:
    """The sheet, in the order of the matrix: credible cells, controls, and those that are not meaningful.

    Args:
        matrix: of the study.
        scored: score of a campaign.
        space: the grid.
        dispositions: of the study.
        finds: of the study.
        campaign: name of the campaign, for commands.
        today: the day by which dispositions expire; None = none does.
    """
    states = {one.mutant: one.state for one in judge(scored, Roster.of(matrix, ()), dispositions, today)}
    flown = {mutant.subject.id: mutant for mutant in (*scored.mutants, *scored.controls)}
    margins = cell_margins(scored, matrix)

    def found(row: SheetRow) -> SheetRow:
        accepted, mutant = row.disposition, row.mutant or ""
        accepted = replace(accepted, state=states[mutant]) if accepted else None
        row = replace(row, margins=margins[row.cell.name], disposition=accepted)
        if (score := flown.get(mutant)) is None:
            return row
        row = replace(row, results=Results(score, score.condition(space), would_decide(score, scored.lacking)))
        if (find := next_find(score, finds)) is None:
            return row
        said = f"{find.name}: {words(find)} ({effect(find.shows[mutant])})"
        return replace(row, find=said, flies_find=flies(find, mutant, finds, campaign, space.grid))

    return tuple(map(found, bare_rows(matrix, dispositions)))


def population(rows: Sequence[SheetRow], invalid: Sequence[str] = ()) -> str:
    """What the findings speak of, in a few sentences; first why no score is valid, where none is."""
    flown = [row.results.score for row in rows if row.results]
    most = max((len(score.results) for score in flown), default=0)
    meaningful = sum(row.cell.flown for row in rows)
    pooled = any(score.tested for score in flown) or not any(score.verdict is Verdict.UNDECIDED for score in flown)
    first = "".join(f"{sentence(reason)}  " for reason in invalid)
    return (
        f"{first}Findings speak of each cell's default mutant: {len(flown)} of the {meaningful} cells that can happen "
        f"were flown, in up to {most} situations.  A situation tests a mutant that changes a sample there, if the "
        "unmutated drone holds a safety requirement there steadily; it is a kill if most flights of a detected mutant "
        "violate that one."
    ) + ("" if pooled else f"  No verdict: {NO_POOL}.")


TITLE, LOG_TITLE = "HAZOP worksheet", "Deviations not credible"
LOG_KEYS = ("cell", "parameter", "rationale")
IN_TERMINAL = ("cell", "severity", "verdict", "operability", "kill_rate", "margin", "where", "disposition")
SURVIVORS_TITLE = "Survivors, worst class first"
SURVIVORS_KEYS = ("cell", "effect", "severity", "verdict", "disposition")
FINDS_TITLE, FINDS_KEYS = "Finds for survivors", ("cell", *FOUND)
LATEX_NOTE = (
    "% needs longtable, booktabs, array, pdflscape\n"
    "% letters that are not Latin need XeLaTeX or LuaLaTeX, with a font that has them"
)
LONG_WORD = 16
"""A column is made wide enough for words up to this length [characters]."""


def columns(keys: Sequence[str] = ()) -> list[Column]:
    """The columns with these keys, or those that fit a page."""
    return [column for column in COLUMNS if (column.key in keys if keys else column.short)]


def survivors(rows: Sequence[SheetRow]) -> list[SheetRow]:
    """The credible deviations flown and not detected, the worst class first; none where no cell has a class."""
    classed = any(row.severity for row in rows)
    return worst_first((row for row in rows if row.survives), lambda row: row.severity) if classed else []


Section = tuple[str, Sequence[Column], Sequence[SheetRow]]
"""A table of the sheet: its title, columns and rows."""


def sections(rows: Sequence[SheetRow], keys: Sequence[str] = (), *, finds: bool = False) -> list[Section]:
    """The findings of each deviation that can happen, survivors by class and finds where there are any, then the log.

    Args:
        rows: of the worksheet.
        keys: of the columns of the findings, which go where they may be spared and have no value; as of `columns`.
        finds: whether finds have a table of their own.
    """
    log = [row for row in rows if row.cell.status is CellStatus.NOT_MEANINGFUL]
    sheet = [row for row in rows if row.cell.status is not CellStatus.NOT_MEANINGFUL]
    shown = [one for one in columns(keys) if one.key not in SPARE or any(row.values[one.key] for row in sheet)]
    found = [row for row in sheet if row.values["find"] and finds]
    others = [(SURVIVORS_TITLE, columns(SURVIVORS_KEYS), survivors(rows)), (FINDS_TITLE, columns(FINDS_KEYS), found)]
    return [(TITLE, shown, sheet), *(one for one in others if one[2]), (LOG_TITLE, columns(LOG_KEYS), log)]


def texts(row: SheetRow, shown: Iterable[Column]) -> list[str]:
    """The values of a row in some columns; nothing where there is none."""
    return ["" if (value := row.values[column.key]) is None else str(value) for column in shown]


def sheet_tables(rows: Sequence[SheetRow], invalid: Sequence[str] = ()) -> tuple[Table, ...]:
    """The findings of each deviation, survivors by class and finds where there are any, then the log."""
    notes, tables = {TITLE: (population(rows, invalid), "Every column: --format csv or xlsx.")}, []
    for title, shown, listed in sections(rows, IN_TERMINAL, finds=True):
        headers = tuple(column.title for column in shown)
        cells = tuple(tuple(texts(row, shown)) for row in listed)
        tables.append(Table(title, headers, cells, notes.get(title, ())))
    return tuple(tables)


def to_markdown(rows: Sequence[SheetRow], invalid: Sequence[str] = ()) -> str:
    """Markdown tables; every character of the study's is taken literally."""
    blocks = []
    for title, shown, listed in sections(rows):
        lines = [list(map(markdown, texts(row, shown))) for row in listed]
        header = [[column.title for column in shown], ["---"] * len(shown)]
        blocks += [f"### {title}", "\n".join(f"| {' | '.join(cells)} |" for cells in (*header, *lines))]
    blocks.insert(2, markdown(population(rows, invalid)))
    return "\n\n".join(blocks) + "\n"


def to_latex(rows: Sequence[SheetRow], invalid: Sequence[str] = ()) -> str:
    """A fragment with long tables on landscape pages, header rows repeated."""
    first, *others = (_longtable(*section) for section in sections(rows))
    begin = r"\begin{landscape}\scriptsize\setlength{\tabcolsep}{2.5pt}\raggedright"
    return "\n".join([LATEX_NOTE, begin, first, latex(population(rows, invalid)), *others, r"\end{landscape}", ""])


def _longtable(title: str, shown: Sequence[Column], rows: Sequence[SheetRow]) -> str:
    headers, lines = [column.title for column in shown], [texts(row, shown) for row in rows]
    return long_table(headers, lines, [_width(column, rows) for column in shown], title)


def _width(column: Column, rows: Sequence[SheetRow]) -> float:
    """The share of a column: in a narrow one its longest word, capitals half as wide again, fills half of it."""
    longest = longest_word([column.title, *(text for row in rows for text in texts(row, [column]))])
    return max(column.width, 2 * min(LONG_WORD, longest))


def to_csv(rows: Sequence[SheetRow]) -> str:
    """Every column of every cell; a text that a spreadsheet would take for a formula begins with `'`."""
    lines = ([row.values[column.key] for column in COLUMNS] for row in rows)
    return csv_text([column.key for column in COLUMNS], lines)


LONGEST = 32_767
"""Characters of a cell: Excel's own limit, which openpyxl would cut at without a word."""
CUT, ABOUT = " [cut]", "About"
_ESCAPE = re.compile(r"_(?=x[0-9A-Fa-f]{4}_)")
"""What Excel would read as a character (ECMA-376, ST_Xstring: _x0041_ is an A)."""
CORE = "docProps/core.xml"
"""The file of the workbook that has the time at which it was made."""
FILLS = {"study": "D9E2F3", "findings": "E2EFDA", "team": "FFF2CC"}
"""Header colours of the three parts; the titles say the same in words."""
FRAME = ("Company", "Team", "Process", "Operation mode", "Date", "Page")
"""Header fields of the classic sheet, for the team to fill in."""


def to_xlsx(rows: Sequence[SheetRow], invalid: Sequence[str] = ()) -> bytes:
    """The workbook.

    Raises:
        InputError: openpyxl is not installed.
    """
    openpyxl = needed("openpyxl", "--format=xlsx needs openpyxl", "xlsx")
    book, styles = openpyxl.Workbook(), openpyxl.styles
    for number, (title, shown, listed) in enumerate(sections(rows)):
        _fill(book.create_sheet() if number else book.active, styles, title, shown if number else COLUMNS, listed)
    _about(book.create_sheet(), styles, population(rows, invalid))
    raw = io.BytesIO()
    book.save(raw)
    files = unzipped(raw.getvalue())
    clock = re.compile(rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")
    return zipped(files | {CORE: clock.sub(b"1980-01-01T00:00:00Z", files[CORE])})


def _fill(page: Any, styles: Any, title: str, shown: Sequence[Column], rows: Sequence[SheetRow]) -> None:
    page.title = title
    for at, column in enumerate(shown, 1):
        part = "team" if column in TEAM else "findings" if column in FINDINGS else "study"
        head = _put(page, styles, 1, at, column.title)
        head.font, head.fill = styles.Font(bold=True), styles.PatternFill("solid", fgColor=FILLS[part])
        page.column_dimensions[head.column_letter].width = column.width
    for number, row in enumerate(rows, 2):
        for at, column in enumerate(shown, 1):
            _put(page, styles, number, at, row.values[column.key])
    page.freeze_panes = "B2"
    page.auto_filter.ref = page.dimensions
    page.page_setup.orientation, page.page_setup.fitToWidth, page.page_setup.fitToHeight = "landscape", 1, 0
    page.sheet_properties.pageSetUpPr.fitToPage = True
    page.print_title_rows = "1:1"


def _put(page: Any, styles: Any, line: int, at: int, value: SheetValue) -> Any:
    cell = page.cell(line, at)
    cell.alignment = styles.Alignment(wrap_text=True, vertical="top")
    if isinstance(value, str):
        text = _ESCAPE.sub("_x005F_", printable(value))
        cell.value = text if len(text) <= LONGEST else text[: LONGEST - len(CUT)] + CUT
        cell.data_type = "s"
        cell.quotePrefix = text.startswith(FORMULA)
    else:
        cell.value = value
    return cell


def _about(page: Any, styles: Any, told: str) -> None:
    """What the columns say, and the fields at the head of the classic sheet."""
    page.title = ABOUT
    lines: list[tuple[str, str]] = [*((name, "") for name in FRAME), ("Population", told), ("", "")]
    lines += [(column.title, column.about) for column in COLUMNS]
    for number, pair in enumerate(lines, 1):
        for at, part in enumerate(pair, 1):
            _put(page, styles, number, at, part)
    page.column_dimensions["A"].width, page.column_dimensions["B"].width = 24, 100


@dataclass(frozen=True)
class FilledSheet:
    """The HAZOP worksheet with the findings.

    Attributes:
        rows: every deviation, in the order of the matrix.
        stale: the stored flights that no longer count and were not flown again.
    """

    rows: Sequence[SheetRow]
    stale: Stale


WORKSHEET = Output("worksheet", "2.1", FilledSheet, rows="rows")


XLSX = "xlsx"
_ENDS = {".xlsx": XLSX, ".csv": "csv", ".md": "markdown", ".tex": "latex", ".json": "json", ".txt": "table"}


class Worksheet(Answer):
    """The HAZOP worksheet with what the flights found.

    Args:
        rows: the rows of the sheet.
        stale: the flights that no longer count.
        warnings: as of `Answer`.
    """

    def __init__(self, rows: Sequence[SheetRow], stale: Stale, warnings: Sequence[str]) -> None:
        told = (*stale.sentences, *warnings)
        tables = partial(sheet_tables, rows, stale.invalid)
        super().__init__(WORKSHEET, lambda: FilledSheet(rows, stale), tables, warnings=told)
        self._sheet, self._invalid = rows, stale.invalid

    def text(self, style: str = "table") -> str:
        """What the verb prints; as `csv` the sheet for people.

        Raises:
            InputError: there is no such style.
        """
        made = {Format.MARKDOWN: to_markdown, Format.LATEX: to_latex}
        if style == Format.CSV:
            return to_csv(self._sheet)
        return made[Format(style)](self._sheet, self._invalid) if style in made else super().text(style)

    def content(self, style: str) -> bytes:
        """The bytes of a file in a style of `Format`, or as `XLSX`."""
        if style == XLSX:
            return to_xlsx(self._sheet, self._invalid)
        if style == Format.TABLE:
            return render(self._tables(), Format.TABLE, width=PIPED, marked=False).encode()
        return self.text(style).encode()

    def save(self, path: Path | str) -> Path:
        """Write the sheet; the end of the name decides the format.

        Args:
            path: a name that ends in `.xlsx`, `.csv`, `.md`, `.tex`, `.json` or `.txt`.

        Raises:
            InputError: the name ends otherwise, the file cannot be written, or openpyxl is missing for `.xlsx`.
        """
        file = Path(path)
        style = _ENDS.get(file.suffix.lower())
        if style is None:
            raise InputError(f"path={str(path)!r} must end in {', '.join(_ENDS)}")
        write_named(file, self.content(style), "path")
        return file


def worksheet(study: Study, campaign: options.Campaign, *, today: options.Today = None) -> Worksheet:
    """Every deviation of the matrix beside what its default mutant did in the campaign.

    Raises:
        InputError: there is no such campaign, or it holds no flight that counts.
    """
    with snapshot(study, campaign) as now:
        study, finds, stale, today = now.study, now.study.finds, now.stale, today or date.today()  # noqa: DTZ011
        rows = sheet_rows(study.matrix, now.score, study.space, study.dispositions, finds, now.name, today)
    return Worksheet(rows, stale, finds.warnings)


@verb("worksheet")
def worksheet_command(
    *,
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    style: Annotated[
        str,
        options.FormatOption(
            "How the sheet is written; csv, xlsx and json have every column.  A text that a spreadsheet would take for "
            "a formula begins with ' in csv, and is a plain text in xlsx.",
            type=click.Choice((*options.FORMATS, XLSX)),
        ),
    ],
    output: Annotated[Path | None, Option("Write the sheet to FILE.", metavar="FILE")],
    today: options.Today,
) -> None:
    """Print the HAZOP worksheet: every deviation beside what its default mutant did in the campaign.

    Deviations that are not credible stand in a log with their reason.  What only a team can judge (likelihood,
    recommendation, ...) is left empty; severity is the class that the study gives.

    Examples:
        Print the worksheet with what the flights found: `scaloft-fi worksheet`
        Bring it to the HAZOP meeting as a workbook: `scaloft-fi worksheet --format xlsx --output worksheet.xlsx`
        Put it into a paper: `scaloft-fi worksheet --format latex --output worksheet.tex`
    """
    if style == XLSX and output is None:
        raise click.UsageError("--format xlsx goes into a file: name it with --output")
    ends = [end for end, of in _ENDS.items() if of == style or (end == ".txt" and style != XLSX)]
    check_writable(output, *ends, what=f"--format {style}")

    sheet = worksheet(Study.open(study_folder), campaign, today=today)
    if output is None:
        answer(sheet, style)
    else:
        tell_warnings(sheet)
        write_named(output, sheet.content(style))
