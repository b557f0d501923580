"""What the arms propose: one opening, then each in its own way, all of them equally often off the benign values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, product
from pathlib import Path
from statistics import mean

import pytest
from search_or_chance.pairs import array
from search_or_chance.proposers import ARMS, SEARCH

from scaloft_fi.campaign.runs.seeking.proposals import GENERATION, OPENING, Possible, opening, placed
from scaloft_fi.sim.free_axis import DEVIATES
from scaloft_fi.sim.grids import load_grid
from scaloft_fi.sim.situation import Situation

GRID = load_grid(Path(__file__).parents[3] / "sim", "search")
SMALL = replace(GRID, free=tuple(axis for axis in GRID.free if axis.id in ("Cs", "Ox", "Px", "Li", "Ey")))
"""With fewer free axes, for which an array is built quickly."""
CHANCE = [arm for arm in ARMS if arm != SEARCH]


def light_or_wide(one: Situation) -> bool:
    return one["W"] == 0 or one["D"] == 0


def proposed(
    arm: str, generations: int, *, mutant: str = "A", seed: int = 3, possible: Possible = lambda _: True
) -> list[Situation]:
    proposer = ARMS[arm](SMALL, possible, seed, mutant)
    told: list[Situation] = []
    for _ in range(generations):
        asked = proposer.ask()
        for one in asked:
            one.distance = 0.5
        proposer.tell(asked)
        told += [one.situation for one in asked]
    assert proposer.count == len(told)
    assert proposer.nearest == 0.5
    return told


@pytest.fixture(scope="module")
def sequences() -> dict[str, list[Situation]]:
    return {arm: proposed(arm, 4, possible=light_or_wide) for arm in ARMS}


def test_all_arms_begin_with_the_opening_and_then_differ(sequences: dict[str, list[Situation]]) -> None:
    shared = [
        one for one in (placed(SMALL, row) for row in opening(SMALL, 3)) if one is not None and light_or_wide(one)
    ]
    assert GENERATION < len(shared) <= OPENING
    assert all(told[: len(shared)] == shared for told in sequences.values())
    assert len({tuple(told[len(shared) :]) for told in sequences.values()}) == len(ARMS)


def test_proposals_are_distinct_and_possible(sequences: dict[str, list[Situation]]) -> None:
    for told in sequences.values():
        assert len(set(told)) == len(told) == 4 * GENERATION
        assert all(map(light_or_wide, told))


def test_chance_proposes_the_same_to_every_mutant_and_other_situations_with_another_seed() -> None:
    for arm in CHANCE:
        assert proposed(arm, 3, mutant="A") == proposed(arm, 3, mutant="B")
        assert not set(proposed(arm, 3, seed=4)) & {one for one in proposed(arm, 3) if one.numbers}
    assert proposed(SEARCH, 4, mutant="A") != proposed(SEARCH, 4, mutant="B")


def test_what_the_arms_of_chance_learn_changes_nothing() -> None:
    def told(distance: float) -> list[Situation]:
        proposer = ARMS["low-discrepancy"](SMALL, lambda _: True, 3, "A")
        found = []
        for _ in range(4):
            asked = proposer.ask()
            for one in asked:
                one.distance = distance
            proposer.tell(asked)
            found += [one.situation for one in asked]
        return found

    assert told(-1.0) == told(1.0)


@pytest.mark.parametrize("arm", ["random", "low-discrepancy"])
def test_a_free_axis_is_off_its_benign_value_as_often_as_in_a_random_draw(arm: str) -> None:
    told = proposed(arm, 40)[OPENING:]
    assert mean("Cs" in dict(one.numbers) for one in told) == pytest.approx(DEVIATES, abs=0.06)
    corner = [one for one in told if one["T"] == 1]
    assert mean("Ey" in dict(one.numbers) for one in corner) == pytest.approx(DEVIATES, abs=0.09)


def test_low_discrepancy_is_more_even_than_random() -> None:
    def unevenness(arm: str) -> float:
        shares = sorted(one["O"] * 3 + one["H"] for one in proposed(arm, 14)[OPENING:])
        return mean(abs(shares.count(cell) / len(shares) - 1 / 12) for cell in range(12) if cell // 3 != 2)

    assert unevenness("low-discrepancy") < 0.7 * unevenness("random")


def test_an_array_has_every_pair_of_values_and_bins_that_a_situation_has() -> None:
    def states(one: Situation) -> dict[str, int]:
        return {**dict(one.levels), **{axis.id: int(axis.id in dict(one.numbers)) for axis in SMALL.free}}

    def possible(pair: Sequence[tuple[str, int]]) -> bool:
        wanted = dict(pair)
        free = {axis.id: axis for axis in SMALL.free}
        every = (dict(one.levels) for one in SMALL.situations)
        return any(
            all((levels[a] == v) if a in levels else (not v or free[a].goes_with(levels)) for a, v in wanted.items())
            for levels in every
        )

    situations = [one for row in array(SMALL, 3, 0) if (one := placed(SMALL, row)) is not None]
    had = {pair for one in situations for pair in combinations(sorted(states(one).items()), 2)}
    values = {axis.id: [value.id for value in axis.values] for axis in SMALL.axes}
    values |= {axis.id: [0, 1] for axis in SMALL.free}
    named = [[(axis, value) for value in values[axis]] for axis in sorted(values)]
    asked = {pair for one, other in combinations(named, 2) for pair in product(one, other)}
    assert {pair for pair in asked if possible(pair)} == had
    assert len(situations) == len(array(SMALL, 3, 0)) < 30
    assert set(situations) != {placed(SMALL, row) for row in array(SMALL, 3, 1)}
