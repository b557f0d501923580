from __future__ import annotations

from itertools import permutations

import networkx as nx
import pytest
from builders import GRID, ROSTER, pool, thrice
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.suite import Redundancy, Subsumption, kills_by_requirement, redundancies, subsumption

COLUMNS = "abcdef"
matrices = st.dictionaries(
    st.sampled_from([f"m{n}" for n in range(12)]), st.sets(st.sampled_from(COLUMNS), max_size=6).map(frozenset)
)


def digraph(found: Subsumption) -> nx.DiGraph:
    graph = nx.DiGraph([(found.nodes[above].name, found.nodes[below].name) for above, below in found.edges])
    graph.add_nodes_from(node.name for node in found.nodes)
    return graph


@settings(deadline=None, max_examples=usually(25, release=200))
@given(matrices)
def test_the_graph_says_exactly_which_mutant_subsumes_which(kills: dict[str, frozenset[str]]) -> None:
    found = subsumption(kills)
    below = dict(nx.all_pairs_shortest_path_length(digraph(found)))
    node_of = {mutant: node.name for node in found.nodes for mutant in node.mutants}
    killed = [mutant for mutant, keys in kills.items() if keys]
    assert sorted(node_of) == sorted(killed)
    for a, b in permutations(killed, 2):
        assert (node_of[b] in below[node_of[a]]) == (kills[a] <= kills[b])


@settings(deadline=None, max_examples=usually(25, release=100))
@given(matrices)
def test_no_edge_follows_from_others(kills: dict[str, frozenset[str]]) -> None:
    graph = digraph(subsumption(kills))
    for edge in list(graph.edges):
        graph.remove_edge(*edge)
        assert not nx.has_path(graph, *edge)
        graph.add_edge(*edge)


@given(matrices)
def test_minimal_mutants_are_those_without_a_smaller_kill_set(kills: dict[str, frozenset[str]]) -> None:
    sets = {keys for keys in kills.values() if keys}
    found = subsumption(kills)
    assert {node.kills for node in found.minimal} == {keys for keys in sets if not any(s < keys for s in sets)}
    assert found.layers()[:1] == ((tuple(found.nodes.index(node) for node in found.minimal),) if sets else ())
    assert sorted(place for layer in found.layers() for place in layer) == list(range(len(found.nodes)))


@given(matrices, st.sets(st.sampled_from(COLUMNS)))
def test_what_kills_every_minimal_mutant_kills_every_mutant(kills: dict[str, frozenset[str]], chosen: set[str]) -> None:
    score = subsumption(kills).dominator_score(chosen)
    killed = [bool(keys & chosen) for keys in kills.values() if keys]
    assert (score.part == score.whole) == all(killed)
    assert subsumption(kills).dominator_score(COLUMNS).part == score.whole


def test_a_layer_is_below_every_layer_that_subsumes_it() -> None:
    found = subsumption({"m": "ab", "n": "a", "o": "abc", "p": "c"})
    assert [[found.nodes[place].name for place in layer] for layer in found.layers()] == [["n", "p"], ["m"], ["o"]]
    assert found.to_json()["edges"] == [[0, 2], [1, 0], [3, 2]]


def test_duplicates_are_counted_within_a_cell() -> None:
    kills = {"NO-x@1s": "ab", "NO-x@2s": "ab", "NO-x@3s": "abc", "MORE-y": "ab", "LESS-z@1": "a", "LESS-z@2": "b"}
    assert redundancies(subsumption(kills)) == (
        Redundancy("NO-x", 3, (("NO-x@1s", "NO-x@2s"),)),
        Redundancy("LESS-z", 2, ()),
    )
    assert redundancies(subsumption(kills))[0].redundant == Ratio(1, 3)


def test_a_requirement_can_be_told_from_another() -> None:
    human = "T0O0W0D0H1"
    flights = [
        *pool(human),
        *thrice("LATE-human@3s", human, violated={"SR2": 9.0}),
        *thrice("NO-human@100%", human, violated={"SR2": 8.0, "SR1": 12.0}),
        *thrice("MORE-goal@0.6m", human, violated={"OP1": 60.0}),
    ]
    found = kills_by_requirement(kill_matrix(score(flights, ROSTER, GRID), ROSTER, GRID))
    assert found == {"LATE-human@3s": {f"{human} SR2"}, "NO-human@100%": {f"{human} SR1", f"{human} SR2"}}


@pytest.mark.parametrize("kills", [{}, {"m": frozenset()}])
def test_nothing_killed_is_an_empty_graph(kills: dict[str, frozenset[str]]) -> None:
    found = subsumption(kills)
    assert (found.nodes, found.edges, found.minimal, found.layers()) == ((), (), (), ())
    assert str(found.dominator_score("a")) == "0/0 = n/a"
