from __future__ import annotations

from itertools import combinations, product
from random import Random

import pytest
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.suite import minimal_suite

COLUMNS = "abcdefgh"
matrices = st.dictionaries(
    st.sampled_from([f"m{n}" for n in range(12)]),
    st.sets(st.sampled_from(COLUMNS), max_size=5).map(frozenset),
    max_size=12,
)


def every_smallest(kills: dict[str, frozenset[str]], columns: str) -> list[tuple[str, ...]]:
    """By brute force, in lexicographic order."""
    sets = [keys for keys in kills.values() if keys]
    for size in range(len(columns) + 1):
        found = [chosen for chosen in combinations(columns, size) if all(keys & set(chosen) for keys in sets)]
        if found:
            return found
    raise AssertionError


@settings(deadline=None, max_examples=usually(25, release=300))
@given(matrices)
def test_the_suite_is_the_first_of_all_smallest_ones(kills: dict[str, frozenset[str]]) -> None:
    smallest = every_smallest(kills, COLUMNS)
    found = minimal_suite(kills, COLUMNS)
    assert found.situations == smallest[0]
    assert found.exact
    assert found.alternatives == len(smallest)
    assert set(found.needed) <= set.intersection(*map(set, smallest))


pairs = st.sets(st.sets(st.sampled_from("abcdefghijk"), min_size=2, max_size=2).map(frozenset), min_size=8, max_size=30)


@settings(deadline=None, max_examples=usually(25, release=300))
@given(pairs)
def test_where_no_situation_is_forced_it_is_still_the_first_smallest(rows: set[frozenset[str]]) -> None:
    # pairs make it a vertex cover, of which reductions leave most to the search
    kills = {f"m{number}": keys for number, keys in enumerate(sorted(rows, key=sorted))}
    smallest = every_smallest(kills, "abcdefghijk")
    found = minimal_suite(kills, "abcdefghijk")
    assert (found.situations, found.alternatives) == (smallest[0], len(smallest))


@settings(deadline=None, max_examples=usually(25, release=100))
@given(matrices)
def test_beyond_its_limit_it_is_greedy_still_covers_and_says_so(kills: dict[str, frozenset[str]]) -> None:
    found = minimal_suite(kills, COLUMNS, most_entries=0)
    assert not found.exact
    assert found.alternatives is None
    assert all(keys & set(found.situations) for keys in kills.values() if keys)
    assert len(found.situations) >= len(every_smallest(kills, COLUMNS)[0])
    for left_out in found.situations:
        rest = set(found.situations) - {left_out}
        assert not all(keys & rest for keys in kills.values() if keys)


@given(matrices, st.randoms(use_true_random=False))
def test_the_order_of_the_mutants_does_not_matter(kills: dict[str, frozenset[str]], random: Random) -> None:
    shuffled = list(kills.items())
    random.shuffle(shuffled)
    assert minimal_suite(dict(shuffled), COLUMNS) == minimal_suite(kills, COLUMNS)


def test_without_kills_no_situation_is_needed() -> None:
    assert minimal_suite({"m": frozenset()}, COLUMNS).situations == ()


def test_a_kill_in_an_unknown_situation_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown situations"):
        minimal_suite({"m": frozenset("z")}, COLUMNS)


def test_covers_of_a_cube_by_its_lines_are_still_exact() -> None:
    # 27 points, each on 3 of 27 lines of 3 points: at least 9 lines
    points = list(product("012", repeat=3))
    lines = ["".join((*p[:axis], "*", *p[axis + 1 :])) for axis in range(3) for p in product("012", repeat=3)]
    columns = sorted(set(lines))
    kills = {"".join(p): frozenset("".join((*p[:axis], "*", *p[axis + 1 :])) for axis in range(3)) for p in points}
    found = minimal_suite(kills, columns)
    assert found.exact
    assert len(found.situations) == 9
