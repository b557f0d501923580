"""The worksheet filled back: what its columns say, and that every format says it literally."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
import subprocess
import zipfile
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest
from builders import GRID, campaigns, outcome, pool, seeded
from finding import flies, found, known
from fuzzing import HOSTILE
from hypothesis import given, settings
from hypothesis import strategies as st
from openpyxl import load_workbook
from options import as_recorded, usually
from printed import Call

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import CellStatus, Matrix
from scaloft_fi.hazop.sheet import Line
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import derive
from scaloft_fi.output import line, printable
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.verbs import worksheet
from scaloft_fi.verbs.hazop import edits_of
from scaloft_fi.verbs.snapshot import Stale
from scaloft_fi.views.output import plain
from scaloft_fi.views.table import FORMULA, Format, Table, latex, markdown, render

WHOLE = load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name)
MATRIX = WHOLE.only(["LATE", "NO", "EARLY", "REVERSE"], ["human", "collision"])
ROSTER = Roster.of(MATRIX, [mutant.id for mutant in derive(MATRIX)])
HUMAN, DARK, NOBODY = "T0O0W0D0H1", "T0O0W0D1H1", "T0O0W0D0H0"
SEEDS = range(3)
FLOWN = [
    *pool(HUMAN, DARK, NOBODY),
    *(outcome("LATE-human@3s", HUMAN, seed, violated={"SR2": 8.0}) for seed in SEEDS),
    *(outcome("LATE-human@3s", DARK, seed, digest="clean") for seed in SEEDS),
    *(outcome("LATE-human@3s", NOBODY, seed, altered=0, carried=0) for seed in SEEDS),
    *(outcome("LATE-human@1s", HUMAN, seed) for seed in SEEDS),
]
hostile = st.text(min_size=1, max_size=30) | st.sampled_from(HOSTILE)


def rows(
    outcomes: list[Outcome], matrix: Matrix = MATRIX, dispositions: tuple[Disposition, ...] = ()
) -> tuple[worksheet.SheetRow, ...]:
    return worksheet.sheet_rows(matrix, score(outcomes, ROSTER, GRID), GRID, dispositions)


def named(found: tuple[worksheet.SheetRow, ...], cell: str) -> worksheet.SheetRow:
    return next(row for row in found if row.cell.name == cell)


def with_text(text: str) -> Matrix:
    """The matrix with a text of the study in every field that takes one."""
    cells = {
        key: replace(cell, reason=text)
        if cell.status is CellStatus.NOT_MEANINGFUL
        else replace(cell, deviation=text, causes=(text, "b"), effect=text, predicted=text)
        for key, cell in MATRIX.cells.items()
    }
    parameters = tuple(replace(p, title=text, intent=text, node=text) for p in MATRIX.parameters)
    return Matrix(MATRIX.guidewords, parameters, cells)


SILENT = [outcome("NO-human@100%", HUMAN, seed) for seed in SEEDS]
SHOWN = known(found("NO-human@100%", struck="person"), found("LATE-human@3s"))
RED = pool(DARK, red=10, violated={"SR1": 20.0, "SR2": 20.0})
ONCE = outcome("LATE-human@3s", HUMAN, violated={"SR2": 8.0})
ACCEPTED = Disposition("NO-human@100%", "A. Engineer", "cannot happen", date(2027, 1, 31))
CASES = {
    "killed in the light, masked in the dark, not reached elsewhere": ("LATE-human", rows(FLOWN)),
    "seen once": ("LATE-human", rows([*pool(HUMAN, DARK), ONCE, outcome("LATE-human@3s", DARK)])),
    "put to no test": (
        "LATE-human",
        rows([*RED, *(outcome("LATE-human@3s", DARK, seed, violated={"SR2": 8.0}) for seed in SEEDS)]),
    ),
    "without a pool": ("LATE-human", rows([outcome(situation=HUMAN), ONCE])),
    "not flown, and accepted": ("NO-human", rows(FLOWN, dispositions=(ACCEPTED,))),
    "not credible": ("EARLY-collision", rows(FLOWN)),
    "a survivor with a find": (
        "NO-human",
        worksheet.sheet_rows(MATRIX, score([*FLOWN, *SILENT], ROSTER, GRID), GRID, (), SHOWN, "mine"),
    ),
}


def test_what_the_columns_say_is_as_recorded_and_the_teams_are_empty():
    told = {}
    for name, (cell, found_) in CASES.items():
        values = named(found_, cell).values
        told[name] = "\n".join(f"{key}: {value}" for key, value in values.items() if value not in (None, ""))
        assert all(row.values[column.key] is None for row in found_ for column in worksheet.TEAM)
    as_recorded(__file__, told)


def test_without_a_pool_the_sheet_says_so():
    alone = worksheet.population(CASES["without a pool"][1])
    assert "No verdict: no situation in which a mutant changes a sample has 10 baseline flights" in alone
    assert "No verdict" not in worksheet.population(rows(FLOWN))


@pytest.mark.parametrize(
    ("accepted", "state"),
    [
        (ACCEPTED, ""),
        (replace(ACCEPTED, expires=date(2026, 10, 1)), "expired: "),
        (replace(ACCEPTED, situations=(DARK,)), "uncovered: "),
    ],
)
def test_an_acceptance_stands_with_its_state_and_is_no_edit(accepted: Disposition, state: str):
    scored = score([*FLOWN, *SILENT], ROSTER, GRID)
    told = worksheet.sheet_rows(MATRIX, scored, GRID, (accepted,), today=date(2026, 11, 30))
    said = named(told, "NO-human").values["disposition"]
    assert str(said).startswith(f"{state}accepted ")
    assert plain(told)[[row.cell.name for row in told].index("NO-human")]["disposition"]["state"] == (
        state.removesuffix(": ") or "accepted"
    )
    texts = {"cell": "NO-human", "disposition": str(said)}
    bare = worksheet.bare_rows(MATRIX, (accepted,))
    assert list(edits_of(bare, Path(), [Line("sheet:2", texts, frozenset(texts))])) == []


def test_the_sheet_says_in_every_form_with_room_why_no_score_is_valid():
    stale = Stale(invalid=("no score is valid: gate failed: no pair is steady",))
    sheet, said = worksheet.Worksheet(rows(FLOWN), stale, ()), "No score is valid: gate failed: no pair is steady."
    for style in ("table", "markdown", "latex"):
        assert said in " ".join(sheet.content(style).decode().split())
    about = load_workbook(io.BytesIO(sheet.content("xlsx")))["About"]
    assert any(said in str(cell.value) for cell in about["B"])
    assert json.loads(sheet.content("json"))["stale"]["invalid"] == list(stale.invalid)
    assert said not in worksheet.Worksheet(rows(FLOWN), Stale(), ()).content("markdown").decode()


def test_a_find_and_the_command_that_flies_it_stand_in_every_format():
    survivor, told = "NO-human@100%", CASES["a survivor with a find"][1]
    said = str(named(told, "NO-human").values["find"])
    assert named(told, "LATE-human").values["find"] is None, "it is detected"
    line_, *_ = [line for line in worksheet.to_markdown(told).splitlines() if line.startswith("| NO-human ")]
    assert markdown(said) in line_
    assert markdown(flies(survivor)) in line_
    assert latex(flies(survivor)) in worksheet.to_latex(told)
    (record,) = [entry for entry in plain(told) if entry["cell"] == "NO-human"]
    assert (record["find"], record["flies_find"]) == (said, flies(survivor))
    terminal = " ".join(to_text(told).partition("Finds for survivors")[2].partition("Deviations not")[0].split())
    assert all(word in terminal for word in flies(survivor).split())


def test_a_page_has_no_columns_without_a_value_and_no_list_of_survivors_without_classes():
    plain = rows(FLOWN, with_text("plain"))
    for write in (to_text, worksheet.to_markdown, worksheet.to_latex):
        assert "Flies it" not in write(rows(FLOWN))
        assert not any(words in write(plain) for words in ("Severity", "worst class"))
    assert "flies_find" in read_csv(rows(FLOWN))[0]
    assert {row["severity"] for row in read_csv(plain)} == {""}


def test_deviations_that_are_not_credible_are_in_a_log_and_survivors_stand_by_class():
    early = [outcome(MATRIX.cell("EARLY-human").default_id, HUMAN, seed) for seed in SEEDS]
    told = rows([*FLOWN, *SILENT, *early])
    classed = {row.cell.name: row.values["severity"] for row in worksheet.survivors(told)}
    assert list(classed.items()) == [("NO-human", "injury"), ("EARLY-human", "delay")]
    for text in (to_text(told), worksheet.to_markdown(told), worksheet.to_latex(told).replace("{-}", "-")):
        alive, _, log = text.partition("Survivors, worst class first")[2].partition("Deviations not credible")
        assert alive.index("NO-human") < alive.index("EARLY-human")
        assert "EARLY-collision" in log
    book = load_workbook(io.BytesIO(worksheet.to_xlsx(told)))
    log = [row.cell.name for row in told if row.cell.status is CellStatus.NOT_MEANINGFUL]
    for title, names in (("Deviations not credible", log), ("Survivors, worst class first", list(classed))):
        assert [cell.value for cell in book[title]["A"]][1:] == names


@given(st.one_of(campaigns(), seeded()))
@settings(max_examples=25, deadline=None)
def test_every_figure_is_the_scores(outcomes: list[Outcome]):
    scored = score(outcomes, ROSTER, GRID)
    flown = {mutant.subject.id: mutant for mutant in (*scored.mutants, *scored.controls)}
    records = {record["cell"]: record for record in plain(rows(outcomes))}
    assert set(records) == {cell.name for cell in MATRIX}
    for row in rows(outcomes):
        found = records[row.cell.name]["results"]
        mutant = flown.get(str(row.values["mutant"]))
        assert (found is None) == (mutant is None)
        if found and mutant:
            assert found["kill_rate"] == vars(mutant.kill_rate)
            assert found["killing"] == list(mutant.killing)
            assert (found["verdict"], found["p"]) == (mutant.verdict, dict(mutant.safety.p) if mutant.tested else {})
            assert found["situations_flown"] == mutant.kill_rate_flown.whole
            assert found["infected"] <= found["reached"] <= found["situations_flown"]


def to_text(found: tuple[worksheet.SheetRow, ...]) -> str:
    return render(worksheet.sheet_tables(found), Format.TABLE)


def read_csv(found: tuple[worksheet.SheetRow, ...]) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(worksheet.to_csv(found), newline="")))


@given(hostile)
@settings(max_examples=usually(25, release=40), deadline=None)
def test_what_a_study_says_appears_literally_in_every_format(text: str):
    found = rows(FLOWN, with_text(text))
    row = named(found, "LATE-human")
    (from_csv,) = [entry for entry in read_csv(found) if entry["cell"] == "LATE-human"]
    assert from_csv["deviation"].removeprefix("'") == printable(text).removeprefix("'")
    a_number = re.fullmatch(r"-|[-+]?[\d.]+([eE][-+]?\d+)?", text, re.ASCII)
    assert a_number or not from_csv["deviation"].startswith(FORMULA)
    (record,) = [entry for entry in json.loads(json.dumps(plain(found))) if entry["cell"] == "LATE-human"]
    assert record["deviation"] == text
    assert f"| {markdown(text)} |" in worksheet.to_markdown(found)
    assert f" & {latex(text)} & " in worksheet.to_latex(found)
    assert row.values["deviation"] == text
    said = "".join(line(text).split())
    assert said[:20] in "".join(to_text(found).split()) or len(said) > 20
    for shown in (
        worksheet.to_markdown(found),
        worksheet.to_latex(found),
        to_text(found),
        worksheet.to_csv(found),
    ):
        assert "\x1b" not in shown


@given(hostile)
@settings(max_examples=15, deadline=None)
def test_the_workbook_read_back_is_the_sheet(text: str):
    found = rows(FLOWN, with_text(text))
    raw = worksheet.to_xlsx(found)
    page = load_workbook(io.BytesIO(raw))["HAZOP worksheet"]
    lines = [[cell.value for cell in line] for line in page.iter_rows(min_row=2)]
    credible = [row for row in found if row.cell.status is not CellStatus.NOT_MEANINGFUL]
    assert [cell.value for cell in page[1]] == [column.title for column in worksheet.COLUMNS]
    assert len(lines) == len(credible)
    for row, read in zip(credible, lines, strict=True):
        for column, value in zip(worksheet.COLUMNS, read, strict=True):
            assert in_excel(value) == cut(row.values[column.key])
    assert all(cell.data_type != "f" for line in page.iter_rows() for cell in line)
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        assert not any(b"<f>" in archive.read(name) for name in archive.namelist() if "sheet" in name)


def in_excel(value: object) -> object:
    """A value as Excel shows it: `_x005F_` is an underscore."""
    return re.sub(r"_x005F_", "_", value) if isinstance(value, str) else value


def cut(value: object) -> object:
    """What a cell can hold; openpyxl reads an empty text as nothing."""
    if not isinstance(value, str) or not value:
        return value or (None if value == "" else value)
    shown = printable(value)
    return shown if len(shown) <= worksheet.LONGEST else shown[: worksheet.LONGEST - 6] + " [cut]"


def test_the_workbook_is_made_to_be_worked_with_and_carries_no_clock_and_no_formula():
    told = rows(FLOWN, with_text("=1+1"))
    raw = worksheet.to_xlsx(told)
    assert raw == worksheet.to_xlsx(told)
    page = load_workbook(io.BytesIO(raw))["HAZOP worksheet"]
    assert (page.freeze_panes, page.auto_filter.ref[:3]) == ("B2", "A1:")
    assert page["B2"].alignment.wrap_text
    assert all(page.column_dimensions[cell.column_letter].width >= 9 for cell in page[1])
    formulas = [cell for line in page.iter_rows(min_row=2) for cell in line if str(cell.value).startswith("=")]
    assert formulas
    assert all(cell.quotePrefix and cell.data_type == "s" for cell in formulas)


def test_every_row_of_the_markdown_has_as_many_cells_as_its_header():
    for block in worksheet.to_markdown(rows(FLOWN, with_text("a|b\\|c\nd"))).split("\n\n"):
        lines = [line for line in block.splitlines() if line.startswith("|")]
        assert len({len(re.findall(r"(?<!\\)(?:\\\\)*\|", line)) for line in lines}) <= 1


ENGINES = {
    "pdflatex": r"\usepackage[T1]{fontenc}",
    "pdflatex, old fonts": "",
    "xelatex": r"\usepackage{fontspec}",
    "lualatex": r"\usepackage{fontspec}",
}
LATIN = (
    "<script>alert(1)</script>",
    "\"quotes\" 'single' `grave` --- ?` !` << >>",
    "[option] of the line before",
    "*starred",
    "a|b||c",
    r"\input{/etc/passwd} $y_1^2$ 100 % #1 & ~ {} \end{longtable} \write18{id}",
    "one\ntwo\r\nthree\tfour",
    "\x1b[31mred\x07",
    "Überprüfung größer als 3 m",
)
OTHERS = ("人が検出されない", "Детектор", "≤ 3 m")


def latex_sheet(matrix: Matrix) -> str:
    roster = Roster.of(matrix, [mutant.id for mutant in derive(matrix)])
    flown = pool(*(key for key, _ in GRID.points))
    flown += [outcome("LATE-human@3s", HUMAN, seed, violated={"SR2": 8.0}) for seed in SEEDS]
    return worksheet.to_latex(worksheet.sheet_rows(matrix, score(flown, roster, GRID), GRID, ()))


def compiled(fragments: list[str], engine: str, folder: Path) -> str:
    """The log of the engine; the document must compile."""
    command = engine.split(",", maxsplit=1)[0]
    if shutil.which(command) is None:
        pytest.skip(f"{command} is not installed; nothing else needs it")
    packages = ENGINES[engine] + r"\usepackage{longtable,booktabs,array,pdflscape}"
    text = "\n".join(
        [r"\documentclass[a4paper]{article}", packages, r"\begin{document}", *fragments, r"\end{document}"]
    )
    (folder / "sheet.tex").write_text(text, encoding="utf-8")
    words = [command, "-no-shell-escape", "-interaction=nonstopmode", "-halt-on-error", "sheet.tex"]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, errors="replace", timeout=120, check=False)
    said = (folder / "sheet.log").read_text(encoding="utf-8", errors="replace")
    if missing := re.search(r"LaTeX Error: File `.*?' not found|Font .* not loadable", said):
        pytest.skip(f"{command} lacks a package: {missing[0]}")
    assert done.returncode == 0, said[-3000:]
    return said


@pytest.mark.parametrize("engine", ENGINES)
def test_the_reference_studys_worksheet_compiles_and_no_column_runs_into_the_next(engine: str, tmp_path: Path):
    said = compiled([latex_sheet(WHOLE)], engine, tmp_path)
    too_wide = [float(found) for found in re.findall(r"Overfull \\hbox \(([\d.]+)pt too wide\)", said)]
    assert [width for width in too_wide if width > 1.0] == []


@pytest.mark.parametrize("engine", ENGINES)
def test_hostile_texts_compile_as_texts(engine: str, tmp_path: Path):
    others = OTHERS if engine in ("xelatex", "lualatex") else ()
    compiled([latex_sheet(with_text(text)) for text in (*LATIN, *others)], engine, tmp_path)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_table_of_any_verb_compiles_and_fits_the_page(engine: str, tmp_path: Path):
    wide = ("UNINTENDED-collision@20s", "(human & light) or " * 20, "injury", "[8/24]", "SR1 8/24, SR2 8/8", "100 %")
    headers = ("mutant", "where", "severity", "killed in", "by", "share")
    tables = [Table("Killed & shown", headers, (wide,) * 80, ("50 % of it",)), Table("Few", ("a_b",), (("*c",),))]
    said = compiled([render(tables, Format.LATEX)], engine, tmp_path)
    too_wide = [float(found) for found in re.findall(r"Overfull \\hbox \(([\d.]+)pt too wide\)", said)]
    assert [width for width in too_wide if width > 6.0] == [], "wider than the room between two columns"
    assert "Overfull \\vbox" not in said


def test_a_file_has_what_would_be_printed(told: Call, tmp_path: Path):
    path = tmp_path / "sheet"
    assert told("worksheet", "--format", "xlsx", "--output", str(path)).exit_code == 0
    assert load_workbook(io.BytesIO(path.read_bytes())).sheetnames[0] == "HAZOP worksheet"
    for style in ("table", "csv", "json"):
        done = told("worksheet", "--format", style, "--output", str(path))
        assert (done.exit_code, done.stdout) == (0, "")
        assert path.read_text(encoding="utf-8") == told("worksheet", "--format", style).stdout
