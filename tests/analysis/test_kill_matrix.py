from __future__ import annotations

import json
from itertools import pairwise

from builders import GRID, ROSTER, campaigns, outcome, pool, seeded, thrice
from hypothesis import given, settings

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import NOT_FLOWN, KillMatrix, kill_matrix
from scaloft_fi.analysis.score import score
from scaloft_fi.judge.outcome import PLACEBO_ID, Outcome

LATE, NO, CONTROL = "LATE-human@3s", "NO-human@100%", "REVERSE-human"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T1O0W0D1H0"


def matrix_of(outcomes: list[Outcome]) -> KillMatrix:
    return kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID)


CAMPAIGN = [
    *pool(HUMAN, NOBODY),
    *pool(DARK, red=10, violated={"SR1": 30.0}, struck="bar"),
    outcome(PLACEBO_ID, HUMAN, altered=0),
    *thrice(CONTROL, HUMAN, violated={"SR2": 9.0}),
    *thrice(LATE, HUMAN, violated={"SR2": 12.35}),
    *thrice(LATE, NOBODY, carried=0, altered=0),
    *thrice(LATE, DARK, violated={"SR2": 12.0}),
    outcome(NO, HUMAN, digest="clean"),
    outcome(NO, NOBODY, altered=0),
    outcome(NO, DARK, invalid="the worker died"),
]


def test_every_state_has_its_name() -> None:
    found = matrix_of(CAMPAIGN)
    states = {row.id: {e.situation: e.state for e in row.entries if e.state != NOT_FLOWN} for row in found.rows}
    assert states[LATE] == {HUMAN: "revealed", NOBODY: "not_reached", DARK: "revealed"}
    assert states[NO] == {HUMAN: "masked", NOBODY: "not_infected"}
    assert [row.kind for row in found.rows] == ["mutant", "mutant", "control", "placebo"]


def test_where_nothing_is_steady_nothing_is_killed_survived_or_tested() -> None:
    row = matrix_of(CAMPAIGN).row[LATE]
    (dark,) = [entry for entry in row.entries if entry.situation == DARK]
    assert (dark.kills, dark.seen, dark.tested, dark.survived) == ((), (), False, False)
    assert dict(dark.violated) == {"SR2": 3}
    assert row.kills == {HUMAN}
    assert row.surviving == (NOBODY,)
    assert matrix_of(CAMPAIGN).kills == {LATE: {HUMAN}}


def test_what_does_not_decide_is_seen_and_no_kill() -> None:
    row = matrix_of([*pool(HUMAN), outcome(LATE, HUMAN, violated={"SR2": 9.0})]).row[LATE]
    (entry,) = [entry for entry in row.entries if entry.flown]
    assert (row.verdict, entry.seen, entry.kills) == (Verdict.UNDECIDED, ("SR2",), ())


def test_a_detected_mutant_without_a_kill_is_named() -> None:
    keys = [key for key, _ in GRID.points[:8]]
    spread = [outcome(LATE, key, seed, violated={"SR2": 9.0} if seed == 1 else {}) for key in keys for seed in range(3)]
    found = matrix_of([*pool(*keys), *spread])
    assert (found.scattered, found.kills) == ((LATE,), {})
    assert matrix_of(CAMPAIGN).scattered == ()


@settings(deadline=None, max_examples=20)
@given(seeded())
def test_the_matrix_says_what_the_score_says(outcomes: list[Outcome]) -> None:
    scored = score(outcomes, ROSTER, GRID)
    found = kill_matrix(scored, ROSTER, GRID)
    assert [row.id for row in found.mutants] == [mutant.subject.id for mutant in scored.mutants]
    for mutant, row in zip(scored.mutants, found.mutants, strict=True):
        assert (row.killing, row.verdict) == (mutant.killing, mutant.verdict)
        assert len(row.kills) == mutant.kill_rate.part
        spared = [r.situation for r in mutant.results if not r.kills and (r.tested or not r.infected)]
        assert list(row.surviving) == spared
        assert mutant.detected or not row.kills
    if scored.pooled:
        counted = [row for row in found.mutants if row.counted]
        assert sum(row.verdict is Verdict.DETECTED for row in counted) == scored.mutation_score.part


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
