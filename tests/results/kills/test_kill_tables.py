from __future__ import annotations

import pytest
from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given, settings

from scaloft_fi.results.kills import kill_tables as tables
from scaloft_fi.results.kills.interaction import interactions, orders
from scaloft_fi.results.kills.kill_matrix import KillMatrix, kill_matrix
from scaloft_fi.results.kills.minimal_suite import minimal_suite
from scaloft_fi.results.kills.situation_kills import chosen_kills, situation_kills
from scaloft_fi.results.kills.subsumption import redundancies, subsumption
from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.scoring.score import score
from scaloft_fi.results.telling.table import WIDTH, Format, Table, render

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T0O0W0D1H0"


def matrix_of(outcomes: list[Outcome]) -> KillMatrix:
    return kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID)


def all_tables(outcomes: list[Outcome]) -> list[Table]:
    matrix = matrix_of(outcomes)
    found, graph, situations = interactions(matrix), subsumption(matrix.kills), situation_kills(matrix)
    suite = minimal_suite(matrix.kills, matrix.flown)
    return [
        tables.interaction_table(found),
        tables.order_table(orders(found, GRID)),
        *(tables.situation_table(situations, GRID, short=short) for short in (True, False)),
        tables.suite_table(suite, matrix),
        *(tables.subsumption_table(graph, short=short) for short in (True, False)),
        tables.redundancy_table(redundancies(graph)),
        tables.chosen_table(chosen_kills(matrix, [HUMAN, DARK])),
    ]


KILLS = {(LATE, HUMAN), (NO, HUMAN), (NO, DARK), (GOAL, NOBODY)}
CAMPAIGN = [
    *(outcome(BASELINE, key) for key in (HUMAN, NOBODY, DARK)),
    *(
        outcome(mutant, key, violated={"SR2": 9.0} if (mutant, key) in KILLS else {})
        for mutant in (LATE, NO, GOAL)
        for key in (HUMAN, NOBODY, DARK)
    ),
    outcome(BASELINE, "T1O0W0D1H0", violated={"SR1": 30.0}, struck="bar"),
    outcome(LATE, "T1O0W0D1H0"),
]


def test_a_situation_tells_what_it_alone_kills() -> None:
    rows = {entry.situation: entry for entry in situation_kills(matrix_of(CAMPAIGN))}
    assert rows[HUMAN].killed == (NO, LATE)
    assert rows[HUMAN].alone == (LATE,)
    assert rows[DARK].alone == ()
    assert (rows[HUMAN].eligible, rows["T1O0W0D1H0"].eligible) == (3, 0)
    # LATE and MORE-goal are the minimal ones
    assert [str(rows[key].minimal.plain) for key in (HUMAN, DARK)] == ["1/2 = 50 %", "0/2 = 0 %"]


def test_some_situations_are_scored_with_and_without_redundant_mutants() -> None:
    found = chosen_kills(matrix_of(CAMPAIGN), [HUMAN, DARK])
    assert (str(found.killed.plain), str(found.dominator.plain)) == ("2/3 = 67 %", "1/2 = 50 %")
    assert found.lost == (GOAL,)
    whole = chosen_kills(matrix_of(CAMPAIGN), GRID.point)
    assert (whole.killed.value, whole.dominator.value, whole.lost) == (1.0, 1.0, ())


def test_the_tables_say_it_in_words() -> None:
    text = " ".join(render(all_tables(CAMPAIGN), Format.TABLE).split())
    assert "Fewest situations that keep every kill: 2, proved; sets of that size: 1." in text
    assert "1 of 4 situations flown kill nothing, 1 because no flight there is eligible." in text
    assert f"> {NO} 2 {LATE}" in text
    assert "3 killed mutants, 3 different kill sets, 2 of them minimal" in text


def test_a_greedy_suite_says_at_most() -> None:
    matrix = matrix_of(CAMPAIGN)
    suite = minimal_suite(matrix.kills, matrix.flown, most_entries=0)
    assert "at most 2;" in render([tables.suite_table(suite, matrix)], Format.TABLE)


@settings(deadline=None, max_examples=12)
@given(campaigns())
def test_every_table_of_every_campaign_fits_a_terminal_and_every_node_is_listed_once(outcomes: list[Outcome]) -> None:
    text = render(all_tables(outcomes), Format.TABLE)
    assert max(len(line) for line in text.splitlines()) <= WIDTH
    graph = subsumption(matrix_of(outcomes).kills)
    listed = [str(row[0]).replace("> ", "") for row in tables.subsumption_table(graph).rows]
    assert sorted(listed) == sorted(", ".join(node.mutants) for node in graph.nodes)


@pytest.mark.parametrize("how", Format)
def test_every_format_names_the_mutants(how: Format) -> None:
    assert LATE in render(all_tables(CAMPAIGN), how)
