"""What code of others prints goes to standard error, and what it raises is told; Ctrl-C stays the user's."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from processes import ROOT

from scaloft_fi import output
from scaloft_fi.aside import foreign
from scaloft_fi.sources import closure

APART = """
import ctypes, os, subprocess, sys
from contextlib import suppress
from scaloft_fi.aside import answers_apart

c = ctypes.CDLL(None)
print("before")
c.puts(b"before in C")
with suppress(KeyError), answers_apart():
    print("printed")
    c.puts(b"printed in C")
    subprocess.run([sys.executable, "-c", "print('printed by a child')"], check=True)
    raise KeyError
print("after")
os.write(1, b"beside Python\\n")
"""


def test_what_is_printed_where_answers_are_apart_goes_to_the_standard_error_from_c_too():
    done = _run(APART)
    assert sorted(done.stdout.splitlines()) == ["after", "before", "before in C", "beside Python"]
    assert sorted(done.stderr.splitlines()) == ["printed", "printed by a child", "printed in C"]


@pytest.mark.parametrize("closed", [1, 2])
def test_answers_stand_apart_where_a_standard_stream_is_closed(closed: int):
    imports, _, _ = APART.partition("c =")
    done = _run(f"{imports}os.close({closed})\nwith answers_apart():\n    os.write({3 - closed}, b'on')")
    assert (done.stdout, done.stderr)[2 - closed] == "on"


def _run(program: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)


@pytest.mark.parametrize(
    ("handler", "users"),
    [(signal.default_int_handler, True), (signal.SIG_IGN, False), (signal.SIG_DFL, False), (output._end, False)],
)
def test_an_interrupt_is_the_users_only_where_a_handler_raises_it(
    monkeypatch: pytest.MonkeyPatch, handler: object, users: bool
):
    monkeypatch.setattr(signal, "getsignal", {signal.SIGINT: handler}.__getitem__)
    assert (KeyboardInterrupt in foreign()) is not users
    assert {Exception, SystemExit} <= set(foreign())


def test_the_key_of_a_flight_covers_no_module_that_prints_answers():
    assert not {"scaloft_fi.output", "scaloft_fi.defaults"} & set(closure(["scaloft_fi.campaign.flights.fly"]))
