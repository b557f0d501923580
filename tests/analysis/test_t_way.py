from __future__ import annotations

from itertools import combinations

from grids import keys_of, space_of, spaces
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.coverage import t_way
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.judge.space import Space


def by_hand(keys: list[str], space: Space, strength: int) -> list[int]:
    return [
        len({tuple(space.point[key][axis] for axis in axes) for key in keys})
        for axes in combinations(range(len(space.axes)), strength)
    ]


@given(spaces(), st.data())
def test_only_combinations_that_some_situation_has_are_counted(space: Space, data: st.DataObject) -> None:
    flown = data.draw(st.lists(st.sampled_from(keys_of(space)), unique=True))
    for strength in range(1, len(space.axes) + 1):
        found = t_way(flown, space, strength)
        assert [one.part for one in found.axes] == by_hand(flown, space, strength)
        assert [one.whole for one in found.axes] == by_hand(keys_of(space), space, strength)
        assert t_way(keys_of(space), space, strength).complete(1.0).value == 1.0


def test_completeness_counts_choices_of_axes() -> None:
    # 00, 01 on the first two axes is half of their pairs, and the third axis is 0 in both
    found = t_way(["Aa0Ab0Ac0", "Aa0Ab1Ac0"], space_of([2, 2, 2]), 2)
    assert [one.part for one in found.axes] == [2, 1, 2]
    assert (found.complete(0.5), found.complete(0.25), found.complete(0.51)) == (Ratio(2, 3), Ratio(3, 3), Ratio(0, 3))


def test_ten_axes_of_three_values_are_counted_without_listing_the_product() -> None:
    space = space_of([3] * 10)
    some = keys_of(space)[:: 59049 // 50][:50]
    for strength, wanted in ((2, 405), (3, 3240), (5, 61236)):
        assert t_way(some, space, strength).total.whole == wanted
