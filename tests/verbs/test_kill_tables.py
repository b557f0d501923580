from __future__ import annotations

import pytest
from builders import GRID, ROSTER, outcome, pool, seeded, thrice
from hypothesis import given, settings

from scaloft_fi.analysis.kill_matrix import KillMatrix, kill_matrix
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.suite import (
    chosen_kills,
    interactions,
    minimal_suite,
    orders,
    redundancies,
    situation_kills,
    subsumption,
)
from scaloft_fi.console import PIPED
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.kills import (
    chosen_table,
    interaction_table,
    order_table,
    redundancy_table,
    situation_table,
    subsumption_table,
    suite_table,
    with_detected,
)
from scaloft_fi.views.table import Format, Table, render

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T0O0W0D1H0"


def matrix_of(outcomes: list[Outcome]) -> KillMatrix:
    return kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID)


def all_tables(outcomes: list[Outcome]) -> list[Table]:
    matrix = matrix_of(outcomes)
    found, graph, situations = interactions(matrix), subsumption(matrix.kills), situation_kills(matrix)
    suite = minimal_suite(matrix.kills, matrix.flown)
    return [
        interaction_table(found),
        order_table(orders(found, GRID)),
        *(situation_table(situations, GRID, short=short) for short in (True, False)),
        suite_table(suite, matrix),
        *(subsumption_table(graph, short=short) for short in (True, False)),
        redundancy_table(redundancies(graph)),
        chosen_table(chosen_kills(matrix, [HUMAN, DARK])),
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


def test_a_situation_tells_what_it_alone_kills() -> None:
    rows = {entry.situation: entry for entry in situation_kills(matrix_of(CAMPAIGN))}
    assert rows[HUMAN].killed == (NO, LATE)
    assert rows[HUMAN].alone == (LATE,)
    assert rows[DARK].alone == ()
    assert (rows[HUMAN].tested, rows["T1O0W0D1H0"].tested) == (3, 0)
    # LATE and MORE-goal are the minimal ones
    assert [str(rows[key].minimal) for key in (HUMAN, DARK)] == ["1/2 = 50 %", "0/2 = 0 %"]


def test_some_situations_are_scored_with_and_without_redundant_mutants() -> None:
    found = chosen_kills(matrix_of(CAMPAIGN), [HUMAN, DARK])
    assert (str(found.killed), str(found.dominator_score)) == ("2/3 = 67 %", "1/2 = 50 %")
    assert found.lost == (GOAL,)
    whole = chosen_kills(matrix_of(CAMPAIGN), GRID.point)
    assert (whole.killed.value, whole.dominator_score.value, whole.lost) == (1.0, 1.0, ())


def test_the_tables_say_it_in_words() -> None:
    text = " ".join(render(all_tables(CAMPAIGN), Format.TABLE).split())
    assert "Fewest situations that keep every kill: 2, proved; sets of that size: 1." in text
    assert "In 1 of 4 situations flown no mutant is killed; 1 of them test none." in text
    assert f"> {NO} 2 {LATE}" in text
    assert "3 killed mutants, 3 different kill sets, 2 of them minimal" in text


def test_the_first_table_names_what_is_detected_without_a_kill() -> None:
    keys = [key for key, _ in GRID.points[:8]]
    spread = [outcome(LATE, key, 1, violated={"SR2": 9.0}) for key in keys]
    calm = [outcome(LATE, key, seed) for key in keys for seed in (0, 2)]
    matrix = matrix_of([*pool(*keys), *spread, *calm])
    shown = with_detected([interaction_table(interactions(matrix))] * 2, matrix)
    assert f"Detected without a kill, so in no table of kills: {LATE}." in shown[0].notes[-1]
    assert shown[1].notes == interaction_table(()).notes
    assert (
        f"Detected mutants: 1, of them 0 firmly: whichever one seed is left out.  Not firm: {LATE}." in shown[0].notes
    )
    assert with_detected([], matrix) == []
    assert not any("without a kill" in note for note in with_detected(shown[1:], matrix_of(CAMPAIGN))[0].notes)


def test_a_greedy_suite_says_at_most() -> None:
    matrix = matrix_of(CAMPAIGN)
    suite = minimal_suite(matrix.kills, matrix.flown, most_entries=0)
    assert "at most 2;" in render([suite_table(suite, matrix)], Format.TABLE)


@settings(deadline=None, max_examples=12)
@given(seeded())
def test_every_table_of_every_campaign_fits_a_terminal_and_every_node_is_listed_once(outcomes: list[Outcome]) -> None:
    text = render(all_tables(outcomes), Format.TABLE)
    assert max(len(line) for line in text.splitlines()) <= PIPED
    graph = subsumption(matrix_of(outcomes).kills)
    listed = [str(row[0]).replace("> ", "") for row in subsumption_table(graph).rows]
    assert sorted(listed) == sorted(", ".join(node.mutants) for node in graph.nodes)


@pytest.mark.parametrize("how", Format)
def test_every_format_names_the_mutants(how: Format) -> None:
    assert LATE in render(all_tables(CAMPAIGN), how)
