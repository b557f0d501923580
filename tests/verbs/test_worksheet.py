"""The verb `worksheet` on the reference study without physics, with a study that is hostile."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from openpyxl import load_workbook
from refusal import sentence

Call = Callable[..., Result]
ASKED = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H*", "--seeds", "3", "--jobs", "1", "--quiet")


@pytest.fixture
def flown(call: Call) -> Call:
    assert call(*ASKED).exit_code == 0
    return call


def test_xlsx_goes_into_a_file_only(flown: Call, tmp_path: Path) -> None:
    refused = flown("worksheet", "--format", "xlsx")
    assert refused.exit_code == 2
    assert "name it with --output" in refused.stderr
    path = tmp_path / "sheet.xlsx"
    assert flown("worksheet", "--format", "xlsx", "--output", str(path)).exit_code == 0
    assert load_workbook(path).sheetnames == ["HAZOP worksheet", "Deviations not credible", "About"]


@pytest.mark.parametrize("style", ["table", "markdown", "csv", "json", "latex"])
def test_a_file_has_what_would_be_printed(flown: Call, tmp_path: Path, style: str) -> None:
    path = tmp_path / "sheet"
    done = flown("worksheet", "--format", style, "--output", str(path))
    assert (done.exit_code, done.stdout) == (0, "")
    assert path.read_text(encoding="utf-8") == flown("worksheet", "--format", style).stdout


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--output", "/nowhere/sheet.csv"), "there is no folder"),
        (("--format", "xls"), "'xls'"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(flown: Call, words: tuple[str, ...], says: str) -> None:
    assert says in sentence(flown("worksheet", *words))
