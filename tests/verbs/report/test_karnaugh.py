"""The Karnaugh maps of the page: a fold whose neighbours differ in one axis, terms that brute force cannot shorten."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Sequence
from itertools import combinations, product

import pytest
from counting import counts_of, exported
from reading import embedded

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import KillEntry, KillRow
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.judge.outcome import Subject
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Status
from scaloft_fi.verbs.report.analyses import Evidence, folding, terms
from scaloft_fi.verbs.report.page import asset


def grid(*sizes: int) -> Space:
    """Axes with these numbers of values."""
    axes = tuple("ABCDEFGH"[: len(sizes)])
    values = tuple(tuple(map(str, range(size))) for size in sizes)
    keyed = tuple(("".join(a + v for a, v in zip(axes, point, strict=True)), point) for point in product(*values))
    return Space(axes, values, values, keyed)


@pytest.mark.parametrize("count", range(2, 7))
def test_neighbours_differ_in_one_axis_and_opposite_edges_meet(count: int) -> None:
    space = grid(*[2] * count)
    fold = folding(space)
    keys = fold["keys"]
    assert sorted(key for row in keys for key in row) == sorted(space.point)
    for row, column in product(range(len(keys)), range(len(keys[0]))):
        here = space.point[keys[row][column]]
        sides = zip((*fold["down"], *fold["across"]), (*fold["rows"][row], *fold["columns"][column]), strict=True)
        assert [level for _, level in sorted(sides)] == list(map(int, here))
        for beside in (keys[row][column - 1], keys[row - 1][column]):
            assert sum(a != b for a, b in zip(here, space.point[beside], strict=True)) == 1


@pytest.mark.parametrize(
    ("sizes", "said"),
    [
        ((8,) * 4, "of 4096 situations could not be read; at most 512 are drawn"),
        ((2,), "needs 2 axes or more; this grid has 1"),
    ],
)
def test_a_grid_without_a_map_says_why_and_has_no_terms(sizes: tuple[int, ...], said: str) -> None:
    space = grid(*sizes)
    (key, *_) = space.point
    entries = (KillEntry("X-x", key, kills=("R",)),)
    row = KillRow(Subject("X-x"), "mutant", True, Status.REVEALED, Verdict.DETECTED, Ratio(1, 1), entries)
    assert said in folding(space)["reason"]
    assert folding(space).keys() == {"reason"}
    assert terms(space, row) == []


def test_terms_hold_every_kill_and_no_survival_and_are_the_fewest(evidence: Evidence, text: str) -> None:
    told, counted = embedded(text, "figures"), counts_of(exported(evidence))
    levels = {entry["key"]: entry["levels"] for entry in told["situations"]}
    boxes = list(product(([0], [1], [0, 1]), repeat=5))

    def inside(key: str, box: Sequence[Sequence[int]]) -> bool:
        return all(level in admitted for admitted, level in zip(box, levels[key], strict=True))

    for mutant in told["mutants"]:
        counts = counted[mutant["id"]]
        on = {key for key, count in counts.items() if mutant["verdict"] == "detected" and count.most}
        off = {key for key, count in counts.items() if count.flown and (count.tests or not count.infected)} - on
        patterns = [term["levels"] for term in mutant["terms"]]
        assert on <= {key for key in levels if any(inside(key, pattern) for pattern in patterns)}
        assert not any(inside(key, pattern) for key in off for pattern in patterns)
        fitting = [box for box in boxes if not any(inside(key, box) for key in off)]
        fewest = next(
            size
            for size in range(len(patterns) + 1)
            for chosen in combinations(fitting, size)
            if all(any(inside(key, box) for box in chosen) for key in on)
        )
        assert len(patterns) == fewest
        # the condition in words is that of the terms; of a mutant without a kill it says where a violation was seen
        if on:
            assert mutant["condition"].count(" or ") + 1 == len(patterns)
        assert all(term["words"] in mutant["condition"] or term["words"] == "everywhere" for term in mutant["terms"])


def edges(space: Space, *boxes: Sequence[Sequence[int]]) -> tuple[int, int]:
    """Horizontal and vertical pieces of the outlines that the page's script draws around some boxes."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    script = f"""
        const DATA = {{ karnaugh: {json.dumps(folding(space))} }};
        const s = (name, properties, ...children) => ({{ name, properties, children: children.flat(Infinity) }});
        {asset("karnaugh.js")}
        const terms = {json.dumps([{"levels": box} for box in boxes])};
        const drawn = outlines(terms).children.filter((one) => "data-term" in one.properties);
        console.log(drawn.map((one) => one.properties.d).join(""));
    """
    drawn = subprocess.run([node, "-e", script], capture_output=True, text=True, check=True).stdout
    return drawn.count("H"), drawn.count("V")


ANY, TWO = [0, 1], grid(2, 2, 2, 2, 2)


def test_an_outline_is_open_where_its_term_goes_on_at_the_opposite_edge() -> None:
    # the fourth axis at 0: columns 0, 1 and 6, 7 of all four rows, one block across the edge
    assert edges(TWO, [ANY, ANY, ANY, [0], ANY]) == (2 * 4, 2 * 4)
    assert edges(TWO, [ANY, ANY, ANY, [1], ANY]) == (2 * 4, 2 * 4)
    assert edges(TWO, [ANY] * 5) == (2 * 8, 2 * 4)
    # with the fifth axis at 1: two blocks of one column each
    assert edges(TWO, [ANY, ANY, ANY, [0], [1]]) == (2 * 2, 4 * 4)


def test_where_opposite_edges_are_no_neighbours_every_outline_is_shut() -> None:
    # columns 0, 1 and 4, 5 of 6: the last differs from the first on two axes
    assert edges(grid(3, 3, 2), [[0, 1, 2], [0, 2], ANY]) == (2 * 4, 4 * 3)


def test_terms_of_axes_with_more_values_name_all_levels_that_they_admit() -> None:
    space = grid(3, 2)
    killing = ("A0B0", "A0B1", "A1B0", "A1B1")
    entries = tuple(KillEntry("X-x", key, kills=("R",) if key in killing else (), tested=True) for key in space.point)
    row = KillRow(Subject("X-x"), "mutant", True, Status.REVEALED, Verdict.DETECTED, Ratio(4, 6), entries)
    (term,) = terms(space, row)
    assert term["levels"] == [[0, 1], [0, 1]]
