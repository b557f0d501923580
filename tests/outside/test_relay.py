"""Relays over the border `lines`: a program writes `/x_raw` and reads `/x`, and a tap stands between them."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operator import Facts
from scaloft_fi.mutants.wire import TappedWire, contexts, wire_for
from scaloft_fi.outside.border import BorderError
from scaloft_fi.outside.command import ClockTopic, Relay, Relays, Told, load_command, run_command
from scaloft_fi.stack.declaration import Declaration, PlainWire, Wire
from scaloft_fi.stack.reference.declaration import REFERENCE

RELAY = {"drive": Relay("/cmd_raw", "/cmd", "lines")}
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
    path = tmp_path / "flyer.yaml"
    seams = "{drive: {relay: {from: /cmd_raw, to: /cmd, border: lines}, message: velocity}}"
    path.write_text(f"flyer: command\nrun: [x]\nrecord: x.csv\nlimit_s: 9\nseams: {seams}\n")
    command = load_command(path)
    assert command.relays == RELAY
    assert not command.injects("drive")
    return command.declared(REFERENCE)


def _facts() -> Facts:
    from scaloft_fi.mutants.operators import OPERATORS

    return OPERATORS["delay"].example.context().facts


def _wire(stack: Declaration, operator: str, **arguments: float | str) -> Wire:
    mutant = Mutant(f"X-{operator}", "X", operator, "", 0.0, "drive", operator, arguments)
    return wire_for(mutant, stack, contexts(mutant.id, "T0", 0, _facts()))


def _run(
    tmp_path: Path, stack: Declaration, wire: Wire, program: str = PROGRAM, clock: ClockTopic | None = None
) -> Told:
    folder, beside = tmp_path / "borders", tmp_path / "beside"
    folder.mkdir()
    beside.mkdir()
    relays = Relays(RELAY, stack, wire, folder, clock)
    try:
        env = relays.begin()
        return run_command([sys.executable, "-c", program], env, tmp_path, 20.0, beside, relays.attend)
    finally:
        relays.close()


def test_without_a_fault_every_message_arrives_as_it_was_sent(tmp_path: Path, stack: Declaration) -> None:
    assert _run(tmp_path, stack, PlainWire()).altered == sum(range(1, 21))


def test_a_tap_alters_what_arrives_and_counts_it(tmp_path: Path, stack: Declaration) -> None:
    wire = _wire(stack, "scale", factor=2.0, field="velocity")
    assert isinstance(wire, TappedWire)
    assert _run(tmp_path, stack, wire).altered == 2 * sum(range(1, 21))
    assert (wire.counts["drive"].carried, wire.counts["drive"].altered) == (20, 20)


def test_a_late_message_is_delivered_while_none_comes(tmp_path: Path, stack: Declaration) -> None:
    program = PROGRAM.replace("range(1, 21)", "range(1, 3)").replace(
        "    came.append(answer())", "    began = time.monotonic(); answer(); came.append(time.monotonic() - began)"
    )
    told = _run(tmp_path, stack, _wire(stack, "delay", delay_s=1.5), program)
    assert told.altered in (2, 3, 4)  # two waits of 1.5 s, each until the next poll


def test_a_message_that_does_not_fit_its_seam_is_one_sentence(tmp_path: Path, stack: Declaration) -> None:
    program = PROGRAM.replace("[float(i), 0.0, 0.0]", "'fast'")
    with pytest.raises(BorderError, match="the relay of seam 'drive' cannot read /cmd_raw: "):
        _run(tmp_path, stack, PlainWire(), program)


def test_messages_that_come_faster_than_they_are_carried_are_not_lost_silently(
    tmp_path: Path, stack: Declaration
) -> None:
    program = PROGRAM.replace("    came.append(answer())\n", "").replace("print", "time.sleep(1); print")
    with pytest.raises(BorderError, match="the relay of seam 'drive' lost"):
        _run(tmp_path, stack, PlainWire(), program)


def test_two_seams_may_have_relays_of_one_border(tmp_path: Path, stack: Declaration) -> None:
    two = replace(stack, seams=(*stack.seams, replace(stack.seams[0], name="second")), canaries=())
    relays = Relays({**RELAY, "second": Relay("/b_raw", "/b", "lines")}, two, PlainWire(), tmp_path)
    assert len(relays.begin()) == 1
    relays.close()


def test_time_is_that_of_the_simulators_clock(tmp_path: Path, stack: Declaration) -> None:
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
    clock = ClockTopic("/time", "lines")
    assert _run(tmp_path, stack, _wire(stack, "delay", delay_s=60.0), program, clock).altered == 7
