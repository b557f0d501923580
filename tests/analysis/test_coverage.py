from __future__ import annotations

from itertools import combinations, product

import pytest
from builders import GRID, campaigns, flights, outcome, pool
from hypothesis import given
from hypothesis import strategies as st
from ranges import RANGED, drawn

from scaloft_fi.analysis.coverage import coverage, t_way
from scaloft_fi.analysis.pool import State
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.judge.outcome import BASELINE, Outcome

KEYS = [key for key, _ in GRID.points]


@pytest.mark.parametrize(("strength", "combinations_"), [(1, 10), (2, 40), (3, 80), (4, 80), (5, 32)])
def test_the_whole_grid_covers_every_combination(strength: int, combinations_: int) -> None:
    assert t_way(KEYS, GRID, strength).total == Ratio(combinations_, combinations_)


def test_six_situations_cover_every_pair() -> None:
    # the smallest pairwise suite of five binary axes
    suite = [
        "".join(f"{a}{v}" for a, v in zip("TOWDH", p, strict=True))
        for p in ("00000", "01000", "10011", "11101", "00111", "11110")
    ]
    assert t_way(suite, GRID, 2).total == Ratio(40, 40)
    assert t_way(suite, GRID, 5).total == Ratio(6, 32)


def test_one_situation_covers_one_combination_of_each_choice_of_axes() -> None:
    assert [t_way(KEYS[:1], GRID, t).total.part for t in (1, 2, 3, 4, 5)] == [5, 10, 10, 5, 1]


def test_more_axes_than_there_are_cover_nothing_of_nothing() -> None:
    assert t_way(KEYS, GRID, 6).total == Ratio(0, 0)


def test_a_situation_flown_twice_is_one_situation_and_two_draws() -> None:
    found = coverage([outcome(seed=0), outcome(seed=1), outcome("LATE-human@3s", seed=1)], GRID)
    assert (found.situations, found.draws) == (Ratio(1, 32), 2)


def test_draws_of_the_baseline_alone_are_draws_and_said_to_be_the_baselines_alone() -> None:
    found = coverage([outcome(seed=0), outcome("LATE-human@3s", seed=0), outcome(seed=1), outcome(seed=2)], GRID)
    assert (found.draws, found.pool) == (3, 2)


def test_a_situation_is_realised_when_all_its_values_came_true_in_one_baseline_flight() -> None:
    found = coverage([outcome(realised=False), outcome(situation=KEYS[1]), outcome("LATE-human@3s", KEYS[2])], GRID)
    assert found.realised == Ratio(1, 32)
    assert dict(found.by_axis)["T"] == Ratio(1, 2)


def test_an_invalid_flight_covers_nothing() -> None:
    assert coverage([outcome(invalid="worker died")], GRID) == coverage([], GRID)


def test_steady_pairs_are_counted_of_the_situations_that_have_a_pool() -> None:
    outcomes = pool(KEYS[0]) + pool(KEYS[1], vacuous=("SR2",)) + pool(KEYS[2], red=9, violated={"SR2": 3.0})
    outcomes += [*pool(KEYS[3], seeds=9), outcome("LATE-human@3s", KEYS[4])]
    found = coverage(outcomes, GRID)
    assert found.steady == Ratio(4, 6)
    assert found.states[State.STEADY] == 4
    assert sum(found.states.values()) == 10
    assert found.states == {
        State.STEADY: 4,
        State.UNSTEADY: 0,
        State.RED: 1,
        State.OPEN: 0,
        State.VACUOUS: 1,
        State.UNKNOWN: 4,
    }


@given(campaigns())
def test_every_safety_pair_of_the_situations_flown_has_one_state(outcomes: list[Outcome]) -> None:
    found = coverage(outcomes, GRID)
    requirements = 2 if any(o.subject.id == BASELINE and not o.invalid for o in outcomes) else 0
    assert sum(found.states.values()) == requirements * found.situations.part


def parts(found: list[Outcome]) -> list[int]:
    covered = coverage(found, GRID)
    ratios = [covered.situations, covered.realised, *(ratio for _, ratio in covered.t_way)]
    ratios += [found.complete(share) for found in covered.combinations for share in (0.5, 1.0)]
    ratios += [ratio for _, ratio in covered.requirements]
    return [covered.draws, *(ratio.part for ratio in ratios), *(ratio.part for _, ratio in covered.by_axis)]


@given(campaigns(), flights())
def test_coverage_never_falls_when_a_flight_is_added(outcomes: list[Outcome], more: Outcome) -> None:
    before, after = parts(outcomes), parts([*outcomes, more])
    assert all(a >= b for a, b in zip(after, before, strict=True))


@given(campaigns())
def test_t_way_coverage_is_counted_as_by_hand(outcomes: list[Outcome]) -> None:
    flown = {o.situation for o in outcomes if not o.invalid}
    for strength, ratio in coverage(outcomes, GRID).t_way:
        wanted = [
            (axes, values)
            for axes in combinations(range(5), strength)
            for values in product("01", repeat=strength)
            if any(all(GRID.point[k][a] == v for a, v in zip(axes, values, strict=True)) for k in flown)
        ]
        assert ratio.part == len(wanted)


@given(st.dictionaries(st.sampled_from(KEYS), st.floats(0, 1, exclude_max=True), min_size=1), st.booleans())
def test_drawn_numbers_cover_what_their_bins_cover(shares: dict[str, float], mutated: bool) -> None:
    def flown(keys: list[str]) -> list[Outcome]:
        clean = [outcome(situation=key, realised=place % 2 == 0) for place, key in enumerate(keys)]
        return clean + [outcome("LATE-human@3s", key) for key in keys if mutated]

    binned = coverage(flown(list(shares)), RANGED)
    assert coverage(flown([drawn(*entry) for entry in shares.items()]), RANGED) == binned


def test_two_numbers_of_a_bin_cover_one_situation_in_two_draws() -> None:
    keys = [drawn(KEYS[1], share) for share in (0.1, 0.9)]
    found = coverage([outcome(situation=key) for key in keys], RANGED)
    assert (found.situations, found.draws, found.realised) == (Ratio(1, 32), 2, Ratio(1, 32))
