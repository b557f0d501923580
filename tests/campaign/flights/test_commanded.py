"""Studies whose flights a command flies; the command here writes a table at once, and simulates nothing."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from processes import ROOT
from refused import refusal
from studies import copied, edit_in

from scaloft_fi.campaign.flights.fly import Batch, Flight, Worker
from scaloft_fi.campaign.flights.physics import Commanded
from scaloft_fi.campaign.store.held import Keys, flight_named, with_tracks
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.outside.command import CommandError
from scaloft_fi.study import Study

PROGRAM = """
import json, os, sys
situation, seed, fault, record, mass, level = sys.argv[1:]
fault = json.loads(fault)
near = -0.5 if fault and fault["operator"] == "delay" else 0.8
with open(record, "w") as file:
    file.write("t,x,near,person\\n")
    for i in range(60):
        file.write(f"{i / 20},{i / 100},{near if i == 40 else 1},{100 if level == '0' else 2}\\n")
print("mass", mass, os.environ["SEED"])
if fault:
    print(json.dumps({"altered": 4, "carried": 8, "first_altered_s": 0.5}))
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    copied(tmp_path)
    (tmp_path / "fly.py").write_text(PROGRAM)
    shutil.copytree(Path(__file__).parent / "commanded", tmp_path / "sim", dirs_exist_ok=True)
    return tmp_path


def _fly(study: Study, *names: str, shared: bool = False) -> list[Outcome]:
    flyer = Commanded()
    flyer.prepare(study, lambda _: None)
    flights = []
    for name in names:
        mutant, situation, seed = name.split("/")
        flights.append(flight_named(study, mutant, situation, int(seed)))
    outcomes: list[Outcome] = []
    Worker(study, flyer)(Batch(tuple(flights), shared=shared), outcomes.append)
    return outcomes


def test_a_flight_is_judged_from_what_the_command_recorded(folder: Path):
    clean, late = _fly(Study.open(folder), "baseline/T0O0W0D0H1/0", "LATE-human@3s/T0O0W0D0H1/0")
    assert (clean.invalid, clean.ending, clean.duration_s) == ("", "timed_out", 2.95)
    assert not clean.violations
    assert (late.ending, late.first_violation and late.first_violation.t_s) == ("struck", 2.0)
    assert (late.altered, late.carried, late.infected_at_s) == (4, 8, 0.5)
    assert clean.digest != late.digest


def test_the_situation_reaches_the_command_and_comes_true_in_its_record(folder: Path):
    near, far = _fly(Study.open(folder), "baseline/T0O0W0D0H1/0", "baseline/T0O0W0D0H0/0")
    assert (dict(near.realised)["H"], dict(far.realised)["H"]) == (True, True)
    assert near.digest != far.digest


def test_a_shared_batch_flies_each_flight_alone_and_one_failure_is_one_invalid_flight(folder: Path):
    edit_in(folder / "fly.py", "fault = json.loads(fault)", "fault = json.loads(fault)\nif fault: sys.exit('no fault')")
    clean, late = _fly(Study.open(folder), "baseline/T0O0W0D0H1/0", "LATE-human@3s/T0O0W0D0H1/0", shared=True)
    assert not clean.invalid
    assert "the command ended with code 1; it said last: no fault" in late.invalid


def test_a_flight_ends_at_its_time_limit_though_its_record_goes_on(folder: Path):
    with (folder / "sim" / "flyer.yaml").open("a") as file:
        file.write("mission_s: 1.5\n")
    (late,) = _fly(Study.open(folder), "LATE-human@3s/T0O0W0D0H1/0")
    assert (late.invalid, late.ending, late.duration_s) == ("", "timed_out", 1.5)


def test_a_track_may_be_as_long_as_the_time_limit_of_the_command(folder: Path, tmp_path: Path):
    with (folder / "sim" / "flyer.yaml").open("a") as file:
        file.write("mission_s: 1000\n")
    edit_in(folder / "fly.py", "range(60)", "range(19000)")
    study = Study.open(folder)
    (clean,) = _fly(study, "baseline/T0O0W0D0H1/0")
    assert clean.duration_s > study.limit_s(study.grid.situation("T0O0W0D0H1"))
    with Store(tmp_path / "outcomes.sqlite") as store:
        store.put(Keys(study).key(flight_named(study, "baseline", "T0O0W0D0H1", 0)), clean)
        assert with_tracks(study, store, [replace(clean, track=b"")]) == (clean,)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("with open(record", "with open(record + '.part'", "0 files 'flight.csv' must be 1"),
        ("near if i == 40 else 1", "'nan' if i == 40 else 1", "line 42: signal 'clearance_m' must be a finite number"),
        ("t,x,near,person", "t,x,nea,person", "did you mean 'nea'"),
        ("for i in range(60)", "for i in range(0)", "'x_m' has no message"),
        ("import json", "raise SystemExit(7)\nimport json", "ended with code 7"),
    ],
)
def test_a_command_that_records_nothing_usable_makes_an_invalid_flight(old: str, new: str, said: str, folder: Path):
    edit_in(folder / "fly.py", old, new)
    (outcome,) = _fly(Study.open(folder), "baseline/T0O0W0D0H1/0")
    assert said in outcome.invalid


def test_a_fault_whose_altered_samples_nobody_counts_is_invalid(folder: Path):
    edit_in(folder / "fly.py", 'print(json.dumps({"altered": 4,', 'print(json.dumps({"altred": 4,')
    clean, late = _fly(Study.open(folder), "PLACEBO/T0O0W0D0H1/0", "LATE-human@3s/T0O0W0D0H1/0")
    assert not clean.invalid
    assert "says how many samples the fault altered" in late.invalid


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("flyer.yaml", '"{python}"', "no-such-program", "flyer.yaml:2: there is no program 'no-such-program' here"),
        ("flyer.yaml", "{H}", "{Q}", "flyer.yaml:2: there is no value {Q}"),
        ("flyer.yaml", "flight.csv", "flight.cvs", "did you mean '.csv'"),
        ("record.yaml", "  speed_mps: {constant: 0.2}\n", "", "needs the signal 'speed_mps'"),
        ("record.yaml", "told_range_m", "told_rnge_m", "needs the signal 'told_range_m'"),
    ],
)
def test_what_would_fail_in_every_flight_is_refused_before_the_first(
    file: str, old: str, new: str, said: str, folder: Path
):
    edit_in(folder / "sim" / file, old, new)
    study = Study.open(folder)
    assert said in refusal(Commanded().prepare, study, print)


def test_the_matrix_may_use_only_the_seams_that_the_command_offers(folder: Path):
    edit_in(folder / "sim" / "flyer.yaml", "every:", "person:")
    with pytest.raises(InputError, match="seam"):
        _ = Study.open(folder).matrix


def test_program_mapping_and_declaration_are_part_of_the_key_of_a_flight(folder: Path):
    def key() -> str:
        study = Study.open(folder)
        return Keys(study).key(Flight(None, study.grid.situations[0], 0))

    keys = {key()}
    edit_in(folder / "fly.py", "0.8", "0.7")
    keys.add(key())
    edit_in(folder / "sim" / "record.yaml", "constant: 0.2", "constant: 0.3")
    keys.add(key())
    edit_in(folder / "sim" / "flyer.yaml", "limit_s: 20", "limit_s: 30")
    keys.add(key())
    assert len(keys) == 4


def test_a_command_is_not_deterministic_unless_it_says_so(folder: Path):
    assert not Study.open(folder).stack.deterministic
    with (folder / "sim" / "flyer.yaml").open("a") as file:
        file.write("deterministic: true\n")
    assert Study.open(folder).stack.deterministic


def test_a_requirement_may_use_a_signal_that_only_the_record_has(folder: Path):
    with (folder / "sim" / "record.yaml").open("a") as file:
        file.write("  dust: {column: x}\n")
    edit_in(folder / "sim" / "requirements.yaml", "always(clearance_m > 0)", "always(clearance_m > 0 and dust < 0.5)")
    (outcome,) = _fly(Study.open(folder), "baseline/T0O0W0D0H1/0")
    assert outcome.first_violation.t_s == 2.55  # at 0.5 exactly its robustness is 0, which is no violation


def test_without_a_command_nothing_changes():
    study = Study.open(ROOT)
    assert study.command is None
    assert study.stack.deterministic


RELAYED = """
import json, sys
from scaloft_fi.outside.client import connect
situation, seed, fault, record, mass, level = sys.argv[1:]
assert json.loads(fault) is None, "the relay injects it"
border = connect(publishes=["/cmd_raw"])
with open(record, "w") as file:
    file.write("t,x,near,person\\n")
    for i in range(60):
        border.send("/cmd_raw", {"velocity": [0.01, 0.0, 0.0], "turn_radps": 0.0})
        message = next(message for message in border if message.get("topic") == "/cmd")
        file.write(f"{i / 20},{i * message['data']['velocity'][0]},1,100\\n")
"""


def test_a_relay_carries_the_topic_of_a_seam_through_the_tap_of_the_mutant(folder: Path):
    (folder / "fly.py").write_text(RELAYED)
    relay = "{drive: {relay: {from: /cmd_raw, to: /cmd, border: lines}, message: velocity}}"
    edit_in(folder / "sim" / "flyer.yaml", "{every: {parameter: true}}", relay)
    study = Study.open(folder)
    Commanded().prepare(study, lambda _: None)
    fast = Mutant("X", "X", "drive", "", 0.0, "drive", "scale", {"factor": 2.0, "field": "velocity"})
    situation = study.grid.situations[0]
    clean, faulty, placebo = (Commanded()(study, Flight(one, situation, 0)) for one in (None, fast, PLACEBO))
    assert (clean.carried, clean.altered) == (0, 0)
    assert (faulty.carried, faulty.altered) == (60, 60)
    assert (placebo.carried, placebo.altered) == (60, 0)
    assert clean.digest == placebo.digest != faulty.digest
    with pytest.raises(CommandError, match="strikes at an event"):
        Commanded()(study, Flight(replace(fast, event="contact"), situation, 0))
