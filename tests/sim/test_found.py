"""The found situations: read with bounds, flown beside the study's own grid."""

from __future__ import annotations

from dataclasses import replace

import pytest
from finding import BAR

from scaloft_fi.campaign.seeking.finds import break_saver, saver, text
from scaloft_fi.errors import InputError
from scaloft_fi.sim.found import Evidence, Find, Finds, read_finds
from scaloft_fi.sim.grids import grid_names, load_grid

SHOWN = Evidence("SR2", 1, 0.00025, 0.005, 6, 6, "person", 10, 10, 0.071, 0.02, 10)
FIND = Find("shows-A@1", "T0O0W0D0H2Cs=0.8", ("human walks", "cruise speed 0.8 m/s"), "A@1", {"A@1": SHOWN}, 0)
BLIND = replace(
    BAR, name="breaks-SR2-nothing-home_to_corner-near_home-no_belief", struck="", belief="", error=0.0, unit=""
)
PAPERS = Find("shows-B", "T0O0W0D0H1", ("human",), "B", {"B": SHOWN, "A@1": SHOWN}, 3)


def test_what_is_written_is_read_again(study):
    assert read_finds(study) is None
    saver(study, "search")([FIND, PAPERS])
    assert read_finds(study) == Finds("search", (FIND, PAPERS))


def test_finds_of_earlier_searches_stay_but_for_those_of_the_same_mutant(study):
    saver(study, "search")([FIND, PAPERS])
    newer = Find("shows-B", "T1O0W0D0H0", ("corner",), "B", {"B": SHOWN}, 4)
    saver(study, "search")([newer])
    assert read_finds(study) == Finds("search", (FIND, newer))


def test_finds_of_another_grid_are_not_mixed(study):
    saver(study, "search")([FIND])
    with pytest.raises(InputError, match=r"found.yaml: grid='search' must be 'wide', the grid that is searched"):
        saver(study, "wide")


def test_a_find_for_placebo_is_not_written(study):
    saver(study, "search")([Find("shows-PLACEBO", "T0O0W0D0H0", (), "PLACEBO", {"PLACEBO": SHOWN}, 0)])
    assert read_finds(study) == Finds("search", ())


def test_the_grid_with_the_found_situations_has_the_own_ones_and_those(study):
    assert "paper+found" not in grid_names(study)
    saver(study, "search")([FIND, PAPERS])
    assert grid_names(study)[-1] == "paper+found"
    grid, own = load_grid(study, "paper+found"), load_grid(study)
    assert [one.key for one in grid.situations] == [*own.by_key, FIND.situation]
    assert grid.situation("shows-A@1").key == FIND.situation
    assert grid.situation("1").key == "T0O0W0D0H1"
    assert [one.key for one in grid.select(["shows-A@1", "T1*H1"])][-1] == FIND.situation
    assert [one.key for one in grid.select(["shows-*"])] == [PAPERS.situation, FIND.situation]
    assert grid.selected == {FIND.situation}
    assert load_grid(study, "search").selected == {FIND.situation}
    assert load_grid(study).selected == frozenset()


def test_breaks_stand_beside_finds_and_each_search_keeps_those_of_others(study):
    break_saver(study, "search")([BAR])
    saver(study, "search")([FIND])
    break_saver(study, "search")([BLIND])
    assert read_finds(study) == Finds("search", (FIND,), (BAR, BLIND))
    newer = replace(BAR, situation="T1O0W0D1H0", words=("corner", "dark"))
    break_saver(study, "search")([newer])
    assert read_finds(study) == Finds("search", (FIND,), (newer, BLIND))


def test_a_break_is_flown_by_name_over_the_grid_that_was_searched_and_not_beside_the_papers_situations(study):
    saver(study, "search")([FIND])
    break_saver(study, "search")([BAR])
    grid = load_grid(study, "search")
    assert grid.situation(BAR.name).key == BAR.situation
    assert grid.situation(FIND.name).key == FIND.situation
    assert grid.selected == {BAR.situation, FIND.situation}
    beside = load_grid(study, "paper+found")
    assert [one.key for one in beside.situations] == [*load_grid(study).by_key, FIND.situation]
    assert BAR.name not in beside.aliases


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("violated: 10", "violated: 5", r"found.yaml:\d+: violated=5 must be more than half of flights=10"),
        ("alike: 9", "alike: 11", r"found.yaml:\d+: alike=11 must be at most violated=10"),
        ("violated: 10", "violated: 11", r"found.yaml:\d+: violated=11 must be .* no more than all"),
        ("    near: bar\n", "", r"found.yaml:\d+: .*near"),
        ("flight: 0", "flihgt: 0", r"flight"),
    ],
)
def test_a_break_that_cannot_be_is_refused_with_its_place(study, old, new, message):
    content = text(Finds("search", (), (BAR,)))
    assert old in content
    (study / "found.yaml").write_text(content.replace(old, new, 1))
    with pytest.raises(InputError, match=message):
        load_grid(study, "search")


def test_a_break_that_the_study_has_outgrown_has_no_name_in_the_grid(study):
    content = text(Finds("search", (), (BAR,)))
    (study / "found.yaml").write_text(content.replace("Cs=0.8\n", "Cs=8\n", 1))
    assert BAR.name not in load_grid(study, "search").aliases


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "grid: search",
            "grid: serach",
            r"found.yaml: grid='serach' must be a grid of the study; did you mean 'search'",
        ),
        ("Cs=0.8\n", "Cs=8\n", r"found.yaml: grid 'search': .*search.yaml:\d+: Cs=8 must be 0.3 to 1.2"),
        ("p: 0.00025", "p: 7", r"found.yaml:\d+: p=7 must be >= 0 and <= 1"),
        ("mutant: A@1", "mutant: C", "shows must have the evidence for 'C', its own mutant"),
        ("candidate: 1", "candidat: 1", r"unknown key 'candidat'.*did you mean 'candidate'"),
    ],
)
def test_a_file_that_cannot_be_is_refused_with_its_place(study, old, new, message):
    content = text(Finds("search", (FIND,)))
    assert old in content
    (study / "found.yaml").write_text(content.replace(old, new, 1))
    with pytest.raises(InputError, match=message):
        load_grid(study, "paper+found")
