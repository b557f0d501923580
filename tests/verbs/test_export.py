from __future__ import annotations

import csv
import io
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from refusal import sentence

from scaloft_fi.verbs.export.dossier import FORMATS, Dossier, export_format

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
    (row,) = csv.DictReader(io.StringIO(call("dispositions", "--format", "csv").stdout))
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


def test_the_help_lists_every_format_and_a_wrong_name_gets_the_nearest(call: Call) -> None:
    listed = call("export", "--help").stdout
    assert all(f"\n  {name} " in listed for name in FORMATS)
    assert "no export format 'jnuit'; did you mean 'junit'?" in sentence(call("export", "--format", "jnuit"))


def test_a_format_that_is_no_text_asks_for_a_file_before_anything_is_read(call: Call) -> None:
    assert "--format='parquet' is no text: give --output FILE" in sentence(call("export", "--format", "parquet"))


def test_a_format_that_somebody_else_declares_is_listed_and_written(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(FORMATS, "_entries", dict(FORMATS._entries))

    @export_format("flown", "the flights, counted")
    def flown(dossier: Dossier) -> dict[str, int]:
        return {"flights": len(dossier.rows)}

    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--baseline-seeds", "1", "--quiet")
    assert "the flights, counted" in call("export", "--help").stdout
    written = json.loads(call("export", "--format", "flown").stdout)["flights"]
    assert written == len(json.loads(call("export").stdout))
    with pytest.raises(ValueError, match="export format 'flown' is declared twice"):
        export_format("flown", "again")(flown)


def test_a_plugin_of_another_package_adds_a_format(tmp_path: Path) -> None:
    package = tmp_path / "loud"
    (tmp_path / "loud-1.dist-info").mkdir()
    (tmp_path / "loud-1.dist-info" / "METADATA").write_text("Name: loud\nVersion: 1\n")
    (tmp_path / "loud-1.dist-info" / "entry_points.txt").write_text("[scaloft_fi.plugins]\nloud = loud\n")
    package.mkdir()
    (package / "__init__.py").write_text(
        "from scaloft_fi.verbs.export import Dossier, export_format\n\n\n"
        "@export_format('loud', 'everything in capitals')\n"
        "def loud(dossier: Dossier) -> str:\n    return dossier.campaign.upper()\n"
    )
    path = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[2])])
    words = [sys.executable, "-m", "scaloft_fi", "export", "--help"]
    done = subprocess.run(words, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=True)
    assert "loud everything in capitals" in " ".join(done.stdout.split())
