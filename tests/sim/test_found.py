"""The found situations: read with bounds, flown beside the study's own grid."""

from __future__ import annotations

import pytest

from scaloft_fi.campaign.runs.seeking.finds import saver, text
from scaloft_fi.errors import InputError
from scaloft_fi.sim.found import Evidence, Find, Finds, read_finds
from scaloft_fi.sim.grids import grid_names, load_grid

SHOWN = Evidence("SR2", 1, 0.00025, 0.005, 6, 6, "person", 10, 10, 0.071, 0.02)
FIND = Find("shows-A@1", "T0O0W0D0H2Cs=0.8", ("human walks", "cruise speed 0.8 m/s"), "A@1", {"A@1": SHOWN}, 0)
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
