"""The kill matrix, Gray's order of situations, and Karnaugh's map."""

from __future__ import annotations

from itertools import combinations, pairwise, permutations, product
from math import prod

import networkx as nx
import pytest
from builders import GRID, ROSTER, outcome, pool, seeded, thrice
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis import kill_matrix
from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import order
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import admits, score
from scaloft_fi.judge.outcome import PLACEBO_ID, Outcome
from scaloft_fi.judge.space import Space

LATE, NO, CONTROL = "LATE-human@3s", "NO-human@100%", "REVERSE-human"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T1O0W0D1H0"


def matrix_of(outcomes: list[Outcome]) -> kill_matrix.KillMatrix:
    return kill_matrix.kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID)


CAMPAIGN = [
    *pool(HUMAN, NOBODY),
    *pool(DARK, red=10, violated={"SR1": 30.0}, struck="bar"),
    outcome(PLACEBO_ID, HUMAN, altered=0),
    *thrice(CONTROL, HUMAN, violated={"SR2": 9.0}),
    *thrice(LATE, HUMAN, violated={"SR2": 12.35}),
    *thrice(LATE, NOBODY, carried=0, altered=0),
    *thrice(LATE, DARK, violated={"SR2": 12.0}),
    outcome(NO, HUMAN, digest="clean"),
    outcome(NO, NOBODY, altered=0),
    outcome(NO, DARK, invalid="the worker died"),
]


def test_every_state_has_its_name():
    found = matrix_of(CAMPAIGN)
    states = {
        row.id: {e.situation: e.state for e in row.entries if e.state != kill_matrix.NOT_FLOWN} for row in found.rows
    }
    assert states[LATE] == {HUMAN: "revealed", NOBODY: "not_reached", DARK: "revealed"}
    assert states[NO] == {HUMAN: "masked", NOBODY: "not_infected"}
    assert [row.kind for row in found.rows] == ["mutant", "mutant", "control", "placebo"]


def test_where_nothing_is_steady_nothing_is_killed_survived_or_tested():
    row = matrix_of(CAMPAIGN).row[LATE]
    (dark,) = [entry for entry in row.entries if entry.situation == DARK]
    assert (dark.kills, dark.seen, dark.tested, dark.survived) == ((), (), False, False)
    assert dict(dark.violated) == {"SR2": 3}
    assert row.kills == {HUMAN}
    assert row.surviving == (NOBODY,)
    assert matrix_of(CAMPAIGN).kills == {LATE: {HUMAN}}


def test_what_does_not_decide_is_seen_and_no_kill():
    row = matrix_of([*pool(HUMAN), outcome(LATE, HUMAN, violated={"SR2": 9.0})]).row[LATE]
    (entry,) = [entry for entry in row.entries if entry.flown]
    assert (row.verdict, entry.seen, entry.kills) == (Verdict.UNDECIDED, ("SR2",), ())


def test_a_detected_mutant_without_a_kill_is_named():
    keys = [key for key, _ in GRID.points[:8]]
    spread = [outcome(LATE, key, seed, violated={"SR2": 9.0} if seed == 1 else {}) for key in keys for seed in range(3)]
    found = matrix_of([*pool(*keys), *spread])
    assert (found.scattered, found.kills) == ((LATE,), {})
    assert matrix_of(CAMPAIGN).scattered == ()


@given(seeded())
def test_the_matrix_says_what_the_score_says(outcomes: list[Outcome]):
    scored = score(outcomes, ROSTER, GRID)
    found = kill_matrix.kill_matrix(scored, ROSTER, GRID)
    assert [row.id for row in found.mutants] == [mutant.subject.id for mutant in scored.mutants]
    for mutant, row in zip(scored.mutants, found.mutants, strict=True):
        assert (row.killing, row.verdict) == (mutant.killing, mutant.verdict)
        assert len(row.kills) == mutant.kill_rate.part
        spared = [r.situation for r in mutant.results if not r.kills and (r.tested or not r.infected)]
        assert list(row.surviving) == spared
        assert mutant.detected or not row.kills
        assert [entry.situation for entry in row.entries] == list(GRID.point)
    if scored.pooled:
        counted = [row for row in found.mutants if row.counted]
        assert sum(row.verdict is Verdict.DETECTED for row in counted) == scored.mutation_score.part


radices = st.lists(st.integers(1, 4), min_size=1, max_size=4)


def test_neighbouring_situations_of_the_grid_differ_on_one_axis():
    order = kill_matrix.gray_order(GRID)
    assert sorted(order) == sorted(GRID.point)
    assert order[0] == "T0O0W0D0H0"
    for key, following in pairwise(order):
        assert sum(a != b for a, b in zip(GRID.point[key], GRID.point[following], strict=True)) == 1


@given(radices)
def test_neighbouring_words_differ_in_one_digit_by_one(sizes: list[int]):
    words = kill_matrix.gray_words(sizes)
    assert sorted(words) == sorted(product(*map(range, sizes)))
    for word, following in pairwise(words):
        assert sum(abs(a - b) for a, b in zip(word, following, strict=True)) == 1


@given(radices)
def test_a_words_rank_is_its_place(sizes: list[int]):
    assert [kill_matrix.gray_rank(word, sizes) for word in kill_matrix.gray_words(sizes)] == list(range(prod(sizes)))


def test_a_grid_with_situations_left_out_keeps_the_order_of_the_rest():
    kept = tuple(entry for entry in GRID.points if entry[0] != "T0O0W0D1H1")
    partial = Space(GRID.axes, GRID.values, GRID.words, kept)
    assert kill_matrix.gray_order(partial) == tuple(key for key in kill_matrix.gray_order(GRID) if key != "T0O0W0D1H1")


CUT = Space(
    axes=("light", "floor", "people"),
    values=(("0", "1", "2"), ("0", "1", "2"), ("0", "1")),
    words=(("bright", "dim", "dark"), ("dry", "wet", "gone"), ("nobody", "human")),
    points=tuple((f"L{a}F{b}P{c}", (a, b, c)) for a, b, c in product("012", "012", "01") if (a, b) != ("2", "2")),
)


def test_five_axes_make_four_rows_of_eight_and_every_situation_is_on_the_map_once():
    folded = kill_matrix.fold(GRID)
    assert [len(keys) for keys in folded.keys] == [8] * 4
    assert sorted(key for keys in folded.keys for key in keys if key) == sorted(GRID.point)


def test_neighbours_on_the_map_differ_on_one_axis_also_across_its_edges():
    folded = kill_matrix.fold(GRID)
    assert kill_matrix.cyclic(folded.rows)
    assert kill_matrix.cyclic(folded.columns)
    for r, c in product(range(4), range(8)):
        for other in (folded.keys[(r + 1) % 4][c], folded.keys[r][(c + 1) % 8]):
            here, there = GRID.point[folded.keys[r][c] or ""], GRID.point[other or ""]
            assert sum(a != b for a, b in zip(here, there, strict=True)) == 1


def test_axes_of_three_values_fold_too_and_what_a_constraint_excludes_is_empty():
    folded = kill_matrix.fold(CUT)
    assert sorted(key for keys in folded.keys for key in keys if key) == sorted(CUT.point)
    assert sum(key is None for keys in folded.keys for key in keys) == 2
    for side in (folded.rows, folded.columns):
        assert all(sum(a != b for a, b in zip(*pair, strict=True)) == 1 for pair in pairwise(side))
    assert not kill_matrix.cyclic(folded.columns)


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
    found = matrix_of([*pool(HUMAN, NOBODY), *thrice(LATE, HUMAN, violated={"SR2": 9.0}), *thrice(LATE, NOBODY)])
    assert kill_matrix.interactions(found) == (
        kill_matrix.Interaction(LATE, True, "human", order=1, order_at_most=5, killing=1, unknown=30),
    )


def test_the_histogram_counts_default_mutants_only():
    found = [kill_matrix.Interaction(f"m{n}", n != 3, "", n, n, 1, 0) for n in (1, 2, 2, 3)]
    histogram = kill_matrix.orders(found, GRID)
    assert [one.mutants for one in histogram] == [0, 1, 2, 0, 0, 0]
    assert [one.cumulative_percent for one in histogram] == pytest.approx((0, 100 / 3, 100, 100, 100, 100))
    assert {one.cumulative_percent for one in kill_matrix.orders([], GRID)} == {None}


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
    found = kill_matrix.minimal_suite(kills, COLUMNS)
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
    found = kill_matrix.minimal_suite(kills, "abcdefghijk")
    assert (found.situations, found.alternatives) == (smallest[0], len(smallest))


@given(matrices)
def test_beyond_its_limit_it_is_greedy_still_covers_and_says_so(kills: dict[str, frozenset[str]]):
    found = kill_matrix.minimal_suite(kills, COLUMNS, most_entries=0)
    assert found.exact is not any(kills.values())
    assert found.alternatives is None
    assert all(keys & set(found.situations) for keys in kills.values() if keys)
    assert len(found.situations) >= len(every_smallest(kills, COLUMNS)[0])
    for left_out in found.situations:
        rest = set(found.situations) - {left_out}
        assert not all(keys & rest for keys in kills.values() if keys)


def test_without_kills_no_situation_is_needed():
    assert kill_matrix.minimal_suite({"m": frozenset()}, COLUMNS).situations == ()


def test_a_kill_in_an_unknown_situation_is_refused():
    with pytest.raises(ValueError, match="unknown situations"):
        kill_matrix.minimal_suite({"m": frozenset("z")}, COLUMNS)


def test_covers_of_a_cube_by_its_lines_are_still_exact():
    # 27 points, each on 3 of 27 lines of 3 points: at least 9 lines
    points = list(product("012", repeat=3))
    lines = ["".join((*p[:axis], "*", *p[axis + 1 :])) for axis in range(3) for p in product("012", repeat=3)]
    columns = sorted(set(lines))
    kills = {"".join(p): frozenset("".join((*p[:axis], "*", *p[axis + 1 :])) for axis in range(3)) for p in points}
    found = kill_matrix.minimal_suite(kills, columns)
    assert found.exact
    assert len(found.situations) == 9


def digraph(found: kill_matrix.Subsumption) -> nx.DiGraph:
    graph = nx.DiGraph([(found.nodes[above].name, found.nodes[below].name) for above, below in found.edges])
    graph.add_nodes_from(node.name for node in found.nodes)
    return graph


@given(matrices)
def test_the_graph_says_exactly_which_mutant_subsumes_which(kills: dict[str, frozenset[str]]):
    found = kill_matrix.subsumption(kills)
    below = dict(nx.all_pairs_shortest_path_length(digraph(found)))
    node_of = {mutant: node.name for node in found.nodes for mutant in node.mutants}
    killed = [mutant for mutant, keys in kills.items() if keys]
    assert sorted(node_of) == sorted(killed)
    for a, b in permutations(killed, 2):
        assert (node_of[b] in below[node_of[a]]) == (kills[a] <= kills[b])


@given(matrices)
def test_no_edge_follows_from_others(kills: dict[str, frozenset[str]]):
    graph = digraph(kill_matrix.subsumption(kills))
    for edge in list(graph.edges):
        graph.remove_edge(*edge)
        assert not nx.has_path(graph, *edge)
        graph.add_edge(*edge)


@given(matrices)
def test_minimal_mutants_are_those_without_a_smaller_kill_set(kills: dict[str, frozenset[str]]):
    sets = {keys for keys in kills.values() if keys}
    found = kill_matrix.subsumption(kills)
    assert {node.kills for node in found.minimal} == {keys for keys in sets if not any(s < keys for s in sets)}


@given(matrices, st.sets(st.sampled_from(COLUMNS)))
def test_what_kills_every_minimal_mutant_kills_every_mutant(kills: dict[str, frozenset[str]], chosen: set[str]):
    score = kill_matrix.subsumption(kills).dominator_score(chosen)
    killed = [bool(keys & chosen) for keys in kills.values() if keys]
    assert (score.part == score.whole) == all(killed)
    assert kill_matrix.subsumption(kills).dominator_score(COLUMNS).part == score.whole


def test_a_layer_is_below_every_layer_that_subsumes_it():
    found = kill_matrix.subsumption({"m": "ab", "n": "a", "o": "abc", "p": "c"})
    assert {node.name: node.layer for node in found.nodes} == {"n": 0, "p": 0, "m": 1, "o": 2}
    assert found.edges == ((0, 2), (1, 0), (3, 2))


def test_duplicates_are_counted_within_a_cell():
    kills = {"NO-x@1s": "ab", "NO-x@2s": "ab", "NO-x@3s": "abc", "MORE-y": "ab", "LESS-z@1": "a", "LESS-z@2": "b"}
    assert kill_matrix.redundancies(kill_matrix.subsumption(kills)) == (
        kill_matrix.Redundancy("NO-x", 3, (("NO-x@1s", "NO-x@2s"),)),
        kill_matrix.Redundancy("LESS-z", 2, ()),
    )
    assert kill_matrix.redundancies(kill_matrix.subsumption(kills))[0].redundant == Ratio(1, 3)


def test_a_requirement_can_be_told_from_another():
    human = "T0O0W0D0H1"
    flights = [
        *pool(human),
        *thrice("LATE-human@3s", human, violated={"SR2": 9.0}),
        *thrice("NO-human@100%", human, violated={"SR2": 8.0, "SR1": 12.0}),
        *thrice("MORE-goal@0.6m", human, violated={"OP1": 60.0}),
    ]
    found = kill_matrix.kill_matrix(score(flights, ROSTER, GRID), ROSTER, GRID).kill_sets(by_requirement=True)
    assert found == {"LATE-human@3s": {f"{human} SR2"}, "NO-human@100%": {f"{human} SR1", f"{human} SR2"}}


@pytest.mark.parametrize("kills", [{}, {"m": frozenset()}])
def test_nothing_killed_is_an_empty_graph(kills: dict[str, frozenset[str]]):
    found = kill_matrix.subsumption(kills)
    assert (found.nodes, found.edges, found.minimal) == ((), (), ())
    assert str(found.dominator_score("a")) == "0/0 = n/a"
