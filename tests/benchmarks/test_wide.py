from __future__ import annotations

import json
from collections import Counter

import pytest

from experiments import PUBLISHED, wide
from experiments.flights import outcomes, published
from experiments.pages import registered
from experiments.wide import halves
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import Redraw, score
from scaloft_fi.study import Study

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""

ONCE = Redraw(3, Ratio(1, 200), Ratio(0, 200))


@pytest.fixture(scope="module")
def paper(study: Study) -> wide.Side:
    return wide.side(study, published())


def test_each_default_is_in_one_half_and_each_parameter_in_both(study: Study):
    choosing, judging = halves(study.roster.defaults)
    assert sorted([*choosing, *judging]) == sorted(study.roster.defaults.values())
    cell_of = {mutant: cell for cell, mutant in study.roster.defaults.items()}
    first, second = (Counter(cell_of[mutant].split("-")[1] for mutant in half) for half in (choosing, judging))
    assert all(abs(first[parameter] - second[parameter]) <= 1 for parameter in first | second)


def test_the_published_flights_have_the_published_score(study: Study):
    found = score(outcomes(study, published()), study.roster, study.space)
    told = json.loads((PUBLISHED / "reference" / "score.json").read_text(encoding="utf-8"))
    detected = [m["id"] for m in told["mutants"] if m["verdict"] == "detected"]
    assert [mutant.subject.id for mutant in found.mutants if mutant.detected] == detected
    assert found.mutation_score.part == told["ratios"]["mutation_score"]["part"]


def test_the_side_of_the_paper_counts_three_seeds_and_ten_of_the_pool(paper: wide.Side):
    assert len(paper.detected) == 32
    assert paper.situations == 32
    assert {pair.flights for pair in paper.score.pool.pairs.values()} == {10}
    assert {result.flown for mutant in paper.score.mutants for result in mutant.results} == {3}


def test_a_grid_beside_itself_detects_the_same_at_once_the_flying(study: Study, paper: wide.Side):
    page = wide.results(
        paper, paper, study.roster.defaults, [(1, 2, 3), (4, 5, 6)], [ONCE, ONCE], {"NO-battery": "it lands"}
    )
    assert ": 1.00 times the flying" in page
    assert "3 of the judging half, 3 of the other" in page
    assert "| all (half selected) | 32 of 114 | 32 of 114 | 32 of 114 |" in page
    assert "One seed alone detects 1, 2, 3 of the judging half in the paper's grid, 4, 5, 6 in the wide grid." in page
    assert "1 of 200, 1 of 200 redraws are called detected" in page
    assert "| battery | 8 | 0 | 0 | 0 |" in page
    assert "| NO-battery | it lands |" in page
    assert page.count("| judging |") == 1 + 57


def test_the_published_page_is_that_of_the_published_flights(study: Study):
    """Two minutes of processor time: five hundred draws of the pool are scored."""
    told = (PUBLISHED / "wide.md").read_text(encoding="utf-8")
    assert told == registered("wide") + wide.page(study, 1, PUBLISHED)


def test_a_seed_that_a_half_was_not_wholly_flown_with_does_not_count(study: Study):
    _, judging = halves(study.roster.defaults)
    rows = [row for row in published() if (row["mutant"], row["seed"]) != (judging[0], 2)]
    found = wide.side(study, rows)
    choosing, _ = halves(study.roster.defaults)
    assert (found.seeds(choosing), found.seeds(judging)) == (3, 2)
