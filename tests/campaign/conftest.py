"""A study without physics: four situations, a small matrix, and a flyer whose verdicts are a table."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from paper_flyer import Whole, made
from running import Runs

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.campaign.flights.fly import Batch, Flight, invalid, reason_of
from scaloft_fi.campaign.workers import MAKE, security_of
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.mutants.catalogue import realise, with_events
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.stack.reference.declaration import REFERENCE

KINDS = {"SR1": Kind.SAFETY, "SR2": Kind.SAFETY, "OP1": Kind.OPERABILITY}


@dataclass(frozen=True)
class FakeSituation:
    key: str
    nominal_s: float


class FakeGrid(tuple[FakeSituation, ...]):
    """The situations, found by key."""

    __slots__ = ()

    def situation(self, key: str) -> FakeSituation:
        for situation in self:
            if situation.key == key:
                return situation
        raise InputError(f"no situation {key!r}")


GRID = FakeGrid(FakeSituation(f"D{d}H{h}", 30.0 + 10 * d + 20 * h) for d in (0, 1) for h in (0, 1))
MATRIX = with_events(load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name), {"sight": ""})
LATE, MORE, CONTROL = (realise(MATRIX, name) for name in ("LATE-human@3s", "MORE-goal@1m", "REVERSE-velcmd"))


SPACE = Space(
    axes=("D", "H"),
    values=(("0", "1"), ("0", "1")),
    words=(("light", "dark"), ("nobody", "human")),
    points=tuple((s.key, (s.key[1], s.key[3])) for s in GRID),
)
ROSTER = Roster(
    defaults={"LATE-human": LATE.id, "MORE-goal": MORE.id},
    controls=frozenset({"REVERSE-velcmd"}),
    ids=(LATE.id, MORE.id, CONTROL.id),
)

_SHARED = {"sim": "s", "requirements": "r", "code": "c"}
_OPERATORS = {f"operator {name}": "o" for name in OPERATORS}


@dataclass(frozen=True)
class FakeStudy:
    """What a run asks of a study."""

    folder: Path
    inputs: Mapping[str, str] = field(default_factory=lambda: {**_SHARED, **_OPERATORS})
    grid: FakeGrid = GRID
    matrix: Matrix = MATRIX
    stack: Declaration = REFERENCE
    space: Space = SPACE
    roster: Roster = ROSTER
    predicate: str = "t"
    alpha: float = 0.01
    grid_name: str | None = None
    command: None = None
    tests_of: str = ""
    again: str = "scaloft-fi run"
    most_wall_s: float = 0.0

    @property
    def operator_modules(self) -> dict[str, str]:
        return {name: operator.make.__module__ for name, operator in OPERATORS.items()}

    def runner(self, situation: FakeSituation) -> str:
        return situation.key

    def noted(self) -> dict[str, Any]:
        return {}

    def changes(self, situation: FakeSituation) -> dict[str, Any]:
        return {"key": situation.key}

    def realised(self, situation: FakeSituation) -> dict[str, Any]:
        return {"predicate": self.predicate}

    def expected_s(self, situation: FakeSituation) -> float:
        return situation.nominal_s


def fly(study: FakeStudy, flight: Flight) -> Outcome:
    """The control strikes the wall at 5 s everywhere; LATE kills by SR2 where a person is; a dark person is red."""
    subject, key = flight.subject.id, flight.situation.key
    violated: dict[str, float] = {}
    if key == "D1H1":
        violated["SR2"] = 6.0
    if subject == CONTROL.id:
        violated["SR1"] = 5.0
    if subject == LATE.id and "H1" in key:
        violated.setdefault("SR2", 7.0)
    infected = subject not in (BASELINE, PLACEBO.id) and not (subject == LATE.id and "H0" in key)
    return made(
        *(flight.subject, key, flight.seed, KINDS, violated),
        place=(0.1, 1.0, 1.6),
        carried=10,
        altered=3 if infected else 0,
        infected_at_s=1.0 if infected else None,
        duration_s=flight.situation.nominal_s,
        digest=f"{subject}-{key}-{flight.seed}" if infected else f"{key}-{flight.seed}",
        perceived_digest="p",
        realised=(("D", True), ("H", True)) if flight.mutant is None else (),
    )


@dataclass
class Log(Whole):
    """A flyer that notes on disk what it flew, and lets a test change what comes out."""

    path: Path
    change: Callable[[Flight, Outcome], Outcome] = lambda _flight, outcome: outcome

    def __call__(self, study: Any, flight: Flight) -> Outcome:
        with self.path.open("a") as file:
            file.write(f"{flight.name}\n")
        return self.change(flight, fly(study, flight))

    def share(self, study: Any, batch: Batch, home: Callable[[Outcome], None]) -> None:
        for flight in batch.flights:
            try:
                home(self(study, flight))
            except RuntimeError as error:
                home(invalid(flight, reason_of(error)))

    @property
    def flown(self) -> list[str]:
        return self.path.read_text().splitlines() if self.path.exists() else []


@pytest.fixture
def study(tmp_path: Path) -> FakeStudy:
    return FakeStudy(tmp_path)


@pytest.fixture
def log(tmp_path: Path) -> Log:
    return Log(tmp_path / "flown.txt")


@pytest.fixture(name="fly")
def _fly(study: FakeStudy, log: Log) -> Runs:
    return Runs(study, log)


def _files(folder: Path) -> tuple[str, ...]:
    """The options of a part of the cluster that has the certificate in a folder."""
    certificate, key = folder / "cert.pem", folder / "key.pem"
    return f"--tls-ca-file={certificate}", f"--tls-cert={certificate}", f"--tls-key={key}"


class DaskProcesses:
    """Schedulers and workers of Dask in processes of their own, on the loopback interface."""

    def __init__(self, folder: Path) -> None:
        self.folder = self._folder = folder
        subprocess.run(MAKE, shell=True, check=True, cwd=folder, capture_output=True)
        self.certificates = folder / "cluster"
        self._all: list[subprocess.Popen[bytes]] = []

    def scheduler(self, *more: str, **environment: str) -> str:
        """Start one; returns its HOST:PORT."""
        path = self._folder / f"scheduler-{len(self._all)}.json"
        words = ("--port", "0", "--host", "tls://127.0.0.1", "--no-dashboard", "--scheduler-file", path)
        process = self._start("scheduler", *words, *_files(self.certificates), *more, environment=environment)
        while not (path.exists() and path.read_text().endswith("}")):
            assert process.poll() is None
            time.sleep(0.05)
        return str(json.loads(path.read_text())["address"]).removeprefix("tls://")

    def worker(
        self, address: str, *words: str | Path, certificates: Path | None = None, **environment: str
    ) -> subprocess.Popen[bytes]:
        """Start one with a thread and the certificate of the cluster, or another."""
        files = _files(certificates or self.certificates)
        own = self._folder / f"worker-{len(self._all)}"
        local = ("--host", "tls://127.0.0.1", "--no-dashboard", "--nthreads", "1", "--local-directory", own)
        return self._start("worker", f"tls://{address}", *local, *files, *words, environment=environment)

    def client(self, address: str) -> Any:
        """A client of the scheduler at HOST:PORT, as anybody with the certificate has it."""
        from distributed import Client

        return Client(f"tls://{address}", set_as_default=False, security=security_of(self.certificates))

    def _start(self, *words: str | Path, environment: Mapping[str, str]) -> subprocess.Popen[bytes]:
        log = (self._folder / f"dask-{len(self._all)}.log").open("wb")
        path = os.pathsep.join(filter(None, sys.path))
        with log:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", *map(str, words)],
                env={**os.environ, "PYTHONPATH": path, **environment},
                cwd=self._folder,  # a module that is run has its folder on its path
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        self._all.append(process)
        return process

    @property
    def last(self) -> subprocess.Popen[bytes]:
        """The one that was started last."""
        return self._all[-1]

    def end(self) -> None:
        """End all of them and what they started."""
        for process in reversed(self._all):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DaskProcesses]:
    processes = DaskProcesses(tmp_path_factory.mktemp("dask"))
    yield processes
    processes.end()
