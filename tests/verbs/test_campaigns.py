"""Verbs over whole campaigns: `status`, shards and `merge`."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path

import pytest
from builders import GRID, ROSTER, campaigns, outcome
from click.testing import Result
from crafted import ONE, Crafted, campaign, crafted, sql
from hypothesis import given
from paper_flyer import Paper, made
from printed import STUDY, Call, commands, invoked, of_form, sentence, told_by
from studies import copied

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.platforms import claim
from scaloft_fi.campaign.store.record import MOST_FLIGHTS
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.hazop.load import named_study
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Facts
from scaloft_fi.study import Study
from scaloft_fi.verbs.campaigns import Difference, FlightDifferences, differences_of, differences_table
from scaloft_fi.verbs.snapshot import snapshot

WORDS = ("--mutant", "LATE-human", "--situation", "T0O0W0D?H?", "--quiet")


def _shards(call: Call, folder: Path) -> list[str]:
    names = [f"{folder}/{k}" for k in (1, 2)]
    for k, name in enumerate(names, 1):
        told_by(call("run", *WORDS, "--shard", f"{k}/2", "--campaign", name, campaign=False))
    return names


def test_two_shards_merged_export_the_bytes_of_the_undivided_run(call: Call, tmp_path: Path):
    call("run", *WORDS)
    names = _shards(call, tmp_path)
    merged = call("merge", *names, "--campaign", f"{tmp_path}/both", campaign=False)
    assert merged.stdout == f"31 flights added to {tmp_path}/both, 0 known already\n"
    both = call("export", "--campaign", f"{tmp_path}/both", campaign=False)
    assert both.stdout == call("export").stdout


def test_flights_whose_baseline_is_not_home_wait_for_it_and_are_not_called_invalid(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    with closing(sqlite3.connect(tmp_path / "campaign" / STORE_NAME)) as connection:
        connection.execute("DELETE FROM outcomes WHERE mutant = 'baseline' AND situation = 'T0O0W0D0H1'")
        connection.commit()
    statuses = json.loads(call("status", "--format", "json").stdout)["statuses"]
    counted = {row["status"]: row["flights"] for row in statuses if row["subject"] == "mutants"}
    rows = json.loads(call("export").stdout)
    assert counted["waiting"] == sum(row["situation"] == "T0O0W0D0H1" for row in rows) >= 2
    assert "invalid" not in counted
    assert "waiting for their baseline" in call("status").stdout


def test_status_says_why_flights_are_invalid(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    with closing(sqlite3.connect(tmp_path / "campaign" / STORE_NAME)) as connection:
        connection.execute("UPDATE outcomes SET invalid = 'no memory' WHERE mutant LIKE 'LATE%' AND seed = 0")
        connection.commit()
    (reason,) = json.loads(call("status", "--format", "json").stdout)["invalid"]
    assert (reason["why"], reason["flights"]) == ("no memory", 2)
    assert "no memory" in call("status").stdout
    told = call("score")
    assert "2 invalid flights, which say nothing" in told.stderr
    assert all("/0 (no memory)" in " ".join(stream.split()) for stream in (told.stdout, told.stderr))
    assert all("get a valid score" in call(verb).stdout for verb in ("score", "kills", "status"))


def test_first_screen_kills_and_status_say_the_same_next_step(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    with named_study(STUDY), snapshot(Study.open(STUDY), f"{tmp_path}/campaign") as now:
        step = now.next_step
    assert f"scaloft-fi run --study {STUDY} --campaign" in step
    for words in (("score",), ("score", "--all"), ("kills",), ("status",)):
        said = " ".join(call(*words).stdout.replace("\\\n", "\n").split())
        assert f"What next {step}" in said or f"What next: {step}" in said


def test_every_verb_that_shows_a_campaign_of_two_platforms_says_so(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    with Store(tmp_path / "campaign" / STORE_NAME) as store:
        assert "platform" not in call("status").stdout
        flights = [flight.key for flight in store.flights() if (flight.situation, flight.seed) == ("T0O0W0D0H1", 0)]
        rows = list(store.rows(flights))
        claim(store, [("T0O0W0D0H1", 0)], {**store.meta(), "machine": "PDP-11"})
        store.put_all(rows)
        whole = len(list(store.flights())) - len(flights)  # without those that were set apart
    mixture = f"{whole - len(rows)} flights of one platform and {len(rows)} of another (machine PDP-11, not "
    said = " ".join(call("status").stdout.split())
    assert mixture in said
    assert f"stale, not counted {len(rows)} " in said
    assert mixture in " ".join(call("score").stderr.split())
    assert mixture in " ".join(call("export", "--format", "sace").stdout.split())
    with snapshot(Study.open(STUDY), f"{tmp_path}/campaign") as now:
        assert now.platform["other platforms"].startswith(mixture)


class Cured(Paper):
    """The flyer whose drone obeys the speed limit in spite of a late person."""

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        flown = super().__call__(study, flight)
        if flight.subject.guideword != "LATE":
            return flown
        kinds = {requirement.name: requirement.kind for requirement in study.requirements}
        harmless = made(flown.subject, flown.situation, flown.seed, kinds, {}, digest=flown.digest)
        return replace(flown, readings=harmless.readings, violations=())


@pytest.fixture
def two(call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[str, str]:
    """A campaign in which LATE-human is detected, and one of a drone that it does not harm."""
    words = ("--mutant", "LATE-human", "--situation", "T?O?W0D0H1", "--seeds", "3", "--quiet", "--campaign")
    names = f"{tmp_path}/old", f"{tmp_path}/new"
    told_by(call("run", *words, names[0], campaign=False))
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", Cured)
    told_by(call("run", *words, names[1], campaign=False))
    return names


def test_a_lost_fault_is_told_as_text_and_data_and_fails_a_pipeline_that_asks(call: Call, two: tuple[str, str]):
    old, new = two
    text = told_by(call("compare", old, new, campaign=False))
    assert "LATE-human@3s" in text
    assert "1 lost, 0 gained, 0 unsure of 1 fault that both flew." in text
    told = of_form("compare", told_by(call("compare", old, new, "--format", "json", campaign=False)))
    assert (told["lost"], told["gained"], told["unsure"], told["flights"]) == ([M], [], [], None)
    assert told["agreement"] == {"same": {"part": 0, "whole": 1}, "kappa": 0.0}
    failed = call("compare", old, new, "--fail-on-lost", campaign=False)
    assert failed.exit_code == 3
    assert failed.stderr.endswith(f"lost: {M}\n")


def test_a_gained_fault_and_an_equal_campaign_fail_no_pipeline(call: Call, two: tuple[str, str]):
    old, new = two
    for names in ((new, old), (old, old)):
        assert call("compare", *names, "--fail-on-lost", campaign=False).exit_code == 0


def test_a_gate_that_could_never_fail_is_refused_and_the_comparison_says_of_how_many_faults(
    call: Call, two: tuple[str, str], tmp_path: Path
):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet", "--campaign", f"{tmp_path}/one")
    told_by(call("run", *words, campaign=False))  # one flight, by the drone that the fault does not harm
    names = two[0], f"{tmp_path}/one"
    told = of_form("compare", told_by(call("compare", *names, "--format", "json", campaign=False)))
    assert (told["unsure"], told["could_be_lost"]) == ([M], {"part": 0, "whole": 1})
    assert "1 of the 1 firm in old could not be called lost" in told_by(call("compare", *names, campaign=False))
    page = tmp_path / "both.html"
    refused = sentence(call("compare", *names, "--fail-on-lost", "--output", str(page), campaign=False))
    assert refused.startswith("error: --fail-on-lost could never fail here")
    assert not page.exists()


def test_no_gate_passes_beside_a_campaign_whose_own_gate_failed(call: Call, two: tuple[str, str]):
    with closing(sqlite3.connect(Path(two[1]) / STORE_NAME)) as connection:
        connection.execute("UPDATE outcomes SET digest = 'other' WHERE mutant = 'PLACEBO'")
        connection.commit()
    failed = call("compare", two[0], two[1], "--fail-on-lost", campaign=False)
    assert failed.exit_code == 4
    assert "no score is valid: gate failed: PLACEBO differs from the baseline" in failed.stderr


def test_the_page_has_both_matrices_with_a_sign_for_each_verdict_and_fetches_nothing(
    call: Call, two: tuple[str, str], tmp_path: Path
):
    told_by(call("compare", *two, "--output", f"{tmp_path}/both.html", campaign=False))
    page = (tmp_path / "both.html").read_text()
    assert page.count("<table>") == 2
    assert f'aria-label="{M}: detected, firm; lost">&#9679;<' in page
    assert f'aria-label="{M}: not detected; lost">&#8211;<' in page
    assert "http" not in page
    assert "<script" not in page
    refused = call("compare", *two, "--output", f"{tmp_path}/both.pdf", campaign=False)
    assert refused.exit_code == 2
    assert ".html" in refused.stderr


def test_campaigns_of_two_studies_are_compared_each_with_its_own(call: Call, two: tuple[str, str], tmp_path: Path):
    second = copied(tmp_path / "b", "found.yaml")
    (second / "sim" / "world.yaml").write_text(
        (second / "sim" / "world.yaml").read_text().replace("cruise_mps: 0.5", "cruise_mps: 0.6")
    )
    words = ("--mutant", "LATE-human", "--situation", "T?O?W0D0H1", "--seeds", "3", "--quiet", "--campaign", "b")
    told_by(call("run", *words, study=second, campaign=False))
    named = str(second / "results" / "campaigns" / "b")
    told = of_form("compare", told_by(call("compare", two[0], named, "--format", "json", campaign=False)))
    assert (told["lost"], told["redefined"]) == ([M], [])
    requirements = second / "sim" / "requirements.yaml"
    requirements.write_text(requirements.read_text().replace("speed_mps / 0.25", "speed_mps / 0.35"))
    done = call("compare", two[0], named, "--format", "json", campaign=False)
    assert of_form("compare", told_by(done))["redefined"] == ["SR2", "SR2-literal"]
    assert "the two studies define SR2 otherwise: formula" in done.stderr


def test_a_fault_that_two_studies_define_otherwise_is_compared_in_no_list(
    call: Call, two: tuple[str, str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("scaloft_fi.verbs.campaigns._redefined", lambda *_: {M})
    done = call("compare", *two, "--flights", "--format", "json", campaign=False)
    told = of_form("compare", told_by(done))
    assert (told["flights"]["differences"], told["mutants"], told["only_first"]) == ([], [], [])
    assert f"not compared: {M}" in done.stderr


def test_a_bare_name_beside_a_path_is_a_campaign_of_the_study_here(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    words = ("--situation", "T0O0W0D0H1", "--quiet", "--campaign", "night")
    there, here = copied(tmp_path / "a", "found.yaml"), copied(tmp_path / "b", "found.yaml")
    told_by(call("run", "--mutant", "LATE-human", *words, study=there, campaign=False))
    told_by(call("run", "--mutant", "NO-human", *words, study=here, campaign=False))
    monkeypatch.chdir(here)
    told = of_form("compare", told_by(invoked("compare", "../a/results/campaigns/night", "night", "--format", "json")))
    assert (told["only_first"], told["only_second"]) == ([M], ["NO-human@100%"])


def test_a_campaign_that_a_change_made_stale_is_compared_as_it_was_flown(
    call: Call, tmp_path: Path, two: tuple[str, str]
):
    changed = copied(tmp_path / "changed", "found.yaml")
    world = changed / "sim" / "world.yaml"
    world.write_text(world.read_text().replace("cruise_mps: 0.5", "cruise_mps: 0.6"))
    done = call("compare", *two, "--format", "json", study=changed, campaign=False)
    assert of_form("compare", told_by(done))["lost"] == [M]
    assert done.stderr.count("no flight is of the study as it is now, so all are compared as they were flown") == 2


def test_campaigns_without_a_common_situation_are_not_compared(call: Call, two: tuple[str, str], tmp_path: Path):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H0", "--quiet", "--campaign", f"{tmp_path}/apart")
    told_by(call("run", *words, campaign=False))
    assert "share no situation that both flew" in sentence(call("compare", two[0], f"{tmp_path}/apart", campaign=False))
    told_by(call("compare", two[0], f"{tmp_path}/apart", "--flights", campaign=False))


def test_only_campaigns_of_one_grid_are_compared(call: Call, two: tuple[str, str], tmp_path: Path):
    wide = ("--grid", "wide", "--choose", "first:1", "--mutant", "LATE-human", "--quiet", "--campaign", f"{tmp_path}/w")
    told_by(call("run", *wide, campaign=False))
    refused = call("compare", two[0], f"{tmp_path}/w", campaign=False)
    assert "only campaigns of one grid have the same situations" in sentence(refused)


def test_with_flights_the_flights_that_differ_are_listed_and_the_old_verb_names_the_new_one(
    call: Call, two: tuple[str, str]
):
    old, new = two
    told = of_form("compare", told_by(call("compare", old, new, "--flights", "--format", "json", campaign=False)))
    assert {one["mutant"] for one in told["flights"]["differences"]} == {M}
    assert "0 differ" in told_by(call("compare", old, old, "--flights", campaign=False)).replace("\n", " ")
    diff = call("diff", old, new, campaign=False)
    assert diff.stdout == told_by(call("compare", old, new, "--flights", campaign=False))
    assert "`compare --flights`" in diff.stderr


M = "LATE-human@3s"


def _compare(first: list[Outcome], second: list[Outcome]) -> FlightDifferences:
    return differences_of(("old", "new"), first, second, ROSTER, GRID)


def test_another_status_is_a_difference():
    compared = _compare([outcome(), outcome(M, violated={"SR2": 5.0})], [outcome(), outcome(M)])
    assert compared.same == 1
    first, second = Facts("revealed", "landed", ("SR2",)), Facts("survived", "landed", ())
    assert compared.differences == (Difference(M, "T0O0W0D0H0", 0, first, second),)


def test_another_ending_is_a_difference():
    (difference,) = _compare([outcome()], [replace(outcome(), ending="struck")]).differences
    assert (str(difference.first), str(difference.second)) == ("held, landed", "held, struck")


def test_other_bits_with_the_same_status_are_only_counted():
    compared = _compare([outcome(), outcome(M, digest="a")], [outcome(), outcome(M, digest="b")])
    assert (compared.same, compared.other_bits, compared.differences) == (1, 1, ())


def test_a_flight_that_one_of_them_lacks_is_a_difference():
    compared = _compare([outcome(), outcome(M)], [outcome()])
    (difference,) = compared.differences
    assert (difference.mutant, difference.second) == (M, None)
    assert "0 differ, and 1 are in one campaign alone" in differences_table(compared).notes[0]


def test_the_table_names_both_campaigns():
    compared = _compare([outcome(), outcome(M, violated={"SR2": 5.0})], [outcome(), outcome(M)])
    table = differences_table(compared)
    assert table.headers[3:] == ("old", "new")
    assert table.rows == ((M, "T0O0W0D0H0", 0, "revealed SR2, landed", "survived, landed"),)
    assert "1 flights are the same bit for bit" in table.notes[0]


@given(campaigns())
def test_a_campaign_does_not_differ_from_itself(outcomes: list[Outcome]):
    once = list({outcome.name: outcome for outcome in outcomes}.values())
    assert _compare(once, once[::-1]) == FlightDifferences("old", "new", len(once), 0, ())


NAME = "outcomes.sqlite"
FIXED = (("status",), ("report", "--output", "OUT"))
"""These read every table."""
OTHERS = commands(
    "score --all; score --format json; kills; kills --format json --show survivors; coverage; "
    "compare CRAFTED GOOD; compare GOOD CRAFTED --flights; export; export --format junit; "
    "export --format parquet --output OUT; worksheet --format csv; dispositions; matrix --margins; "
    "score --baseline-from CRAFTED"
)
turn = count()


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("good")
    campaign(Study.open(STUDY), folder / NAME)
    return folder


@pytest.fixture
def read(good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Call a verb on the campaign in the folder `crafted`; the study is read once."""
    study = _study()
    monkeypatch.setattr(Study, "open", lambda _folder=None: study)
    (tmp_path / "crafted").mkdir()
    shutil.copy(good / NAME, tmp_path / "crafted" / NAME)
    names = {"CRAFTED": f"{tmp_path}/crafted", "GOOD": str(good), "OUT": f"{tmp_path}/out"}

    def calling(*words: str) -> Result:
        told = [names.get(word, word) for word in words]
        where = () if words[0] == "compare" else ("--campaign", f"{tmp_path}/crafted")
        return invoked(*told, "--study", str(STUDY), *where)

    return calling


@cache
def _study() -> Study:
    return Study.open(STUDY)


def _content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def _ends_well(result: Result, path: Path) -> bool:
    """Whether the verb has read the store; otherwise it has refused it with one sentence that names the file."""
    if result.exit_code == 0:
        return True
    assert result.exit_code == 2, result.output
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("error: ")
    return str(path) not in line  # a sentence about the campaign, such as that it has no pool


@pytest.mark.parametrize("store", [*crafted()], ids=lambda store: store.name)
def test_a_crafted_store_is_read_or_refused_with_a_sentence_and_left_alone(read: Call, tmp_path: Path, store: Crafted):
    path = tmp_path / "crafted" / NAME
    store.make(path)
    before = _content(path.parent)
    for words in (FIXED[next(turn) % 2], OTHERS[next(turn) % len(OTHERS)]):
        _ends_well(read(*words), path)
    if store.says:
        result = read(*store.by)
        assert result.exit_code == 2, result.output
        assert all(part in result.stderr for part in (str(path), *store.says.split("|"))), result.stderr
        assert len(result.stderr) < 500
    assert _content(path.parent) == before


@pytest.mark.parametrize("words", [*FIXED, *OTHERS], ids=" ".join)
def test_a_verb_that_reads_changes_nothing_and_creates_nothing(read: Call, tmp_path: Path, words: tuple[str, ...]):
    folder = tmp_path / "crafted"
    before = _content(folder)
    assert read(*words).exit_code == 0
    assert _content(folder) == before
    (folder / NAME).write_bytes(b"")
    assert read(*words).exit_code == 2
    assert _content(folder) == {NAME: b""}
    shutil.rmtree(folder)
    assert "no campaign was flown here" in sentence(read(*words))
    assert not folder.exists()
    assert {path.name for path in tmp_path.iterdir()} <= {"out"}


def test_a_table_with_too_many_rows_is_refused_and_the_limit_can_be_raised(
    read: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv(MOST_FLIGHTS, "30")
    twelve = "WITH RECURSIVE r (n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r LIMIT 12)"
    columns = "key || n, mutant, situation, seed, canary, origin"
    assert read("status").exit_code == 0
    sql(f"{twelve} INSERT INTO plan SELECT {columns} FROM plan, r {ONE}")(tmp_path / "crafted" / NAME)
    result = read("status")
    assert result.exit_code == 2
    assert (
        f"table plan has more rows than the limit for 30 flights; the environment variable {MOST_FLIGHTS}"
        in result.stderr
    )
    assert read("score").exit_code == 0
    for most, code in (("10", 2), ("31", 0), ("0", 2), ("many", 2)):
        monkeypatch.setenv(MOST_FLIGHTS, most)
        assert read("status").exit_code == code
