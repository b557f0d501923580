from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import combinations, permutations, product

import numpy as np
import pytest
from builders import GRID, ROSTER, outcome, pool, seeded
from grids import FIVE, keys_of, space_of, spaces
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.coverage_against_kills import correlate, curve_tables, predict
from experiments.coverage_curves import (
    MOST_SUBSETS,
    RESAMPLES,
    SeedSet,
    Trial,
    apfd,
    curves,
    firsts,
    in_orders,
    in_subsets,
    redrawn,
    relabelled,
    resamples,
    seed_draws,
    sub_cube,
    trial,
    with_replacement,
    without_replacement,
)
from scaloft_fi.analysis.coverage import covering_array, t_way
from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.score import score
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.views.table import Format, render


def small() -> st.SearchStrategy[np.ndarray]:
    """(things, situations) of up to 5 situations."""
    rows = st.integers(2, 5).flatmap(
        lambda n: st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=1, max_size=4)
    )
    return rows.map(np.array)


@given(small())
def test_a_random_suite_meets_what_counting_all_suites_gives(found: np.ndarray) -> None:
    n = found.shape[1]
    chances = without_replacement(n)[found.sum(axis=1)]
    for k in range(1, n + 1):
        counted = np.mean([found[:, suite].any(axis=1) for suite in combinations(range(n), k)], axis=0)
        assert np.allclose(chances[:, k - 1], counted)


@given(small())
def test_random_draws_meet_what_counting_all_draws_gives(found: np.ndarray) -> None:
    n = found.shape[1]
    chances = with_replacement(n)[found.sum(axis=1)]
    for k in range(1, min(n, 4) + 1):
        counted = np.mean([found[:, draws].any(axis=1) for draws in product(range(n), repeat=k)], axis=0)
        assert np.allclose(chances[:, k - 1], counted)


@given(small())
def test_all_orders_together_are_random_order(found: np.ndarray) -> None:
    n = found.shape[1]
    every = np.array(list(permutations(range(n))))
    assert np.allclose(in_orders(found, every), without_replacement(n)[found.sum(axis=1)])


@given(small())
def test_all_suites_together_are_random_order(found: np.ndarray) -> None:
    n = found.shape[1]
    for size in range(1, n + 1):
        suites = np.array(list(combinations(range(n), size)))
        assert np.allclose(in_subsets(found, suites), without_replacement(n)[found.sum(axis=1), :size])


def test_the_first_to_meet_is_counted_from_0_and_never_is_the_number_of_situations() -> None:
    found = np.array([[False, True, True], [False, False, False]])
    assert firsts(found, np.array([[0, 2, 1]])).tolist() == [[1, 3]]


# expected t-way coverage of k random situations of 2^5, published to three digits
TABLE = {
    4: (0.949, 0.705, 0.431, 0.238, 0.125),
    6: (0.991, 0.851, 0.584, 0.345, 0.188),
    10: (1.0, 0.970, 0.797, 0.534, 0.312),
    16: (1.0, 0.999, 0.949, 0.758, 0.500),
    24: (1.0, 1.0, 0.998, 0.944, 0.750),
}


@pytest.mark.parametrize("k", TABLE)
def test_expected_coverage_of_the_reference_grid_is_as_published(k: int) -> None:
    trial = Trial(FIVE, tuple(keys_of(FIVE)), (), (), np.zeros((0, 32), bool))
    for strength, wanted in enumerate(TABLE[k], start=1):
        found, possible = trial.combinations(strength)
        expected = without_replacement(32)[found.sum(axis=1), k - 1].sum() / possible
        assert expected == pytest.approx(wanted, abs=6e-4)


@pytest.mark.parametrize(("t", "wanted"), [(1, 0.955), (2, 0.901), (3, 0.809), (4, 0.672), (5, 0.500)])
def test_the_expected_apfd_of_a_block_of_t_axes_is_as_published(t: int, wanted: float) -> None:
    assert apfd(without_replacement(32)[[2 ** (5 - t)]]) == pytest.approx(wanted, abs=6e-4)


@given(small(), st.randoms())
def test_apfd_is_its_definition_and_leaves_out_what_no_situation_kills(found: np.ndarray, rng) -> None:
    n = found.shape[1]
    order = list(range(n))
    rng.shuffle(order)
    places = np.argsort(order)[None, :]
    first = [min(place for place, s in enumerate(order, start=1) if row[s]) for row in found if row.any()]
    wanted = 1 - sum(first) / (n * len(first)) + 1 / (2 * n) if first else None
    assert apfd(in_orders(found, places)) == (None if wanted is None else pytest.approx(wanted))


ALIVE, FIRST, SECOND, BOTH = [False, False], [True, False], [False, True], [True, True]


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_seeds_come_out_as_often_as_in_all_draws_with_replacement(n: int) -> None:
    seeds = [10 * number for number in range(n)]
    counted = Counter(tuple(sorted(set(drawn))) for drawn in product(seeds, repeat=n))
    assert {drawn: chance * n**n for drawn, chance in seed_draws(seeds)} == pytest.approx(counted)


def test_of_many_seeds_a_fixed_sample_of_the_sets_is_judged() -> None:
    drawn = seed_draws(range(10))
    assert len(drawn) <= MOST_SUBSETS
    assert sum(chance for _, chance in drawn) == pytest.approx(1)
    # of n draws n (1 - (1 - 1/n)^n) come out
    assert sum(chance * len(seeds) for seeds, chance in drawn) == pytest.approx(10 * (1 - 0.9**10), abs=0.5)
    assert drawn == seed_draws(range(10))
    assert len(seed_draws(range(6))) == 63


def test_mutants_are_resampled_within_their_parameter() -> None:
    weights = resamples(["a", "b", "a", "a"])
    assert (weights[:, [0, 2, 3]].sum(axis=1) == 3).all()
    assert (weights[:, 1] == 1).all()
    assert (weights == resamples(["a", "b", "a", "a"])).all()


def test_the_campaign_flown_comes_first_and_counts_equal_kill_sets_once() -> None:
    kills = np.array([FIRST, FIRST, ALIVE, BOTH])
    found = redrawn(["a", "a", "b", "b"], kills, ())
    assert (found.kill_sets[found.place] == kills).all()
    assert found.mutants[0] @ found.kill_sets.any(axis=1) == 3
    assert found.distinct[0].sum() == 2
    assert (found.mutants[1:].sum(axis=1) == 4).all()
    assert (found.distinct[1:].sum(axis=1) == 2).all()
    assert len(found.mutants) == len(found.distinct) == 1 + RESAMPLES


def test_a_redrawn_campaign_has_the_kills_of_the_seeds_that_came_out() -> None:
    one, other = np.array([FIRST, ALIVE]), np.array([FIRST, SECOND])
    sets = [SeedSet((0,), 0.25, one), SeedSet((1,), 0.25, other), SeedSet((0, 1), 0.5, one)]
    found = redrawn(["a", "b"], one, sets)
    killed = found.mutants @ found.kill_sets
    assert killed[0].tolist() == [1, 0]
    assert set(map(tuple, killed[1:].tolist())) == {(1, 0), (1, 1)}
    assert killed[1:, 1].mean() == pytest.approx(0.25, abs=0.04)
    drawn = found.distinct[1:].sum(axis=1)
    assert ((drawn == 2) == (killed[1:, 1] == 1)).all()


def test_seed_sets_without_a_kill_have_no_kill_set() -> None:
    found = redrawn(["a"], np.array([FIRST]), [SeedSet((0,), 1.0, np.array([ALIVE]))])
    assert found.distinct[0].sum() == 1
    assert not found.distinct[1:].any()


LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
KEYS = [key for key, _ in GRID.points]


def tried(outcomes: list[Outcome]) -> Trial | None:
    return trial(score(outcomes, ROSTER, GRID), rulings_of(outcomes), ROSTER, GRID)


def flown(mutant: str, situations: list[str], killing: list[str], seeds: int = 1) -> list[Outcome]:
    return [
        outcome(mutant, key, seed, violated={"SR1": 5.0} if key in killing else {}, digest=mutant)
        for key in situations
        for seed in range(seeds)
    ]


def test_the_trial_takes_the_default_mutants_that_were_flown_together() -> None:
    outcomes = pool(*KEYS[:8])
    outcomes += flown(LATE, KEYS[:6], KEYS[:3]) + flown(NO, KEYS[:6], KEYS[2:6])
    outcomes += flown(GOAL, KEYS[6:8], []) + flown("LATE-human@1s", KEYS[:8], KEYS[:8]) + flown("PLACEBO", KEYS[:8], [])
    found = tried(outcomes)
    assert found.situations == tuple(KEYS[:6])
    assert (found.mutants, found.parameters, found.left_out) == ((NO, LATE), ("human", "human"), (GOAL,))
    assert found.kills.astype(int).tolist() == [[0, 0, 1, 1, 1, 1], [1, 1, 1, 0, 0, 0]]
    assert (found.killed, len(found.kill_sets), found.unkilled) == (2, 2, ())
    assert tried([]) is None


def test_nothing_dies_in_a_red_situation_nor_of_what_is_not_detected() -> None:
    outcomes = pool(*KEYS[:4]) + pool(KEYS[4], red=9, violated={"SR1": 30.0})
    outcomes += flown(LATE, KEYS[:5], KEYS[:5]) + flown(NO, KEYS[:5], KEYS[:1])
    assert tried(outcomes).kills.astype(int).tolist() == [[0, 0, 0, 0, 0], [1, 1, 1, 1, 0]]


def test_a_mutant_that_is_detected_without_a_kill_is_named() -> None:
    # one of three flights in each of many situations: too often for chance, most flights nowhere
    outcomes = pool(*KEYS[:12], seeds=30)
    outcomes += [
        outcome(LATE, key, seed, violated={"SR1": 5.0} if seed == 0 else {}) for key in KEYS[:12] for seed in range(3)
    ]
    found = tried(outcomes)
    assert (found.unkilled, found.killed) == ((LATE,), 0)
    assert any(LATE in sentence for sentence in predict(curves(found)).answer)


def test_a_campaign_of_one_seed_has_no_seeds_to_resample_and_says_so() -> None:
    found = tried(pool(*KEYS[:6]) + flown(LATE, KEYS[:6], KEYS[:3]))
    assert (found.seeds, found.seed_sets) == ((0,), ())
    said = predict(curves(found)).answer[-1]
    assert "only one in common" in said
    assert "nothing follows beyond this seed" in said


def test_seeds_that_only_some_mutants_flew_stand() -> None:
    outcomes = pool(*KEYS[:6]) + flown(LATE, KEYS[:6], KEYS[:3], seeds=3) + flown(NO, KEYS[:6], KEYS[:4], seeds=2)
    found = tried(outcomes)
    assert (found.seeds, found.more_seeds) == ((0, 1), (2,))
    assert [one.seeds for one in found.seed_sets] == [(0,), (1,), (0, 1)]
    assert (found.seed_sets[-1].kills == found.kills).all()


def test_seeds_are_judged_anew_with_the_alpha_that_the_campaign_spends() -> None:
    # one situation and three seeds: p = 0.0070, enough where alpha is spent once, not where it is spent by looks
    outcomes = pool(*KEYS[:2]) + flown(LATE, KEYS[:2], KEYS[:1], seeds=3)
    for spending, killed in ((Spending(), 1), (Spending(grown=frozenset({LATE})), 0)):
        scored = score(outcomes, ROSTER, GRID, spending)
        found = trial(scored, rulings_of(outcomes), ROSTER, GRID, spending)
        assert [found.kills.sum(), found.seed_sets[-1].kills.sum()] == [killed, killed]


@settings(max_examples=10, deadline=None)
@given(seeded())
def test_the_kills_of_some_seeds_are_those_of_a_campaign_flown_with_these_beside_the_whole_pool(
    outcomes: list[Outcome],
) -> None:
    found = tried(outcomes)
    if found is None:
        return
    shared = set(found.seeds)
    if 1 < len(shared) < 7:
        subsets = [set(some) for size in range(1, len(shared) + 1) for some in combinations(sorted(shared), size)]
        assert [set(one.seeds) for one in found.seed_sets] == subsets
    for one in found.seed_sets:
        some = [o for o in outcomes if o.subject.id == BASELINE or o.seed in one.seeds or o.seed not in shared]
        again = {mutant.subject.id: mutant.killing for mutant in score(some, ROSTER, GRID).mutants}
        assert one.kills.tolist() == [[key in again.get(id_, ()) for key in found.situations] for id_ in found.mutants]


FIVE_KEYS = tuple(keys_of(FIVE))


def made(kills: np.ndarray, space: Space = FIVE, keys: tuple[str, ...] | None = None) -> Trial:
    names = tuple(f"NO-p{number % 4}@{number}s" for number in range(len(kills)))
    keys = keys or tuple(keys_of(space))
    return Trial(space, keys, names, tuple(name.split("-")[1].split("@")[0] for name in names), kills)


def blocks() -> np.ndarray:
    """(243, 32): one mutant for each block of the reference grid, dying exactly where some axes have certain values."""
    points = [point for _, point in FIVE.points]
    rows = [
        [all(f in ("*", value) for f, value in zip(fixed, point, strict=True)) for point in points]
        for fixed in product("01*", repeat=5)
    ]
    return np.array(rows)


def scattered(mutants: int = 30) -> np.ndarray:
    rng = np.random.default_rng(7)
    return rng.random((mutants, 32)) < rng.choice([0, 0.05, 0.3, 1], mutants)[:, None]


def test_mutants_that_die_in_blocks_are_killed_as_combinations_are_covered() -> None:
    """The identity: kills at k random situations are expected t-way coverage, for every t and k."""
    for strength in (1, 2, 3, 4):
        kills = np.array([row for row in blocks() if row.sum() == 2 ** (5 - strength)])
        random = curves(made(kills)).curve("random")
        covered = dict(random.t_way)[strength]
        assert np.allclose(np.array(random.kills.mean) / len(kills), covered)


def test_a_covering_array_kills_every_block_of_its_strength_and_random_situations_do_not() -> None:
    kills = np.array([row for row in blocks() if row.sum() == 8])
    found = curves(made(kills))
    array = found.curve("2-way")
    assert array.kills.mean[-1] == pytest.approx(40)
    assert array.difference.low[-1] > 0
    assert array.matched > 6
    assert "Here yes: 2 of 3 covering arrays meet more" in predict(found).answer[-1]


def test_mutants_that_die_everywhere_or_nowhere_tell_nothing() -> None:
    kills = np.array([[True] * 32, [False] * 32])
    found = curves(made(kills))
    assert all(curve.kills.mean[-1] == pytest.approx(1) for curve in found.curves)
    said = predict(found)
    assert "Not shown here" in said.answer[-1]
    assert all(tau is None for one in said.correlations for tau in one.within)
    assert "nothing follows" in predict(curves(made(kills[1:]))).answer[-1].lower()


def test_an_array_that_kills_fewer_than_random_situations_is_said_to() -> None:
    # a 4-way array of 16 is all points of one parity: of two deadly points of equal parity it has both or none
    even = [number for number, (_, point) in enumerate(FIVE.points) if point.count("1") % 2 == 0]
    kills = np.zeros((120, 32), bool)
    for mutant, pair in enumerate(combinations(even, 2)):
        kills[mutant, list(pair)] = True
    found = curves(made(kills))
    array, random = found.curve("4-way"), found.curve("random")
    assert array.kills.mean[-1] == pytest.approx(60)
    assert random.kills.mean[15] == pytest.approx(120 * (1 - 15 * 16 / (31 * 32)))
    assert array.difference.high[-1] < 0
    assert array.distinct.high[-1] < 0
    assert "No: 1 of 3 covering arrays meets fewer" in predict(found).answer[-1]


def test_arrays_that_differ_in_both_directions_are_said_to() -> None:
    # pairs of one parity, which an array of 16 meets less often, and blocks, which one of 6 meets more often
    even = [number for number, (_, point) in enumerate(FIVE.points) if point.count("1") % 2 == 0]
    pairs = [np.isin(np.arange(32), pair) for pair in combinations(even, 2)]
    kills = np.array([*pairs, *(row for row in blocks() if row.sum() == 8)])
    assert "Not in one direction: 2 of 3 covering arrays meet more" in predict(curves(made(kills))).answer[-1]


def test_mutants_that_die_in_the_same_situations_count_once_in_the_headline() -> None:
    # twenty mutants that an array finds sooner, all of one kill set, beside single ones that it does not
    block = next(row for row in blocks() if row.sum() == 8)
    kills = np.array([*[block] * 20, *np.eye(32, dtype=bool)])
    array = curves(made(kills)).curve("2-way")
    assert array.kills.mean[-1] == pytest.approx(20 + 6)
    assert array.kill_sets.mean[-1] == pytest.approx(1 + 6)
    chance = without_replacement(32)[8, 5]
    assert array.difference.mean[-1] == pytest.approx(20 * (1 - chance))
    assert array.distinct.mean[-1] == pytest.approx(1 - chance)
    assert array.distinct.low[-1] <= array.distinct.mean[-1] <= array.distinct.high[-1]


def test_what_another_seed_kills_widens_the_intervals_and_moves_no_expected_value() -> None:
    kills = scattered()
    alone = made(kills)
    seeds = (SeedSet((0,), 0.25, kills), SeedSet((1,), 0.25, kills & (np.arange(32) < 4)), SeedSet((0, 1), 0.5, kills))
    one, both = curves(alone), curves(replace(alone, seeds=(0, 1), seed_sets=seeds))
    for before, after in zip(one.curves, both.curves, strict=True):
        assert before.kills.mean == pytest.approx(after.kills.mean, rel=1e-12)  # the order of additions may differ
        assert before.t_way == after.t_way
        assert after.kills.low[-1] < before.kills.low[-1]
    assert "resample 2 seeds" in predict(both).answer[-1]
    assert "nothing follows beyond" not in predict(both).answer[-1]


def test_the_answer_ends_with_what_the_figures_carry_and_what_not() -> None:
    whole, part = predict(curves(made(scattered()))), predict(curves(made(scattered()[:, :8], keys=FIVE_KEYS[:8])))
    for said in (whole.answer[-1], part.answer[-1]):
        assert "mutants of this matrix within their parameter" in said
        assert "do not carry to another grid or another drone" in said
    assert whole.answer[-1].endswith("the 32 situations are the whole grid, a census and no sample.")
    assert part.answer[-1].endswith("the 8 situations are those that were flown, no sample of others.")


@settings(max_examples=15, deadline=None)
@given(spaces(most=12), st.data())
def test_every_strategy_keeps_the_laws(space: Space, data: st.DataObject) -> None:
    keys = tuple(keys_of(space))
    rows = data.draw(st.lists(st.lists(st.booleans(), min_size=len(keys), max_size=len(keys)), min_size=1, max_size=5))
    found = curves(made(np.array(rows), space))
    killed = np.array(rows).any(axis=1).sum()
    one = np.array(rows).sum() / len(keys)
    for curve in found.curves:
        mean = np.array(curve.kills.mean)
        assert (np.diff(mean) >= -1e-9).all()
        assert mean[-1] <= killed + 1e-9
        assert (np.array(curve.kills.low) <= np.array(curve.kills.high)).all()
        for _, shares in curve.t_way:
            assert (np.diff(shares) >= -1e-9).all()
            assert shares[-1] <= 1 + 1e-9
        if len(mean) == len(keys) and curve.id != "draws":
            assert mean[-1] == pytest.approx(killed)
            assert all(shares[-1] == pytest.approx(1) for _, shares in curve.t_way)
    assert found.curve("random").kills.mean[0] == pytest.approx(one)
    assert found.curve("draws").kills.mean[0] == pytest.approx(one)
    assert found.curve("greedy").kills.mean[0] == pytest.approx(one)
    assert found.curve("oracle").kills.mean[0] == pytest.approx(np.array(rows).sum(axis=0).max())


def test_the_greedy_strategy_has_every_combination_of_one_axis_after_two_situations() -> None:
    greedy = curves(made(scattered())).curve("greedy")
    assert dict(greedy.t_way)[1][1] == 1.0
    assert dict(greedy.t_way)[2][7] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("strength", [2, 3, 4])
def test_relabelled_arrays_have_every_situation_equally_often_and_stay_arrays(strength: int) -> None:
    suites = relabelled(FIVE, FIVE_KEYS, covering_array(FIVE, FIVE_KEYS, strength, 0))
    assert len(set(np.bincount(suites.ravel(), minlength=32))) == 1
    for suite in suites[:20]:
        assert t_way([FIVE_KEYS[number] for number in suite], FIVE, strength).total.value == 1.0


def test_axes_of_different_size_keep_their_places() -> None:
    space = space_of([2, 3])
    suites = relabelled(space, keys_of(space), ["Aa0Ab0", "Aa1Ab1"])
    # the values of the first axis two ways, those of the second six, and the pair has no order
    assert len(suites) == 6
    assert len(set(np.bincount(suites.ravel(), minlength=6))) == 1


def test_random_suites_pooled_over_sizes_correlate_and_within_a_size_they_do_not() -> None:
    """Simpson: coverage and kills both grow with the size, and are unrelated among suites of one size."""
    [two] = [one for one in correlate(made(scattered(60))) if one.strength == 2]
    assert two.pooled > 0.5
    assert abs(two.median) < 0.15


def test_blocks_are_told_from_other_sets() -> None:
    for row in blocks():
        killing = [key for key, killed in zip(FIVE_KEYS, row, strict=True) if killed]
        assert sub_cube(FIVE, killing) == 5 - np.log2(row.sum())
    assert sub_cube(FIVE, [FIVE_KEYS[0], FIVE_KEYS[3]]) is None
    assert sub_cube(FIVE, []) is None
    three = space_of([3, 2])
    assert sub_cube(three, ["Aa0Ab0", "Aa1Ab0"]) is None
    assert sub_cube(three, ["Aa0Ab0", "Aa1Ab0", "Aa2Ab0"]) == 1


def test_part_of_the_grid_covers_part_of_the_combinations() -> None:
    found = curves(made(scattered()[:, :8], keys=FIVE_KEYS[:8]))
    random = found.curve("random")
    assert dict(random.t_way)[1][-1] == pytest.approx(0.8)  # 8 of 10 values: two axes stay benign
    assert len(random.kills.mean) == 8
    assert predict(found).sub_cubes == ()


def test_the_tables_tell_the_curves() -> None:
    found = curves(made(scattered()))
    names = "random", "draws", "lexicographic", "greedy", "2-way", "3-way", "4-way", "oracle"
    assert tuple(one.id for one in found.curves) == names
    random = found.curves[0]
    expected = without_replacement(32)[scattered().sum(axis=1)].sum(axis=0)
    assert random.kills.mean == pytest.approx(list(expected))
    assert random.difference is None
    assert len(predict(found).correlations[1].within) == 32
    text = render(curve_tables(found, predict(found)), Format.TABLE)
    assert [line for line in text.splitlines() if len(line) > 100] == []
    assert "Seeds are not resampled" in " ".join(text.split())
    assert f"{expected[5]:.1f}" in text
    assert " ".join(predict(found).answer[0].split()) in " ".join(text.split())


def test_without_an_array_nothing_is_judged() -> None:
    missing = predict(replace(whole := curves(made(scattered())), curves=whole.curves[:1]))
    assert "Not judged" in missing.answer[-1]
