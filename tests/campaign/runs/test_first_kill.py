"""Killed or not with the least flying: the answer is the whole campaign's, the flights are fewer and kept apart."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass, replace
from typing import Any

import pytest

from scaloft_fi.campaign.held.folder import STORE_NAME
from scaloft_fi.campaign.held.held import held
from scaloft_fi.campaign.plan.plan import Flight, Plan, plan
from scaloft_fi.campaign.progress.progress import Silence
from scaloft_fi.campaign.runs.first_kill import first_kills
from scaloft_fi.campaign.runs.interrupt import Interrupted
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.rounds import kill_rates, ordered, promise
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.errors import GateError
from scaloft_fi.mutants.derive import defaults, realise
from scaloft_fi.results.outcome import FIRST_KILL, Outcome
from scaloft_fi.results.scoring.first_kills import FirstKills
from scaloft_fi.results.scoring.score import score
from scaloft_fi.results.store import Store
from scaloft_fi.results.telling.export import export_rows, to_json

LATE, CONTROL = "LATE-human@3s", "REVERSE-velcmd"


@dataclass
class Cutting:
    """A flyer that cuts at the first kill, as the real one does."""

    log: Any

    def prepare(self, study: Any, say: Any) -> None:
        pass

    def __call__(self, study: Any, flight: Flight, baseline: Outcome | None = None) -> Outcome:
        whole: Outcome = self.log(study, flight, baseline)
        killed = whole.first_violation
        if baseline is None or flight.mutant is None or killed is None or baseline.first_violation is not None:
            return whole
        open_ = tuple(replace(r, open=not r.violated) for r in whole.readings)
        return replace(whole, readings=open_, duration_s=killed.t_s, truncated=FIRST_KILL, digest="cut")

    def share(self, study: Any, task: Any, home: Any) -> None:
        for flight in task.flights:
            home(self(study, flight, task.baseline))


def _plan(study: Any, seeds: tuple[int, ...] = (0,), names: tuple[str, ...] = (LATE, "MORE-goal@1m")) -> Plan:
    return plan(study.grid, seeds, [realise(study.matrix, name) for name in names], realise(study.matrix, CONTROL))


def _hunt(study: Any, log: Any, planned: Plan | None = None, folder: str = "c", **options: Any) -> FirstKills:
    where = study.folder / folder
    return first_kills(
        study, planned or _plan(study), where, RunOptions(**options), progress=Silence(), flyer=Cutting(log)
    )


def test_a_mutant_flies_until_its_first_kill_and_no_further(study: Any, log: Any) -> None:
    found = {answer.subject.id: answer for answer in _hunt(study, log).answers}
    assert found[LATE].killed is True
    assert found[LATE].requirement == "SR2"
    assert found[LATE].t_s == 7.0
    flown = [name for name in log.flown if name.startswith(LATE)]
    assert flown[-1].startswith(f"{LATE}/D0H1") or found[LATE].kill is not None
    assert len(flown) == found[LATE].flown < 4


def test_a_survivor_flies_wherever_a_baseline_holds_a_requirement(study: Any, log: Any) -> None:
    found = {answer.subject.id: answer for answer in _hunt(study, log).answers}
    assert found["MORE-goal@1m"].killed is False
    assert found["MORE-goal@1m"].flown == found["MORE-goal@1m"].possible == 4


def test_where_no_baseline_holds_a_safety_requirement_only_controls_fly(study: Any, log: Any) -> None:
    def red(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.situation.key != "D1H1" or flight.subject.id == CONTROL:
            return outcome
        return replace(outcome, readings=tuple(replace(r, violated_at_s=2.0) for r in outcome.readings))

    log.change = red
    found = _hunt(study, log)
    assert found.idle == (("D1H1", 0),)
    assert not any(name.startswith("MORE-goal") and "D1H1" in name for name in log.flown)


def test_the_answers_are_those_of_the_whole_campaign(study: Any, log: Any) -> None:
    planned = plan(study.grid, (0,), [*defaults(study.matrix)[:30], realise(study.matrix, LATE)], None)
    report = run(study, planned, study.folder / "whole", progress=Silence(), flyer=log)
    whole = score(report.outcomes, study.roster, study.space)
    killed = {m.subject.id for m in (*whole.mutants, *whole.controls) if m.killed}
    before = len(log.flown)
    found = _hunt(study, log, planned)
    assert {answer.subject.id for answer in found.answers if answer.killed} == killed
    assert len(log.flown) - before < before


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_table_depends_neither_on_jobs_nor_on_sharing(study: Any, log: Any, jobs: int) -> None:
    planned = plan(study.grid, (0, 1), defaults(study.matrix)[:60], None)
    first = _hunt(study, log, planned, "one")
    assert _hunt(study, log, planned, "more", jobs=jobs).to_json() == first.to_json()
    assert _hunt(study, log, planned, "alone", jobs=jobs, share=False).to_json() == first.to_json()


def test_an_interrupted_hunt_resumes_to_the_same_table_and_flies_nothing_twice(study: Any, log: Any) -> None:
    undisturbed = _hunt(study, log, folder="undisturbed")

    def interrupt(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.name == "MORE-goal@1m/D1H0/0":
            os.kill(os.getppid(), signal.SIGINT)
        return outcome

    log.change = interrupt
    with pytest.raises(Interrupted, match="flights are saved"):
        _hunt(study, log)
    log.change = lambda _flight, outcome: outcome
    before = len(log.flown)
    assert _hunt(study, log).to_json() == undisturbed.to_json()
    again = [name for name in log.flown[before:] if not name.startswith("baseline")]
    assert len(again) < undisturbed.flown
    before = len(log.flown)
    _hunt(study, log)
    assert log.flown[before:] == []


def test_a_whole_flight_in_the_store_answers_without_flying(study: Any, log: Any) -> None:
    run(study, _plan(study), study.folder / "c", progress=Silence(), flyer=log)
    before = len(log.flown)
    found = _hunt(study, log)
    assert log.flown[before:] == []
    assert [answer.killed for answer in found.answers] == [True, False]


def test_cut_flights_enter_no_score_no_export_and_nothing_owed(study: Any, log: Any) -> None:
    _hunt(study, log)
    found = held(study, f"{study.folder}/c")
    assert {outcome.mutant for outcome in found.current} == {"baseline", "PLACEBO", CONTROL}
    assert not any(outcome.truncated for outcome in found.current)
    assert (found.stale, found.owed) == (0, 0)


def test_a_whole_run_after_a_hunt_exports_the_bytes_of_one_without(study: Any, log: Any) -> None:
    _hunt(study, log)
    after = run(study, _plan(study), study.folder / "c", progress=Silence(), flyer=log)
    fresh = run(study, _plan(study), study.folder / "fresh", progress=Silence(), flyer=log)
    texts = [to_json(export_rows(report.outcomes, study.roster, study.space)) for report in (after, fresh)]
    assert texts[0] == texts[1]


def test_a_placebo_that_differs_fails_the_gate_of_a_hunt_too(study: Any, log: Any) -> None:
    log.change = lambda f, outcome: replace(outcome, digest="other") if f.subject.id == "PLACEBO" else outcome
    with pytest.raises(GateError, match="PLACEBO differs"):
        _hunt(study, log)


def test_a_flight_that_the_harness_fails_at_leaves_the_question_open(study: Any, log: Any) -> None:
    def broken(flight: Flight, outcome: Outcome) -> Outcome:
        return replace(outcome, invalid="no memory") if flight.name == "MORE-goal@1m/D0H0/0" else outcome

    log.change = broken
    found = {answer.subject.id: answer for answer in _hunt(study, log, max_invalid=1.0).answers}
    assert found["MORE-goal@1m"].killed is None
    assert "not known" in str(_hunt(study, log, max_invalid=1.0).table().rows)


def test_what_the_campaign_knows_of_kills_decides_the_order_else_the_baselines(study: Any, log: Any) -> None:
    planned = _plan(study)
    report = run(study, planned, study.folder / "c", progress=Silence(), flyer=log)
    clean = [outcome for outcome in report.outcomes if outcome.mutant == "baseline"]
    assert kill_rates(clean) == {}
    assert min(promise(clean).values()) == promise(clean)["D0H0", 0]
    assert [f.situation.key for f in ordered(planned.baselines, clean)] == ["D0H0", "D0H1", "D1H0", "D1H1"]
    known = [outcome for outcome in report.outcomes if outcome.mutant != CONTROL]
    assert ordered(planned.baselines, known)[0].situation.key == "D0H1"


def test_what_is_held_then_what_is_tested_then_what_has_least_to_lose_promises_a_kill(study: Any, log: Any) -> None:
    flights = _plan(study).baselines

    def rho(outcome: Outcome, safety: float, triggered: int) -> Outcome:
        readings = [replace(r, rho=safety, triggered=triggered) for r in outcome.readings]
        return replace(outcome, readings=tuple(readings))

    clean = [log(study, flight) for flight in flights]
    clean = [rho(clean[0], 0.5, 1), rho(clean[1], 0.1, 0), rho(clean[2], 0.2, 1), clean[3]]
    assert [f.situation.key for f in ordered(flights, clean)] == ["D1H0", "D0H0", "D0H1", "D1H1"]


def test_the_seeds_are_flown_one_after_the_other(study: Any, log: Any) -> None:
    planned = _plan(study, (0, 1))
    clean = [log(study, flight) for flight in planned.baselines]
    assert [flight.seed for flight in ordered(planned.baselines, clean)] == [0] * 4 + [1] * 4


def test_the_cut_flights_are_in_the_store_under_keys_of_their_own(study: Any, log: Any) -> None:
    _hunt(study, log)
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        found = {outcome.name: outcome.truncated for outcome in store.outcomes()}
    cut = {name for name, why in found.items() if why == FIRST_KILL}
    assert {name.split("/")[0] for name in cut} == {LATE, "MORE-goal@1m"}
