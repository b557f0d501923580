from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from scaloft_fi.campaign.store.origin import BRING_OPENBLAS, differences, fingerprint

CPUINFO = Path("/proc/cpuinfo")
PROGRAM = "from scaloft_fi.campaign.store.origin import fingerprint as f; print(f()['{package} kernels'])"


def test_a_fingerprint_differs_by_what_changed() -> None:
    here = fingerprint()
    assert {"system", "machine", "processor", "python", "numpy", "pybullet"} <= here.keys()
    assert differences(here, here) == []
    assert differences({"numpy": "2"}, {"numpy": "1"}) == ["numpy 2 here, 1 there"]


@pytest.mark.skipif(not CPUINFO.exists() or "avx2" not in CPUINFO.read_text(), reason="no kernels to choose between")
@pytest.mark.parametrize("package", BRING_OPENBLAS)
def test_a_fingerprint_names_the_kernels_that_each_package_multiplies_with(package: str) -> None:
    if fingerprint()[f"{package} kernels"] == "unknown":
        pytest.skip(f"{package} is not linked with OpenBLAS")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(package=package)],
        env=os.environ | {"OPENBLAS_CORETYPE": "HASWELL", "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "Haswell"


def test_kernels_of_a_library_that_does_not_tell_are_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scaloft_fi.campaign.store.origin.find_spec", lambda _package: None)
    here = fingerprint()
    assert (here["numpy kernels"], here["scipy kernels"]) == ("unknown", "unknown")
