from __future__ import annotations

from itertools import product

import pytest
from builders import GRID, ROSTER, pool, thrice
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.condition import admits
from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.suite import NIST, Interaction, interactions, order, orders
from scaloft_fi.judge.space import Space

THREE = Space(
    axes=("light", "floor", "people"),
    values=(("0", "1", "2"), ("0", "1"), ("0", "1")),
    words=(("bright", "dim", "dark"), ("dry", "wet"), ("nobody", "human")),
    points=tuple((f"L{a}F{b}P{c}", (a, b, c)) for a, b, c in product("012", "01", "01")),
)
fates = st.lists(st.sampled_from(["kill", "survive", "unknown"]), min_size=12, max_size=12).filter(
    lambda drawn: "kill" in drawn
)


def least_literals(killing: list[str], surviving: list[str]) -> int:
    """Over every box of the grid, with any set of values on each axis."""
    sets = [
        [frozenset(v for v, inside in zip(values, bits, strict=True) if inside) for bits in product((0, 1), repeat=n)]
        for values in THREE.values
        for n in (len(values),)
    ]
    boxes = [
        box
        for box in product(*sets)
        if any(admits(box, THREE.point[key]) for key in killing)
        and not any(admits(box, THREE.point[key]) for key in surviving)
    ]
    return min(
        sum(len(chosen) < len(values) for chosen, values in zip(box, THREE.values, strict=True)) for box in boxes
    )


@settings(deadline=None, max_examples=usually(25, release=60))
@given(fates)
def test_the_order_is_the_fewest_literals_of_any_box_without_a_survivor(drawn: list[str]) -> None:
    keys = [key for key, _ in THREE.points]
    killing = [key for key, fate in zip(keys, drawn, strict=True) if fate == "kill"]
    surviving = [key for key, fate in zip(keys, drawn, strict=True) if fate == "survive"]
    assert order(THREE, killing, surviving) == least_literals(killing, surviving)


def test_human_and_light_is_of_order_two() -> None:
    killing = [key for key in GRID.point if "D0" in key and "H1" in key]
    assert order(GRID, killing, [key for key in GRID.point if key not in killing]) == 2
    assert order(GRID, list(GRID.point), []) == 0
    assert order(GRID, ["T0O0W0D0H0"], [key for key in GRID.point if key != "T0O0W0D0H0"]) == 5


def test_no_order_without_a_kill() -> None:
    with pytest.raises(ValueError, match="killing situation"):
        order(GRID, [], ["T0O0W0D0H0"])


def test_what_is_not_known_makes_the_order_a_range() -> None:
    human, nobody = "T0O0W0D0H1", "T0O0W0D0H0"
    late = "LATE-human@3s"
    flights = [*pool(human, nobody), *thrice(late, human, violated={"SR2": 9.0}), *thrice(late, nobody)]
    scored = score(flights, ROSTER, GRID)
    assert interactions(kill_matrix(scored, ROSTER, GRID)) == (
        Interaction(late, True, "human", order=1, order_at_most=5, killing=1, unknown=30),
    )


def test_the_histogram_counts_default_mutants_only() -> None:
    found = [Interaction(f"m{n}", n != 3, "", n, n, 1, 0) for n in (1, 2, 2, 3)]
    histogram = orders(found, GRID)
    assert histogram.counts == (0, 1, 2, 0, 0, 0)
    assert histogram.cumulative() == pytest.approx((0, 100 / 3, 100, 100, 100, 100))
    assert orders([], GRID).cumulative() == (None,) * 6


def test_nists_shares_never_fall_with_the_order() -> None:
    for shares in NIST.values():
        known = [share for share in shares if share is not None]
        assert known == sorted(known)
