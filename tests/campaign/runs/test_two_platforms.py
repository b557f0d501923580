"""Two platforms on one machine: the kernels of OpenBLAS for processors with and without AVX-512."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT

from scaloft_fi.campaign.store.platforms import fingerprint

CPUINFO = Path("/proc/cpuinfo")
pytestmark = [
    pytest.mark.flight,
    pytest.mark.skipif(
        not CPUINFO.is_file() or "avx512vl" not in CPUINFO.read_text(), reason="the processor has no AVX-512"
    ),
    pytest.mark.skipif(fingerprint()["numpy kernels"] == "unknown", reason="numpy has no OpenBLAS that names itself"),
]
WORDS = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--baseline-seeds", "1", "--jobs", "1")
NAME = "LATE-human@3s/T0O0W0D0H1/0"


def _call(kernels: str, *words: str | Path) -> tuple[int, str]:
    """Exit code and all that was printed, with line breaks as spaces."""
    call = [sys.executable, "-m", "scaloft_fi", *map(str, words)]
    environment = {**os.environ, "OPENBLAS_CORETYPE": kernels}
    done = subprocess.run(call, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    return done.returncode, " ".join((done.stderr + done.stdout).split())


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign flown with AVX-512."""
    folder = tmp_path_factory.mktemp("platforms") / "first"
    code, said = _call("SKYLAKEX", "run", *WORDS, "--campaign", folder)
    assert code == 0, said
    return folder


@pytest.mark.release
def test_a_run_on_another_platform_keeps_the_facts_and_flies_a_pair_that_grows_on_one_platform(
    campaign: Path, tmp_path: Path
):
    second = tmp_path / "second"
    shutil.copytree(campaign, second)
    code, said = _call("HASWELL", "run", *WORDS, "--mutant", "MORE-goal", "--campaign", second)
    assert code == 0, said  # the gates hold: PLACEBO equals the baseline of its own platform
    assert "the platform has changed (numpy kernels Haswell here, SkylakeX there" in said
    assert "4 of 4 stored flights have other digests on this platform, and all have the same status, ending" in said
    assert "4 stored flights of another platform are flown again" in said
    merged = tmp_path / "merged"
    assert _call("HASWELL", "merge", campaign, "--campaign", merged)[0] == 0
    code, said = _call("HASWELL", "merge", second, "--campaign", merged)
    assert code == 0, said
    assert "numpy kernels SkylakeX here, Haswell there" in said
    assert "of 4 flights in both 0 have equal digests, and 4 differ in bits only" in said
    assert "1 flights of " in said  # MORE-goal has no baseline of its own platform there
    code, said = _call("HASWELL", "merge", second, "--campaign", merged, "--same-platform")
    assert (code, "--same-platform allows equal digests only" in said) == (4, True)


@pytest.mark.release
def test_a_replay_on_another_platform_names_both_and_compares_the_facts(campaign: Path):
    code, said = _call("HASWELL", "replay", NAME, "--campaign", campaign)
    assert code == 0, said
    assert "another platform (numpy kernels Haswell here, SkylakeX there" in said
    assert "and the same status, ending and violations; the drones are more than 1 mm apart at no time" in said


@pytest.mark.release
def test_doctor_tells_other_bits_from_other_facts():
    code, said = _call("HASWELL", "doctor", "--format", "json")
    assert code == 0, said
    whole = json.loads(said[said.index("{") :])
    kernels = next(row for row in whole["platform"] if row["part"] == "numpy kernels")
    assert (kernels["value"], kernels["decides_bits"]) == ("Haswell", True)
    answer = whole["known_flight"]["told"]
    assert "and the published status, ending and violations (held, landed)" in answer
    assert "numpy kernels Haswell here, SkylakeX there" in answer
