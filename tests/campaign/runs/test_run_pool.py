"""The baseline pool of a run: where it is flown, what fails without it, and how runs spend alpha."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import Plan, plan
from scaloft_fi.campaign.progress import Silence
from scaloft_fi.campaign.runs.run import Report, run
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise

LATE, CONTROL = "LATE-human@3s", "REVERSE-velcmd"


def _plan(study: Any) -> Plan:
    return plan(study.grid, (0,), [realise(study.matrix, LATE)], realise(study.matrix, CONTROL))


def _run(study: Any, log: Any, planned: Plan | None = None) -> Report:
    return run(study, planned or _plan(study), study.folder / "c", progress=Silence(), flyer=log)


def _seeds(report: Report, situation: str) -> set[int]:
    return {o.seed for o in report.outcomes if o.mutant == "baseline" and o.situation == situation}


def test_a_pool_of_ten_is_flown_in_each_situation_where_a_mutant_infects(study: Any, log: Any) -> None:
    report = _run(study, log, planned=plan(study.grid, (0,), [realise(study.matrix, LATE)], None).with_pool())
    assert {key: _seeds(report, key) for key in ("D0H0", "D0H1", "D1H0", "D1H1")} == {
        "D0H0": {0},
        "D0H1": set(range(10)),
        "D1H0": {0},
        "D1H1": set(range(10)),
    }
    assert {o.seed for o in report.outcomes if o.mutant != "baseline"} == {0}


def test_a_resumed_run_completes_the_pool_and_flies_nothing_twice(study: Any, log: Any) -> None:
    planned = _plan(study)
    _run(study, log, planned=planned)
    before = len(log.flown)
    report = _run(study, log, planned=planned.with_pool())
    assert [len(_seeds(report, key)) for key in ("D0H0", "D0H1", "D1H0", "D1H1")] == [1, 10, 1, 10]
    # the last one is the flight that each run repeats
    assert len(log.flown) - before == 2 * 9 + 1


def test_a_pool_in_which_no_pair_is_steady_fails_the_gate(study: Any, log: Any) -> None:
    def red(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.mutant is not None or flight.seed % 2:
            return outcome
        return replace(outcome, readings=tuple(replace(r, violated_at_s=2.0) for r in outcome.readings))

    log.change = red
    with pytest.raises(GateError, match="no situation flown has a steady pair"):
        _run(study, log, planned=_plan(study).with_pool())


def test_without_a_pool_some_baseline_must_hold_a_safety_requirement(study: Any, log: Any) -> None:
    def red(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.mutant is not None:
            return outcome
        return replace(outcome, readings=tuple(replace(r, violated_at_s=2.0) for r in outcome.readings))

    log.change = red
    with pytest.raises(GateError, match="no situation flown has a baseline that holds a safety requirement"):
        _run(study, log)


def test_a_campaign_remembers_with_which_seeds_its_mutants_were_asked_for(study: Any, log: Any) -> None:
    late, more = (realise(study.matrix, name) for name in (LATE, "MORE-goal@1m"))
    once = _run(study, log, planned=plan(study.grid, (0,), [late, more], None))
    assert once.spending == Spending(0.01, frozenset())
    again = _run(study, log, planned=plan(study.grid, (0,), [late], None))
    assert again.spending.grown == frozenset()
    grown = _run(study, log, planned=plan(study.grid, range(3), [late], None))
    assert grown.spending.grown == {LATE, "PLACEBO"}


def test_to_ask_for_fewer_seeds_than_before_is_no_growth(study: Any, log: Any) -> None:
    late = realise(study.matrix, LATE)
    _run(study, log, planned=plan(study.grid, range(3), [late], None))
    again = _run(study, log, planned=plan(study.grid, (1,), [late], None))
    assert again.spending.grown == frozenset()
