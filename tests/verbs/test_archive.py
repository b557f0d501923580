"""What a campaign says, its archive says too, from any folder; nothing is flown into an archive."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from refusal import sentence

import scaloft_fi
from scaloft_fi.campaign.store.archive import MANIFEST
from scaloft_fi.cli import main
from scaloft_fi.verbs.export.dossier import FORMATS

Call = Callable[..., Result]
READS = (
    ("score", "--all", "--format", "json"),
    ("score", "--by", "axis", "--format", "markdown"),
    ("kills", "--format", "json"),
    ("worksheet", "--format", "csv"),
    ("coverage", "--format", "json"),
    ("dispositions", "--format", "json", "--today", "2027-01-31"),
    ("matrix", "--margins", "--format", "json"),
    *(("export", "--format", name) for name in sorted(FORMATS) if FORMATS[name].text),
    ("report", "--output", "OUT"),
)


@pytest.fixture
def home(call: Call, tmp_path: Path) -> Path:
    """A folder with a campaign, and its archives as a folder and as a file."""
    call("run", "--mutant", "LATE-human", "--mutant", "MORE-goal", "--situation", "T0O0W0D0H?", "--quiet")
    for name in ("archive", "campaign.zip"):
        result = call("export", "--format", "archive", "--output", f"{tmp_path}/{name}")
        assert (result.exit_code, result.stdout) == (0, ""), result.output
    return tmp_path


def read(*words: str, campaign: str, out: Path) -> Result:
    told = [str(out) if word == "OUT" else word for word in words]
    return CliRunner().invoke(main, [*told, "--campaign", campaign], catch_exceptions=False)


def squeezed(text: str) -> str:
    """The text as if every name were as long as every other."""
    return re.sub(r"-+|\s+", lambda run: run[0][0], text)


def test_every_verb_that_reads_says_of_an_archive_what_it_says_of_the_campaign(call: Call, home: Path) -> None:
    out = home / "out.html"
    for words in READS:
        told = call(*[str(out) if word == "OUT" else word for word in words])
        assert told.exit_code == 0, told.output
        page = out.read_bytes() if "OUT" in words else b""
        for archive in ("archive/", "campaign.zip"):  # the current folder is no study
            again = read(*words, campaign=archive, out=out)
            assert (again.exit_code, again.stderr) == (0, ""), again.output
            assert squeezed(again.stdout.replace("\\_", "_")) == squeezed(
                told.stdout.replace("\\_", "_").replace(f"{home}/campaign", "campaign")
            ), words
            page_again = out.read_bytes() if "OUT" in words else b""
            assert len(page_again) == pytest.approx(len(page), rel=0.01)


def test_two_archives_of_a_campaign_hold_the_same_flights(home: Path) -> None:
    result = CliRunner().invoke(main, ["diff", "./archive", "campaign.zip", "--format", "json"], catch_exceptions=False)
    values = json.loads(result.stdout)
    assert values["same"] > 10
    assert values["differences"] == []


def test_status_tells_what_a_paper_cites_and_what_flew_it(call: Call, home: Path) -> None:
    values = json.loads(read("status", "--format", "json", campaign="campaign.zip", out=home).stdout)
    mine = json.loads(call("status", "--format", "json").stdout)
    assert mine["archive"] is None
    assert values["platform"] == mine["platform"]
    assert values["counted"] == mine["counted"]
    assert values["stale"] == 0
    said = " ".join(read("status", campaign="archive/", out=home).stdout.split())
    assert f"SHA-256 of its {MANIFEST}: {values['archive']}." in said
    assert f"scaloft-fi {scaloft_fi.__version__}" in said


@pytest.mark.parametrize(
    "words",
    [
        ("run", "--mutant", "LATE-human"),
        ("margin", "LATE-human"),
        ("merge", "./other"),
        ("seek", "LATE-human", "--into", "CAMPAIGN"),
    ],
)
@pytest.mark.parametrize("archive", ["./archive", "campaign.zip"])
def test_nothing_is_flown_or_merged_into_an_archive(home: Path, words: tuple[str, ...], archive: str) -> None:
    told = [archive if word == "CAMPAIGN" else word for word in words]
    where = () if words[0] == "seek" else ("--campaign", archive)
    before = sorted(home.rglob("*"))
    study = ("--study", str(Path(__file__).parents[2]))
    if words[0] == "merge":
        CliRunner().invoke(main, ["run", "--mutant", "NO-human", "--campaign", "./other", "--quiet", *study])
        before = sorted(home.rglob("*"))
    refused = sentence(CliRunner().invoke(main, [*told, *where, *study], catch_exceptions=False))
    assert "name another --campaign" in refused
    assert sorted(home.rglob("*")) == before


def test_an_archive_lends_no_flights(call: Call, home: Path) -> None:
    assert "which lends no flights" in sentence(call("merge", "./archive"))
    assert "which lends no flights" in sentence(call("score", "--baseline-from", "campaign.zip"))


def test_a_report_of_an_archive_needs_a_place(home: Path) -> None:
    assert "give --output FILE" in sentence(read("report", campaign="campaign.zip", out=home))


def test_an_archive_takes_a_new_folder_or_a_zip_file(call: Call, home: Path) -> None:
    refused = sentence(call("export", "--format", "archive", "--output", f"{home}/archive"))
    assert "must be a new or empty folder, or end in .zip" in refused
    assert "give --output FILE" in sentence(call("export", "--format", "archive"))
    assert "is a file, not a folder" in sentence(
        call("export", "--format", "archive", "--output", f"{home}/campaign.zip/x")
    )


def test_a_script_opens_an_archive_as_a_campaign(call: Call, home: Path) -> None:
    mine = json.loads(call("score", "--format", "json").stdout)
    opened = scaloft_fi.open().campaign("campaign.zip")
    assert opened.score().record() == mine
    assert len(opened.flights()["mutant"]) == json.loads(call("status", "--format", "json").stdout)["counted"]
    assert opened.export("archive") == (home / "campaign.zip").read_bytes()
    assert "archive" in opened._repr_html_()
    with pytest.raises(scaloft_fi.InputError, match="an archive is a record"):
        opened.run("LATE-human")
    with pytest.raises(scaloft_fi.InputError, match="give path"):
        opened.report()
    assert opened.report("out.html").is_file()
