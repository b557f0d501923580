"""A flyer without physics that the workers of a cluster can import, and the reference study."""

from __future__ import annotations

import gc
import sys
import warnings
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import pytest
from processes import ROOT

from scaloft_fi.study import Study

FLYER = """
import os, signal, time
from dataclasses import dataclass
from scaloft_fi.judge.outcome import Outcome

FLOWN = {"ending": "landed", "digest": "0" * 64, "perceived_digest": "0" * 64}

@dataclass(frozen=True)
class Flyer:
    deadly: str = ""  # over this flight the Dask worker dies
    slow_s: float = 0.0
    after: str = ""  # flies when this file exists
    mark: str = ""  # a file for the number of the process that flies

    def prepare(self, study, say):
        pass

    def __call__(self, study, flight):
        if self.mark:
            with open(self.mark, "w") as file:
                file.write(f"{os.getpid()}\\n")
        time.sleep(self.slow_s)
        while self.after and not os.path.exists(self.after):
            time.sleep(0.02)
        if flight.name == self.deadly:
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(60.0)
        return Outcome(flight.subject, flight.situation.key, flight.seed, **FLOWN, stack_error=str(study.folder))

    def share(self, study, batch, home):
        for flight in batch.flights:
            home(self(study, flight))
"""


@pytest.fixture(scope="module", autouse=True)
def _sockets() -> Iterator[None]:
    """Sockets that Dask leaves to the garbage collector are collected here, not in a test of another file."""
    yield
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        gc.collect()


@pytest.fixture(scope="module")
def flyer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The class of a flyer that workers can import."""
    folder = tmp_path_factory.mktemp("flyer")
    (folder / "cluster_flyer.py").write_text(FLYER)
    sys.path.insert(0, str(folder))
    yield import_module("cluster_flyer").Flyer
    sys.path.remove(str(folder))


@pytest.fixture(scope="module")
def reference() -> Study:
    return Study.open(ROOT)
