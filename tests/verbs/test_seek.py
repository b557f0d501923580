"""The verb `seek`, what it prints, and what `run --grid paper+found` and `score` make of its finds, without physics."""

from __future__ import annotations

import json
import shutil
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import Result
from finding import Ruled, breached, fast, flies, found
from pages import embedded
from printed import Call, no_terms, of_form, sentence, told_by
from studies import GRIDS

import scaloft_fi
from scaloft_fi.analysis.seeking import Effort
from scaloft_fi.campaign.seeking.finds import SeekReport, Sought, anew, interrupted, saver
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import PLACEBO_ID
from scaloft_fi.sim.grid import read_finds
from scaloft_fi.verbs.seek import seek_tables, why_not
from scaloft_fi.views.table import Format, render

LATE, MORE = "LATE-human@3s", "MORE-goal@0.6m"


@pytest.fixture
def ruled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: Call) -> Ruled:
    flyer = Ruled(tmp_path / "flown.txt", {LATE: fast})
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", lambda: flyer)
    return flyer


@pytest.fixture
def sought(ruled: Ruled, call: Call, copy: Path) -> Result:
    return call("seek", "LATE-human", "--jobs", "1", "--format", "json", study=copy)


def test_a_find_is_printed_written_and_flown_beside_the_papers_situations(sought: Result, call: Call, copy: Path):
    assert sought.exit_code == 0, sought.output
    told = of_form("seek", sought.stdout)
    (find,) = told["finds"]
    assert [one["shown_in"] for one in told["sought"]] == [find["situation"]]
    assert [one["mutant"] for one in find["shows"]] == [LATE]
    assert f"found: {find['situation']} (human, cruise speed " in sought.stderr
    assert (copy / "sim" / "found.yaml").exists()
    words = ("--grid", "paper+found", "--mutant", "LATE-human", "--seeds", "3", "--jobs", "1", "--quiet")
    done = told_by(call("run", *words, "--situation", "shows-LATE-human@3s", "--situation", "T0O0W0D0H1", study=copy))
    screen = " ".join(done.split())
    assert "by safety requirements, not firmly: hangs on a seed. Selected: 1 situation was found" in screen
    record = json.loads(call("score", "--format", "json", study=copy).stdout)
    assert record["selected"] == [find["situation"]]
    assert record["mutants"][0]["kills"][0]["situation"] == find["situation"]
    assert no_terms(call("seek", "LATE-human", "--quiet", "--format", "markdown", study=copy).stdout) == []
    again = call("seek", "LATE-human", "--jobs", "1", "--quiet", study=copy)
    table = " ".join(again.stdout.split())
    assert "Found: 1 of 1 mutants, 1 situations" in table
    of_search = call("score", "--campaign", "search", "--format", "json", study=copy, campaign=False)
    (invalid,) = json.loads(of_search.stdout)["stale"]["invalid"]
    assert "a search chose what to fly by what it saw" in invalid
    assert f"shows-{LATE}: {find['situation']}: human, cruise speed" in table
    assert " 0 of them flown now; the search came to its end." in table
    asked = scaloft_fi.open(copy).campaign("mine").seek("LATE-human", jobs=1)
    assert asked.record() == told | {"flown": 0}
    assert asked["finds_shows"]["mutant"].tolist() == [LATE]


def test_by_default_the_mutants_are_sought_that_neither_the_campaign_nor_a_find_shows(
    ruled: Ruled, call: Call, copy: Path
):
    words = ("--mutant", "LATE-human", "--mutant", "MORE-goal", "--situation", "T0O0W0D0H*", "--seeds", "3")
    ruled.rules = {LATE: lambda _situation: -0.2}
    assert call("run", *words, "--jobs", "1", "--quiet", study=copy).exit_code == 0
    few = ("--budget", "1flight", "--jobs", "1", "--format", "json")
    stale = found("EARLY-human@3s", "T0O0W0D0H9", others=("NO-depth@3s",))
    with closing(sqlite3.connect(copy.parent / "campaign" / STORE_NAME)) as connection:
        connection.execute("UPDATE outcomes SET digest = 'other' WHERE mutant = 'PLACEBO' AND seed = 0")
        connection.commit()
    saver(copy / "sim", "search")([found(MORE), stale])
    done = call("seek", *few, study=copy)
    assert done.exit_code == 0, done.output
    named = [one["mutant"] for one in json.loads(done.stdout)["sought"]]
    assert len(named) == 112
    assert not {LATE, MORE} & set(named)
    assert {"EARLY-human@3s", "NO-depth@3s"} <= set(named), "the study lacks the situation that would show them"
    assert "warning: sim/found.yaml: left out, because the study has changed since: shows-EARLY" in done.stderr
    assert "warning: no score is valid: gate failed: PLACEBO differs from the baseline" in done.stderr
    assert "not sought: 1 of 113 defaults that are not detected, because situations in sim/found.yaml" in done.stderr
    again = call("seek", "MORE-goal", *few, study=copy)
    assert [one["mutant"] for one in json.loads(again.stdout)["sought"]] == [MORE]


def test_an_interrupted_search_goes_on_with_its_own_mutants_whatever_it_has_found(ruled: Ruled, call: Call, copy: Path):
    saver(copy / "sim", "search")([found(LATE)])
    folder, campaign = copy / "results" / "campaigns" / "search", str(copy.parent / "campaign")
    folder.mkdir(parents=True)
    with Store(folder / STORE_NAME) as store:
        anew(folder, 0, campaign, [LATE, MORE]).begin(store)
    done = call("seek", "--budget", "1flight", "--jobs", "1", "--format", "json", study=copy)
    assert [one["mutant"] for one in json.loads(done.stdout)["sought"]] == [LATE, MORE]
    assert interrupted(folder, 0, campaign) is None
    assert "no campaign was flown here" in sentence(call("seek", study=copy)), "it asks for what is not detected"


def test_verbs_that_read_tell_of_the_find_and_its_flights_take_its_place(ruled: Ruled, call: Call, copy: Path):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H0", "--seeds", "3")
    assert call("run", *words, "--jobs", "1", "--quiet", study=copy).exit_code == 0
    saver(copy / "sim", "search")([found(LATE, "T0O0W0D0H1Cs=0.9")])
    campaign = ("--campaign", str(copy.parent / "campaign"))
    command = flies(LATE).replace("--grid paper+found", f"--grid paper+found --study {copy}")
    screen = " ".join(call("score", study=copy).stdout.replace("\\\n", "\n").split())
    assert f"fly where a search found that {LATE} violates SR2: `{command}`." in screen
    survivors = " ".join(call("kills", "--show", "survivors", "--format", "csv", study=copy).stdout.split())
    assert "find,A search found a situation that shows it" in survivors.replace('"', "")
    assert command in survivors
    assert command in call("worksheet", "--format", "csv", study=copy).stdout
    assert command in call("export", "--format", "junit", study=copy).stdout
    assert f"A search found situations that show {LATE}" in " ".join(call("dispositions", study=copy).stdout.split())
    flown = call(*command.split()[1:], "--jobs", "1", "--quiet", study=copy, campaign=False)
    assert "1 of 1 fault by safety requirements" in " ".join(flown.stdout.split())
    page = copy / "page.html"
    told = []
    for name in (campaign, ("--campaign", "paper+found")):
        assert call("report", "--output", str(page), *name, study=copy, campaign=False).exit_code == 0
        told.append(embedded(page.read_text(encoding="utf-8"), "figures"))
    before, after = (figures["found"]["finds"][0] for figures in told)
    assert (before["name"], before["flights"], before["command"]) == (f"shows-{LATE}", None, command)
    assert [one["mutant"] for one in after["flights"]] == [LATE, "baseline"]
    assert [one["find"] for one in told[0]["survivors"]] == [f"shows-{LATE}"]
    assert told[1]["survivors"] == []


def test_what_breaks_the_unmutated_drone_is_printed_and_written(
    ruled: Ruled, call: Call, copy: Path, monkeypatch: pytest.MonkeyPatch
):
    told = "scaloft_fi.campaign.seeking.breaks.recalled"
    monkeypatch.setattr(told, lambda _study, _flight, violations: breached(violations, "person detection"))
    ruled.baseline = fast
    shutil.copy(GRIDS / "small.yaml", copy / "sim" / "grids")
    words = ("baseline", "--grid", "small", "--into", "where", "--budget", "70flights", "--jobs", "1")
    done = call("seek", *words, "--format", "json", study=copy)
    assert done.exit_code == 0, done.output
    (found,) = of_form("seek", done.stdout)["breaks"]
    assert found["name"] == "breaks-SR2-person-home_to_corner-near_corner-person_detection"
    assert f"found: {found['name']}: {found['situation']} (human, cruise speed " in done.stderr
    written = read_finds(copy / "sim")
    assert [one.situation for one in written.breaks] == [found["situation"]]
    assert no_terms(call("seek", *words, "--quiet", "--format", "markdown", study=copy).stdout) == []
    again = call("seek", *words, "--quiet", study=copy)
    table = " ".join(again.stdout.replace("\\\n", " ").split())
    assert "The unmutated drone breaks in 1 way" in table
    assert "1 SR2 10/10 person near corner, home to corner person detection, 1.50 m 10/10" in table
    assert f"`scaloft-fi replay baseline/{found['situation']}/0 --campaign where --study {copy}`" in table
    assert ", 0 of them flown now, " in table
    words = ("--mutant", "LATE-human", "--situation", found["name"], "--situation", "T0D0H0", "--jobs", "1", "--quiet")
    told_by(call("run", "--grid", "small", *words, study=copy))
    assert json.loads(call("score", "--format", "json", study=copy).stdout)["selected"] == [found["situation"]]


def test_without_optuna_a_sentence_names_what_to_install(
    ruled: Ruled, call: Call, copy: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(sys.modules, "optuna", None)
    refused = sentence(call("seek", "LATE-human", study=copy))
    assert refused == "error: seek needs optuna: pip install 'scaloft-fi[seek]'"


def test_a_study_without_the_grid_that_is_searched_by_default_is_told_to_write_one_or_to_name_another(
    call: Call, copy: Path, tmp_path: Path
):
    (copy / "sim" / "grids" / "search.yaml").unlink()
    said = sentence(call("seek", "baseline", study=copy))
    assert said.endswith(
        "write sim/grids/search.yaml, as the site's page Finding missing tests says, "
        "or name another grid, such as --grid paper"
    )
    with pytest.raises(scaloft_fi.InputError, match=r"page Finding missing tests says, or .*, such as grid paper$"):
        scaloft_fi.open(copy).campaign(f"{tmp_path}/c").seek("baseline")


def test_finds_are_replicated_and_what_does_not_hold_leaves(ruled: Ruled, call: Call, copy: Path):
    saver(copy / "sim", "search")([found(LATE, "T0O0W0D0H1Cs=0.9"), found(MORE, "T0O0W0D0H0Cs=0.9")])
    told = of_form("seek", told_by(call("seek", "--replicate", "--jobs", "1", "--format", "json", study=copy)))
    assert [(one["mutant"], one["holds"]) for one in told["replicas"]] == [(LATE, True), (MORE, False)]
    assert told["first"] == 100_000
    written = read_finds(copy / "sim")
    assert [find.name for find in written.finds] == [f"shows-{LATE}"]
    again = call("seek", "--replicate", "LATE-human", "--jobs", "1", "--quiet", study=copy)
    screen = " ".join(again.stdout.split())
    assert "Replicated: 1 of 1 pairs of find and mutant hold" in screen
    assert "Flown on the seeds 100100, 100101" in screen


def test_without_a_find_nothing_is_replicated(ruled: Ruled, call: Call, copy: Path):
    assert f"there is no find to replicate; `scaloft-fi seek --study {copy}` finds some" in sentence(
        call("seek", "--replicate", study=copy)
    )
    assert "there is no find of MORE-goal to replicate" in sentence(
        call("seek", "--replicate", "MORE-goal", study=copy)
    )
    assert not (copy / "sim" / "found.yaml").exists()


def test_the_file_says_of_a_find_what_holds_of_any_though_it_stands_in_the_studys_own_grid(tmp_path: Path):
    saver(tmp_path, "search")([found(LATE, "T0O0W0D0H1")])
    head = (tmp_path / "found.yaml").read_text(encoding="utf-8").partition("\ngrid:")[0]
    assert "finds: each shows mutants: the mutant violates a safety requirement there that" in head
    assert "does not detect" not in head


def test_what_flies_the_finds_is_advised_where_there_are_some():
    for finds, advised in (((), False), ((found(PLACEBO_ID),), False), ((found(LATE),), True)):
        tables = seek_tables(SeekReport(finds=finds, used=9, flown=9, alpha=0.01), "paper")
        assert ("+found" in str(tables)) == advised


NEAR = Effort(5, 4, 3, 2, 0, 0.83, "SR1", "T1O0W0D0H1")


@pytest.mark.parametrize(
    ("effort", "candidates", "why"),
    [
        (Effort(), 0, "not flown"),
        (Effort(5), 0, "its seam carried no sample"),
        (Effort(5, 4), 0, "it changed no sample"),
        (Effort(5, 4, 3), 0, "it changed samples in 3, and the drone flew the same to the bit"),
        (Effort(5, 4, 3, 2), 0, "no safety requirement is held with room in the 3 where it changed samples"),
        (NEAR, 0, "it kept 83% of the robustness of SR1 in T1O0W0D0H1"),
        (Effort(5, 4, 3, 2, 1, -0.1, "SR1", "T1"), 0, "it violated SR1 in 1, not with every seed of the search"),
        (Effort(5, 4, 3, 2, 1, -0.1, "SR1", "T1"), 1, "1 candidate that fresh seeds did not confirm"),
        (NEAR, 2, "2 candidates that fresh seeds did not confirm"),
    ],
)
def test_a_mutant_without_a_find_says_where_it_stopped(effort: Effort, candidates: int, why: str):
    sought = Sought("LATE-depth@0.4s", "", 0, candidates, 0.005 * candidates, effort)
    assert why_not(sought) == why
    tables = seek_tables(SeekReport(sought=(sought,), used=9, flown=9, spent=True, alpha=0.01, anyhow=False), "paper")
    assert tables[1].rows == (("LATE-depth@0.4s", effort.situations, why),)
    assert no_terms(render(tables, Format.MARKDOWN)) == []
