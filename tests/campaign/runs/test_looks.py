"""Sequential looks: whole rounds, decided by the outcomes alone."""

from __future__ import annotations

import os
import signal
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

from scaloft_fi.campaign.plan.plan import Flight, Plan, plan
from scaloft_fi.campaign.progress.progress import Silence
from scaloft_fi.campaign.runs.baseline_pool import joined
from scaloft_fi.campaign.runs.interrupt import Interrupted
from scaloft_fi.campaign.runs.looks import Look, look_table, run_looks
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import Report
from scaloft_fi.errors import GateError
from scaloft_fi.mutants.derive import realise
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.scoring.decision import LOOKS, Decision, decisions
from scaloft_fi.results.telling.export import export_rows, to_json

LATE, MORE, CONTROL = "LATE-human@3s", "MORE-goal@1m", "REVERSE-velcmd"


def _plan(study: Any) -> Plan:
    mutants = [realise(study.matrix, name) for name in (LATE, MORE)]
    return plan(study.grid, (0,), mutants, realise(study.matrix, CONTROL)).with_pool(range(50))


def _looks(study: Any, log: Any, folder: str = "c", **options: Any) -> tuple[Report, tuple[Look, ...]]:
    where = study.folder / folder
    return run_looks(study, _plan(study), where, RunOptions(**options), progress=Silence(), flyer=log)


def _export(study: Any, report: Report) -> str:
    return to_json(export_rows(report.outcomes, study.roster, study.space))


def _seeds(report: Report, mutant: str, situation: str) -> set[int]:
    return {o.seed for o in report.outcomes if (o.mutant, o.situation) == (mutant, situation)}


def test_only_undecided_pairs_fly_on(study: Any, log: Any) -> None:
    report, looks = _looks(study, log)
    assert [look.seeds for look in looks] == list(LOOKS[: len(looks)])
    assert looks[0].pairs == 8
    for before, after in pairwise(looks):
        assert after.pairs == before.decided[Decision.UNDECIDED]
    said = decisions(report.outcomes, joined(report.outcomes, ()))
    for (mutant, situation), decided in said.items():
        if mutant in (LATE, MORE) and decided.decision is not Decision.UNDECIDED:
            assert _seeds(report, mutant, situation) == set(range(decided.look))


def test_what_the_run_decided_is_what_its_outcomes_decide(study: Any, log: Any) -> None:
    report, looks = _looks(study, log)
    said = decisions(report.outcomes, joined(report.outcomes, ()))
    final = [entry.decision for (mutant, _), entry in said.items() if mutant in (LATE, MORE)]
    settled = sum(sum(look.decided[d] for d in (Decision.KILLED, Decision.SURVIVED)) for look in looks)
    assert settled == sum(decision is not Decision.UNDECIDED for decision in final)


def test_a_pair_that_cannot_be_tested_flies_no_further_than_the_first_look(study: Any, log: Any) -> None:
    report, _ = _looks(study, log)
    assert _seeds(report, LATE, "D0H0") == set(range(LOOKS[0]))


def test_placebo_flies_wherever_a_mutant_does(study: Any, log: Any) -> None:
    report, _ = _looks(study, log)
    flown = {(o.situation, o.seed) for o in report.outcomes if o.mutant in (LATE, MORE)}
    assert flown <= {(o.situation, o.seed) for o in report.outcomes if o.mutant == "PLACEBO"}


def test_the_pool_is_flown_before_anything_is_decided_and_no_mutant_beyond_the_looks(study: Any, log: Any) -> None:
    report, _ = _looks(study, log)
    assert _seeds(report, "baseline", "D0H0") == set(range(50))
    assert max(o.seed for o in report.outcomes if o.mutant != "baseline") < LOOKS[-1]


@pytest.mark.parametrize("options", [{"jobs": 2}, {"jobs": 1, "share": False}])
def test_neither_jobs_nor_sharing_changes_anything(study: Any, log: Any, options: dict[str, Any]) -> None:
    one, looks = _looks(study, log)
    other, same = _looks(study, log, "other", **options)
    assert same == looks
    assert _export(study, other) == _export(study, one)


@pytest.mark.parametrize("at", [f"{MORE}/D0H1/1", f"{MORE}/D0H1/4", "PLACEBO/D1H0/3", "baseline/D1H1/30"])
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
    clean = [log(study, flight) for flight in own.with_pool(range(50)).pool]
    red = [replace(o, readings=tuple(replace(r, violated_at_s=9.0) for r in o.readings)) for o in clean]
    killed = []
    for number, others in enumerate(([], clean, red)):
        where = study.folder / str(number)
        _, looks = run_looks(study, own, where, others=others, progress=Silence(), flyer=log)
        killed.append(looks[0].decided[Decision.KILLED])
    assert killed == [1, 1, 0]


def test_a_baseline_of_both_pools_counts_once(study: Any, log: Any) -> None:
    flights = _plan(study).baselines
    clean = [log(study, flight) for flight in flights]
    assert joined(clean, clean) == joined(clean, ())
    assert {key: len(found) for key, found in joined(clean, ()).items()} == {s.key: 1 for s in study.grid}


def test_the_gates_are_held(study: Any, log: Any) -> None:
    log.change = lambda f, outcome: replace(outcome, digest="other") if f.subject.id == "PLACEBO" else outcome
    with pytest.raises(GateError, match="PLACEBO differs"):
        _looks(study, log)


def test_the_table_says_how_the_looks_went(study: Any, log: Any) -> None:
    _, looks = _looks(study, log)
    first = look_table(looks).records()[0]
    assert (first["seeds"], first["pairs"], first["flights"]) == (3, 8, 24)
    assert first["not tested"] == 8 - looks[0].decided.total()
