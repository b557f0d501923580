"""The same faults below four flight controls, and the firmwares' own seams: what was drawn, and the pages."""

from __future__ import annotations

import pytest

from experiments import PUBLISHED, ROOT, firmware_matrix, four_autopilots
from experiments.four_autopilots import ARMS, DRAWN, NAME, PARAMETERS_DRAWN, ROWS, mutants
from experiments.operating_point import LIGHT
from experiments.pages import registered
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.study import Study
from scaloft_fi.verbs.snapshot import snapshot


@pytest.fixture(scope="module")
def reference() -> Study:
    return Study.open(ROOT)


SEEDS = {"again": (10, range(10, 20))}
"""Seed of the mutants and seeds of the pool of an arm whose are not 0 and 0 to 9."""


def test_the_papers_cells_come_first_then_the_drawn_ones_of_perception_and_navigation(reference: Study):
    ids = mutants(reference.matrix)
    assert len(set(ids)) == len(ROWS) + DRAWN
    assert [id_.partition("@")[0] for id_ in ids[:3]] == list(ROWS)
    assert {id_.partition("@")[0].partition("-")[2] for id_ in ids} <= PARAMETERS_DRAWN


@pytest.mark.parametrize("arm", ARMS)
def test_an_arm_has_the_flights_that_were_registered(reference: Study, arm: str):
    seed, pool = SEEDS.get(arm, (0, range(10)))
    with snapshot(reference, str(PUBLISHED / NAME / arm)) as now:
        flown = {(one.mutant, one.seed) for one in now.outcomes}
        counts = [sum(one.mutant == subject for one in now.outcomes) for subject, _ in sorted(flown)]
    assert {own for subject, own in flown if subject == BASELINE} == set(pool)
    subjects = {subject for subject, own in flown if subject != BASELINE and own == seed}
    assert {*mutants(reference.matrix), PLACEBO.id} <= subjects
    assert {own for subject, own in flown if subject != BASELINE} == {seed}
    assert max(counts) == len(LIGHT) * 10


@pytest.mark.release
def test_the_pages_are_what_their_archives_make(reference: Study):
    for script in (four_autopilots, firmware_matrix):
        made = script.results(reference, 1, PUBLISHED)
        assert (PUBLISHED / f"{script.NAME}.md").read_text(encoding="utf-8") == registered(script.NAME) + made
