"""Sequential looks: whole rounds, decided by the outcomes alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from running import LATE, MORE, Runs, asked, interrupting, red, same

from scaloft_fi.analysis.detection import LOOKS, Verdict
from scaloft_fi.analysis.score import score
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.progress import Silence
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.request import Look, run_looks
from scaloft_fi.campaign.runs.run import Report
from scaloft_fi.campaign.workers.local import Interrupted
from scaloft_fi.errors import GateError
from scaloft_fi.verbs.score import look_table


def _looks(fly: Runs, folder: str = "c", **options: Any) -> tuple[Report, tuple[Look, ...]]:
    planned = asked(fly.study, names=(LATE, MORE)).with_pool()
    return run_looks(fly.study, planned, fly.folder(folder), RunOptions(**options), progress=Silence(), flyer=fly.log)


def _seeds(report: Report, mutant: str, situation: str) -> set[int]:
    return {o.seed for o in report.outcomes if (o.mutant, o.situation) == (mutant, situation)}


def test_only_undecided_mutants_fly_on_each_look_with_a_quarter_of_alpha(fly: Runs) -> None:
    """LATE violates SR2 in one situation that tests it: p is 0.18, 0.0070 and 0.0007 with 1, 3 and 5 seeds."""
    report, looks = _looks(fly)
    assert [(look.seeds, look.mutants) for look in looks] == [*zip(LOOKS, (2, 1, 1), strict=False)]
    assert [look.undecided for look in looks] == [1, 1, 0]
    assert looks[0].not_detected == looks[2].detected == 1
    assert (_seeds(report, LATE, "D0H1"), _seeds(report, MORE, "D0H1")) == (set(range(5)), {0})
    assert _seeds(report, "baseline", "D0H1") == set(range(10)), "the pool is the same at every look"
    flown = {(o.situation, o.seed) for o in report.outcomes if o.mutant in (LATE, MORE)}
    assert flown <= {(o.situation, o.seed) for o in report.outcomes if o.mutant == "PLACEBO"}
    first = look_table(looks).records()[0]
    assert (first["seeds"], first["mutants"], first["flights"]) == (1, 2, 8)
    assert (first["undecided"], first["not detected"]) == (1, 1)
    scored = score(report.outcomes, fly.study.roster, fly.study.space, report.spending)
    told = {one.subject.id: one for one in scored.mutants}
    assert {name: one.verdict for name, one in told.items()} == {LATE: Verdict.DETECTED, MORE: Verdict.NOT_DETECTED}
    assert (told[LATE].safety.seeds, told[LATE].safety.share) == (5, 0.0025)


def test_a_mutant_flies_on_only_where_the_pool_has_a_steady_pair(log: Any, fly: Runs) -> None:
    log.change = lambda flight, outcome: red(outcome) if flight.name.startswith("baseline/D1H1") else outcome
    report, _ = _looks(fly)
    assert _seeds(report, LATE, "D1H1") == {0}
    assert _seeds(report, LATE, "D0H1") == set(range(5))


@pytest.mark.parametrize("options", [{"jobs": 2}, {"jobs": 1, "share": False}])
def test_neither_jobs_nor_sharing_changes_anything(fly: Runs, options: dict[str, Any]) -> None:
    one, looks = _looks(fly)
    other, again = _looks(fly, "other", **options)
    assert again == looks
    assert fly.export(other.outcomes) == fly.export(one.outcomes)


@pytest.mark.parametrize("at", [f"{MORE}/D0H1/0", f"{LATE}/D0H1/4", "PLACEBO/D1H0/3", "baseline/D1H1/7"])
def test_an_interruption_and_a_resumption_change_nothing(log: Any, fly: Runs, at: str) -> None:
    undisturbed, looks = _looks(fly, "undisturbed")

    log.change = interrupting(lambda flight: flight.name == at)
    with pytest.raises(Interrupted, match="flights are saved"):
        _looks(fly)
    log.change = same
    resumed, again = _looks(fly)
    assert again == looks
    assert fly.export(resumed.outcomes) == fly.export(undisturbed.outcomes)


def test_baselines_of_another_campaign_decide_too(study: Any, log: Any) -> None:
    own = asked(study, canary="")
    clean = [log(study, Flight(None, situation, seed)) for situation in study.grid for seed in range(50)]
    reds = [replace(red(outcome), violations=()) for outcome in clean]
    fates = []
    for number, others in enumerate(([], clean, reds)):
        _, looks = run_looks(study, own, study.folder / str(number), others=others, progress=Silence(), flyer=log)
        fates.append((len(looks), looks[-1].undecided, looks[-1].detected, looks[-1].not_tested))
    assert fates[0] == (1, 1, 0, 0)  # nothing is steady without a pool, so nothing flies on
    assert fates[1] == (2, 0, 1, 0)
    assert fates[2] == (1, 0, 0, 1)


def test_the_gates_are_held(log: Any, fly: Runs) -> None:
    log.change = lambda f, outcome: replace(outcome, digest="other") if f.subject.id == "PLACEBO" else outcome
    with pytest.raises(GateError, match="PLACEBO differs"):
        _looks(fly)
