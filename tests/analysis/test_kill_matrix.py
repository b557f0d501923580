"""The kill matrix, Gray's order of situations, and Karnaugh's map."""

from __future__ import annotations

from itertools import pairwise, product
from math import prod

from builders import GRID, ROSTER, outcome, pool, seeded, thrice
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import (
    NOT_FLOWN,
    KillMatrix,
    cyclic,
    fold,
    gray_order,
    gray_rank,
    gray_words,
    kill_matrix,
)
from scaloft_fi.analysis.score import score
from scaloft_fi.judge.outcome import PLACEBO_ID, Outcome
from scaloft_fi.judge.space import Space

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


def test_every_state_has_its_name():
    found = matrix_of(CAMPAIGN)
    states = {row.id: {e.situation: e.state for e in row.entries if e.state != NOT_FLOWN} for row in found.rows}
    assert states[LATE] == {HUMAN: "revealed", NOBODY: "not_reached", DARK: "revealed"}
    assert states[NO] == {HUMAN: "masked", NOBODY: "not_infected"}
    assert [row.kind for row in found.rows] == ["mutant", "mutant", "control", "placebo"]


def test_where_nothing_is_steady_nothing_is_killed_survived_or_tested():
    row = matrix_of(CAMPAIGN).row[LATE]
    (dark,) = [entry for entry in row.entries if entry.situation == DARK]
    assert (dark.kills, dark.seen, dark.tested, dark.survived) == ((), (), False, False)
    assert dict(dark.violated) == {"SR2": 3}
    assert row.kills == {HUMAN}
    assert row.surviving == (NOBODY,)
    assert matrix_of(CAMPAIGN).kills == {LATE: {HUMAN}}


def test_what_does_not_decide_is_seen_and_no_kill():
    row = matrix_of([*pool(HUMAN), outcome(LATE, HUMAN, violated={"SR2": 9.0})]).row[LATE]
    (entry,) = [entry for entry in row.entries if entry.flown]
    assert (row.verdict, entry.seen, entry.kills) == (Verdict.UNDECIDED, ("SR2",), ())


def test_a_detected_mutant_without_a_kill_is_named():
    keys = [key for key, _ in GRID.points[:8]]
    spread = [outcome(LATE, key, seed, violated={"SR2": 9.0} if seed == 1 else {}) for key in keys for seed in range(3)]
    found = matrix_of([*pool(*keys), *spread])
    assert (found.scattered, found.kills) == ((LATE,), {})
    assert matrix_of(CAMPAIGN).scattered == ()


@given(seeded())
def test_the_matrix_says_what_the_score_says(outcomes: list[Outcome]):
    scored = score(outcomes, ROSTER, GRID)
    found = kill_matrix(scored, ROSTER, GRID)
    assert [row.id for row in found.mutants] == [mutant.subject.id for mutant in scored.mutants]
    for mutant, row in zip(scored.mutants, found.mutants, strict=True):
        assert (row.killing, row.verdict) == (mutant.killing, mutant.verdict)
        assert len(row.kills) == mutant.kill_rate.part
        spared = [r.situation for r in mutant.results if not r.kills and (r.tested or not r.infected)]
        assert list(row.surviving) == spared
        assert mutant.detected or not row.kills
        assert [entry.situation for entry in row.entries] == list(GRID.point)
    if scored.pooled:
        counted = [row for row in found.mutants if row.counted]
        assert sum(row.verdict is Verdict.DETECTED for row in counted) == scored.mutation_score.part


radices = st.lists(st.integers(1, 4), min_size=1, max_size=4)


def test_neighbouring_situations_of_the_grid_differ_on_one_axis():
    order = gray_order(GRID)
    assert sorted(order) == sorted(GRID.point)
    assert order[0] == "T0O0W0D0H0"
    for key, following in pairwise(order):
        assert sum(a != b for a, b in zip(GRID.point[key], GRID.point[following], strict=True)) == 1


@given(radices)
def test_neighbouring_words_differ_in_one_digit_by_one(sizes: list[int]):
    words = gray_words(sizes)
    assert sorted(words) == sorted(product(*map(range, sizes)))
    for word, following in pairwise(words):
        assert sum(abs(a - b) for a, b in zip(word, following, strict=True)) == 1


@given(radices)
def test_a_words_rank_is_its_place(sizes: list[int]):
    assert [gray_rank(word, sizes) for word in gray_words(sizes)] == list(range(prod(sizes)))


def test_a_grid_with_situations_left_out_keeps_the_order_of_the_rest():
    kept = tuple(entry for entry in GRID.points if entry[0] != "T0O0W0D1H1")
    partial = Space(GRID.axes, GRID.values, GRID.words, kept)
    assert gray_order(partial) == tuple(key for key in gray_order(GRID) if key != "T0O0W0D1H1")


CUT = Space(
    axes=("light", "floor", "people"),
    values=(("0", "1", "2"), ("0", "1", "2"), ("0", "1")),
    words=(("bright", "dim", "dark"), ("dry", "wet", "gone"), ("nobody", "human")),
    points=tuple((f"L{a}F{b}P{c}", (a, b, c)) for a, b, c in product("012", "012", "01") if (a, b) != ("2", "2")),
)


def test_five_axes_make_four_rows_of_eight_and_every_situation_is_on_the_map_once():
    folded = fold(GRID)
    assert [len(keys) for keys in folded.keys] == [8] * 4
    assert sorted(key for keys in folded.keys for key in keys if key) == sorted(GRID.point)


def test_neighbours_on_the_map_differ_on_one_axis_also_across_its_edges():
    folded = fold(GRID)
    assert cyclic(folded.rows)
    assert cyclic(folded.columns)
    for r, c in product(range(4), range(8)):
        for other in (folded.keys[(r + 1) % 4][c], folded.keys[r][(c + 1) % 8]):
            here, there = GRID.point[folded.keys[r][c] or ""], GRID.point[other or ""]
            assert sum(a != b for a, b in zip(here, there, strict=True)) == 1


def test_axes_of_three_values_fold_too_and_what_a_constraint_excludes_is_empty():
    folded = fold(CUT)
    assert sorted(key for keys in folded.keys for key in keys if key) == sorted(CUT.point)
    assert sum(key is None for keys in folded.keys for key in keys) == 2
    for side in (folded.rows, folded.columns):
        assert all(sum(a != b for a, b in zip(*pair, strict=True)) == 1 for pair in pairwise(side))
    assert not cyclic(folded.columns)
