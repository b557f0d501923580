"""Finds flown again on seeds of their own, without physics; what a study keeps of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from finding import BAR, Ruled, fast, found, never, small_study
from running import dying, quiet

from scaloft_fi.analysis.seeking import POOL, SEEDS
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.seeking.finds import BLOCK, FRESH, SeekReport, break_saver, holding, keep, replicate, saver
from scaloft_fi.campaign.workers import Interrupted
from scaloft_fi.sim.grid import Find, read_finds
from scaloft_fi.study import Study

LATE, MORE = "LATE-human@3s", "MORE-goal@1m"
SITUATION = "T0D0H1Cs=0.9"


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return small_study(tmp_path / "study")


@pytest.fixture
def flyer(tmp_path: Path) -> Ruled:
    return Ruled(tmp_path / "flown.txt", {LATE: fast, MORE: never})


def again(study: Study, flyer: Ruled, *finds: Find, progress: Progress | None = None) -> SeekReport:
    ask = {find.name: list(find.shows) for find in finds}
    return replicate(study, finds, ask, study.folder / "c", progress=progress or quiet(), flyer=flyer)


def seeds(flyer: Ruled, subject: str) -> set[int]:
    return {int(name.rsplit("/", 1)[1]) for name in flyer.flown if name.startswith(subject)}


def test_each_pair_flies_on_ten_seeds_beside_thirty_baselines_that_nothing_used(study: Study, flyer: Ruled):
    report = again(study, flyer, found(LATE, SITUATION, others=(MORE,)))
    assert [(one.mutant, one.holds) for one in report.replicas] == [(LATE, True), (MORE, False)]
    assert seeds(flyer, LATE) == seeds(flyer, MORE) == set(range(FRESH, FRESH + SEEDS))
    assert seeds(flyer, "baseline") == set(range(FRESH, FRESH + POOL))
    assert (report.used, report.first) == (POOL + 2 * SEEDS, FRESH)


def test_the_next_replication_has_other_seeds_in_the_same_campaign_and_in_another(study: Study, flyer: Ruled):
    find = found(LATE, SITUATION)
    first, second = again(study, flyer, find), again(study, flyer, find)
    assert (first.first, second.first) == (FRESH, FRESH + BLOCK)
    (kept,) = holding([find], first.replicas)
    elsewhere = replicate(study, [kept], {kept.name: [LATE]}, study.folder / "d", progress=quiet(), flyer=flyer)
    assert elsewhere.first == FRESH + BLOCK


def test_an_interrupted_replication_goes_on_with_its_seeds(study: Study, flyer: Ruled):
    with pytest.raises(Interrupted):
        again(study, flyer, found(LATE, SITUATION), progress=dying(7, Interrupted("stopped")))
    report = again(study, flyer, found(LATE, SITUATION))
    assert report.first == FRESH
    assert report.flown < report.used


def test_what_does_not_hold_leaves_and_the_find_takes_the_name_of_what_does(study: Study, flyer: Ruled):
    find, left = found(MORE, SITUATION, others=(LATE,)), found("NO-depth@3s", "T0D0H0Cs=0.9")
    saver(study.folder / "sim", "small")([find, left])
    break_saver(study.folder / "sim", "small")([BAR])
    report = again(study, flyer, find, left)
    kept = holding([find, left], report.replicas)
    keep(study.folder / "sim", "small", kept)
    written = read_finds(study.folder / "sim")
    assert [(one.name, one.mutant, list(one.shows)) for one in written.finds] == [(f"shows-{LATE}", LATE, [LATE])]
    assert written.breaks == (BAR,)
    told = written.finds[0].shows[LATE].again
    assert (told.seed, told.violated, told.flights, told.baselines) == (FRESH, SEEDS, SEEDS, POOL)
    assert told.p == pytest.approx(report.replicas[1].again.p, rel=1e-3)


def test_what_was_not_replicated_stays_and_a_name_that_is_taken_is_not_given_twice(study: Study, flyer: Ruled):
    find, other = found(MORE, SITUATION, others=(LATE,)), found(LATE, "T0D1H1Cs=0.9")
    report = again(study, flyer, find)
    kept = holding([find, other], report.replicas)
    assert [(one.name, one.mutant) for one in kept] == [(f"shows-{LATE}", LATE), (f"shows-{MORE}", LATE)]
    assert kept[0] == other
