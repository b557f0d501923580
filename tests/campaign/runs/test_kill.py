"""A campaign that is killed with SIGKILL at random moments and given again is the undisturbed one, byte for byte."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.flight


@pytest.mark.release
def test_a_campaign_killed_and_resumed_exports_the_bytes_of_an_undisturbed_one() -> None:
    words = ("--kills", "1", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--baseline-seeds", "2")
    call = [sys.executable, "benchmarks/kill.py", *words]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    figures = json.loads(done.stdout)
    assert figures["kills"] == figures["sound"] == 1
    assert figures["campaigns"] == figures["right"] > 0
    assert figures["outlived"] == 0
