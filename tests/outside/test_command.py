"""A simulator of one's own: its declaration, its command, and relays over the border `lines`."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from options import cases
from processes import alive, soon

from scaloft_fi.errors import InputError
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.mutants.wire import TappedWire, contexts, wire_for
from scaloft_fi.outside import command as commands
from scaloft_fi.outside.border import BorderError, Motion
from scaloft_fi.outside.command import told
from scaloft_fi.stack.declaration import Declaration, PlainWire, Wire
from scaloft_fi.stack.reference.declaration import REFERENCE

GOOD = {"flyer": "command", "run": '[fly, "{situation}", 5]', "record": "flight.csv", "limit_s": "60"}


def _load(tmp_path: Path, **keys: str) -> commands.FlightCommand:
    path = tmp_path / "flyer.yaml"
    path.write_text("".join(f"{key}: {text}\n" for key, text in (GOOD | keys).items() if text))
    return commands.load_command(path)


def test_a_declaration_is_read_and_is_not_deterministic_unless_it_says_so(tmp_path: Path):
    command = _load(tmp_path)
    assert [word.text for word in command.run] == ["fly", "{situation}", "5"]
    assert (command.limit_s, command.mission_s, command.deterministic) == (60.0, None, False)
    assert _load(tmp_path, deterministic="true").deterministic


@cases("keys", "said")
def test_a_wrong_declaration_is_refused_with_its_line(keys: dict[str, str], said: str, tmp_path: Path):
    with pytest.raises(InputError, match=r"flyer\.yaml:\d+: ") as refused:
        _load(tmp_path, **keys)
    assert said in str(refused.value)


def test_the_matrix_may_use_the_declared_seams_only(tmp_path: Path):
    command = _load(tmp_path, seams="{person: {parameter: true}, own: {parameter: true, message: velocity}}")
    narrowed = command.declared(REFERENCE)
    assert set(narrowed.by_name) == {"person", "own"}
    assert narrowed.by_name["own"].message is Motion
    assert not narrowed.deterministic
    every = _load(tmp_path, seams="{every: {parameter: true}}").declared(REFERENCE)
    assert every.by_name == REFERENCE.by_name
    assert every.canaries == REFERENCE.canaries


def test_a_seam_without_a_message_must_be_one_of_the_stack(tmp_path: Path):
    command = _load(tmp_path, seams="{persn: {parameter: true}}")
    with pytest.raises(InputError, match=r"'persn' is no seam of the stack 'reference'.*did you mean 'person'"):
        command.declared(REFERENCE)


def test_places_are_filled_with_values_and_other_braces_stay():
    values = {"seed": 3, "vehicle.mass_kg": 1.5, "dark": True, "situation": "T0"}
    text = commands.Text('{situation}/{seed} {vehicle.mass_kg} {dark} {"a": {}}', "flyer.yaml:3")
    assert text.filled(values) == 'T0/3 1.5 true {"a": {}}'
    with pytest.raises(InputError, match=r"flyer\.yaml:3: there is no value \{sead\}; did you mean 'seed'"):
        commands.Text("{sead}", "flyer.yaml:3").filled(values)


def _run(tmp_path: Path, program: str, limit_s: float = 20.0) -> commands.Told:
    (tmp_path / "beside").mkdir(exist_ok=True)
    return commands.run_command([sys.executable, "-c", program], {"OWN": "1"}, tmp_path, limit_s, tmp_path / "beside")


def test_what_the_last_line_says_is_told(tmp_path: Path):
    program = """
print("warming up")
print('{"altered": 3, "carried": 9, "first_altered_s": 1.5, "stack_error": "died"}')
"""
    assert _run(tmp_path, program) == commands.Told(3, 9, 1.5, "died")
    assert _run(tmp_path, "print('done')") == commands.Told()
    assert _run(tmp_path, "pass") == commands.Told()


def test_it_runs_in_the_folder_with_its_own_environment(tmp_path: Path):
    _run(tmp_path, "import os, pathlib; pathlib.Path('here').write_text(os.environ['OWN'])")
    assert (tmp_path / "here").read_text() == "1"


def test_a_command_that_hangs_is_ended_with_all_that_it_started(tmp_path: Path):
    program = """
import pathlib, subprocess, sys, time
deaf = "import signal, time; signal.signal(15, signal.SIG_IGN); time.sleep(60)"
child = subprocess.Popen([sys.executable, "-c", deaf])
pathlib.Path("child").write_text(str(child.pid))
print("waiting for the simulator", flush=True)
time.sleep(60)
"""
    began = time.monotonic()
    with pytest.raises(commands.CommandError, match=r"ran longer than 1 s; it said last: waiting for the simulator"):
        _run(tmp_path, program, 1.0)
    assert time.monotonic() - began < 15.0
    child = int((tmp_path / "child").read_text())
    assert soon(lambda: not alive(child), within_s=5.0)


@cases("program", "said")
def test_a_command_that_fails_says_its_last_lines(program: str, said: str, tmp_path: Path):
    with pytest.raises(commands.CommandError, match=said):
        _run(tmp_path, program)


@pytest.mark.parametrize(
    "last", ['{"altered": -1}', '{"altered": true}', '{"carried": 1.5}', '{"first_altered_s": "a"}']
)
def test_a_wrong_count_is_refused(last: str):
    with pytest.raises(commands.CommandError, match="the last line says"):
        told(last)


@pytest.mark.parametrize("last", ["", "{", "[1]", "{" * 100_000])
def test_what_is_no_object_says_nothing(last: str):
    assert told(last) == commands.Told()


RELAY = {"drive": commands.Relay("/cmd_raw", "/cmd", "lines")}
PROGRAM = """
import json, sys, time
from scaloft_fi.outside.client import connect
border = connect(publishes=["/cmd_raw"])
came = []
def answer():
    for message in border:
        if message.get("topic") == "/cmd":
            return message["data"]["velocity"][0]
for i in range(1, 21):
    border.send("/cmd_raw", {"velocity": [float(i), 0.0, 0.0], "turn_radps": 0.0})
    came.append(answer())
print("came", came)
print(json.dumps({"altered": int(sum(came))}))
"""


@pytest.fixture
def stack(tmp_path: Path) -> Declaration:
    command = _load(tmp_path, seams="{drive: {relay: {from: /cmd_raw, to: /cmd, border: lines}, message: velocity}}")
    assert command.relays == RELAY
    assert not command.injects("drive")
    return command.declared(REFERENCE)


def _wire(stack: Declaration, operator: str, **arguments: float | str) -> Wire:
    mutant = Mutant(f"X-{operator}", "X", operator, "", 0.0, "drive", operator, arguments)
    return wire_for(mutant, stack, contexts(mutant.id, "T0", 0, OPERATORS["delay"].example.context().facts))


def _relayed(
    tmp_path: Path, stack: Declaration, wire: Wire, program: str = PROGRAM, clock: commands.ClockTopic | None = None
) -> commands.Told:
    folder, beside = tmp_path / "borders", tmp_path / "beside"
    folder.mkdir()
    beside.mkdir()
    relays = commands.Relays(RELAY, stack, wire, folder, clock)
    try:
        env = relays.begin()
        return commands.run_command([sys.executable, "-c", program], env, tmp_path, 20.0, beside, relays.attend)
    finally:
        relays.close()


def test_without_a_fault_every_message_arrives_as_it_was_sent(tmp_path: Path, stack: Declaration):
    assert _relayed(tmp_path, stack, PlainWire()).altered == sum(range(1, 21))


def test_a_tap_alters_what_arrives_and_counts_it(tmp_path: Path, stack: Declaration):
    wire = _wire(stack, "scale", factor=2.0, field="velocity")
    assert isinstance(wire, TappedWire)
    assert _relayed(tmp_path, stack, wire).altered == 2 * sum(range(1, 21))
    assert (wire.counts["drive"].carried, wire.counts["drive"].altered) == (20, 20)


def test_a_late_message_is_delivered_while_none_comes(tmp_path: Path, stack: Declaration):
    program = PROGRAM.replace("range(1, 21)", "range(1, 3)").replace(
        "    came.append(answer())", "    began = time.monotonic(); answer(); came.append(time.monotonic() - began)"
    )
    told = _relayed(tmp_path, stack, _wire(stack, "delay", delay_s=1.5), program)
    assert told.altered in (2, 3, 4)  # two waits of 1.5 s, each until the next poll


def test_a_message_that_does_not_fit_its_seam_is_one_sentence(tmp_path: Path, stack: Declaration):
    program = PROGRAM.replace("[float(i), 0.0, 0.0]", "'fast'")
    with pytest.raises(BorderError, match="the relay of seam 'drive' cannot read /cmd_raw: "):
        _relayed(tmp_path, stack, PlainWire(), program)


def test_messages_that_come_faster_than_they_are_carried_are_not_lost_silently(tmp_path: Path, stack: Declaration):
    program = PROGRAM.replace("    came.append(answer())\n", "").replace("print", "time.sleep(1); print")
    with pytest.raises(BorderError, match="the relay of seam 'drive' lost"):
        _relayed(tmp_path, stack, PlainWire(), program)


def test_two_seams_may_have_relays_of_one_border(tmp_path: Path, stack: Declaration):
    two = replace(stack, seams=(*stack.seams, replace(stack.seams[0], name="second")), canaries=())
    relays = commands.Relays({**RELAY, "second": commands.Relay("/b_raw", "/b", "lines")}, two, PlainWire(), tmp_path)
    assert len(relays.begin()) == 1
    relays.close()


def test_time_is_that_of_the_simulators_clock(tmp_path: Path, stack: Declaration):
    """A delay of 60 s lasts as long as the simulator takes for them, which is no time here."""
    program = """
import json
from scaloft_fi.outside.client import connect
border = connect(publishes=["/cmd_raw", "/time"])
messages = (message for message in border if message.get("topic") == "/cmd")
def tick(t_s):
    border.send("/time", {"stamp_s": t_s})
tick(100.0)
border.send("/cmd_raw", {"velocity": [7.0, 0.0, 0.0], "turn_radps": 0.0})
import time
time.sleep(0.1)
tick(159.0)
time.sleep(0.3)
tick(160.1)
print(json.dumps({"altered": int(next(messages)["data"]["velocity"][0])}))
"""
    clock = commands.ClockTopic("/time", "lines")
    assert _relayed(tmp_path, stack, _wire(stack, "delay", delay_s=60.0), program, clock).altered == 7
