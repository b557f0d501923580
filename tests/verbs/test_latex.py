"""The LaTeX worksheet compiled, where a TeX is installed: the reference study's, and one with hostile texts."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from builders import GRID, outcome, pool

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import score
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import CellStatus, Matrix
from scaloft_fi.mutants.catalogue import derive
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.verbs.worksheet import sheet_rows, to_latex

MATRIX = load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name)
SOME = MATRIX.only(["LATE", "NO", "EARLY"], ["human", "collision"])
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


def with_text(text: str) -> Matrix:
    """The matrix with a text of the study in every field that the sheet prints."""
    cells = {
        key: replace(cell, reason=text) if cell.status is CellStatus.NOT_MEANINGFUL else replace(cell, deviation=text)
        for key, cell in SOME.cells.items()
    }
    return Matrix(SOME.guidewords, tuple(replace(p, title=text) for p in SOME.parameters), cells)


def sheet(matrix: Matrix) -> str:
    roster = Roster.of(matrix, [mutant.id for mutant in derive(matrix)])
    flown = pool(*(key for key, _ in GRID.points))
    flown += [outcome("LATE-human@3s", "T0O0W0D0H1", seed, violated={"SR2": 8.0}) for seed in range(3)]
    return to_latex(sheet_rows(matrix, flown, score(flown, roster, GRID), GRID, ()))


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
    if "not found" in said and "LaTeX Error: File" in said:
        pytest.skip(f"{command} lacks a package: " + re.findall(r"File `(.*?)' not found", said)[0])
    assert done.returncode == 0, said[-3000:]
    return said


@pytest.mark.parametrize("engine", ENGINES)
def test_the_reference_studys_worksheet_compiles_and_no_column_runs_into_the_next(engine: str, tmp_path: Path) -> None:
    said = compiled([sheet(MATRIX)], engine, tmp_path)
    too_wide = [float(found) for found in re.findall(r"Overfull \\hbox \(([\d.]+)pt too wide\)", said)]
    assert [width for width in too_wide if width > 1.0] == []


@pytest.mark.parametrize("engine", ENGINES)
def test_hostile_texts_compile_as_texts(engine: str, tmp_path: Path) -> None:
    compiled([sheet(with_text(text)) for text in LATIN], engine, tmp_path)


@pytest.mark.parametrize("engine", ["xelatex", "lualatex"])
def test_letters_that_are_not_latin_compile_in_a_unicode_engine(engine: str, tmp_path: Path) -> None:
    compiled([sheet(with_text(text)) for text in OTHERS], engine, tmp_path)
