"""The same faults below four flight controls, and the firmwares' own seams: what was drawn, and the pages."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments import PUBLISHED, ROOT, firmware_matrix, four_autopilots
from experiments.four_autopilots import ARMS, DRAWN, NAME, PARAMETERS_DRAWN, ROWS, mutants
from experiments.pages import registered
from scaloft_fi.campaign.store.archive import MANIFEST
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.study import Study
from scaloft_fi.verbs.snapshot import snapshot


@pytest.fixture(scope="module")
def reference() -> Study:
    return Study.open(ROOT)


def archives(name: str) -> list[Path]:
    return [path.parent for path in sorted((PUBLISHED / name).glob(f"*/{MANIFEST}"))]


def test_the_papers_cells_come_first_then_the_drawn_ones_of_perception_and_navigation(reference: Study):
    ids = mutants(reference.matrix)
    assert len(set(ids)) == len(ROWS) + DRAWN
    assert [id_.partition("@")[0] for id_ in ids[:3]] == list(ROWS)
    assert {id_.partition("@")[0].partition("-")[2] for id_ in ids} <= PARAMETERS_DRAWN


@pytest.mark.parametrize("archive", archives(NAME), ids=lambda path: path.name)
def test_an_arm_has_the_flights_that_were_registered(reference: Study, archive: Path):
    arm = ARMS[archive.name]
    (seed,) = {int(part) for part in arm.seeds.split("-")}
    low, high = map(int, arm.pool.split("-"))
    with snapshot(reference, str(archive)) as now:
        flown = {(one.mutant, one.seed) for one in now.outcomes}
        counts = [sum(one.mutant == subject for one in now.outcomes) for subject, _ in sorted(flown)]
    assert {own for subject, own in flown if subject == BASELINE} == set(range(low, high + 1))
    subjects = {subject for subject, own in flown if subject != BASELINE and own == seed}
    assert {*mutants(reference.matrix), PLACEBO.id} <= subjects
    assert {own for subject, own in flown if subject != BASELINE} == {seed}
    assert max(counts) == len(four_autopilots.LIGHT) * 10


@pytest.mark.release
def test_the_pages_are_what_their_archives_make(reference: Study):
    for name, results in (
        (NAME, four_autopilots.results(reference)),
        (firmware_matrix.NAME, firmware_matrix.results()),
    ):
        assert (PUBLISHED / f"{name}.md").read_text(encoding="utf-8") == registered(name) + results
