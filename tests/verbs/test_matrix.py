from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.console import PIPED
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Cell, CellStatus, Guideword, Matrix, Parameter
from scaloft_fi.hazop.render import overview, sheet
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.verbs.matrix import matrix_command

CHECKOUT = Path(__file__).resolve().parents[2]
MATRIX = load_matrix(CHECKOUT / "hazop", REFERENCE.by_name)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(matrix_command, ["--study", str(CHECKOUT), *arguments])


def printed(*arguments: str) -> str:
    outcome = run(*arguments)
    assert outcome.exit_code == 0, outcome.exception
    return outcome.output


@pytest.mark.parametrize("columns", [60, 80, 100, 160])
def test_the_matrix_fits_the_terminal_in_plain_ascii(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    text = printed()
    assert max(map(len, text.splitlines())) <= columns
    assert text.isascii()


def test_the_matrix_shows_the_grid_the_legend_and_the_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    lines = printed("--grid").splitlines()
    assert lines[0].split() == [word.id for word in MATRIX.guidewords]
    assert lines[2].split()[:2] == ["human", "100%"]
    assert [line.split()[0] for line in lines[2:15]] == [parameter.id for parameter in MATRIX.parameters]
    assert lines[-1] == "13 parameters x 12 guidewords = 156 cells: 114 credible, 11 control, 31 not meaningful"


def test_the_matrix_tells_every_cell_with_its_deviation_or_reason() -> None:
    text = " ".join(printed().split())
    assert all(" ".join(cell.told.split()) in text for cell in MATRIX)


def test_filters_keep_only_what_they_name_in_any_case() -> None:
    words = ("--guideword", "late", "--guideword", "MORE", "--parameter", "Human")
    cells = json.loads(printed(*words, "--format", "json"))["cells"]
    assert [cell["cell"] for cell in cells] == ["MORE-human", "LATE-human"]


def test_one_cell_is_told_whole() -> None:
    text = printed("--cell", "LATE-human")
    for fragment in (
        "Detection delivered late.",
        "The network runs on a throttled processor.",
        "SR2",
        "person (person detector -> speed limit)",
        "delay_s = 0.5 s, 1 s, 3 s*, 5 s",
        "LATE-human@0.5s, LATE-human@1s, LATE-human@3s*, LATE-human@5s",
    ):
        assert fragment in text


def test_every_cell_fits_the_terminal() -> None:
    for cell in MATRIX:
        assert max(map(len, sheet(MATRIX, cell, {}, PIPED).splitlines())) <= PIPED, cell.name


def process(*arguments: str, **extra: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *arguments]
    environment = os.environ | {"PYTHONPATH": str(CHECKOUT)} | extra
    return subprocess.run(command, capture_output=True, text=True, cwd=CHECKOUT, env=environment, check=False)


def test_the_matrix_is_printed_without_what_takes_long_to_import() -> None:
    source = (
        "import sys\n"
        "from scaloft_fi.cli import main\n"
        "sys.argv[1:] = ['matrix']\n"
        "try:\n    main()\n"
        "finally:\n    assert not {'numpy', 'numba', 'pybullet', 'tabulate'} & set(sys.modules)\n"
    )
    ended = process("-c", source)
    assert ended.returncode == 0, ended.stderr


@given(st.integers(0, 30), st.integers(0, 6), st.integers(1, 20))
def test_a_study_with_many_guidewords_still_fits(words: int, parameters: int, length: int) -> None:
    guidewords = tuple(Guideword(f"{'W' * length}{i}", "", "") for i in range(words))
    rows = tuple(Parameter(f"p{i}", "", "", "", "") for i in range(parameters))
    cells = {(w.id, p.id): Cell(w.id, p.id, CellStatus.CONTROL) for w in guidewords for p in rows}
    text = overview(Matrix(guidewords, rows, cells), PIPED)
    assert max(map(len, text.splitlines())) <= PIPED
    assert all(word.id in text for word in guidewords)
