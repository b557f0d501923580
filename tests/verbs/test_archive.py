"""What a campaign says, its archive says too, from any folder; nothing is flown into an archive."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import Result
from printed import STUDY, Call, invoked, sentence

import scaloft_fi
from scaloft_fi.campaign.store.archive import MANIFEST

READS = (("score", "--all"), ("worksheet", "--format", "csv"), ("export",), ("export", "--format", "sace"))


@pytest.fixture(scope="module")
def home(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the archives of a campaign, as a folder and as a file."""
    home = tmp_path_factory.mktemp("archives")
    for name in ("archive", "campaign.zip"):
        words = ["export", "--format", "archive", "--output", f"{home}/{name}", "--campaign", str(folder)]
        result = invoked(*words)
        assert (result.exit_code, result.stdout) == (0, ""), result.output
    return home


@pytest.fixture(autouse=True)
def here(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(home)


def read(*words: str, campaign: str = "campaign.zip") -> Result:
    return invoked(*words, "--campaign", campaign)


def squeezed(text: str) -> str:
    """The text as if every name were as long as every other."""
    return re.sub(r"-+|\s*\\?\s+", lambda run: "-" if run[0][0] == "-" else " ", text.replace("\\_", "_"))


def test_every_verb_that_reads_says_of_an_archive_what_it_says_of_the_campaign(
    told: Call, folder: Path, tmp_path: Path
):
    for words, archive in zip(READS, ("archive/", "campaign.zip") * 2, strict=True):  # the current folder is no study
        mine, again = told(*words), read(*words, campaign=archive)
        assert (again.exit_code, again.stderr) == (0, ""), again.output
        named = re.sub(r"\S*\b(archive/|campaign\.zip)", "campaign", again.stdout)
        # an archive has its study, so its commands name none
        said = squeezed(mine.stdout.replace(str(folder), "campaign")).replace(squeezed(f" --study {STUDY}"), "")
        assert squeezed(named) == said, words
    page, again_ = tmp_path / "page.html", tmp_path / "again.html"
    assert told("report", "--output", str(page)).exit_code == read("report", "--output", str(again_)).exit_code == 0
    assert len(again_.read_bytes()) == pytest.approx(len(page.read_bytes()), rel=0.01)
    both = invoked("diff", "./archive", "campaign.zip", "--format", "json")
    values = json.loads(both.stdout)
    assert values["same"] > 10
    assert values["differences"] == []


def test_status_tells_what_a_paper_cites_and_what_flew_it(told: Call):
    values = json.loads(read("status", "--format", "json").stdout)
    mine = json.loads(told("status", "--format", "json").stdout)
    assert mine["archive"] is None
    assert (values["platform"], values["counted"], values["stale"]) == (mine["platform"], mine["counted"], 0)
    said = " ".join(read("status", campaign="archive/").stdout.split())
    assert f"SHA-256 of its {MANIFEST}: {values['archive']}." in said
    assert f"scaloft-fi {scaloft_fi.__version__}" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "--mutant", "LATE-human", "--campaign", "./archive"), "name another --campaign"),
        (("margin", "LATE-human", "--campaign", "campaign.zip"), "name another --campaign"),
        (("merge", "CAMPAIGN", "--campaign", "campaign.zip"), "name another --campaign"),
        (("seek", "LATE-human", "--into", "./archive"), "name another --campaign"),
        (("merge", "./archive", "--campaign", "CAMPAIGN"), "which lends no flights"),
        (("score", "--baseline-from", "campaign.zip", "--campaign", "CAMPAIGN"), "which lends no flights"),
        (("report", "--campaign", "campaign.zip"), "give --output FILE"),
        (("export", "--format", "archive", "--campaign", "CAMPAIGN"), "give --output FILE"),
        (("export", "--format", "archive", "--output", "archive", "--campaign", "CAMPAIGN"), "must be a new or empty"),
        (("export", "--format", "archive", "--output", "campaign.zip/x", "--campaign", "CAMPAIGN"), "is a file, not a"),
    ],
    ids=lambda one: one[0] if isinstance(one, tuple) else "",
)
def test_nothing_is_flown_merged_or_written_into_an_archive(
    home: Path, folder: Path, words: tuple[str, ...], said: str
):
    before = sorted([*home.rglob("*"), *folder.rglob("*")])
    named = [str(folder) if word == "CAMPAIGN" else word for word in words]
    study = () if said == "give --output FILE" and "report" in words else ("--study", str(Path(__file__).parents[2]))
    assert said in sentence(invoked(*named, *study))
    assert sorted([*home.rglob("*"), *folder.rglob("*")]) == before


def test_a_script_opens_an_archive_as_a_campaign(told: Call, home: Path, tmp_path: Path):
    opened = scaloft_fi.open().campaign("campaign.zip")
    assert opened.score().record() == json.loads(told("score", "--format", "json").stdout)
    assert len(opened.flights()["mutant"]) == json.loads(told("status", "--format", "json").stdout)["counted"]
    assert opened.export("archive") == (home / "campaign.zip").read_bytes()
    assert "archive" in opened._repr_html_()
    with pytest.raises(scaloft_fi.InputError, match="an archive is a record"):
        opened.run("LATE-human")
    with pytest.raises(scaloft_fi.InputError, match="give path"):
        opened.report()
    assert opened.report(str(tmp_path / "out.html")).is_file()
