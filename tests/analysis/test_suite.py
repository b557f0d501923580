"""Orders of interaction, suites that kill all, subsumption."""

from __future__ import annotations

from itertools import combinations, permutations, product

import networkx as nx
import pytest
from builders import GRID, ROSTER, pool, thrice
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.kill_matrix import (
    Interaction,
    Redundancy,
    Subsumption,
    interactions,
    kill_matrix,
    minimal_suite,
    order,
    orders,
    redundancies,
    subsumption,
)
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import admits, score
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


@given(fates)
def test_the_order_is_the_fewest_literals_of_any_box_without_a_survivor(drawn: list[str]):
    keys = [key for key, _ in THREE.points]
    killing = [key for key, fate in zip(keys, drawn, strict=True) if fate == "kill"]
    surviving = [key for key, fate in zip(keys, drawn, strict=True) if fate == "survive"]
    assert order(THREE, killing, surviving) == least_literals(killing, surviving)


def test_human_and_light_is_of_order_two():
    killing = [key for key in GRID.point if "D0" in key and "H1" in key]
    assert order(GRID, killing, [key for key in GRID.point if key not in killing]) == 2
    assert order(GRID, list(GRID.point), []) == 0
    assert order(GRID, ["T0O0W0D0H0"], [key for key in GRID.point if key != "T0O0W0D0H0"]) == 5


def test_no_order_without_a_kill():
    with pytest.raises(ValueError, match="killing situation"):
        order(GRID, [], ["T0O0W0D0H0"])


def test_what_is_not_known_makes_the_order_a_range():
    human, nobody = "T0O0W0D0H1", "T0O0W0D0H0"
    late = "LATE-human@3s"
    flights = [*pool(human, nobody), *thrice(late, human, violated={"SR2": 9.0}), *thrice(late, nobody)]
    scored = score(flights, ROSTER, GRID)
    assert interactions(kill_matrix(scored, ROSTER, GRID)) == (
        Interaction(late, True, "human", order=1, order_at_most=5, killing=1, unknown=30),
    )


def test_the_histogram_counts_default_mutants_only():
    found = [Interaction(f"m{n}", n != 3, "", n, n, 1, 0) for n in (1, 2, 2, 3)]
    histogram = orders(found, GRID)
    assert [one.mutants for one in histogram] == [0, 1, 2, 0, 0, 0]
    assert [one.cumulative_percent for one in histogram] == pytest.approx((0, 100 / 3, 100, 100, 100, 100))
    assert {one.cumulative_percent for one in orders([], GRID)} == {None}


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


@given(matrices)
def test_the_suite_is_the_first_of_all_smallest_ones(kills: dict[str, frozenset[str]]):
    smallest = every_smallest(kills, COLUMNS)
    found = minimal_suite(kills, COLUMNS)
    assert found.situations == smallest[0]
    assert found.exact
    assert found.alternatives == len(smallest)
    assert set(found.needed) <= set.intersection(*map(set, smallest))


pairs = st.sets(st.sets(st.sampled_from("abcdefghijk"), min_size=2, max_size=2).map(frozenset), min_size=8, max_size=30)


@given(pairs)
def test_where_no_situation_is_forced_it_is_still_the_first_smallest(rows: set[frozenset[str]]):
    # pairs make it a vertex cover, of which reductions leave most to the search
    kills = {f"m{number}": keys for number, keys in enumerate(sorted(rows, key=sorted))}
    smallest = every_smallest(kills, "abcdefghijk")
    found = minimal_suite(kills, "abcdefghijk")
    assert (found.situations, found.alternatives) == (smallest[0], len(smallest))


@given(matrices)
def test_beyond_its_limit_it_is_greedy_still_covers_and_says_so(kills: dict[str, frozenset[str]]):
    found = minimal_suite(kills, COLUMNS, most_entries=0)
    assert found.exact is not any(kills.values())
    assert found.alternatives is None
    assert all(keys & set(found.situations) for keys in kills.values() if keys)
    assert len(found.situations) >= len(every_smallest(kills, COLUMNS)[0])
    for left_out in found.situations:
        rest = set(found.situations) - {left_out}
        assert not all(keys & rest for keys in kills.values() if keys)


def test_without_kills_no_situation_is_needed():
    assert minimal_suite({"m": frozenset()}, COLUMNS).situations == ()


def test_a_kill_in_an_unknown_situation_is_refused():
    with pytest.raises(ValueError, match="unknown situations"):
        minimal_suite({"m": frozenset("z")}, COLUMNS)


def test_covers_of_a_cube_by_its_lines_are_still_exact():
    # 27 points, each on 3 of 27 lines of 3 points: at least 9 lines
    points = list(product("012", repeat=3))
    lines = ["".join((*p[:axis], "*", *p[axis + 1 :])) for axis in range(3) for p in product("012", repeat=3)]
    columns = sorted(set(lines))
    kills = {"".join(p): frozenset("".join((*p[:axis], "*", *p[axis + 1 :])) for axis in range(3)) for p in points}
    found = minimal_suite(kills, columns)
    assert found.exact
    assert len(found.situations) == 9


def digraph(found: Subsumption) -> nx.DiGraph:
    graph = nx.DiGraph([(found.nodes[above].name, found.nodes[below].name) for above, below in found.edges])
    graph.add_nodes_from(node.name for node in found.nodes)
    return graph


@given(matrices)
def test_the_graph_says_exactly_which_mutant_subsumes_which(kills: dict[str, frozenset[str]]):
    found = subsumption(kills)
    below = dict(nx.all_pairs_shortest_path_length(digraph(found)))
    node_of = {mutant: node.name for node in found.nodes for mutant in node.mutants}
    killed = [mutant for mutant, keys in kills.items() if keys]
    assert sorted(node_of) == sorted(killed)
    for a, b in permutations(killed, 2):
        assert (node_of[b] in below[node_of[a]]) == (kills[a] <= kills[b])


@given(matrices)
def test_no_edge_follows_from_others(kills: dict[str, frozenset[str]]):
    graph = digraph(subsumption(kills))
    for edge in list(graph.edges):
        graph.remove_edge(*edge)
        assert not nx.has_path(graph, *edge)
        graph.add_edge(*edge)


@given(matrices)
def test_minimal_mutants_are_those_without_a_smaller_kill_set(kills: dict[str, frozenset[str]]):
    sets = {keys for keys in kills.values() if keys}
    found = subsumption(kills)
    assert {node.kills for node in found.minimal} == {keys for keys in sets if not any(s < keys for s in sets)}


@given(matrices, st.sets(st.sampled_from(COLUMNS)))
def test_what_kills_every_minimal_mutant_kills_every_mutant(kills: dict[str, frozenset[str]], chosen: set[str]):
    score = subsumption(kills).dominator_score(chosen)
    killed = [bool(keys & chosen) for keys in kills.values() if keys]
    assert (score.part == score.whole) == all(killed)
    assert subsumption(kills).dominator_score(COLUMNS).part == score.whole


def test_a_layer_is_below_every_layer_that_subsumes_it():
    found = subsumption({"m": "ab", "n": "a", "o": "abc", "p": "c"})
    assert {node.name: node.layer for node in found.nodes} == {"n": 0, "p": 0, "m": 1, "o": 2}
    assert found.edges == ((0, 2), (1, 0), (3, 2))


def test_duplicates_are_counted_within_a_cell():
    kills = {"NO-x@1s": "ab", "NO-x@2s": "ab", "NO-x@3s": "abc", "MORE-y": "ab", "LESS-z@1": "a", "LESS-z@2": "b"}
    assert redundancies(subsumption(kills)) == (
        Redundancy("NO-x", 3, (("NO-x@1s", "NO-x@2s"),)),
        Redundancy("LESS-z", 2, ()),
    )
    assert redundancies(subsumption(kills))[0].redundant == Ratio(1, 3)


def test_a_requirement_can_be_told_from_another():
    human = "T0O0W0D0H1"
    flights = [
        *pool(human),
        *thrice("LATE-human@3s", human, violated={"SR2": 9.0}),
        *thrice("NO-human@100%", human, violated={"SR2": 8.0, "SR1": 12.0}),
        *thrice("MORE-goal@0.6m", human, violated={"OP1": 60.0}),
    ]
    found = kill_matrix(score(flights, ROSTER, GRID), ROSTER, GRID).kill_sets(by_requirement=True)
    assert found == {"LATE-human@3s": {f"{human} SR2"}, "NO-human@100%": {f"{human} SR1", f"{human} SR2"}}


@pytest.mark.parametrize("kills", [{}, {"m": frozenset()}])
def test_nothing_killed_is_an_empty_graph(kills: dict[str, frozenset[str]]):
    found = subsumption(kills)
    assert (found.nodes, found.edges, found.minimal) == ((), (), ())
    assert str(found.dominator_score("a")) == "0/0 = n/a"
