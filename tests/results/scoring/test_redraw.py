from __future__ import annotations

import pytest
from builders import GRID, ROSTER, outcome
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.scoring.ratio import Ratio
from scaloft_fi.results.scoring.redraw import redraw
from scaloft_fi.results.scoring.score import score

LATE, GOAL = "LATE-human@3s", "MORE-goal@0.6m"
KEYS = [key for key, _ in GRID.points]


def baselines(key: str, seeds: int, red: int = 0, **how: str) -> list[Outcome]:
    """The last `red` of them violate SR1; every flight has its own digest."""
    return [
        outcome(BASELINE, key, s, violated={"SR1": 30.0} if s >= seeds - red else {}, digest=f"{key}{s}", **how)  # type: ignore[arg-type]
        for s in range(seeds)
    ]


@given(st.integers(2, 12).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, n))))
def test_a_red_seed_is_killed_beside_every_green_one(seeds: tuple[int, int]) -> None:
    """SR2 is held by the red ones too, so they are eligible baselines, of which a green one is no kill."""
    n, red = seeds
    assert redraw({KEYS[0]: baselines(KEYS[0], n, red)}).rate == Ratio((n - red) * red, n * (n - 1))


def test_a_seed_that_is_cut_short_holds_nothing_and_makes_no_eligible_pair() -> None:
    cut = outcome(BASELINE, KEYS[0], 1, violated={"SR1": 30.0}, struck="bar", digest="cut")
    assert redraw({KEYS[0]: [outcome(BASELINE, KEYS[0]), cut]}).rate == Ratio(1, 1)


def test_one_seed_or_an_invalid_second_measures_nothing() -> None:
    assert redraw({KEYS[0]: baselines(KEYS[0], 1)}).pairs == {}
    assert redraw({KEYS[0]: [*baselines(KEYS[0], 1), outcome(BASELINE, KEYS[0], 5, invalid="died")]}).pairs == {}
    assert redraw({}).rate == Ratio(0, 0)


def test_seeds_never_meet_those_of_another_situation() -> None:
    pool = {KEYS[0]: baselines(KEYS[0], 4), KEYS[1]: baselines(KEYS[1], 4, red=4)}
    assert redraw(pool).rate == Ratio(0, 24)


def test_the_expected_false_kills_are_each_situations_rate_times_its_eligible_flights() -> None:
    pool = {KEYS[0]: baselines(KEYS[0], 4, red=1), KEYS[1]: baselines(KEYS[1], 4)}
    measured = redraw(pool)
    assert measured.expected({KEYS[0]: 8, KEYS[1]: 100, KEYS[2]: 7}) == (pytest.approx(3 / 12 * 8), 108)
    assert measured.expected({KEYS[2]: 7}) is None
    assert measured.expected({KEYS[0]: 0}) is None


def test_the_score_counts_the_eligible_flights_of_the_default_mutants() -> None:
    outcomes = [
        *baselines(KEYS[0], 4, red=1),
        *(outcome(LATE, KEYS[0], seed) for seed in range(4)),
        *(outcome(GOAL, KEYS[0], seed, altered=0) for seed in range(4)),
        *(outcome("LATE-human@1s", KEYS[0], seed) for seed in range(4)),
        *(outcome("REVERSE-human", KEYS[0], seed) for seed in range(4)),
    ]
    assert score(outcomes, ROSTER, GRID).false_kills == (pytest.approx(3 / 12 * 4), 4)


def test_left_out_seeds_are_judged_as_mutants_beside_the_rest() -> None:
    measured = redraw({key: baselines(key, 20) for key in KEYS[:3]})
    assert (measured.left_out, measured.decided) == (10, Ratio(0, 2))
    # ten seeds that all violate, and forty that do not: the block of the ten is killed, as it must be
    assert redraw({KEYS[0]: baselines(KEYS[0], 50, red=10)}).decided == Ratio(1, 5)
    assert redraw({KEYS[0]: baselines(KEYS[0], 7)}).left_out == 3
    assert redraw({KEYS[0]: baselines(KEYS[0], 5)}).left_out == 0
