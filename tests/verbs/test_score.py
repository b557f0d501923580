"""The score: what it counts, its tables, the bars of its exit code."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest
from builders import CLASSED, GRID, ROSTER, campaigns, outcome, pool, seeded
from hypothesis import given, settings
from hypothesis import strategies as st
from options import cases
from paper_flyer import Paper
from papers import flight
from printed import STUDY, Call, invoked, sentence
from studies import edit_in

from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.detection import Spending, findings, tallies
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import By, groups, score, score_of
from scaloft_fi.analysis.survivor import Disposition, Judged, Standing
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import remember_differed
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.output import PIPED
from scaloft_fi.study import Study
from scaloft_fi.verbs.first_screen import MANY_ROWS, tables_behind
from scaloft_fi.verbs.score import complaint, shown_so_far
from scaloft_fi.views.table import Format, Table, render

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN = ["T0O0W0D0H1", "T0O1W0D0H1", "T1O0W0D0H1"]
NOBODY, DARK = "T0O0W0D0H0", "T1O0W0D1H0"
CAMPAIGN = [
    *pool(*HUMAN),
    *pool(NOBODY, vacuous=("SR2",)),
    *pool(DARK, red=9, violated={"SR1": 30.0}, struck="bar"),
    outcome(PLACEBO_ID, HUMAN[0], altered=0),
    *(outcome(LATE, key, violated={"SR2": 12.35}) for key in HUMAN),
    outcome(LATE, NOBODY, carried=0, altered=0),
    *(outcome(NO, key, violated={"SR1": 14.0}, struck="person") for key in HUMAN),
    *(outcome(GOAL, key) for key in HUMAN),
    outcome(GOAL, DARK, violated={"SR1": 20.0}, struck="wall"),
]


def tables(outcomes: list[Outcome], by: By | None = None) -> dict[str, Table]:
    rulings, scored = rulings_of(outcomes), score(outcomes, ROSTER, GRID)
    found = tables_behind(scored, rulings, coverage(outcomes, GRID), GRID, by)
    return {table.title: table for table in found}


def test_the_pairs_that_put_no_fault_to_the_test_say_why():
    table = tables(CAMPAIGN)["Pairs that put no fault to the test"]
    assert [row[:4] for row in table.rows] == [
        (NOBODY, "SR2", "vacuous", "0/10"),
        (DARK, "OP1", "open", "0/10"),
        (DARK, "SR1", "red", "9/10"),
        (DARK, "SR2", "open", "0/10"),
    ]


def test_of_many_mutants_the_stages_are_summed_by_parameter():
    ids = [f"LATE-{parameter}@{n}s" for parameter in ("human", "depth") for n in range(MANY_ROWS)]
    flown = [outcome(), outcome(PLACEBO_ID, altered=0), *(outcome(id_) for id_ in ids)]
    table = tables(flown)["Where the faults stopped (flights)"]
    assert [(row[0], row[-1]) for row in table.rows] == [
        (PLACEBO_ID, 1),
        ("human", MANY_ROWS),
        ("depth", MANY_ROWS),
        ("all", 49),
    ]


@pytest.mark.parametrize("by", [None, *By])
@settings(deadline=None, max_examples=15)
@given(outcomes=st.one_of(campaigns(), seeded()))
def test_every_table_of_every_campaign_fits_a_terminal(by: By | None, outcomes: list[Outcome]):
    text = render(list(tables(outcomes, by).values()), Format.TABLE)
    assert max(len(line) for line in text.splitlines()) <= PIPED


def test_a_table_too_wide_narrows_the_column_that_costs_the_fewest_lines():
    """Each row has four words of text; only the last has a long list, which is what wraps."""
    rows = tuple((f"row {n}", "w" * 40, "four words of text", "a, " * (20 if n == 9 else 3)) for n in range(10))
    lines = render([Table("T", ("name", "word", "text", "list"), rows)], Format.TABLE).splitlines()
    assert max(map(len, lines)) <= PIPED
    assert sum("four words of text" in line for line in lines) == 10
    assert len(lines) < 4 + 10 + 4


def parts(by: By) -> dict[str, tuple[Ratio, Ratio]]:
    found = score(CAMPAIGN, ROSTER, GRID)
    return {group.name: (group.tested, group.flown) for group in groups(found, by, GRID)}


def test_the_score_by_guideword_and_by_parameter_is_of_detected_mutants():
    assert parts(By.GUIDEWORD) == {
        "NO": (Ratio(1, 1), Ratio(1, 1)),
        "LATE": (Ratio(1, 1), Ratio(1, 1)),
        "MORE": (Ratio(0, 1), Ratio(0, 1)),
    }
    assert parts(By.PARAMETER) == {"human": (Ratio(2, 2), Ratio(2, 2)), "goal": (Ratio(0, 1), Ratio(0, 1))}


def test_the_score_by_requirement_counts_a_mutant_for_each_that_detects_it():
    found = {name: ratio for name, (ratio, _) in parts(By.REQUIREMENT).items()}
    assert found == {"SR1": Ratio(1, 3), "SR2": Ratio(1, 3), "OP1": Ratio(0, 3)}


def test_the_score_by_situation_and_by_axis_is_of_kills():
    found = parts(By.SITUATION)
    assert found[HUMAN[0]] == (Ratio(2, 3), Ratio(2, 3))
    assert found[DARK] == (Ratio(0, 0), Ratio(0, 1))
    axis = parts(By.AXIS)
    assert len(axis) == 10
    assert axis["H = human"] == (Ratio(6, 9), Ratio(6, 9))
    assert axis["H = nobody"] == (Ratio(0, 0), Ratio(0, 2))


def test_the_score_by_severity_has_the_worst_class_first_and_what_has_no_class_last():
    found = groups(score(CAMPAIGN, CLASSED, GRID), By.SEVERITY, GRID)
    assert [(group.name, group.tested) for group in found] == [
        ("injury", Ratio(0, 1)),
        ("delay", Ratio(1, 1)),
        ("no class", Ratio(1, 1)),
    ]


@given(st.one_of(campaigns(), seeded()))
@settings(deadline=None, max_examples=20)
def test_severity_enters_no_ratio_and_no_verdict(outcomes: list[Outcome]):
    plain, classed = score(outcomes, ROSTER, GRID), score(outcomes, CLASSED, GRID)
    assert [replace(mutant, severity=None) for mutant in classed.mutants] == list(plain.mutants)
    bare = {"mutants": (), "counted": (), "controls": (), "placebo": None}
    assert replace(classed, **bare) == replace(plain, **bare)


@given(st.one_of(campaigns(), seeded()), st.sampled_from([By.GUIDEWORD, By.PARAMETER, By.SEVERITY]))
@settings(deadline=None)
def test_the_parts_of_the_score_sum_to_the_score(outcomes: list[Outcome], by: By):
    found = score(outcomes, CLASSED, GRID)
    listed = groups(found, by, GRID)
    assert sum(group.tested.part for group in listed) == found.mutation_score.part
    assert sum(group.tested.whole for group in listed) == found.tested.part
    assert sum(group.flown.whole for group in listed) == found.tested.whole


def test_the_baselines_findings_name_the_first_violation_and_what_stayed_open():
    flown = [
        outcome(BASELINE, DARK, 0, violated={"SR1": 30.0}, struck="bar"),
        outcome(BASELINE, DARK, 1, violated={"SR1": 28.0}, struck="bar"),
        outcome(BASELINE, DARK, 2),
    ]
    (dark,) = findings(flown, GRID)
    assert (dark.situation, dark.flown, dark.red, dark.violated) == (DARK, 3, 2, ("SR1",))
    assert dark.open == ("SR2", "SR2-literal", "OP1")
    assert (dark.first[0].t_s, dark.first[1]) == (28.0, 1)


def test_each_requirement_is_tallied_over_the_baseline_flights():
    clean = [outcome(), outcome(BASELINE, DARK, violated={"SR1": 30.0}, struck="bar")]
    first, *_, last = tallies(clean)
    assert (first.requirement, dict(first.compliances), first.least_rho) == (
        "SR1",
        {"violated": 1, "open": 0, "vacuous": 0, "held": 1},
        -0.1,
    )
    assert (last.requirement, dict(last.compliances)["open"], last.triggered) == ("OP1", 1, 2)


@given(campaigns())
def test_the_verdicts_on_a_requirement_sum_to_the_baseline_flights(outcomes: list[Outcome]):
    baselines = sum(o.mutant == BASELINE and not o.invalid for o in outcomes)
    assert all(sum(count for _, count in tally.compliances) == baselines for tally in tallies(outcomes))


def test_score_prints_what_the_run_printed_again(call: Call):
    flown = call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    assert call("score").stdout == flown.stdout


class Hovers(Paper):
    """The flyer whose drone never lands."""

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        return replace(super().__call__(study, flight), ending="timed_out")


def test_that_the_unmutated_drone_lands_in_no_flight_is_said(call: Call, monkeypatch: pytest.MonkeyPatch):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    assert "lands in none" not in call("run", *words).stderr
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", Hovers)
    told = call("run", *words, "--campaign", "./other/c", campaign=False)
    assert "the unmutated drone lands in none of its 10 flights" in told.stderr


def test_below_the_asked_score_the_exit_code_is_3(call: Call):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    assert call("run", *words, "--seeds", "3", "--fail-under", "1").exit_code == 0
    call("run", "--mutant", "MORE-goal", "--situation", "T0O0W0D0H0", "--quiet")
    empty = ("--campaign", "./other/c")
    below = call("run", "--mutant", "MORE-goal", "--quiet", "--fail-under", "0.1", *empty, campaign=False)
    assert below.exit_code == 3
    assert "below --fail-under 0.1" in below.stderr


def test_after_a_failed_gate_no_screen_and_no_export_passes_for_a_valid_score(call: Call, tmp_path: Path):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--seeds", "3", "--quiet")
    assert call("run", *words, "--max-invalid", "0.9").exit_code == 0
    assert call("score", "--fail-under", "1").exit_code == 0
    with closing(sqlite3.connect(tmp_path / "campaign" / STORE_NAME)) as connection:
        connection.execute("UPDATE outcomes SET digest = 'other' WHERE mutant = 'PLACEBO' AND seed = 0")
        connection.commit()
    said = "no score is valid: gate failed: PLACEBO differs from the baseline: PLACEBO/T0O0W0D0H1/0"
    for option in (("--fail-under", "0"), ("--ratchet",)):
        failed = call("score", *option)
        assert (failed.exit_code, f"{option[0]}: {said}" in failed.stderr) == (4, True)
    assert said in call("score").stderr
    assert json.loads(call("score", "--format", "json").stdout)["stale"]["invalid"] == [said]
    for words in (("dispositions",), ("matrix", "--margins"), ("export", "--format", "csv"), ("status",), ("propose",)):
        assert f"warning: {said}" in call(*words).stderr
    for style in ("markdown", "gsn", "sace", "junit", "sarif"):
        assert said[1:] in " ".join(call("export", "--format", style).stdout.split())
    with Store(tmp_path / "campaign" / STORE_NAME) as store:
        (repeated,) = (one for one in store.outcomes() if one.name == "baseline/T0O0W0D0H1/1")
        remember_differed(store, "key of then", repeated)
    call("export", "--format", "archive", "--output", f"{tmp_path}/c.zip")
    failed = call("score", "--fail-under", "0", "--campaign", f"{tmp_path}/c.zip", campaign=False)
    assert failed.exit_code == 4
    assert f"{said}; a repeated flight differs from the first: {repeated.name}" in failed.stderr


def test_a_mutant_with_too_few_seeds_counts_for_the_bar_of_detected_mutants_and_not_for_that_of_firm_ones(call: Call):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--seeds", "3", "--quiet")
    assert call("score", "--fail-under", "1").exit_code == 0
    below = call("score", "--fail-under", "1", "--fail-under-firm", "0.1")
    assert below.exit_code == 3
    assert "mutation score 1/1 = 100 %, firm 0/1 = 0 %: below --fail-under-firm 0.1" in below.stderr


def test_a_campaign_without_a_flight_that_counts_has_no_score(call: Call, tmp_path: Path, copy: Path):
    assert f"no campaign was flown here; `scaloft-fi run --study {STUDY}` flies one" in sentence(call("score"))
    assert list(tmp_path.iterdir()) == [copy]
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    assert call("run", *words, study=copy).exit_code == 0
    edit_in(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.8")
    assert "flights are stale" in sentence(call("score", study=copy))


def test_the_score_is_told_with_and_without_accepted_survivors(call: Call, copy: Path):
    call("run", "--mutant", "LATE-human", "--mutant", "MORE-human", "--situation", "T0O0W0D0H?", "--quiet", study=copy)
    before = json.loads(call("score", "--format", "json", study=copy).stdout)
    survivors = [one["id"] for one in before["mutants"] if one["verdict"] in ("not_detected", "undecided")]
    assert before["accepted"] == []
    assert before["ratios"]["without_accepted"] == before["ratios"]["mutation_score"]
    assert "Accepted" not in call("score", study=copy).stdout
    known = f"{survivors[0]}: {{status: accepted, owner: A. Owner, reason: known, expires: 2027-01-31}}\n"
    (copy / "hazop" / "dispositions.yaml").write_text(known)
    days = {"2027-01-31": 1, "2027-02-01": 0}
    for day, accepted in days.items():
        told = json.loads(call("score", "--format", "json", "--today", day, study=copy).stdout)
        assert [one["mutant"] for one in told["accepted"]] == survivors[:accepted]
        assert told["ratios"]["mutation_score"] == before["ratios"]["mutation_score"]
        whole = told["ratios"]["mutation_score"]["whole"] - accepted
        assert told["ratios"]["without_accepted"] == told["ratios"]["mutation_score"] | {"whole": whole}
    said = " ".join(call("score", "--today", "2027-01-31", study=copy).stdout.split())
    assert "(by A. Owner). Shown: " in said


@pytest.fixture(scope="module")
def outcomes(study: Study) -> list[Outcome]:
    pool = [flight(study, BASELINE, key, seed) for key in HUMAN for seed in range(10)]
    return pool + [flight(study, id_, key, 0) for id_ in ("LATE-human@3s", "MORE-goal@0.6m") for key in HUMAN]


def test_it_counts_what_the_score_detects_of_what_is_stored_and_shows_the_sign_of_each_cell(
    study: Study, outcomes: list[Outcome]
):
    scored = score_of(rulings_of(outcomes), study.roster, study.space, Spending())
    assert [mutant.subject.id for mutant in scored.counted if mutant.detected] == ["LATE-human@3s"]
    lines = ["shown so far: 1 of 2 flown", "      MORE LATE", "human      ●", "goal  –"]  # noqa: RUF001
    assert shown_so_far(study, outcomes, Spending()) == lines
    assert shown_so_far(study, outcomes[:30], Spending()) == []


FLOWN = ("--situation", "T0O0W0D0H*", "--seeds", "3", "--jobs", "1", "--quiet")


class Mild(Paper):
    """LATE-human is detected, MORE-goal survives in two situations, NO-goal changes nothing."""

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        outcome = super().__call__(study, flight)
        mild = flight.subject.guideword == "MORE"
        return replace(outcome, altered=3, infected_at_s=1.0, digest=flight.name) if mild else outcome


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dispositions") / "campaign"
    words = ("--mutant", "LATE-human", "--mutant", "MORE-goal", "--mutant", "NO-goal", "--campaign", str(folder))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scaloft_fi.campaign.flights.physics.Physics", Mild)
        assert invoked("run", *words, *FLOWN, "--study", str(STUDY)).exit_code == 0
    return folder


@pytest.fixture
def flown(campaign: Path, copy: Path, tmp_path: Path) -> Path:
    """A study of one's own with that campaign."""
    shutil.copytree(campaign, tmp_path / "campaign")
    return copy


def accept(study: Path, mutant: str, expires: str = "2099-01-01", more: str = "") -> None:
    path = study / "hazop" / "dispositions.yaml"
    entry = f"{mutant}: {{status: accepted, owner: me, reason: why, expires: {expires}{more}}}\n"
    path.write_text((path.read_text() if path.exists() else "") + entry)


def states(call: Call, study: Path, *words: str) -> dict[str, str]:
    told = json.loads(call("dispositions", "--format", "json", *words, study=study).stdout)
    return {row["mutant"]: row["state"] for row in told["survivors"]}


def test_survivors_stand_beside_what_was_accepted(call: Call, flown: Path):
    assert states(call, flown) == {"MORE-goal@0.6m": "open"}
    accept(flown, "MORE-goal")
    accept(flown, "LATE-human")
    assert states(call, flown) == {"MORE-goal@0.6m": "accepted", "LATE-human@3s": "stale"}
    assert states(call, flown, "--today", "2099-01-02") == {"MORE-goal@0.6m": "expired", "LATE-human@3s": "stale"}


def test_what_is_written_stays_open_until_somebody_has_decided(call: Call, flown: Path):
    path = flown / "hazop" / "dispositions.yaml"
    done = call("dispositions", "--write", study=flown)
    assert done.exit_code == 0
    assert "1 survivor to decide on" in done.stderr
    assert states(call, flown) == {"MORE-goal@0.6m": "open"}
    written = path.read_text()
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert path.read_text() == written
    path.write_text(written.replace("status: to_do  #", "status: accepted  #"))
    refused = call("dispositions", study=flown)
    assert refused.exit_code == 2
    assert "lacks the key 'owner'" in refused.stderr
    accepted = "status: accepted\n  owner: me\n  reason: why\n  expires: 2099-01-01  #"
    path.write_text(written.replace("status: to_do  #", accepted))
    assert states(call, flown) == {"MORE-goal@0.6m": "accepted"}


def test_writing_keeps_what_stands_there_with_its_comments(call: Call, flown: Path):
    accept(flown, "LATE-human")
    path = flown / "hazop" / "dispositions.yaml"
    path.write_text("# mine\n" + path.read_text())
    before = path.read_text()
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert path.read_text().startswith(before)
    assert "\nMORE-goal@0.6m:\n" in path.read_text()


def test_the_study_works_beside_survivors_that_nobody_has_decided_on(call: Call, flown: Path):
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert call("run", "--mutant", "LATE-human", *FLOWN, study=flown).exit_code == 0
    assert call("score", study=flown).exit_code == 0
    assert call("score", "--ratchet", study=flown).exit_code == 3


@cases("accepted", "more", "words", "code", "said")
def test_the_ratchet_fails_on_a_survivor_that_nobody_accepts_today(
    call: Call, flown: Path, accepted: tuple[str, ...], more: str, words: tuple[str, ...], code: int, said: str
):
    for mutant in accepted:
        accept(flown, mutant, more=more)
    done = call("score", "--ratchet", *words, study=flown)
    assert done.exit_code == code
    assert said in done.stderr
    assert "by safety requirements" in done.stdout
    assert ("ratchet: " in done.stderr) == (code == 3 and "--fail-under" not in words)


def test_a_campaign_in_which_nothing_was_tested_passes_no_ratchet(call: Call, flown: Path):
    words = ("--campaign", f"{flown}/other", "--study", str(flown))
    assert call("run", "--mutant", "NO-goal", *FLOWN, *words, campaign=False).exit_code == 0
    done = call("score", "--ratchet", *words, campaign=False)
    assert done.exit_code == 3
    assert "nothing to hold" in done.stderr


def test_an_undecided_mutant_is_a_survivor_whose_verdict_is_told(call: Call, flown: Path):
    words = ("--campaign", f"{flown}/other", "--study", str(flown))
    once = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--jobs", "1", "--quiet", "--baseline-seeds", "10")
    assert call("run", *once, *words, campaign=False).exit_code == 0
    done = call("score", "--ratchet", *words, campaign=False)
    assert done.exit_code == 3
    assert "ratchet: LATE-human@3s is undecided (tested in T0O0W0D0H1) and not accepted" in done.stderr
    told = json.loads(call("dispositions", "--format", "json", *words, campaign=False).stdout)
    assert [(row["mutant"], row["state"], row["verdict"]) for row in told["survivors"]] == [
        ("LATE-human@3s", "open", "undecided")
    ]


@pytest.mark.parametrize("verb", [("score", "--ratchet"), ("dispositions",), ("dispositions", "--write")])
def test_without_a_pool_it_is_refused_and_the_command_is_named_that_flies_one(
    call: Call, flown: Path, verb: tuple[str, ...]
):
    words = ("--campaign", f"{flown}/other", "--study", str(flown))
    assert call("run", "--mutant", "LATE-human", *FLOWN, "--baseline-seeds", "1", *words, campaign=False).exit_code == 0
    done = call(*verb, *words, campaign=False)
    assert done.exit_code == 2
    (line,) = done.stderr.strip().splitlines()
    assert line.startswith(
        "error: no mutant is known to survive: no situation in which a mutant changes a sample has 10"
    )
    assert f"`scaloft-fi run --study {STUDY}` with the same mutants flies them" in line
    assert not (flown / "hazop" / "dispositions.yaml").exists()


def test_every_sentence_names_the_mutant_and_what_to_do():
    known = Disposition("LATE-human@3s", "me", "why", date(2027, 1, 31), ("D0",), "f.yaml:3")
    for state in Standing:
        judged = Judged("LATE-human@3s", state, ("D0", "D1"), None if state is Standing.OPEN else known)
        assert "LATE-human@3s" in complaint(judged)
        assert state is Standing.OPEN or "f.yaml:3" in complaint(judged)
