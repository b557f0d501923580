"""Runs without physics: what is flown, what is saved, what stops them; the gates that a score must pass."""

from __future__ import annotations

import io
import json
import multiprocessing
import os
import shutil
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given
from running import CONTROL, LATE, MORE, Change, Runs, asked, changed, interrupting, red, same
from studies import example

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.plan import plan
from scaloft_fi.campaign.progress import FLIGHT_S, Progress, Reporter, violation_line
from scaloft_fi.campaign.runs.gates import RISE_M, failed_gates, failed_in
from scaloft_fi.campaign.runs.merge import merge
from scaloft_fi.campaign.runs.run import Report, changed_since, mission_log, run
from scaloft_fi.campaign.store.archive import LOG_NAME, STORE_NAME
from scaloft_fi.campaign.store.held import Now, differed_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.workers import Interrupted
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, pack_track
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.output import json_text
from scaloft_fi.sim import observer
from scaloft_fi.study import Study


def test_everything_flies_everywhere_one_control_somewhere_one_flight_again_and_nothing_the_next_time(
    study: Any, log: Any, fly: Runs
):
    report = fly()
    flown = len(log.flown)
    assert report.flown == len(report.outcomes) == 3 * len(study.grid) + 1 == flown - 1
    assert sum(name.startswith(CONTROL) for name in log.flown) == 1
    assert log.flown[-1] == "baseline/D0H0/0"
    second = fly()
    assert (second.flown, len(log.flown)) == (0, flown)
    assert fly.export(report.outcomes) == fly.export(second.outcomes)


def test_the_control_flies_where_its_baseline_holds(study: Any, fly: Runs):
    report = fly(plan(study.grid[::-1], (0,), [], asked(study).canary))
    (control,) = [o for o in report.outcomes if o.mutant == CONTROL]
    assert control.situation != "D1H1"


def test_a_run_says_which_part_of_its_study_changed_while_it_flew(tmp_path: Path):
    example("outside_planner", tmp_path / "planner")
    study = Study.open(tmp_path / "planner")
    assert study.inputs
    assert changed_since(study) == ""
    (tmp_path / "planner" / "sim" / "notes.txt").write_text("x")
    assert changed_since(study).startswith("the study changed during the run (sim), so")


def test_more_seeds_fly_only_what_is_new(study: Any, log: Any, fly: Runs):
    fly()
    flown = len(log.flown)
    fly(asked(study, (0, 1)))
    assert {name.rsplit("/", 1)[1] for name in log.flown[flown:-1]} == {"1"}


def test_the_mission_log_names_every_safety_violation_and_as_many_are_counted(fly: Runs):
    stream, path = io.StringIO(), fly.folder() / LOG_NAME
    fly(stream=stream)
    written = json.loads(path.read_text())
    assert written["total_test_cases"] == written["generated_test_cases"] == 4
    assert f"SR2:{LATE}/D0H1/0" in written["safety_violation_ids"]
    told = f"violations: {len(written['violations'])} (baseline 1, mutants 3, PLACEBO 1); all of them are in {path}"
    assert stream.getvalue().splitlines()[:-1] == [told]


def test_a_crash_of_the_harness_is_invalid_with_its_reason_and_is_flown_again_next_time(log: Any, fly: Runs):
    def crash(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.name == f"{LATE}/D0H1/0":
            raise RuntimeError("no memory\nleft")
        return outcome

    log.change = crash
    report = fly()
    (invalid,) = [o for o in report.outcomes if o.invalid]
    assert invalid.invalid == "RuntimeError: no memory left"
    log.change = same
    assert not any(o.invalid for o in fly().outcomes)


def test_more_than_a_tenth_of_invalid_flights_or_than_the_declared_share_fails_the_gate(log: Any, fly: Runs):
    log.change = changed(f"{LATE}/D0H1/0", invalid="its worker process died every time it was flown")
    fly()
    with pytest.raises(GateError, match=r"1 of 13 flights are invalid, more than 5%: LATE-human@3s/D0H1/0 \(its"):
        fly(folder="strict", max_invalid=0.05)
    broken = (f"{LATE}/D0H0/0", f"{LATE}/D0H1/0")
    log.change = lambda flight, outcome: replace(outcome, invalid="no memory") if flight.name in broken else outcome
    with pytest.raises(GateError, match=r"2 of 13 flights are invalid, more than 10%: LATE-human@3s/D0H0/0 \(no"):
        fly(folder="other")


def test_an_interrupted_run_saves_all_and_resumes(study: Any, log: Any, fly: Runs):
    log.change = interrupting(lambda _flight: len(log.flown) == 6)
    with pytest.raises(Interrupted, match=r"flights are saved in .*; the same command resumes"):
        fly()
    with fly.store() as store:
        saved = len(list(store.outcomes()))
    assert 5 <= saved < 13
    assert (study.folder / "c" / LOG_NAME).exists()
    log.change = same
    assert fly().flown == 13 - saved


def test_flights_that_share_and_flights_that_do_not_export_the_same_bytes(fly: Runs):
    shared = fly(folder="shared")
    whole = fly(folder="whole", share=False)
    assert fly.export(shared.outcomes) == fly.export(whole.outcomes)


THREE = (LATE, MORE, "LESS-goal@0.05m")


def test_mutants_that_come_later_fly_with_their_baseline_again_and_nothing_else(study: Any, log: Any, fly: Runs):
    fly()
    before = len(log.flown)
    report = fly(asked(study, names=THREE))
    again = log.flown[before:]
    assert report.flown == 2 * len(study.grid)
    assert sorted({name.split("/")[0] for name in again}) == ["LESS-goal@0.05m", "MORE-goal@1m", "baseline"]


def test_a_known_baseline_that_comes_out_otherwise_fails_the_gate(study: Any, log: Any, fly: Runs):
    fly()
    log.change = changed("baseline/D0H1/0", digest="other")
    with pytest.raises(GateError, match="a repeated flight differs from the first: baseline/D0H1/0"):
        fly(asked(study, names=THREE))


def test_a_folder_that_cannot_be_written_is_one_sentence_before_anything_flies(study: Any, log: Any, fly: Runs):
    (study.folder / "c").write_text("a file stands where the folder should be")
    with pytest.raises(InputError, match="the results folder cannot be written"):
        fly()
    assert log.flown == []


def test_a_study_that_cannot_be_flown_stops_the_run_with_its_sentence(log: Any, fly: Runs):
    def refuse(_flight: Flight, _outcome: Outcome) -> Outcome:
        raise InputError("sim/stack.yaml: gain=-1 must be > 0")

    log.change = refuse
    with pytest.raises(InputError, match="gain=-1"):
        fly()


def test_an_interrupted_run_says_the_command_that_resumes_it(log: Any, fly: Runs):
    log.change = interrupting(lambda _flight: True)
    with pytest.raises(Interrupted, match=r"the same command resumes: scaloft-fi run --mutant 'LATE-human\*'$"):
        fly(command="scaloft-fi run --mutant 'LATE-human*'")


def test_a_disk_that_fills_up_is_one_sentence_and_the_same_command_resumes(
    log: Any, fly: Runs, monkeypatch: pytest.MonkeyPatch
):
    whole = fly.export(fly(folder="whole").outcomes)
    flown = len(log.flown)
    log.change = lambda _flight, outcome: replace(outcome, track=os.urandom(30_000))
    with monkeypatch.context() as patched:
        open_store = Store.__init__

        def small(store: Store, *words: Any, **options: Any) -> None:
            open_store(store, *words, **options)
            store._connection.execute("PRAGMA max_page_count = 24")

        patched.setattr(Store, "__init__", small)
        with pytest.raises(InputError, match=r"c/outcomes\.sqlite: .* disk is full"):
            fly()
    with fly.store() as store:
        saved = {outcome.name for outcome in store.outcomes()}
    assert 0 < len(saved) < 13
    tried = len(log.flown)
    assert fly.export(fly().outcomes) == whole
    assert not saved.intersection(name for name in log.flown[tried:] if not name.startswith("baseline"))
    assert tried > flown


def test_a_run_that_was_killed_before_its_store_had_tables_is_resumed(study: Any, fly: Runs):
    whole = fly.export(fly(folder="whole").outcomes)
    (study.folder / "c").mkdir()
    (study.folder / "c" / STORE_NAME).touch()
    assert fly.export(fly().outcomes) == whole


def test_two_runs_of_one_campaign_at_once_lose_and_double_nothing(fly: Runs):
    whole = fly.export(fly(folder="whole").outcomes)
    processes = [multiprocessing.get_context("fork").Process(target=fly) for _ in range(2)]
    for process in processes:
        process.start()
    for process in processes:
        process.join(60)
    assert [process.exitcode for process in processes] == [0, 0]
    again = fly()
    assert again.flown == 0
    assert fly.export(again.outcomes) == whole


def _seeds(report: Report, situation: str) -> set[int]:
    return {o.seed for o in report.outcomes if o.mutant == "baseline" and o.situation == situation}


def test_a_pool_of_ten_is_flown_in_each_situation_where_a_mutant_infects(study: Any, fly: Runs):
    report = fly(asked(study, canary="").with_pool())
    assert {key: _seeds(report, key) for key in ("D0H0", "D0H1", "D1H0", "D1H1")} == {
        "D0H0": {0},
        "D0H1": set(range(10)),
        "D1H0": {0},
        "D1H1": set(range(10)),
    }
    assert {o.seed for o in report.outcomes if o.mutant != "baseline"} == {0}


def test_the_time_left_counts_each_pool_until_it_is_announced_or_nothing_there_can_need_it(
    study: Any, fly: Runs, monkeypatch: pytest.MonkeyPatch
):
    waiting: list[float] = []
    arrived = Reporter.arrived

    def noting(reporter: Reporter, flight: Flight, outcome: Outcome, *, news: bool) -> None:
        waiting.append(reporter.maybe_s)
        arrived(reporter, flight, outcome, news=news)

    monkeypatch.setattr(Reporter, "arrived", noting)
    fly(asked(study, canary="").with_pool())
    whole_s = sum(9 * (study.expected_s(situation) + FLIGHT_S) for situation in study.grid)
    assert waiting[0] == pytest.approx(whole_s)
    # of the last of four situations, beside two or one that needed its pool
    last_s = [9 * (study.expected_s(one) + FLIGHT_S) * share for one in study.grid for share in (3 / 4, 2 / 4)]
    assert any(min(filter(None, waiting)) == pytest.approx(one) for one in last_s)
    assert waiting[-1] == 0.0


def test_a_resumed_run_completes_the_pool_and_flies_nothing_twice(study: Any, log: Any, fly: Runs):
    planned = asked(study)
    fly(planned)
    before = len(log.flown)
    report = fly(planned.with_pool())
    assert [len(_seeds(report, key)) for key in ("D0H0", "D0H1", "D1H0", "D1H1")] == [1, 10, 1, 10]
    # the last one is the flight that each run repeats
    assert len(log.flown) - before == 2 * 9 + 1


def test_a_pool_in_which_no_pair_is_steady_fails_the_gate(study: Any, log: Any, fly: Runs):
    log.change = lambda flight, outcome: outcome if flight.mutant or flight.seed % 2 else red(outcome)
    with pytest.raises(GateError, match="no situation flown has a steady pair"):
        fly(asked(study).with_pool())


def test_a_campaign_remembers_with_which_seeds_its_mutants_were_asked_for(study: Any, fly: Runs):
    once = fly(asked(study, names=(LATE, MORE), canary=""))
    assert once.spending == Spending(0.01, frozenset())
    again = fly(asked(study, canary=""))
    assert again.spending.grown == frozenset()
    grown = fly(asked(study, range(3), canary=""))
    assert grown.spending.grown == {LATE, "PLACEBO"}


def test_to_ask_for_fewer_seeds_than_before_is_no_growth(study: Any, fly: Runs):
    fly(asked(study, range(3), canary=""))
    again = fly(asked(study, (1,), canary=""))
    assert again.spending.grown == frozenset()


ERROR = "autopilot at 0.000 s: RuntimeError: no bus"


def _track(*heights: float) -> bytes:
    signals = {name: [0.0] * 5 * len(heights) for name in TRACK_COLUMNS}
    return pack_track(signals | {"z_m": [z for z in heights for _ in range(5)]})


GROUNDED = {"ending": "timed_out", "track": _track(0.06, 0.06, 0.2, 0.06)}
FLOWN = {"ending": "timed_out", "track": _track(0.06, 1.6, 1.6)}
SENTENCE = "the drone never leaves the ground without any fault: baseline/D0H1/0"


SILENT = "a control shows nothing, so faults may not reach the drone: REVERSE-velcmd"


def _tame(flight: Flight, outcome: Outcome) -> Outcome:
    """The control violates nothing."""
    if flight.subject.id != CONTROL:
        return outcome
    calm = tuple(replace(reading, violated_at_s=None) for reading in outcome.readings)
    return replace(outcome, readings=calm, violations=())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (changed("PLACEBO/D0H1/0", digest="other"), "PLACEBO differs from the baseline: PLACEBO/D0H1/0"),
        (changed("PLACEBO/D0H1/0", perceived_digest="other"), "PLACEBO differs from the baseline: PLACEBO/D0H1/0"),
        (_tame, SILENT),
        (
            lambda flight, outcome: outcome if flight.mutant else red(outcome),
            "no situation flown has a baseline that holds a safety requirement: D0H0, D0H1, D1H0 and 1 more; " + SILENT,
        ),
        (changed("baseline/D0H1", stack_error=ERROR), f"the stack raises without any fault: baseline/D0H1/0 ({ERROR})"),
        (changed("baseline/D0H1", **GROUNDED), SENTENCE),
    ],
)
def test_a_gate_that_fails_names_the_flights(log: Any, fly: Runs, change: Change, said: str):
    log.change = change
    with pytest.raises(GateError) as caught:
        fly()
    assert str(caught.value) == f"gate failed: {said}"


def test_a_repeat_that_differs_fails_the_gate(log: Any, fly: Runs):
    log.change = lambda _flight, outcome: replace(outcome, digest=f"{outcome.digest}-{len(log.flown) > 13}")
    with pytest.raises(GateError, match="a repeated flight differs from the first: baseline/D0H0/0"):
        fly()


def test_a_repeat_that_differed_fails_the_gate_of_each_later_run_that_the_flight_counts_for(
    study: Any, log: Any, fly: Runs
):
    fly()
    log.change = changed("baseline/D0H1/0", digest="other")
    said = "a repeated flight differs from the first: baseline/D0H1/0"
    with pytest.raises(GateError, match=said):
        fly(asked(study, names=THREE))
    log.change = same
    for names in (THREE, (LATE,)):
        with pytest.raises(GateError, match=said):
            fly(asked(study, names=names))
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        differed = differed_in(Now(study, store))
    assert differed == ("baseline/D0H1/0",)
    assert failed(study) == ["a repeated flight differs from the first"]


def failed(study: Any) -> list[str]:
    """What fails of the gates on the flights of the campaign that count."""
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        told = failed_in(Now(study, store), study.folder / "c")
    return [one.partition(":")[0] for one in told.removeprefix("gate failed: ").split("; ") if one]


def test_too_many_invalid_flights_fail_the_gate_of_a_campaign_until_they_are_flown_again(
    study: Any, log: Any, fly: Runs
):
    log.change = lambda flight, outcome: replace(outcome, invalid="no memory") if flight.seed == 1 else outcome
    with pytest.raises(GateError, match="more than 10%"):
        fly(asked(study, (0, 1), names=THREE))
    assert failed(study) == ["20 of 41 flights are invalid, more than 10%"]
    log.change = same
    with pytest.raises(GateError, match="8 of 41"):
        fly(asked(study, (0, 1), names=(LATE,)))
    fly(asked(study, (0, 1), names=THREE), max_invalid=0.5)
    assert failed(study) == []


def test_a_gate_that_held_once_takes_back_none_that_fails_later_over_the_same_flights(study: Any, log: Any, fly: Runs):
    def of_control(number: int) -> Any:
        """The study after an edit of the control's operator."""
        operator = f"operator {realise(study.matrix, CONTROL).operator}"
        return replace(study, inputs={**study.inputs, operator: str(number)})

    for number, change, fails in ((0, _tame, True), (1, same, False), (2, _tame, True)):
        log.change = change
        with pytest.raises(GateError, match="a control shows nothing") if fails else nullcontext():
            fly(of=of_control(number))
        assert bool(failed(of_control(number))) == fails


def test_no_later_run_takes_back_a_gate_that_fails_on_flights_that_it_leaves_out(study: Any, log: Any, fly: Runs):
    log.change = _tame
    with pytest.raises(GateError, match="a control shows nothing"):
        fly()
    fly(asked(study, names=THREE), part=True)
    assert failed(study) == ["a control shows nothing, so faults may not reach the drone"]
    with pytest.raises(GateError, match="a control shows nothing"):
        fly(asked(study, names=(MORE,), canary=""))


PLACEBO_DIFFERS = "PLACEBO differs from the baseline"


def test_a_failed_gate_stands_as_long_as_its_flights_count_whatever_else_flies_or_changes(
    study: Any, log: Any, fly: Runs
):
    log.change = changed("PLACEBO/D0H1/0", digest="other")
    with pytest.raises(GateError, match=PLACEBO_DIFFERS):
        fly(asked(study, names=THREE))
    log.change = same
    other = replace(
        study, inputs={**study.inputs, f"operator {study.matrix.cell('LATE-human').faults[0].operator}": "x"}
    )
    assert failed(other) == [PLACEBO_DIFFERS]
    with pytest.raises(GateError, match=PLACEBO_DIFFERS):
        fly(asked(study, (0, 1), names=(LATE,)))
    assert PLACEBO_DIFFERS in failed(study)
    mended = replace(study, inputs={**study.inputs, "code": "mended"})
    for names in (THREE, (LATE,)):
        Runs(mended, log)(asked(mended, (0, 1), names=names))
    assert failed(mended) == []


def test_a_gate_that_holds_over_more_flights_takes_back_one_that_failed_over_some(study: Any, log: Any, fly: Runs):
    def shy(flight: Flight, outcome: Outcome) -> Outcome:
        return outcome if flight.mutant or flight.situation.key != "D0H0" else red(outcome)

    log.change = shy
    mutants = realise(study.matrix, LATE), realise(study.matrix, CONTROL)
    with pytest.raises(GateError, match="no situation flown"):
        fly(plan([study.grid.situation("D0H0")], (0,), mutants[:1], mutants[1]))
    assert failed(study)
    fly()
    assert failed(study) == []


@pytest.fixture
def theirs(monkeypatch: pytest.MonkeyPatch) -> None:
    """The operator of LATE is that of a plugin."""

    def make(context: Any, **arguments: Any) -> Any:
        raise AssertionError

    make.__module__ = "their_faults"
    monkeypatch.setitem(OPERATORS._entries, "delay", replace(OPERATORS["delay"], make=make))


@pytest.mark.usefixtures("theirs")
def test_the_short_flight_that_an_operator_of_a_plugin_altered_most_is_repeated(study: Any, log: Any, fly: Runs):
    log.change = changed(f"{LATE}/D0H1/1", altered=4)
    fly(asked(study, (0, 1), (LATE, MORE)))
    assert log.flown[-2:] == ["baseline/D0H0/0", f"{LATE}/D0H1/1"]


@pytest.mark.usefixtures("theirs")
def test_an_operator_of_a_plugin_that_draws_numbers_of_its_own_fails_the_gate(log: Any, fly: Runs):
    log.change = lambda flight, outcome: (
        replace(outcome, digest=str(len(log.flown))) if flight.name.startswith(LATE) else outcome
    )
    with pytest.raises(GateError, match=f"a repeated flight differs from the first: {LATE}/D0H1/0"):
        fly()


@pytest.mark.parametrize(
    "change",
    [changed("LATE-human", stack_error=ERROR), changed("baseline", ending="timed_out", track=b"")],
    ids=["a stack raises under a fault", "a baseline has no track"],
)
def test_what_no_gate_asks_for_fails_none(log: Any, fly: Runs, change: Change):
    log.change = change
    fly()


def test_the_gate_holds_when_nothing_is_left_to_fly_and_in_a_part_of_a_run(log: Any, fly: Runs):
    log.change = changed("baseline/D0H1", **GROUNDED)
    for part in (False, True):
        with pytest.raises(GateError, match=SENTENCE):
            fly(part=part)
    assert len(log.flown) == 14  # each once, and one again


def test_a_mutant_may_stay_on_the_ground_and_a_baseline_may_fly_to_its_time_limit(log: Any, fly: Runs):
    def change(flight: Flight, outcome: Outcome) -> Outcome:
        how = GROUNDED if flight.name.startswith("LATE-human") else FLOWN if flight.mutant is None else {}
        return replace(outcome, **how)

    log.change = change
    fly()


def test_outcomes_that_come_with_their_tracks_are_judged_without_a_store(study: Any, log: Any):
    clean = [replace(log(study, flight), **GROUNDED) for flight in asked(study).baselines[:1]]
    assert failed_gates(clean, study.roster) == ["the drone never leaves the ground without any fault: baseline/D0H0/0"]


def test_the_ground_is_left_at_the_height_from_which_a_touch_down_counts():
    assert RISE_M == observer.AIRBORNE_M


@pytest.mark.parametrize(
    "lose",
    [lambda folder: (folder / STORE_NAME).unlink(), shutil.rmtree, lambda folder: folder.rename(f"{folder}-moved")],
    ids=["the file is removed", "the folder is removed", "the folder is renamed"],
)
def test_a_run_stops_at_the_next_save_and_its_copy_is_a_campaign_that_goes_on(
    study: Any, log: Any, fly: Runs, lose: Callable[[Path], object]
):
    folder, rescued = study.folder / "c", study.folder / "c-rescued"

    def losing(flight: Flight, outcome: Outcome) -> Outcome:
        if len(log.flown) >= 5 and (folder / STORE_NAME).exists():
            with suppress(OSError):  # the other process was faster
                lose(folder)
        return outcome

    with pytest.raises(
        InputError, match=rf"the campaign's store is lost: .* flights is in {rescued}, which --campaign"
    ):
        Runs(study, replace(log, change=losing))(asked(study, (0, 1)), jobs=2)
    assert multiprocessing.active_children() == []
    flown = len(log.flown)
    assert 5 <= flown < 26
    if folder.exists():
        shutil.rmtree(folder)
    with Store(rescued / STORE_NAME, create=False) as store:
        saved = len(store.flights())
    rescued.rename(folder)
    assert fly(asked(study, (0, 1))).flown + saved == 25
    assert (folder / LOG_NAME).exists()


def test_a_store_that_is_lost_after_its_last_save_is_noticed_before_any_table(study: Any, log: Any, fly: Runs):
    fly(asked(study, (0, 1)))
    planned = plan(study.grid, (0, 1), [], None)

    class Losing(Progress):
        def close(self) -> None:
            (study.folder / "c" / STORE_NAME).unlink()

    with pytest.raises(InputError, match=r"store is lost: outcomes.sqlite was removed or renamed; a copy with its 25"):
        run(study, planned, study.folder / "c", progress=Losing(stream=io.StringIO()), flyer=log)


def test_a_merge_into_a_store_that_is_lost_says_where_the_copy_is(
    study: Any, fly: Runs, monkeypatch: pytest.MonkeyPatch
):
    fly(asked(study, (0, 1)))
    put_all = Store.put_all

    def losing(self: Store, rows: Any) -> None:
        self.path.unlink()
        put_all(self, rows)

    monkeypatch.setattr(Store, "put_all", losing)
    with pytest.raises(InputError, match=r"store is lost: .*; a copy with its 25 flights is in .*/all-rescued"):
        merge(study, study.folder / "all", [study.folder / "c"])


def test_the_log_keeps_the_keys_of_the_published_one():
    struck = outcome(LATE, "T1O0W0D1H0", violated={"SR1": 20.0}, struck="bar")
    log = mission_log([outcome(), outcome(seed=1), struck], ROSTER, GRID)
    assert (log["total_test_cases"], log["generated_test_cases"]) == (64, 3)
    assert log["safety_violation_ids"] == ["SR1:LATE-human@3s/T1O0W0D1H0/0"]
    assert log["generated_situations"][2] == {
        "type": "corner+dark",
        "parameters": {"T": "1", "O": "0", "W": "0", "D": "1", "H": "0"},
        "situation": "T1O0W0D1H0",
        "seed": 0,
    }
    assert log["generated_situations"][0]["type"] == "none"
    assert log["coverage"] == {"distinct_situations": {"part": 2, "whole": 32}, "draws": 3}
    assert log["violations"] == [
        {
            "id": "SR1:LATE-human@3s/T1O0W0D1H0/0",
            "requirement": "SR1",
            "t_s": 20.0,
            "position": [1.0, 2.0, 1.65],
            "struck": "bar",
            "mutant": LATE,
            "situation": "T1O0W0D1H0",
            "seed": 0,
        }
    ]


def test_an_operability_violation_is_kept_apart():
    log = mission_log([outcome(violated={"OP1": 60.0, "SR2-literal": 9.0})], ROSTER, GRID)
    assert log["safety_violation_ids"] == log["violations"] == []
    assert [entry["id"] for entry in log["operability_violations"]] == ["OP1:baseline/T0O0W0D0H0/0"]


def test_what_was_planned_is_told_where_it_is_known():
    assert mission_log([outcome()], ROSTER, GRID, planned=7)["total_test_cases"] == 7
    assert mission_log([], ROSTER, GRID)["total_test_cases"] == 32


def test_a_warning_line_names_requirement_time_place_body_and_flight():
    struck = outcome(LATE, violated={"SR1": 20.0}, struck="bar")
    said = "SR1 violated at 20.00 s at (1.00, 2.00, 1.65) m, struck bar: LATE-human@3s/T0O0W0D0H0/0"
    assert violation_line(struck, struck.violations[0]) == said


@given(campaigns())
def test_ids_are_unique_and_each_names_a_violation(outcomes: list[Outcome]):
    log = mission_log(outcomes, ROSTER, GRID)
    assert json.loads(json_text(log)) == log
    ids = [entry["id"] for entry in log["violations"] + log["operability_violations"]]
    assert len(set(ids)) == len(ids)
    assert log["safety_violation_ids"] == [entry["id"] for entry in log["violations"]]
    assert len(log["generated_situations"]) == log["generated_test_cases"] <= log["total_test_cases"]
