from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import pytest
from builders import outcome
from finding import found
from studies import copied

from experiments import PUBLISHED
from experiments import found as experiment
from experiments.found import END, Evidence, results
from experiments.pages import registered
from scaloft_fi.analysis.seeking import POOL, SEEDS, Effort
from scaloft_fi.campaign.seeking.finds import Sought
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.sim.grid import Finds
from scaloft_fi.study import Study
from scaloft_fi.views.output import plain

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""

SHOWN, LEFT = "LATE-human@3s", "NO-human@100%"
FIND = found(SHOWN, "T0O0W0D0H1")
FIRST = 100_000


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return Study.open(copied(tmp_path_factory.mktemp("study"), "found.yaml"), "paper")


def evidence(study: Study, violating: int) -> Evidence:
    """Thirty baselines that hold, ten flights of the mutant of which the first `violating` violate."""
    flown: list[Outcome] = [outcome(situation=FIND.situation, seed=FIRST + seed) for seed in range(POOL)]
    flown += [
        outcome(SHOWN, FIND.situation, FIRST + seed, violated={"SR2": 7.0} if seed < violating else {})
        for seed in range(SEEDS)
    ]
    sought = (
        Sought(SHOWN, FIND.situation, 90, 1, 0.005, Effort(24, 24, 24, 24, 3, -1.2, "SR2", FIND.situation)),
        Sought(LEFT, "", 0, 0, 0.0, Effort(24, 20, 0, 0, 0)),
    )
    shows = [{"mutant": mutant, **plain(told)} for mutant, told in FIND.shows.items()]
    search: dict[str, Any] = {
        "wall_s": 3600,
        "processor_s": 7100,
        "jobs": 2,
        "flown": 9000,
        "seed": 0,
        "alpha": 0.01,
        "finds": [asdict(replace(FIND, shows={})) | {"shows": shows}],
        "sought": [asdict(one) for one in sought],
    }
    return Evidence(
        study=study,
        finds=Finds("search", (FIND,)),
        search=search,
        replication={"first": FIRST},
        flights={"replication": {one.name: one for one in flown}},
        survivors=[SHOWN, LEFT],
        wide=[LEFT],
    )


def test_a_mutant_counts_where_its_find_holds_on_fresh_seeds(study):
    shown = evidence(study, violating=10)
    assert shown.held == [SHOWN]
    assert shown.left_out == (1, 1)
    total = len(study.roster.defaults)
    assert f"| **{total - 1}** | {total} | these, and each of the others by its find alone" in results(shown)


def test_a_find_that_does_not_hold_does_not_count(study):
    failed = evidence(study, violating=1)
    assert failed.held == []
    total = len(study.roster.defaults)
    assert f"| **{total - 2}** | {total} |" in results(failed)
    assert "no: p=" in results(failed)


def test_a_find_that_hangs_on_a_seed_is_seen_when_that_seed_is_left_out(study):
    """Three of ten violate: too few, but enough where a seed that does not violate is left out."""
    some = evidence(study, violating=3)
    assert (some.held, some.left_out) == ([], (0, 1))


def test_the_published_page_and_what_held_follow_from_the_published_flights():
    published = experiment.evidence(PUBLISHED)
    assert registered("found", end=END) + results(published) == (PUBLISHED / "found.md").read_text(encoding="utf-8")
    assert {(one["find"], one["mutant"]): one["holds"] for one in published.replication["replicas"]} == {
        (one.find, one.mutant): one.holds for one in published.replicas
    }
    kept = {mutant for find in published.finds.finds for mutant in find.shows}
    assert kept == set(published.held)
