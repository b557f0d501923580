"""Coverage against kills: chances, redrawn campaigns, answers, the published page."""

from __future__ import annotations

from collections import Counter
from contextlib import nullcontext
from dataclasses import replace
from itertools import combinations, product
from types import SimpleNamespace

import numpy as np
import pytest
from builders import FIVE, GRID, ROSTER, keys_of, outcome, pool, seeded, space_of, spaces
from hypothesis import given, settings
from hypothesis import strategies as st

import experiments.coverage_against_kills as experiment
from experiments import ROOT, coverage_curves
from experiments.coverage_against_kills import predict
from scaloft_fi.analysis.coverage import covering_array, t_way
from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.score import score
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.study import Study

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""


def small() -> st.SearchStrategy[np.ndarray]:
    """(things, situations) of up to 5 situations."""
    rows = st.integers(2, 5).flatmap(
        lambda n: st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=1, max_size=4)
    )
    return rows.map(np.array)


@given(small())
def test_a_random_suite_meets_what_counting_all_suites_gives(found: np.ndarray):
    n = found.shape[1]
    chances = coverage_curves.without_replacement(n)[found.sum(axis=1)]
    for k in range(1, n + 1):
        counted = np.mean([found[:, suite].any(axis=1) for suite in combinations(range(n), k)], axis=0)
        assert np.allclose(chances[:, k - 1], counted)


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_seeds_come_out_as_often_as_in_all_draws_with_replacement(n: int):
    seeds = [10 * number for number in range(n)]
    counted = Counter(tuple(sorted(set(drawn))) for drawn in product(seeds, repeat=n))
    assert {drawn: chance * n**n for drawn, chance in coverage_curves.seed_draws(seeds)} == pytest.approx(counted)


def test_of_many_seeds_a_fixed_sample_of_the_sets_is_judged():
    drawn = coverage_curves.seed_draws(range(10))
    assert len(drawn) <= coverage_curves.MOST_SUBSETS
    assert sum(chance for _, chance in drawn) == pytest.approx(1)
    # of n draws n (1 - (1 - 1/n)^n) come out
    assert sum(chance * len(seeds) for seeds, chance in drawn) == pytest.approx(10 * (1 - 0.9**10), abs=0.5)
    assert drawn == coverage_curves.seed_draws(range(10))
    assert len(coverage_curves.seed_draws(range(6))) == 63


LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
KEYS = [key for key, _ in GRID.points]


def tried(outcomes: list[Outcome]) -> coverage_curves.Trial | None:
    return coverage_curves.trial(score(outcomes, ROSTER, GRID), rulings_of(outcomes), ROSTER, GRID)


def flown(mutant: str, situations: list[str], killing: list[str], seeds: int = 1) -> list[Outcome]:
    return [
        outcome(mutant, key, seed, violated={"SR1": 5.0} if key in killing else {}, digest=mutant)
        for key in situations
        for seed in range(seeds)
    ]


def test_the_trial_takes_the_default_mutants_that_were_flown_together():
    outcomes = pool(*KEYS[:8])
    outcomes += flown(LATE, KEYS[:6], KEYS[:3]) + flown(NO, KEYS[:6], KEYS[2:6])
    outcomes += flown(GOAL, KEYS[6:8], []) + flown("LATE-human@1s", KEYS[:8], KEYS[:8]) + flown("PLACEBO", KEYS[:8], [])
    found = tried(outcomes)
    assert found.situations == tuple(KEYS[:6])
    assert (found.mutants, found.parameters, found.left_out) == ((NO, LATE), ("human", "human"), (GOAL,))
    assert found.kills.astype(int).tolist() == [[0, 0, 1, 1, 1, 1], [1, 1, 1, 0, 0, 0]]
    assert (found.killed, len(found.kill_sets), found.unkilled) == (2, 2, ())
    assert tried([]) is None


def test_a_campaign_of_one_seed_has_no_seeds_to_resample_and_says_so():
    found = tried(pool(*KEYS[:6]) + flown(LATE, KEYS[:6], KEYS[:3]))
    assert (found.seeds, found.seed_sets) == ((0,), ())
    said = predict(coverage_curves.curves(found)).answer[-1]
    assert "only one in common" in said
    assert "nothing follows beyond this seed" in said


def test_seeds_that_only_some_mutants_flew_stand():
    outcomes = pool(*KEYS[:6]) + flown(LATE, KEYS[:6], KEYS[:3], seeds=3) + flown(NO, KEYS[:6], KEYS[:4], seeds=2)
    found = tried(outcomes)
    assert (found.seeds, found.more_seeds) == ((0, 1), (2,))
    assert [one.seeds for one in found.seed_sets] == [(0,), (1,), (0, 1)]
    assert (found.seed_sets[-1].kills == found.kills).all()


def test_seeds_are_judged_anew_with_the_alpha_that_the_campaign_spends():
    # one situation and three seeds: p = 0.0070, enough where alpha is spent once, not where it is spent by looks
    outcomes = pool(*KEYS[:2]) + flown(LATE, KEYS[:2], KEYS[:1], seeds=3)
    for spending, killed in ((Spending(), 1), (Spending(grown=frozenset({LATE})), 0)):
        scored = score(outcomes, ROSTER, GRID, spending)
        found = coverage_curves.trial(scored, rulings_of(outcomes), ROSTER, GRID, spending)
        assert [found.kills.sum(), found.seed_sets[-1].kills.sum()] == [killed, killed]


@settings(max_examples=10, deadline=None)
@given(seeded())
def test_the_kills_of_some_seeds_are_those_of_a_campaign_flown_with_these_beside_the_whole_pool(
    outcomes: list[Outcome],
):
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


def made(kills: np.ndarray, space: Space = FIVE, keys: tuple[str, ...] | None = None) -> coverage_curves.Trial:
    names = tuple(f"NO-p{number % 4}@{number}s" for number in range(len(kills)))
    keys = keys or tuple(keys_of(space))
    return coverage_curves.Trial(space, keys, names, tuple(name.split("-")[1].split("@")[0] for name in names), kills)


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


def test_mutants_that_die_in_blocks_are_killed_as_combinations_are_covered():
    """The identity: kills at k random situations are expected t-way coverage, for every t and k."""
    for strength in (1, 2, 3, 4):
        kills = np.array([row for row in blocks() if row.sum() == 2 ** (5 - strength)])
        random = coverage_curves.curves(made(kills)).curve("random")
        covered = dict(random.t_way)[strength]
        assert np.allclose(np.array(random.kills.mean) / len(kills), covered)


def test_a_covering_array_kills_every_block_of_its_strength_and_random_situations_do_not():
    kills = np.array([row for row in blocks() if row.sum() == 8])
    found = coverage_curves.curves(made(kills))
    array = found.curve("2-way")
    assert array.kills.mean[-1] == pytest.approx(40)
    assert array.difference.low[-1] > 0
    assert array.matched > 6
    assert "Here yes: 2 of 3 covering arrays meet more" in predict(found).answer[-1]


def test_mutants_that_die_everywhere_or_nowhere_tell_nothing():
    kills = np.array([[True] * 32, [False] * 32])
    found = coverage_curves.curves(made(kills))
    assert all(curve.kills.mean[-1] == pytest.approx(1) for curve in found.curves)
    said = predict(found)
    assert "Not shown here" in said.answer[-1]
    assert all(tau is None for one in said.correlations for tau in one.within)
    assert "nothing follows" in predict(coverage_curves.curves(made(kills[1:]))).answer[-1].lower()


def test_an_array_that_kills_fewer_than_random_situations_is_said_to():
    # a 4-way array of 16 is all points of one parity: of two deadly points of equal parity it has both or none
    even = [number for number, (_, point) in enumerate(FIVE.points) if point.count("1") % 2 == 0]
    kills = np.zeros((120, 32), bool)
    for mutant, pair in enumerate(combinations(even, 2)):
        kills[mutant, list(pair)] = True
    found = coverage_curves.curves(made(kills))
    array, random = found.curve("4-way"), found.curve("random")
    assert array.kills.mean[-1] == pytest.approx(60)
    assert random.kills.mean[15] == pytest.approx(120 * (1 - 15 * 16 / (31 * 32)))
    assert array.difference.high[-1] < 0
    assert array.distinct.high[-1] < 0
    assert "No: 1 of 3 covering arrays meets fewer" in predict(found).answer[-1]


def test_arrays_that_differ_in_both_directions_are_said_to():
    # pairs of one parity, which an array of 16 meets less often, and blocks, which one of 6 meets more often
    even = [number for number, (_, point) in enumerate(FIVE.points) if point.count("1") % 2 == 0]
    pairs = [np.isin(np.arange(32), pair) for pair in combinations(even, 2)]
    kills = np.array([*pairs, *(row for row in blocks() if row.sum() == 8)])
    assert (
        "Not in one direction: 2 of 3 covering arrays meet more"
        in predict(coverage_curves.curves(made(kills))).answer[-1]
    )


def test_the_answer_ends_with_what_the_figures_carry_and_what_not():
    whole, part = (
        predict(coverage_curves.curves(made(scattered()))),
        predict(coverage_curves.curves(made(scattered()[:, :8], keys=FIVE_KEYS[:8]))),
    )
    for said in (whole.answer[-1], part.answer[-1]):
        assert "mutants of this matrix within their parameter" in said
        assert "do not carry to another grid or another drone" in said
    assert whole.answer[-1].endswith("the 32 situations are the whole grid, a census and no sample.")
    assert part.answer[-1].endswith("the 8 situations are those that were flown, no sample of others.")


@settings(max_examples=15, deadline=None)
@given(spaces(most=12), st.data())
def test_every_strategy_keeps_the_laws(space: Space, data: st.DataObject):
    keys = tuple(keys_of(space))
    rows = data.draw(st.lists(st.lists(st.booleans(), min_size=len(keys), max_size=len(keys)), min_size=1, max_size=5))
    found = coverage_curves.curves(made(np.array(rows), space))
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


@pytest.mark.parametrize("strength", [2, 3, 4])
def test_relabelled_arrays_have_every_situation_equally_often_and_stay_arrays(strength: int):
    suites = coverage_curves.relabelled(FIVE, FIVE_KEYS, covering_array(FIVE, FIVE_KEYS, strength, 0))
    assert len(set(np.bincount(suites.ravel(), minlength=32))) == 1
    for suite in suites[:20]:
        assert t_way([FIVE_KEYS[number] for number in suite], FIVE, strength).total.value == 1.0


def test_blocks_are_told_from_other_sets():
    for row in blocks():
        killing = [key for key, killed in zip(FIVE_KEYS, row, strict=True) if killed]
        assert coverage_curves.sub_cube(FIVE, killing) == 5 - np.log2(row.sum())
    assert coverage_curves.sub_cube(FIVE, [FIVE_KEYS[0], FIVE_KEYS[3]]) is None
    assert coverage_curves.sub_cube(FIVE, []) is None
    three = space_of([3, 2])
    assert coverage_curves.sub_cube(three, ["Aa0Ab0", "Aa1Ab0"]) is None
    assert coverage_curves.sub_cube(three, ["Aa0Ab0", "Aa1Ab0", "Aa2Ab0"]) == 1


def test_part_of_the_grid_covers_part_of_the_combinations():
    found = coverage_curves.curves(made(scattered()[:, :8], keys=FIVE_KEYS[:8]))
    random = found.curve("random")
    assert dict(random.t_way)[1][-1] == pytest.approx(0.8)  # 8 of 10 values: two axes stay benign
    assert len(random.kills.mean) == 8
    assert predict(found).sub_cubes == ()


def test_without_an_array_nothing_is_judged():
    missing = predict(replace(whole := coverage_curves.curves(made(scattered())), curves=whole.curves[:4]))
    assert "Not judged" in missing.answer[-1]


TWO = KEYS[:2]


def test_a_campaign_without_default_mutants_is_refused(monkeypatch: pytest.MonkeyPatch):
    now = SimpleNamespace(rulings=rulings_of([*pool(*TWO), outcome("LATE-human@1s", TWO[0])]), spending=Spending())
    monkeypatch.setattr(experiment, "snapshot", lambda _study, _campaign: nullcontext(now))
    with pytest.raises(InputError, match="needs default mutants of credible cells: none was flown"):
        experiment.pages(Study.open(ROOT), "any")
