from __future__ import annotations

import json
from itertools import pairwise

from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given, settings

from scaloft_fi.results.kills.kill_matrix import NOT_FLOWN, KillMatrix, kill_matrix
from scaloft_fi.results.outcome import BASELINE, PLACEBO, Outcome
from scaloft_fi.results.scoring.score import score

LATE, NO, CONTROL = "LATE-human@3s", "NO-human@100%", "REVERSE-human"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T1O0W0D1H0"


def matrix_of(outcomes: list[Outcome]) -> KillMatrix:
    return kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID)


CAMPAIGN = [
    outcome(BASELINE, HUMAN),
    outcome(BASELINE, NOBODY),
    outcome(BASELINE, DARK, violated={"SR1": 30.0}, struck="bar"),
    outcome(PLACEBO, HUMAN, altered=0),
    outcome(CONTROL, HUMAN, violated={"SR2": 9.0}),
    outcome(LATE, HUMAN, violated={"SR2": 12.35}),
    outcome(LATE, NOBODY, carried=0, altered=0),
    outcome(LATE, DARK, violated={"SR2": 12.0}),
    outcome(NO, HUMAN, digest="clean"),
    outcome(NO, NOBODY, altered=0),
    outcome(NO, DARK, invalid="the worker died"),
]


def test_every_state_has_its_name() -> None:
    found = matrix_of(CAMPAIGN)
    states = {row.id: {e.situation: e.state for e in row.entries if e.state != NOT_FLOWN} for row in found.rows}
    assert states[LATE] == {HUMAN: "killed", NOBODY: "not_reached", DARK: "killed"}
    assert states[NO] == {HUMAN: "masked", NOBODY: "not_infected", DARK: "invalid"}
    assert [row.kind for row in found.rows] == ["mutant", "mutant", "control", "placebo"]


def test_a_kill_beside_a_baseline_that_holds_nothing_to_its_end_is_shown_and_not_counted() -> None:
    row = matrix_of(CAMPAIGN).row[LATE]
    assert row.killing == (HUMAN, DARK)
    assert row.kills == {HUMAN}
    assert matrix_of(CAMPAIGN).kills == {LATE: {HUMAN}}


def test_decisions_stand_beside_the_flights() -> None:
    assert [entry.decision for entry in matrix_of(CAMPAIGN).row[LATE].entries if entry.decision] == ["undecided"]


@settings(deadline=None, max_examples=40)
@given(campaigns())
def test_the_matrix_says_what_the_score_says(outcomes: list[Outcome]) -> None:
    scored = score(outcomes, ROSTER, GRID)
    found = kill_matrix(scored, ROSTER, GRID)
    assert [row.id for row in found.mutants] == [mutant.subject.id for mutant in scored.mutants]
    for mutant, row in zip(scored.mutants, found.mutants, strict=True):
        assert row.killing == mutant.killing
        assert row.surviving == mutant.surviving
        assert len(row.kills) == mutant.kill_rate.part
    counted = [row for row in found.mutants if row.counted]
    assert sum(bool(row.kills) for row in counted) == scored.mutation_score.part


@settings(deadline=None, max_examples=20)
@given(campaigns())
def test_its_json_is_plain_and_every_row_has_every_situation(outcomes: list[Outcome]) -> None:
    plain = json.loads(json.dumps(matrix_of(outcomes).to_json(), allow_nan=False))
    assert all(len(row["entries"]) == len(plain["situations"]) == 32 for row in plain["mutants"])
    assert sorted(plain["gray"]) == sorted(situation["key"] for situation in plain["situations"])
    points = {situation["key"]: situation["point"] for situation in plain["situations"]}
    for key, following in pairwise(plain["gray"]):
        assert sum(a != b for a, b in zip(points[key], points[following], strict=True)) == 1
    states = {entry["state"] for row in plain["mutants"] for entry in row["entries"]}
    assert states <= set(plain["states"])
