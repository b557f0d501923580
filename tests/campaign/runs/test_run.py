"""Runs without physics: what is flown, what is saved, what stops them."""

from __future__ import annotations

import io
import json
import multiprocessing
import os
import signal
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import Plan, plan
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.run import Report, run
from scaloft_fi.campaign.store.archive import LOG_NAME, STORE_NAME
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.workers.local import Interrupted
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.verbs.export.rows import export_rows, to_json

CONTROL, LATE = "REVERSE-velcmd", "LATE-human@3s"


def _plan(study: Any, seeds: tuple[int, ...] = (0,)) -> Plan:
    return plan(study.grid, seeds, [realise(study.matrix, LATE)], realise(study.matrix, CONTROL))


def _run(study: Any, log: Any, *, jobs: int = 1, planned: Plan | None = None, folder: str = "c") -> Report:
    progress = Progress(stream=io.StringIO())
    return run(study, planned or _plan(study), study.folder / folder, RunOptions(jobs), progress=progress, flyer=log)


def _export(study: Any, report: Report) -> str:
    return to_json(export_rows(report.outcomes, study.roster, study.space))


def test_baseline_placebo_and_mutant_fly_everywhere_and_one_control_somewhere(study: Any, log: Any) -> None:
    report = _run(study, log)
    assert len(report.outcomes) == 3 * len(study.grid) + 1
    assert sum(name.startswith(CONTROL) for name in log.flown) == 1


def test_the_control_flies_where_its_baseline_holds(study: Any, log: Any) -> None:
    only = plan(study.grid[::-1], (0,), [], _plan(study).canary)
    report = _run(study, log, planned=only)
    (control,) = [o for o in report.outcomes if o.mutant == CONTROL]
    assert control.situation != "D1H1"


def test_one_flight_is_repeated_and_not_saved_twice(study: Any, log: Any) -> None:
    report = _run(study, log)
    assert report.flown == len(report.outcomes)
    assert len(log.flown) == len(report.outcomes) + 1
    assert log.flown[-1] == "baseline/D0H0/0"


def test_the_same_command_flies_nothing_again(study: Any, log: Any) -> None:
    first = _run(study, log)
    flown = len(log.flown)
    second = _run(study, log)
    assert (second.flown, len(log.flown)) == (0, flown)
    assert _export(study, first) == _export(study, second)


def test_another_number_of_jobs_exports_the_same_bytes(study: Any, log: Any) -> None:
    one = _run(study, log, jobs=1, folder="one", planned=_plan(study, (0, 1)))
    two = _run(study, log, jobs=2, folder="two", planned=_plan(study, (0, 1)))
    assert _export(study, one) == _export(study, two)


def test_changed_study_data_fly_again_and_changed_comments_do_not(study: Any, log: Any) -> None:
    _run(study, log)
    flown = len(log.flown)
    changed = replace(study, predicate="u")
    _run(changed, log)
    assert set(log.flown[flown:]) == {f"baseline/{s.key}/0" for s in study.grid}


def test_more_seeds_fly_only_what_is_new(study: Any, log: Any) -> None:
    _run(study, log)
    flown = len(log.flown)
    _run(study, log, planned=_plan(study, (0, 1)))
    assert {name.rsplit("/", 1)[1] for name in log.flown[flown:-1]} == {"1"}


def test_as_many_violations_are_counted_as_the_mission_log_has(study: Any, log: Any) -> None:
    stream = io.StringIO()
    run(study, _plan(study), study.folder / "c", progress=Progress(stream=stream), flyer=log)
    path = study.folder / "c" / LOG_NAME
    listed = len(json.loads(path.read_text())["violations"])
    assert stream.getvalue().splitlines()[:-1] == [
        f"violations: {listed} (baseline 1, mutants 3, PLACEBO 1); all of them are in {path}"
    ]


def test_the_mission_log_names_every_safety_violation(study: Any, log: Any) -> None:
    _run(study, log)
    written = json.loads((study.folder / "c" / LOG_NAME).read_text())
    assert written["total_test_cases"] == written["generated_test_cases"] == 4
    assert f"SR2:{LATE}/D0H1/0" in written["safety_violation_ids"]


def _change(name: str, **changes: Any) -> Callable[[Flight, Outcome], Outcome]:
    return lambda flight, outcome: replace(outcome, **changes) if flight.name == name else outcome


def test_a_placebo_that_differs_fails_the_gate_by_name(study: Any, log: Any) -> None:
    log.change = _change("PLACEBO/D0H1/0", digest="other")
    with pytest.raises(GateError, match=r"PLACEBO differs from the baseline: PLACEBO/D0H1/0"):
        _run(study, log)


def test_a_placebo_that_is_only_perceived_otherwise_fails_the_gate(study: Any, log: Any) -> None:
    log.change = _change("PLACEBO/D0H1/0", perceived_digest="other")
    with pytest.raises(GateError, match="PLACEBO differs"):
        _run(study, log)


def test_a_repeat_that_differs_fails_the_gate(study: Any, log: Any) -> None:
    log.change = lambda _flight, outcome: replace(outcome, digest=f"{outcome.digest}-{len(log.flown) > 13}")
    with pytest.raises(GateError, match="a repeated flight differs from the first: baseline/D0H0/0"):
        _run(study, log)


def test_a_control_that_shows_nothing_fails_the_gate(study: Any, log: Any) -> None:
    def tame(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.subject.id != CONTROL:
            return outcome
        calm = tuple(replace(r, violated_at_s=None) for r in outcome.readings)
        return replace(outcome, readings=calm, violations=())

    log.change = tame
    with pytest.raises(GateError, match="a control shows nothing, so faults may not reach the drone: REVERSE-velcmd"):
        _run(study, log)


def test_red_baselines_everywhere_fail_the_gate(study: Any, log: Any) -> None:
    def red(flight: Flight, outcome: Outcome) -> Outcome:
        return replace(outcome, readings=tuple(replace(r, violated_at_s=2.0) for r in outcome.readings))

    log.change = red
    with pytest.raises(GateError, match="no situation flown has a baseline that holds a safety requirement"):
        _run(study, log)


def test_a_crash_of_the_harness_is_invalid_with_its_reason_and_is_flown_again_next_time(study: Any, log: Any) -> None:
    def crash(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.name == f"{LATE}/D0H1/0":
            raise RuntimeError("no memory\nleft")
        return outcome

    log.change = crash
    report = _run(study, log)
    (invalid,) = [o for o in report.outcomes if o.invalid]
    assert invalid.invalid == "RuntimeError: no memory left"
    log.change = lambda _flight, outcome: outcome
    assert not any(o.invalid for o in _run(study, log).outcomes)


def test_more_than_a_tenth_of_invalid_flights_fails_the_gate(study: Any, log: Any) -> None:
    log.change = _change(f"{LATE}/D0H1/0", invalid="its worker process died every time it was flown")
    _run(study, log)
    broken = (f"{LATE}/D0H0/0", f"{LATE}/D0H1/0")
    log.change = lambda flight, outcome: replace(outcome, invalid="no memory") if flight.name in broken else outcome
    with pytest.raises(GateError, match=r"2 of 13 flights are invalid, more than 10%: LATE-human@3s/D0H0/0 \(no"):
        _run(study, log, folder="other")


def test_an_interrupted_run_saves_all_and_resumes(study: Any, log: Any) -> None:
    def interrupt(flight: Flight, outcome: Outcome) -> Outcome:
        if len(log.flown) == 6:
            os.kill(os.getppid(), signal.SIGINT)
        return outcome

    log.change = interrupt
    with pytest.raises(Interrupted, match=r"flights are saved in .*; the same command resumes"):
        _run(study, log)
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        saved = len(list(store.outcomes()))
    assert 5 <= saved < 13
    assert (study.folder / "c" / LOG_NAME).exists()
    log.change = lambda _flight, outcome: outcome
    assert _run(study, log).flown == 13 - saved


def test_flights_that_share_and_flights_that_do_not_export_the_same_bytes(study: Any, log: Any) -> None:
    shared = _run(study, log, folder="shared")
    progress = Progress(stream=io.StringIO())
    whole = run(study, _plan(study), study.folder / "whole", RunOptions(share=False), progress=progress, flyer=log)
    assert _export(study, shared) == _export(study, whole)


def _three_mutants(study: Any) -> Plan:
    mutants = [realise(study.matrix, name) for name in (LATE, "MORE-goal@1m", "LESS-goal@0.05m")]
    return plan(study.grid, (0,), mutants, realise(study.matrix, CONTROL))


def test_mutants_that_come_later_fly_with_their_baseline_again_and_nothing_else(study: Any, log: Any) -> None:
    _run(study, log)
    before = len(log.flown)
    report = _run(study, log, planned=_three_mutants(study))
    again = log.flown[before:]
    assert report.flown == 2 * len(study.grid)
    assert sorted({name.split("/")[0] for name in again}) == ["LESS-goal@0.05m", "MORE-goal@1m", "baseline"]


def test_a_known_baseline_that_comes_out_otherwise_fails_the_gate(study: Any, log: Any) -> None:
    _run(study, log)
    log.change = _change("baseline/D0H1/0", digest="other")
    with pytest.raises(GateError, match="a repeated flight differs from the first: baseline/D0H1/0"):
        _run(study, log, planned=_three_mutants(study))


def test_a_folder_that_cannot_be_written_is_one_sentence_before_anything_flies(study: Any, log: Any) -> None:
    (study.folder / "c").write_text("a file stands where the folder should be")
    with pytest.raises(InputError, match="the results folder cannot be written"):
        _run(study, log)
    assert log.flown == []


def test_a_study_that_cannot_be_flown_stops_the_run_with_its_sentence(study: Any, log: Any) -> None:
    def refuse(_flight: Flight, _outcome: Outcome) -> Outcome:
        raise InputError("sim/stack.yaml: gain=-1 must be > 0")

    log.change = refuse
    with pytest.raises(InputError, match="gain=-1"):
        _run(study, log)


def test_the_declared_share_of_invalid_flights_decides_whether_a_run_is_believed(study: Any, log: Any) -> None:
    log.change = _change(f"{LATE}/D0H1/0", invalid="no memory")
    strict = RunOptions(max_invalid=0.05)
    with pytest.raises(GateError, match=r"1 of 13 flights are invalid, more than 5%: LATE-human@3s/D0H1/0 \(no"):
        run(study, _plan(study), study.folder / "c", strict, progress=Progress(stream=io.StringIO()), flyer=log)


def test_an_interrupted_run_says_the_command_that_resumes_it(study: Any, log: Any) -> None:
    def interrupt(flight: Flight, outcome: Outcome) -> Outcome:
        os.kill(os.getppid(), signal.SIGINT)
        return outcome

    log.change = interrupt
    typed = RunOptions(command="scaloft-fi run --mutant 'LATE-human*'")
    with pytest.raises(Interrupted, match=r"the same command resumes: scaloft-fi run --mutant 'LATE-human\*'$"):
        run(study, _plan(study), study.folder / "c", typed, progress=Progress(stream=io.StringIO()), flyer=log)


def test_a_disk_that_fills_up_is_one_sentence_and_the_same_command_resumes(
    study: Any, log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = _export(study, _run(study, log, folder="whole"))
    flown = len(log.flown)
    log.change = lambda _flight, outcome: replace(outcome, track=os.urandom(30_000))
    with monkeypatch.context() as patched:
        open_store = Store.__init__

        def small(store: Store, *words: Any, **options: Any) -> None:
            open_store(store, *words, **options)
            store._connection.execute("PRAGMA max_page_count = 24")

        patched.setattr(Store, "__init__", small)
        with pytest.raises(InputError, match=r"c/outcomes\.sqlite: .* disk is full"):
            _run(study, log)
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        saved = {outcome.name for outcome in store.outcomes()}
    assert 0 < len(saved) < 13
    tried = len(log.flown)
    assert _export(study, _run(study, log)) == whole
    assert not saved.intersection(name for name in log.flown[tried:] if not name.startswith("baseline"))
    assert tried > flown


def test_a_run_that_was_killed_before_its_store_had_tables_is_resumed(study: Any, log: Any) -> None:
    whole = _export(study, _run(study, log, folder="whole"))
    (study.folder / "c").mkdir()
    (study.folder / "c" / STORE_NAME).touch()
    assert _export(study, _run(study, log)) == whole


def test_two_runs_of_one_campaign_at_once_lose_and_double_nothing(study: Any, log: Any) -> None:
    whole = _export(study, _run(study, log, folder="whole"))
    processes = [multiprocessing.get_context("fork").Process(target=_run, args=(study, log)) for _ in range(2)]
    for process in processes:
        process.start()
    for process in processes:
        process.join(60)
    assert [process.exitcode for process in processes] == [0, 0]
    again = _run(study, log)
    assert again.flown == 0
    assert _export(study, again) == whole
