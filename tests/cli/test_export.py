from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from refusal import sentence

Call = Callable[..., Result]


def test_an_export_has_one_row_per_flight_in_order_and_csv_says_the_same(call: Call) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--baseline-seeds", "1", "--quiet")
    rows = json.loads(call("export").stdout)
    assert [(row["mutant"], row["situation"]) for row in rows] == [
        (mutant, f"T0O0W0D0H{h}") for mutant in ("baseline", "PLACEBO", "LATE-human@3s") for h in (0, 1)
    ] + [("REVERSE-velcmd", "T0O0W0D0H0")]
    assert (rows[-2]["violated"], rows[-2]["status"], rows[-2]["revealed_by"]) == (["SR2"], "revealed", ["SR2"])
    table = list(csv.DictReader(io.StringIO(call("export", "--format", "csv").stdout)))
    assert [row["digest"] for row in table] == [row["digest"] for row in rows]


@pytest.mark.parametrize(
    ("style", "says"),
    [
        ("markdown", "| mutation score | 1/1 = 100 % |"),
        ("junit", '<testcase classname="scaloft-fi.human" name="LATE-human@3s" />'),
        ("sarif", '"results": []'),
        ("mutation-testing", '"status": "Killed"'),
        ("gsn", "The suite detects 1/1 = 100 % of the mutants flown"),
        ("sace", "Mutants flown, by safety requirements: 1 detected"),
        ("sace-json", "Mutants flown, by safety requirements: 1 detected"),
    ],
)
def test_the_formats_of_other_tools_tell_the_verdict(call: Call, style: str, says: str) -> None:
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--seeds", "3", "--baseline-seeds", "10")
    call("run", *words, "--jobs", "1", "--quiet")
    assert says in " ".join(call("export", "--format", style).stdout.split())


def test_a_campaign_that_grew_spends_alpha_by_looks_in_every_format(call: Call) -> None:
    for seeds in ("1", "3"):
        words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--seeds", seeds, "--baseline-seeds", "10")
        call("run", *words, "--jobs", "1", "--quiet")
    assert "| mutation score | 0/1 = 0 % |" in " ".join(call("export", "--format", "markdown").stdout.split())
    (row,) = csv.DictReader(io.StringIO(call("dispositions", "--format", "csv").stdout.partition("\n")[2]))
    assert (row["mutant"], row["verdict"]) == ("LATE-human@3s", "undecided")
    sheet = csv.DictReader(io.StringIO(call("worksheet", "--format", "csv").stdout))
    assert next(row["needed"] for row in sheet if row["cell"] == "LATE-human") == "5 seeds"


def test_an_export_can_go_to_a_file(call: Call, tmp_path: Path) -> None:
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet")
    assert call("export", "--output", str(tmp_path / "e.json")).stdout == ""
    assert json.loads((tmp_path / "e.json").read_text())[0]["mutant"] == "baseline"
    assert "cannot be written" in sentence(call("export", "--output", str(tmp_path / "no" / "e.json")))


def test_nothing_is_exported_of_a_campaign_that_was_never_flown(call: Call, tmp_path: Path) -> None:
    assert "no campaign was flown here" in sentence(call("export"))
    assert list(tmp_path.iterdir()) == []
