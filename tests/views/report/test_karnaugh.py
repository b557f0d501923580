"""The Karnaugh maps of the page: a fold whose neighbours differ in one axis, terms that brute force cannot shorten."""

from __future__ import annotations

from itertools import combinations, product

import pytest
from counting import counts_of, exported
from reading import embedded

from scaloft_fi.analysis.kills.kill_matrix import Entry, Row
from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.scoring.detection import Verdict
from scaloft_fi.judge.outcome import Subject
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Status
from scaloft_fi.views.report.evidence import Evidence
from scaloft_fi.views.report.karnaugh import MOST_AXES, folding, terms


def grid(*sizes: int) -> Space:
    """Axes with so many values."""
    axes = tuple("ABCDEFGH"[: len(sizes)])
    values = tuple(tuple(map(str, range(size))) for size in sizes)
    keyed = tuple(("".join(a + v for a, v in zip(axes, point, strict=True)), point) for point in product(*values))
    return Space(axes, values, values, keyed)


@pytest.mark.parametrize("count", range(2, MOST_AXES + 1))
def test_neighbours_differ_in_one_axis_and_opposite_edges_meet(count: int) -> None:
    space = grid(*[2] * count)
    fold = folding(space, space.axes)
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
        ((2, 3, 2), "of this grid's, 'B' has 3"),
        ((4, 2, 1), "'A' has 4 and 'C' has 1"),
        ((2,) * 7, "shows 2 to 6 axes; this grid has 7"),
        ((2,), "shows 2 to 6 axes; this grid has 1"),
    ],
)
def test_a_grid_without_a_map_says_why_and_has_no_terms(sizes: tuple[int, ...], said: str) -> None:
    space = grid(*sizes)
    (key, *_) = space.point
    row = Row(
        Subject("X-x"), "mutant", True, Status.REVEALED, Verdict.DETECTED, Ratio(1, 1), (Entry(key, kills=("R",)),)
    )
    assert said in folding(space, space.axes)["reason"]
    assert folding(space, space.axes).keys() == {"reason"}
    assert terms(space, row) == []


def test_terms_hold_every_kill_and_no_survival_and_are_the_fewest(evidence: Evidence, text: str) -> None:
    told, counted = embedded(text, "figures"), counts_of(exported(evidence))
    levels = {entry["key"]: entry["levels"] for entry in told["situations"]}
    boxes = ["".join(box) for box in product("-01", repeat=5)]

    def inside(key: str, pattern: str) -> bool:
        return all(mark in ("-", str(level)) for mark, level in zip(pattern, levels[key], strict=True))

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
