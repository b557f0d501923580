"""Where mutants are killed: tables of kills, and the verb."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from builders import GRID, ROSTER, outcome, pool, seeded, thrice
from click.testing import Result
from hypothesis import given, settings
from paper_flyer import Paper
from printed import STUDY, Call, invoked, one_table, sentence
from processes import ROOT

from scaloft_fi.analysis import kill_matrix
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import backgrounds
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.output import PIPED
from scaloft_fi.study import Study
from scaloft_fi.verbs import kills
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.verbs.verdict import short_units, survivors
from scaloft_fi.views.table import Format, Table, render

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T0O0W0D1H0"


def matrix_of(outcomes: list[Outcome]) -> kill_matrix.KillMatrix:
    return kill_matrix.kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID)


def all_tables(outcomes: list[Outcome]) -> list[Table]:
    matrix = matrix_of(outcomes)
    found, graph, situations = (
        kill_matrix.interactions(matrix),
        kill_matrix.subsumption(matrix.kills),
        kill_matrix.situation_kills(matrix),
    )
    suite = kill_matrix.minimal_suite(matrix.kills, matrix.flown)
    return [
        kills.interaction_table(found),
        kills.order_table(kill_matrix.orders(found, GRID)),
        *(kills.situation_table(situations, GRID, short=short) for short in (True, False)),
        kills.suite_table(suite, matrix),
        *(kills.subsumption_table(graph, short=short) for short in (True, False)),
        kills.redundancy_table(kill_matrix.redundancies(graph)),
        kills.chosen_table(kill_matrix.chosen_kills(matrix, [HUMAN, DARK])),
    ]


KILLS = {(LATE, HUMAN), (NO, HUMAN), (NO, DARK), (GOAL, NOBODY)}
CAMPAIGN = [
    *pool(HUMAN, NOBODY, DARK),
    *(
        flight
        for mutant in (LATE, NO, GOAL)
        for key in (HUMAN, NOBODY, DARK)
        for flight in thrice(mutant, key, violated={"SR2": 9.0} if (mutant, key) in KILLS else {})
    ),
    *pool("T1O0W0D1H0", red=10, violated={"SR1": 30.0}, struck="bar"),
    outcome(LATE, "T1O0W0D1H0"),
]


def test_a_situation_tells_what_it_alone_kills():
    rows = {entry.situation: entry for entry in kill_matrix.situation_kills(matrix_of(CAMPAIGN))}
    assert rows[HUMAN].killed == (NO, LATE)
    assert rows[HUMAN].alone == (LATE,)
    assert rows[DARK].alone == ()
    assert (rows[HUMAN].tested, rows["T1O0W0D1H0"].tested) == (3, 0)
    # LATE and MORE-goal are the minimal ones
    assert [str(rows[key].minimal) for key in (HUMAN, DARK)] == ["1/2 = 50 %", "0/2 = 0 %"]


def test_some_situations_are_scored_with_and_without_redundant_mutants():
    found = kill_matrix.chosen_kills(matrix_of(CAMPAIGN), [HUMAN, DARK])
    assert (str(found.killed), str(found.dominator_score)) == ("2/3 = 67 %", "1/2 = 50 %")
    assert found.lost == (GOAL,)
    whole = kill_matrix.chosen_kills(matrix_of(CAMPAIGN), GRID.point)
    assert (whole.killed.value, whole.dominator_score.value, whole.lost) == (1.0, 1.0, ())


def test_the_first_table_names_what_is_detected_without_a_kill():
    keys = [key for key, _ in GRID.points[:8]]
    spread = [outcome(LATE, key, 1, violated={"SR2": 9.0}) for key in keys]
    calm = [outcome(LATE, key, seed) for key in keys for seed in (0, 2)]
    matrix = matrix_of([*pool(*keys), *spread, *calm])
    shown = kills.with_detected([kills.interaction_table(kill_matrix.interactions(matrix))] * 2, matrix)
    assert f"Detected without a kill, so in no table of kills: {LATE}." in shown[0].notes[-1]
    assert shown[1].notes == kills.interaction_table(()).notes
    assert (
        f"Detected mutants: 1, of them 0 firmly: whichever one seed is left out.  Not firm: {LATE}." in shown[0].notes
    )
    assert kills.with_detected([], matrix) == []
    assert not any("without a kill" in note for note in kills.with_detected(shown[1:], matrix_of(CAMPAIGN))[0].notes)


def test_a_greedy_suite_says_at_most():
    matrix = matrix_of(CAMPAIGN)
    suite = kill_matrix.minimal_suite(matrix.kills, matrix.flown, most_entries=0)
    assert "at most 2;" in render([kills.suite_table(suite, matrix)], Format.TABLE)


@settings(deadline=None, max_examples=12)
@given(seeded())
def test_every_table_of_every_campaign_fits_a_terminal_and_every_node_is_listed_once(outcomes: list[Outcome]):
    text = render(all_tables(outcomes), Format.TABLE)
    assert max(len(line) for line in text.splitlines()) <= PIPED
    graph = kill_matrix.subsumption(matrix_of(outcomes).kills)
    listed = [str(row[0]).replace("> ", "") for row in kills.subsumption_table(graph).rows]
    assert sorted(listed) == sorted(", ".join(node.mutants) for node in graph.nodes)


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Call:
    """A verb on a campaign of LATE-human, which the paper flyer lets violate SR2 where a person is, and a survivor."""
    where = ("--study", str(STUDY), "--campaign", f"{tmp_path_factory.mktemp('kills')}/campaign")

    def telling(*words: str) -> Result:
        return invoked(*words, *where)

    words = ("--mutant", "LATE-human", "--mutant", "EARLY-human", "--situation", "T0O?W0D0H?", "--seeds", "3")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scaloft_fi.campaign.flights.physics.Physics", Paper)
        assert telling("run", *words, "--quiet").exit_code == 0
    return telling


def test_every_part_is_a_csv_file_of_its_own(flown: Call, tmp_path: Path):
    done = flown("kills", "--show", "survivors", "--format", "csv", "--tables", str(tmp_path / "tables"))
    rows = one_table((tmp_path / "tables" / "survivors.csv").read_text())
    assert [(row["mutant"], row["stage"], row["next"]) for row in rows] == [("EARLY-human@3s", "infect", "situation")]
    assert one_table(done.stdout) == rows
    for part in ("conditions", "situations", "suite", "subsumption"):
        assert one_table(flown("kills", "--show", part, "--format", "csv").stdout)
    assert {row["id"] for row in one_table(flown("kills", "--format", "csv").stdout)} >= {LATE, "EARLY-human@3s"}


def test_json_has_the_matrix_and_every_part(flown: Call):
    plain = json.loads(flown("kills", "--format", "json").stdout)
    parts = {"conditions", "orders", "situations", "suite", "subsumption", "redundancies", "survivors"}
    assert {name for name, value in plain.items() if value is None} == {"chosen"}
    assert parts < set(plain)
    assert [entry["verdict"] for entry in plain["survivors"]] == ["not_tested"]
    assert plain["conditions"][0]["condition"] == "human"
    assert plain["suite"]["alternatives"] == 2
    some = json.loads(flown("kills", "LATE-human", "--show", "suite", "--format", "json").stdout)
    assert {name for name in parts if some[name] is not None} == {"suite"}
    assert [row["id"] for row in some["mutants"]] == [LATE]


def test_what_one_seed_shows_is_undecided_and_says_how_many_seeds_decide(call: Call):
    words = ("--mutant", "LATE-human", "--situation", "T0O?W0D0H?", "--quiet")
    assert call("run", *words).exit_code == 0
    text = " ".join(call("kills", "--show", "survivors").stdout.replace("\\\n", "\n").split())
    assert "2 of 2 flights where SR2 is steady violate it" in text
    assert re.search(rf"`scaloft-fi run.* --campaign .+ --mutant {LATE} (--situation \S+ ){{4}}--seeds 3`", text)
    assert json.loads(call("kills", "--format", "json").stdout)["conditions"] == []


def test_a_survivor_is_told_as_beside_all_that_the_published_campaign_holds():
    with snapshot(Study.open(ROOT), "results/published/reference") as now:
        matrix = kill_matrix.kill_matrix(now.score, now.study.roster, now.study.space)
        told = kills._survivors(now, matrix)
        known = backgrounds(now.study.matrix, [mutant.subject.id for mutant in now.score.mutants])
        units = short_units(now.study.requirements)
        whole = now.with_tracks(now.outcomes, lambda one: one.seed == 0)
        assert told == survivors(whole, now.score, matrix, known, units, now.name, now.study.finds)
    assert sum(one.loss is not None for one in told) > 30
    assert sum(one.off_path_m is not None for one in told) > 30


def test_what_some_situations_kill_is_told(flown: Call):
    lone = json.loads(flown("kills", "--situation", "T0O0W0D0H0", "--show", "suite", "--format", "json").stdout)
    assert lone["chosen"]["lost"] == [LATE]
    assert "dominator score 1/1 = 100 %" in " ".join(flown("kills", "--situation", "T0O?W0D0H1").stdout.split())
    assert "situation" in sentence(flown("kills", "--situation", "T0O0W0D0H7"))


def test_kills_by_requirement_are_told_apart(flown: Call):
    plain = json.loads(flown("kills", "--by-requirement", "--show", "subsumption", "--format", "json").stdout)
    assert all(key.endswith(" SR2") for key in plain["subsumption"]["nodes"][0]["kills"])


@pytest.mark.parametrize("suffix", [".svg", ".png", ".dot"])
def test_all_are_drawn_as_the_subsumption_graph(flown: Call, tmp_path: Path, suffix: str):
    path = tmp_path / f"graph{suffix}"
    assert flown("kills", "--output", str(path)).exit_code == 0
    assert path.stat().st_size > 100
