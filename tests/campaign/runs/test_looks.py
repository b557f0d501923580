"""Sequential looks: whole rounds, decided by the outcomes alone."""

from __future__ import annotations

import os
import signal
from dataclasses import replace
from typing import Any

import pytest

from scaloft_fi.analysis.detection import LOOKS, Verdict
from scaloft_fi.analysis.score import score
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import Plan, plan
from scaloft_fi.campaign.progress import Silence
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.request import Look, run_looks
from scaloft_fi.campaign.runs.run import Report
from scaloft_fi.campaign.workers.local import Interrupted
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.verbs.export.rows import export_rows, to_json
from scaloft_fi.verbs.score import look_table

LATE, MORE, CONTROL = "LATE-human@3s", "MORE-goal@1m", "REVERSE-velcmd"


def _plan(study: Any) -> Plan:
    mutants = [realise(study.matrix, name) for name in (LATE, MORE)]
    return plan(study.grid, (0,), mutants, realise(study.matrix, CONTROL)).with_pool()


def _looks(study: Any, log: Any, folder: str = "c", **options: Any) -> tuple[Report, tuple[Look, ...]]:
    where = study.folder / folder
    return run_looks(study, _plan(study), where, RunOptions(**options), progress=Silence(), flyer=log)


def _export(study: Any, report: Report) -> str:
    return to_json(export_rows(report.outcomes, study.roster, study.space))


def _seeds(report: Report, mutant: str, situation: str) -> set[int]:
    return {o.seed for o in report.outcomes if (o.mutant, o.situation) == (mutant, situation)}


def test_only_undecided_mutants_fly_on_each_look_with_a_quarter_of_alpha(study: Any, log: Any) -> None:
    """LATE violates SR2 in one situation that tests it: p is 0.18, 0.0070 and 0.0007 with 1, 3 and 5 seeds."""
    report, looks = _looks(study, log)
    assert [look.seeds for look in looks] == list(LOOKS[:3])
    assert [look.mutants for look in looks] == [2, 1, 1]
    assert [look.fates[Verdict.UNDECIDED] for look in looks] == [1, 1, 0]
    assert looks[0].fates[Verdict.NOT_DETECTED] == 1
    assert looks[2].fates[Verdict.DETECTED] == 1
    assert _seeds(report, LATE, "D0H1") == set(range(5))
    assert _seeds(report, MORE, "D0H1") == {0}


def test_what_the_run_decided_is_what_its_outcomes_decide(study: Any, log: Any) -> None:
    report, _ = _looks(study, log)
    scored = score(report.outcomes, study.roster, study.space, report.spending)
    assert {mutant.subject.id: mutant.verdict for mutant in scored.mutants} == {
        LATE: Verdict.DETECTED,
        MORE: Verdict.NOT_DETECTED,
    }
    late = next(mutant for mutant in scored.mutants if mutant.subject.id == LATE)
    assert (late.safety.seeds, late.safety.share) == (5, 0.0025)


def test_a_mutant_flies_on_only_where_the_pool_has_a_steady_pair(study: Any, log: Any) -> None:
    def red(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.situation.key != "D1H1" or flight.mutant is not None:
            return outcome
        return replace(outcome, readings=tuple(replace(r, violated_at_s=2.0) for r in outcome.readings))

    log.change = red
    report, _ = _looks(study, log)
    assert _seeds(report, LATE, "D1H1") == {0}
    assert _seeds(report, LATE, "D0H1") == set(range(5))


def test_placebo_flies_wherever_a_mutant_does(study: Any, log: Any) -> None:
    report, _ = _looks(study, log)
    flown = {(o.situation, o.seed) for o in report.outcomes if o.mutant in (LATE, MORE)}
    assert flown <= {(o.situation, o.seed) for o in report.outcomes if o.mutant == "PLACEBO"}


def test_the_pool_is_the_same_at_every_look(study: Any, log: Any) -> None:
    report, looks = _looks(study, log)
    assert len(looks) == 3
    assert _seeds(report, "baseline", "D0H1") == set(range(10))


@pytest.mark.parametrize("options", [{"jobs": 2}, {"jobs": 1, "share": False}])
def test_neither_jobs_nor_sharing_changes_anything(study: Any, log: Any, options: dict[str, Any]) -> None:
    one, looks = _looks(study, log)
    other, same = _looks(study, log, "other", **options)
    assert same == looks
    assert _export(study, other) == _export(study, one)


@pytest.mark.parametrize("at", [f"{MORE}/D0H1/0", f"{LATE}/D0H1/4", "PLACEBO/D1H0/3", "baseline/D1H1/7"])
def test_an_interruption_and_a_resumption_change_nothing(study: Any, log: Any, at: str) -> None:
    undisturbed, looks = _looks(study, log, "undisturbed")

    def interrupt(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.name == at:
            os.kill(os.getppid(), signal.SIGINT)
        return outcome

    log.change = interrupt
    with pytest.raises(Interrupted, match="flights are saved"):
        _looks(study, log)
    log.change = lambda _flight, outcome: outcome
    resumed, same = _looks(study, log)
    assert same == looks
    assert _export(study, resumed) == _export(study, undisturbed)


def test_baselines_of_another_campaign_decide_too(study: Any, log: Any) -> None:
    own = plan(study.grid, (0,), [realise(study.matrix, LATE)], None)
    clean = [log(study, Flight(None, situation, seed)) for situation in study.grid for seed in range(50)]
    red = [replace(o, readings=tuple(replace(r, violated_at_s=9.0) for r in o.readings), violations=()) for o in clean]
    fates = []
    for number, others in enumerate(([], clean, red)):
        _, looks = run_looks(study, own, study.folder / str(number), others=others, progress=Silence(), flyer=log)
        fates.append((len(looks), looks[-1].fates))
    assert fates[0] == (1, {Verdict.UNDECIDED: 1})  # nothing is steady without a pool, so nothing flies on
    assert fates[1] == (2, {Verdict.DETECTED: 1})
    assert fates[2] == (1, {Verdict.NOT_TESTED: 1})


def test_the_gates_are_held(study: Any, log: Any) -> None:
    log.change = lambda f, outcome: replace(outcome, digest="other") if f.subject.id == "PLACEBO" else outcome
    with pytest.raises(GateError, match="PLACEBO differs"):
        _looks(study, log)


def test_the_table_says_how_the_looks_went(study: Any, log: Any) -> None:
    _, looks = _looks(study, log)
    first = look_table(looks).records()[0]
    assert (first["seeds"], first["mutants"], first["flights"]) == (1, 2, 8)
    assert (first["undecided"], first["not detected"]) == (1, 1)
