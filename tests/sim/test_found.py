"""The found situations: read with bounds, flown beside the study's own grid, and told apart where they do not fit."""

from __future__ import annotations

from dataclasses import replace

import pytest
from finding import BAR, found

from scaloft_fi.campaign.seeking.finds import break_saver, saver, text
from scaloft_fi.errors import InputError
from scaloft_fi.sim.grid import Evidence, Find, Finds, grid_names, load_grid, read_finds
from scaloft_fi.study import NO_FINDS, Study, known_finds

SHOWN = Evidence("SR2", 1, 0.00025, 0.005, 6, 6, "person", 10, 10, 0.071, 0.02, 10)
FIND = Find("shows-A@1", "T0O0W0D0H2Cs=0.8", ("human walks", "cruise speed 0.8 m/s"), "A@1", {"A@1": SHOWN}, 0)
BLIND = replace(
    BAR, name="breaks-SR2-nothing-home_to_corner-near_home-no_belief", struck="", belief="", error=0.0, unit=""
)
PAPERS = Find("shows-B", "T0O0W0D0H1", ("human",), "B", {"B": SHOWN, "A@1": SHOWN}, 3)


def test_what_is_written_is_read_again_and_earlier_finds_stay_but_for_those_of_the_same_mutant(study):
    assert read_finds(study) is None
    saver(study, "search")([FIND, PAPERS])
    assert read_finds(study) == Finds("search", (FIND, PAPERS))
    newer = Find("shows-B", "T1O0W0D0H0", ("corner",), "B", {"B": SHOWN}, 4)
    saver(study, "search")([newer])
    assert read_finds(study) == Finds("search", (FIND, newer))
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
    assert [grid.situation(name).key for name in ("shows-A@1", "1")] == [FIND.situation, "T0O0W0D0H1"]
    assert [one.key for one in grid.select(["shows-A@1", "T1*H1"])][-1] == FIND.situation
    assert [one.key for one in grid.select(["shows-*"])] == [PAPERS.situation, FIND.situation]
    assert grid.selected == load_grid(study, "search").selected == {FIND.situation}
    assert own.selected == frozenset()


def test_breaks_stand_beside_finds_and_each_search_keeps_those_of_others(study):
    for save, those in ((break_saver, [BAR]), (saver, [FIND]), (break_saver, [BLIND])):
        save(study, "search")(those)
    assert read_finds(study) == Finds("search", (FIND,), (BAR, BLIND))
    newer = replace(BAR, situation="T1O0W0D1H0", words=("corner", "dark"))
    break_saver(study, "search")([newer])
    assert read_finds(study) == Finds("search", (FIND,), (newer, BLIND))


def test_a_break_is_flown_by_name_over_the_grid_that_was_searched_and_not_beside_the_papers_situations(study):
    saver(study, "search")([FIND])
    break_saver(study, "search")([BAR])
    grid, beside = load_grid(study, "search"), load_grid(study, "paper+found")
    assert [grid.situation(one.name).key for one in (BAR, FIND)] == [BAR.situation, FIND.situation]
    assert grid.selected == {BAR.situation, FIND.situation}
    assert [one.key for one in beside.situations] == [*load_grid(study).by_key, FIND.situation]
    assert BAR.name not in beside.aliases


def test_a_break_that_the_study_has_outgrown_has_no_name_in_the_grid(study):
    (study / "found.yaml").write_text(text(Finds("search", (), (replace(BAR, situation="T1O0W0D1H0Cs=8"),))))
    assert BAR.name not in load_grid(study, "search").aliases


LATE, MORE, NO = "LATE-depth@0.4s", "MORE-goal@0.6m", "NO-depth@3s"


@pytest.fixture(scope="module")
def known():
    matrix = Study.open().matrix
    return lambda folder: known_finds(folder, matrix, ["SR1", "SR2", "OP1"])


def test_the_finds_of_a_mutant_are_those_that_show_it_its_own_first(study, known):
    assert known(study) == NO_FINDS
    finds = (found(LATE, others=(MORE,)), found(MORE, "T0O0W0D0H1"))
    saver(study, "search")(finds)
    told = known(study)
    assert (told.finds, told.misfits, told.grid, told.searched.name) == (finds, {}, "paper+found", "search")
    assert [find.name for find in told.of(MORE)] == [f"shows-{MORE}", f"shows-{LATE}"]
    assert (told.of(LATE), told.of(NO)) == (finds[:1], ())


def judged_by(requirement):
    find = found(LATE)
    return replace(find, shows={LATE: replace(find.shows[LATE], requirement=requirement)})


@pytest.mark.parametrize(
    ("stale", "why"),
    [
        (found(LATE, "T0O0W0D0H9"), "no situation 'T0O0W0D0H9' in keys like 'T0O0W0D0H0'"),
        (found(LATE, "T0O0W0D0H2Cs=8"), "Cs=8 must be 0.3 to 1.2"),
        (found(LATE, others=("LATE-depth@1kg",)), "'1kg' is no magnitude of LATE-depth"),
        (judged_by("SR9"), "no requirement 'SR9'; did you mean 'SR"),
    ],
)
def test_a_find_of_another_version_of_the_study_is_left_out_with_the_reason(study, known, stale, why):
    kept = found(MORE, "T0O0W0D0H1")
    saver(study, "search")([stale, kept])
    told = known(study)
    assert told.finds == (kept,)
    assert why in told.misfits[stale.name]
    (warning,) = told.warnings
    assert warning.startswith(f"sim/found.yaml: left out, because the study has changed since: {stale.name}: ")


def test_without_the_grid_that_was_searched_every_find_is_left_out_in_one_sentence(study, known):
    saver(study, "gone")([found(LATE), found(MORE)])
    told = known(study)
    (warning,) = told.warnings
    assert told.finds == ()
    assert f"shows-{LATE}, shows-{MORE}: " in warning
    assert "grid='gone' must be a grid of the study" in warning


def test_breaks_are_known_beside_the_finds_and_old_ones_are_left_out(study, known):
    stale = replace(BAR, name="breaks-SR9-bar", requirement="SR9"), replace(BAR, name="breaks-gone", situation="T7")
    break_saver(study, "search")([BAR, *stale])
    told = known(study)
    assert (told.finds, told.breaks, set(told.misfits)) == ((), (BAR,), {one.name for one in stale})
