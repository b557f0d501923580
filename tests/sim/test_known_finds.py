"""The finds that still fit the study are told apart from those that do not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from finding import BAR, found

from scaloft_fi.campaign.seeking.finds import break_saver, saver
from scaloft_fi.errors import InputError
from scaloft_fi.sim.found import Find
from scaloft_fi.study import NO_FINDS, KnownFinds, Study, known_finds

MATRIX = Study.open(Path(__file__).parents[2]).matrix
LATE, MORE, NO = "LATE-depth@0.4s", "MORE-goal@0.6m", "NO-depth@3s"


def known(folder: Path) -> KnownFinds:
    return known_finds(folder, MATRIX, ["SR1", "SR2", "OP1"])


def test_without_the_file_nothing_is_found(study: Path) -> None:
    assert known(study) == NO_FINDS


def test_the_finds_of_a_mutant_are_those_that_show_it_its_own_first(study: Path) -> None:
    finds = (found(LATE, others=(MORE,)), found(MORE, "T0O0W0D0H1"))
    saver(study, "search")(finds)
    told = known(study)
    assert (told.finds, told.misfits, told.grid) == (finds, {}, "paper+found")
    assert told.searched is not None
    assert told.searched.name == "search"
    assert [find.name for find in told.of(MORE)] == [f"shows-{MORE}", f"shows-{LATE}"]
    assert told.of(LATE) == finds[:1]
    assert told.of(NO) == ()


def judged_by(requirement: str) -> Find:
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
def test_a_find_of_another_version_of_the_study_is_left_out_with_the_reason(study: Path, stale: Find, why: str) -> None:
    kept = found(MORE, "T0O0W0D0H1")
    saver(study, "search")([stale, kept])
    told = known(study)
    assert told.finds == (kept,)
    assert why in told.misfits[stale.name]
    (warning,) = told.warnings
    assert warning.startswith(f"sim/found.yaml: left out, because the study has changed since: {stale.name}: ")


def test_without_the_grid_that_was_searched_every_find_is_left_out_in_one_sentence(study: Path) -> None:
    saver(study, "gone")([found(LATE), found(MORE)])
    told = known(study)
    assert told.finds == ()
    (warning,) = told.warnings
    assert f"shows-{LATE}, shows-{MORE}: " in warning
    assert "grid='gone' must be a grid of the study" in warning


def test_a_file_that_cannot_be_read_is_refused(study: Path) -> None:
    saver(study, "search")([found(LATE)])
    path = study / "found.yaml"
    path.write_text(path.read_text().replace("violated: 6", "violated: many"))
    with pytest.raises(InputError, match=r"found.yaml:\d+: violated='many' must be a whole number"):
        known(study)


def test_breaks_are_known_beside_the_finds_and_old_ones_are_left_out(study: Path) -> None:
    stale = replace(BAR, name="breaks-SR9-bar", requirement="SR9"), replace(BAR, name="breaks-gone", situation="T7")
    break_saver(study, "search")([BAR, *stale])
    told = known(study)
    assert (told.finds, told.breaks) == ((), (BAR,))
    assert set(told.misfits) == {one.name for one in stale}
