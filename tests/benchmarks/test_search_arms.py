"""What the arms propose: one opening, then each in its own way, all of them equally often off the benign values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, product
from statistics import mean

import pytest

from experiments import ROOT
from experiments.search_arms import ARMS, SEARCH, array, with_ends
from scaloft_fi.analysis.seeking import brief
from scaloft_fi.campaign.seeking.seek import Parameters, Proposal, Proposer, at_shares, placed
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.sim.situation import DEVIATES, Situation

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""

GRID = load_grid(ROOT / "sim", "search")
SMALL = replace(GRID, free=tuple(axis for axis in GRID.free if axis.id in ("Cs", "Ox", "Px", "Li", "Ey")))
TINY = replace(GRID, free=tuple(axis for axis in GRID.free if axis.id in ("Cs", "Ox", "Ey")))
"""With fewer free axes, for which an array is built quickly."""
CHANCE = [arm for arm in ARMS if arm != SEARCH]
SPEED = next(axis for axis in GRID.free if axis.id == "Cs")


def light_or_wide(one: Situation) -> bool:
    return one["W"] == 0 or one["D"] == 0


def proposers(arm: str, seed: int = 3) -> list[Proposer]:
    """Those of two mutants of one search."""
    make, grid = ARMS[arm](), TINY if arm == "2-way" else SMALL
    return [make(grid, light_or_wide, seed, mutant) for mutant in "AB"]


def asked(proposer: Proposer, count: int) -> list[Situation]:
    return [one.situation for one in proposer.ask(count)]


@pytest.fixture(scope="module")
def lists() -> dict[str, list[Situation]]:
    return {arm: asked(proposers(arm)[0], 30 if arm == "2-way" else 120) for arm in CHANCE}


def test_chance_proposes_distinct_and_possible_situations(lists: dict[str, list[Situation]]):
    for told in lists.values():
        assert len(set(told)) == len(told) >= 30
        assert all(map(light_or_wide, told))
    assert len({tuple(told[:8]) for told in lists.values()}) == len(CHANCE)


@pytest.mark.parametrize("arm", CHANCE)
def test_the_mutants_of_a_block_share_one_list(arm: str, lists: dict[str, list[Situation]]):
    first, second = proposers(arm)
    assert [*asked(first, 2), *asked(second, 3), *asked(first, 2)] == lists[arm][:7]


@pytest.mark.parametrize("arm", CHANCE)
def test_another_seed_gives_another_list(arm: str, lists: dict[str, list[Situation]]):
    assert asked(proposers(arm, seed=4)[0], 7) != lists[arm][:7]


def test_what_chance_is_told_changes_nothing_and_is_counted(lists: dict[str, list[Situation]]):
    first, second = proposers("random")
    told = zip(lists["random"], (0.7, -1.0), strict=False)
    first.tell([(Proposal(one, {}), distance) for one, distance in told])
    assert (first.nearest, first.count, second.count) == (-1.0, 2, 0)
    assert asked(first, 4) == lists["random"][:4]


@pytest.mark.parametrize("arm", ["random", "low-discrepancy"])
def test_a_free_axis_is_off_its_benign_value_as_often_as_in_a_random_draw(arm: str, lists: dict[str, list[Situation]]):
    assert mean("Cs" in dict(one.numbers) for one in lists[arm]) == pytest.approx(DEVIATES, abs=0.09)


def test_half_of_the_numbers_off_their_benign_values_are_at_an_end_of_their_range():
    def speed(share: float) -> float | None:
        return SPEED.drawn(with_ends(GRID, lambda _axis, what: share if what == "number" else 0.0)["Cs"])

    off = [1 - DEVIATES + DEVIATES * (number + 0.5) / 40 for number in range(40)]
    numbers = [one for share in off if (one := speed(share)) is not None]
    assert len(numbers) == 40
    assert numbers == sorted(numbers)
    assert numbers.count(numbers[0]) == numbers.count(numbers[-1]) == 10
    assert (numbers[0], brief(numbers[-1])) == (SPEED.low, SPEED.high)
    assert speed(0.5) is None


def test_low_discrepancy_is_more_even_than_random(lists: dict[str, list[Situation]]):
    def unevenness(arm: str) -> float:
        shares = [one["O"] * 3 + one["H"] for one in lists[arm] if one["O"] < 2]
        return mean(abs(shares.count(cell) / len(shares) - 1 / 6) for cell in range(6))

    assert unevenness("low-discrepancy") < 0.7 * unevenness("random")


def test_an_array_has_every_pair_of_values_and_bins_that_a_situation_has():
    def states(parameters: Parameters) -> dict[str, int]:
        return {axis.id: int(parameters[axis.id]) for axis in TINY.axes} | {
            axis.id: int(parameters.get(axis.id, 0) >= 1 - DEVIATES) for axis in TINY.free
        }

    def possible(pair: Sequence[tuple[str, int]]) -> bool:
        wanted = dict(pair)
        free = {axis.id: axis for axis in TINY.free}
        every = (dict(one.levels) for one in TINY.situations)
        return any(
            all((levels[a] == v) if a in levels else (not v or free[a].goes_with(levels)) for a, v in wanted.items())
            for levels in every
        )

    rows = [at_shares(TINY, share) for share in array(TINY, 3, 0)]
    had = {pair for row in rows for pair in combinations(sorted(states(row).items()), 2)}
    values = {axis.id: [value.id for value in axis.values] for axis in TINY.axes}
    values |= {axis.id: [0, 1] for axis in TINY.free}
    named = [[(axis, value) for value in values[axis]] for axis in sorted(values)]
    asked = {pair for one, other in combinations(named, 2) for pair in product(one, other)}
    assert {pair for pair in asked if possible(pair)} == had
    assert all(placed(TINY, row) is not None for row in rows)
    assert len(rows) < 30
    assert rows != [at_shares(TINY, share) for share in array(TINY, 3, 1)]
