from __future__ import annotations

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from grids import FIVE, keys_of, space_of, spaces
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.coverage_against_kills.chance import without_replacement
from experiments.coverage_against_kills.curve_tables import curve_tables, curves_json
from experiments.coverage_against_kills.curves import curves
from experiments.coverage_against_kills.orders import relabelled
from experiments.coverage_against_kills.prediction import correlate, predict
from experiments.coverage_against_kills.redrawn import SeedSet
from experiments.coverage_against_kills.trial import Trial, sub_cube
from scaloft_fi.analysis.coverage import covering_array, t_way
from scaloft_fi.judge.space import Space
from scaloft_fi.views.table import Format, render

KEYS = tuple(keys_of(FIVE))


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
    whole, part = predict(curves(made(scattered()))), predict(curves(made(scattered()[:, :8], keys=KEYS[:8])))
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
    suites = relabelled(FIVE, KEYS, covering_array(FIVE, KEYS, strength, 0))
    assert len(set(np.bincount(suites.ravel(), minlength=32))) == 1
    for suite in suites[:20]:
        assert t_way([KEYS[number] for number in suite], FIVE, strength).total.value == 1.0


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
        killing = [key for key, killed in zip(KEYS, row, strict=True) if killed]
        assert sub_cube(FIVE, killing) == 5 - np.log2(row.sum())
    assert sub_cube(FIVE, [KEYS[0], KEYS[3]]) is None
    assert sub_cube(FIVE, []) is None
    three = space_of([3, 2])
    assert sub_cube(three, ["Aa0Ab0", "Aa1Ab0"]) is None
    assert sub_cube(three, ["Aa0Ab0", "Aa1Ab0", "Aa2Ab0"]) == 1


def test_part_of_the_grid_covers_part_of_the_combinations() -> None:
    found = curves(made(scattered()[:, :8], keys=KEYS[:8]))
    random = found.curve("random")
    assert dict(random.t_way)[1][-1] == pytest.approx(0.8)  # 8 of 10 values: two axes stay benign
    assert len(random.kills.mean) == 8
    assert predict(found).sub_cubes == ()


def test_json_and_tables_tell_the_same() -> None:
    found = curves(made(scattered()))
    said = curves_json(found, predict(found))
    assert (said["mutants"], said["situations"], said["grid"]) == (30, 32, 32)
    assert [one["id"] for one in said["strategies"]] == [
        *("random", "draws", "lexicographic", "greedy", "2-way", "3-way", "4-way", "oracle")
    ]
    random = said["strategies"][0]
    expected = without_replacement(32)[scattered().sum(axis=1)].sum(axis=0)
    assert random["kills"]["mean"] == pytest.approx(list(expected))
    assert random["difference"] is None
    assert len(said["correlation"][1]["within"]) == 32
    assert (said["kill_sets"], said["seeds"], said["seeds_resampled"]) == (len(found.trial.kill_sets), [], False)
    text = render(curve_tables(found, predict(found)), Format.TABLE)
    assert [line for line in text.splitlines() if len(line) > 100] == []
    assert "Seeds are not resampled" in " ".join(text.split())
    assert f"{expected[5]:.1f}" in text
    assert " ".join(said["answer"][0].split()) in " ".join(text.split())


def test_without_the_library_the_arrays_are_named_as_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("experiments.coverage_against_kills.curves.find_spec", lambda _: None)
    found = curves(made(scattered()))
    assert [name for name, _ in found.missing] == ["2-way array", "3-way array", "4-way array"]
    assert "Not judged" in predict(found).answer[-1]
