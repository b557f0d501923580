from __future__ import annotations

import shutil
from dataclasses import asdict, replace
from pathlib import Path

import pytest
from finding import found
from found.page import Evidence, page

from scaloft_fi.analysis.seeking.effort import Effort
from scaloft_fi.campaign.runs.seeking.finds import saver
from scaloft_fi.campaign.runs.seeking.seek import Sought
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.sim.found import read_finds
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]
SHOWN, LEFT = "LATE-depth@0.5s", "NO-battery@100%"
FIND = found(SHOWN)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder = tmp_path_factory.mktemp("study")
    for part in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / part, folder / part)
    (folder / "sim" / "found.yaml").unlink(missing_ok=True)
    saver(folder / "sim", "search")([FIND])
    return Study.open(folder, "paper+found")


def flown(mutant: str, seed: int, *, violates: bool) -> Outcome:
    t_s = 7.0 if violates else None
    return Outcome(
        Subject(mutant, "LATE", "depth", "0.5s") if mutant != BASELINE else Subject(BASELINE),
        FIND.situation,
        seed,
        ending="landed",
        readings=(Reading("SR2", Kind.SAFETY, -0.1 if violates else 0.1, t_s, 1, open=False),),
        violations=(Violation("SR2", Kind.SAFETY, 7.0, 0.0, 1.0, 1.6, ""),) if violates else (),
        carried=5,
        altered=0 if mutant == BASELINE else 3,
        duration_s=40.0,
        digest=f"{mutant}{seed}",
    )


def evidence(study: Study, violating: int) -> Evidence:
    """Ten baselines that hold, six flights of the mutant of which the first `violating` violate."""
    flights = [flown(BASELINE, seed, violates=False) for seed in range(10)]
    flights += [flown(SHOWN, seed, violates=seed < violating) for seed in range(6)]
    sought = (
        Sought(SHOWN, FIND.situation, 90, 1, 0.005, Effort(24, 24, 24, 24, 3, -1.2, "SR2", FIND.situation)),
        Sought(LEFT, "", 0, 0, 0.0, Effort(24, 20, 0, 0, 0)),
    )
    finds = read_finds(study.folder / "sim")
    assert finds is not None
    return Evidence(
        study=study,
        finds=finds,
        search={
            "wall_s": 3600,
            "processor_s": 7100,
            "jobs": 2,
            "flown": 9000,
            "seed": 0,
            "sought": [asdict(one) for one in sought],
        },
        false=[],
        again={one.name: one for one in flights},
        survivors=[SHOWN, LEFT],
        wide=[LEFT],
    )


def test_a_mutant_counts_where_its_find_detects_it_alone_when_it_is_flown_again(study):
    shown = evidence(study, violating=6)
    assert shown.detected == [SHOWN]
    text = page(shown)
    total = len(study.roster.defaults)
    assert f"| **{total - 1}** | {total} | these, and each of the others by its find alone" in text
    assert "0 of 1 were not detected again; 1 violated as often" in text


def test_a_find_that_does_not_detect_its_mutant_again_does_not_count(study):
    failed = evidence(study, violating=1)
    assert failed.detected == []
    text = page(failed)
    total = len(study.roster.defaults)
    assert f"| **{total - 2}** | {total} |" in text
    assert "1 of 1 were not detected again; 0 violated as often" in text


def test_flights_of_other_situations_and_of_further_seeds_do_not_count(study):
    shown = evidence(study, violating=6)
    elsewhere = {name: replace(one, situation="T0O0W0D0H1") for name, one in shown.again.items()}
    assert replace(shown, again=elsewhere).detected == []
    late = {name: replace(one, seed=one.seed + 50) for name, one in shown.again.items()}
    assert replace(shown, again=late).detected == []


def test_the_page_says_of_each_mutant_without_a_find_at_which_stage_its_fault_stopped(study):
    text = page(evidence(study, violating=6))
    assert "## Not found: 1" in text
    row = next(line for line in text.splitlines() if line.startswith(f"| {LEFT} |"))
    assert "24" in row
    assert row.count("|") == 5
    assert len(row.split("|")[3].strip()) > 10


def test_the_page_counts_false_searches_that_found_anything(study):
    sought = asdict(Sought("PLACEBO", "", 0, 1, 0.005, Effort(200, 200, 0, 0, 2)))
    runs = [
        {"seed": seed, "used": 400, "finds": [{"name": "x"}] * (seed == 3), "sought": [sought]} for seed in (1, 2, 3)
    ]
    text = page(replace(evidence(study, violating=6), false=runs))
    assert "3 searches for the unmutated drone" in text
    assert "of its own: **1** found anything." in text
