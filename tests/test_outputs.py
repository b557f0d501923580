"""What every verb prints on two small campaigns, in every format: it stays as it is recorded."""

from __future__ import annotations

import os
import subprocess
import sys

import outputs
import pytest
from options import usually

from scaloft_fi.output import PIPED

EVERY = usually(12, release=1)


def test_each_verb_prints_what_is_recorded_in_every_format():
    # A process of its own: operators that other tests declare would be counted.
    asked = [sys.executable, outputs.__file__, "check", str(EVERY)]
    wide = {**os.environ, "COLUMNS": str(PIPED)}
    done = subprocess.run(asked, capture_output=True, text=True, check=False, env=wide)
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout.split()[0]) >= len(outputs.recorded()) // EVERY


def test_no_table_is_wider_than_a_terminal_of_80_columns(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "80")
    tables = [words for words in outputs.commands() if words[-1] == "table"]
    printed = {words: str(outputs.printed(words)[1]).splitlines() for words in tables[::EVERY]}
    assert sum(map(len, printed.values())) > 10
    # a finding is one line: editors jump to it
    wide = [line for lines in printed.values() for line in lines if len(line) > 80 and ": note: " not in line]
    assert wide == []
