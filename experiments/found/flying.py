"""The flights of the page: the search, and the replication of its finds."""

from __future__ import annotations

import json
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments import ROOT
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.sim.found import Finds, read_finds
from scaloft_fi.study import Study

PARTS = ("hazop", "mutants", "sim")
FILE = "found.yaml"
GRID = "search"
Record = dict[str, Any]


@dataclass(frozen=True)
class Place:
    """Where the flights are.

    Attributes:
        folder: holds a campaign for the search and one for the replication of its finds.
        jobs: number of processes.
    """

    folder: Path
    jobs: int

    @property
    def study(self) -> Path:
        """A copy of the study without finds, made where it is missing."""
        copy = self.folder / "study"
        if not copy.exists():
            for part in PARTS:
                shutil.copytree(ROOT / part, copy / part)
            (copy / "sim" / FILE).unlink(missing_ok=True)
        return copy

    def call(self, study: Path, *words: str) -> str:
        """The output of `scaloft-fi WORDS`."""
        call = [sys.executable, "-m", "scaloft_fi", *words, "--study", str(study), "--jobs", str(self.jobs)]
        return subprocess.run(call, cwd=ROOT, stdout=subprocess.PIPE, check=True).stdout.decode()


def search(place: Place, mutants: Sequence[str], budget: str, seed: int) -> Record:
    """Search for mutants, and take the finds over into the study of the checkout; what the search says of itself."""
    words = ("seek", *mutants, "--grid", GRID, "--into", str(place.folder / "search"), "--seed", str(seed))
    begin_s, before_s = time.monotonic(), _processor_s()
    report = json.loads(place.call(place.study, *words, "--budget", budget, "--format", "json"))
    took = {"wall_s": round(time.monotonic() - begin_s), "processor_s": round(_processor_s() - before_s)}
    shutil.copyfile(place.study / "sim" / FILE, ROOT / "sim" / FILE)
    return {"budget": budget, "seed": seed, "jobs": place.jobs, **took, **report}


def replicate(place: Place) -> Record:
    """Fly the finds of the checkout on fresh seeds, and keep those that hold; what the replication says of itself."""
    where = ("--grid", GRID, "--into", str(place.folder / "replication"))
    record: Record = json.loads(place.call(ROOT, "seek", "--replicate", *where, "--quiet", "--format", "json"))
    return record


def finds_of(folder: Path) -> Finds:
    """The finds of a study; none without the file."""
    return read_finds(folder / "sim") or Finds(GRID, ())


def flights_in(place: Place, name: str) -> dict[str, Outcome]:
    """The flights of a campaign by name; none where it was not flown."""
    path = place.folder / name / STORE_NAME
    if not path.exists():
        return {}
    with Store(path, create=False) as store:
        return {outcome.name: outcome for outcome in current_in(Study.open(ROOT, GRID), store)}


def _processor_s() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime
