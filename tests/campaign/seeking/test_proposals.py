"""Proposals: possible, distinct, the same for the same seed, nearer to what was good."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

from scaloft_fi.campaign.seeking.proposals import OPENING, Proposals, draws, opening
from scaloft_fi.sim.grids import load_grid
from scaloft_fi.sim.situation import Situation

GRID = load_grid(Path(__file__).parents[3] / "sim", "search")


def distance(situation: Situation) -> float:
    """Near with a person and at speed."""
    return 0.5 * (situation["H"] != 1) + 1.2 - dict(situation.numbers).get("Cs", 0.5)


def anything(_situation: Situation) -> bool:
    return True


def flown(seed: int, generations: int, mutant: str = "A", possible=anything) -> list[list[Situation]]:
    """The opening, then generations of eight."""
    proposals, first = Proposals(GRID, possible, seed, mutant), list(opening(GRID, seed, possible))
    proposals.tell([(one, distance(one.situation)) for one in first])
    told = [[one.situation for one in first]]
    for _ in range(generations):
        asked = proposals.ask(8)
        proposals.tell([(one, distance(one.situation)) for one in asked])
        told.append([one.situation for one in asked])
    return told


def test_the_first_situations_are_the_same_for_every_mutant_and_then_each_has_its_own():
    first, second = flown(0, 1, "A"), flown(0, 1, "B")
    assert len(first[0]) == OPENING
    assert first[0] == second[0]
    assert first[1] != second[1]


def test_half_of_the_numbers_of_the_opening_are_at_an_end_of_their_range():
    ends = {axis.id: (axis.distribution.low, axis.distribution.high) for axis in GRID.free}
    numbers = [(axis, number) for one in flown(0, 0)[0] for axis, number in one.numbers]
    at_end = sum(min(abs(number - end) for end in ends[axis]) < 0.01 * ends[axis][1] for axis, number in numbers)
    assert 0.35 < at_end / len(numbers) < 0.65
    assert 4 < len(numbers) / OPENING < 8


def test_the_same_seed_proposes_the_same_and_another_seed_others():
    assert flown(3, 2) == flown(3, 2)
    assert not {*flown(3, 0)[0]} & {*flown(4, 0)[0]}


def test_proposals_are_distinct_situations_of_the_grid_with_short_numbers():
    asked = [one for generation in flown(0, 4) for one in generation]
    assert len(set(asked)) == len(asked) == OPENING + 4 * 8
    assert all(GRID.situation(one.key) == one for one in asked)
    digits = [len(f"{abs(number):g}".replace(".", "").strip("0")) for one in asked for _, number in one.numbers]
    assert sum(count > 2 for count in digits) < len(digits) / 10


def test_what_is_impossible_is_not_proposed():
    asked = [one for generation in flown(0, 3, possible=lambda one: one["T"] == 0) for one in generation]
    assert len(asked) > OPENING
    assert all(one["T"] == 0 for one in asked)


def test_later_proposals_are_nearer_to_what_was_good():
    told = flown(0, 5)
    before, after = ([distance(one) for generation in part for one in generation] for part in (told[:1], told[4:]))
    assert sum(after) / len(after) < sum(before) / len(before) - 0.1


def test_what_another_proposed_is_known_and_learned_from():
    """A search that is told of good situations only by others goes where they are, and proposes none of them."""
    told, lone = Proposals(GRID, anything, 0, "A"), Proposals(GRID, anything, 0, "A")
    first = list(opening(GRID, 0, anything))
    theirs = [one for seed in range(1, 4) for one in opening(GRID, seed, anything)]
    for proposals, more in ((told, theirs), (lone, [])):
        proposals.tell([(one, distance(one.situation)) for one in (*first, *more)])
    own, alone = ([one.situation for one in proposals.ask(8)] for proposals in (told, lone))
    assert sum(map(distance, own)) < sum(map(distance, alone))
    assert told.nearest == min(distance(one.situation) for one in (*first, *theirs))
    assert not {*own} & {one.situation for one in (*first, *theirs)}


def test_draws_go_on_after_the_opening_and_end_where_no_more_are_found():
    drawn = [one.situation for one in islice(draws(GRID, 0, anything), OPENING + 8)]
    assert len({*drawn}) == OPENING + 8
    assert drawn[:OPENING] == [one.situation for one in opening(GRID, 0, anything)]
    assert list(draws(GRID, 0, lambda one: one in drawn[:3])) == list(islice(draws(GRID, 0, anything), 3))
