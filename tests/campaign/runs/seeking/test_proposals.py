"""Proposals: possible, distinct, the same for the same seed, nearer to what was good."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

from scaloft_fi.campaign.runs.seeking.proposals import GENERATION, OPENING, Proposals, draws, opening, placed
from scaloft_fi.sim.grids import load_grid
from scaloft_fi.sim.situation import Situation

GRID = load_grid(Path(__file__).parents[4] / "sim", "search")


def distance(situation: Situation) -> float:
    """Near with a person and at speed."""
    return 0.5 * (situation["H"] != 1) + 1.2 - dict(situation.numbers).get("Cs", 0.5)


def flown(seed: int, generations: int, mutant: str = "A", possible=lambda _: True) -> list[list[Situation]]:
    proposals, told = Proposals(GRID, possible, seed, mutant), []
    for _ in range(generations):
        asked = proposals.ask()
        for one in asked:
            one.distance = distance(one.situation)
        proposals.tell(asked)
        told.append([one.situation for one in asked])
    return told


def test_the_first_proposals_are_the_same_for_every_mutant_and_then_each_has_its_own():
    first, second = flown(0, 3, "A"), flown(0, 3, "B")
    assert first[:2] == second[:2]
    assert first[2] != second[2]
    assert [placed(GRID, parameters) for parameters in opening(GRID, 0)] == first[0] + first[1]
    assert OPENING == 2 * GENERATION


def test_the_same_seed_proposes_the_same_and_another_seed_others():
    assert flown(3, 3) == flown(3, 3)
    assert flown(3, 1) != flown(4, 1)


def test_proposals_are_distinct_situations_of_the_grid_with_short_numbers():
    asked = [one for generation in flown(0, 4) for one in generation]
    assert len(set(asked)) == len(asked) == 4 * GENERATION
    assert all(GRID.situation(one.key) == one for one in asked)
    digits = [len(f"{abs(number):g}".replace(".", "").strip("0")) for one in asked for _, number in one.numbers]
    assert sum(count > 2 for count in digits) < len(digits) / 10


def test_what_is_impossible_is_not_proposed():
    asked = [one for generation in flown(0, 3, possible=lambda one: one["T"] == 0) for one in generation]
    assert asked
    assert all(one["T"] == 0 for one in asked)


def test_later_proposals_are_nearer_to_what_was_good():
    told = flown(0, 7)
    before, after = ([distance(one) for generation in part for one in generation] for part in (told[:2], told[5:]))
    assert sum(after) / len(after) < sum(before) / len(before) - 0.1


def test_further_draws_take_half_of_each_generation_after_the_opening():
    drawn = [placed(GRID, parameters) for parameters in islice(draws(GRID, 0), OPENING + GENERATION)]
    further = islice(draws(GRID, 0), OPENING, None)
    proposals, told = Proposals(GRID, lambda _: True, 0, "A", further), []
    for _ in range(4):
        asked = proposals.ask()
        for one in asked:
            one.distance = distance(one.situation)
        proposals.tell(asked)
        told.append([one.situation for one in asked])
    half = GENERATION // 2
    assert told[0] + told[1] + told[2][:half] + told[3][:half] == drawn
    assert not {*told[2][half:], *told[3][half:]} & {*drawn}
