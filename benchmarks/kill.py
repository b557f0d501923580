"""Test that a campaign survives SIGKILL of all or one of its processes at random moments, again and again.

    python benchmarks/kill.py [--kills N] [--seed N] [--mutant ID]... [--situation KEY|GLOB]...
        [--baseline-seeds N] [--jobs N] [--cluster | --seek BUDGET | --outside]

The script flies a small campaign undisturbed and keeps its export.  Then it starts the campaign again and sends SIGKILL
after a random part of that time: in half of the cases to the whole process group, otherwise to one process.  It repeats
command and kill until the campaign is complete; the export must equal the undisturbed one, byte for byte.  New
campaigns follow until the number of kills is reached.

With `--cluster` a Dask cluster on the loopback interface flies: a scheduler and as many workers as `--jobs`.  Then the
victim is, with equal chance, the run as above, the scheduler, a worker, or a process of a worker.  What was killed of
the cluster is started again; a run outlives its workers, and ends when its scheduler does.

With `--seek` a search for the mutants with this budget is killed and resumed, in a copy of the study without finds; its
finds are compared beside the exports.

With `--outside` the planner of `examples/outside_planner` flies, in a process of its own below a guard; both may be the
victim.

kills: number of kills by target.  campaigns: number of completed campaigns.  right: number of campaigns that lost and
doubled no flight and have the undisturbed export.  sound: number of kills after which SQLite
found its file intact.  outlived: number of processes that outlived their run.
"""

from __future__ import annotations

from checkout import ROOT, parser  # first: it sets the path and the threads

# isort: split

import json
import os
import random
import secrets
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.workers import MAKE
from scaloft_fi.hazop.load import FOLDERS
from scaloft_fi.verbs.new import example_files, write_new

MARK = "SCALOFT_BENCHMARK_KILL"
GRACE_S = 5.0
"""Greatest time from the end of a run to the end of its processes [s, wall]."""


class Marked:
    """A program and every process that it starts.

    Args:
        words: the program and its arguments.
        folder: where it runs.
        output: where it writes; None for nowhere.
    """

    def __init__(self, words: Sequence[str], folder: Path, output: IO[bytes] | None = None) -> None:
        self._mark = secrets.token_hex(8)
        environment = {**os.environ, "PYTHONPATH": str(ROOT), MARK: self._mark}
        where = output or subprocess.DEVNULL
        self.process = subprocess.Popen(
            words, cwd=folder, env=environment, stdout=where, stderr=output, start_new_session=True
        )

    def alive(self) -> set[int]:
        """The processes that have not ended (proc(5): the state follows the name in brackets)."""
        found, mark = set(), f"{MARK}={self._mark}".encode()
        for path in Path("/proc").glob("[0-9]*"):
            try:
                if mark in (path / "environ").read_bytes().split(b"\0"):
                    state, *_ = (path / "stat").read_text().rpartition(")")[2].split()
                    found |= {int(path.name)} if state not in "ZX" else set()
            except OSError:  # it has just ended
                continue
        return found

    def kill(self, draw: random.Random) -> str:
        """Kill the session of the program, or one of all processes; returns which."""
        if draw.random() < 0.5:
            os.killpg(self.process.pid, signal.SIGKILL)
            return "all"
        victim = draw.choice(sorted(self.alive()) or [self.process.pid])
        name = self._name(victim)
        try:
            os.kill(victim, signal.SIGKILL)
        except ProcessLookupError:  # it has just ended by itself
            return ""
        return name

    def outlived(self) -> int:
        """End the processes that still run after `GRACE_S`; returns their number."""
        until_s = time.monotonic() + GRACE_S
        while (left := self.alive()) and time.monotonic() < until_s:
            time.sleep(0.05)
        for process in left:
            os.kill(process, signal.SIGKILL)
        return len(left)

    def _name(self, process: int) -> str:
        if process == self.process.pid:
            return "first"
        try:
            words = Path(f"/proc/{process}/cmdline").read_text().split("\0")
        except OSError:
            return "other"
        programs = {"guard.py": "guard", STAGE: Path(STAGE).stem}
        return next((programs[Path(word).name] for word in words if Path(word).name in programs), "other")


STAGE = "over_lines.py"
"""The program of the stage outside, in the study of `--outside`."""


class Cluster:
    """A scheduler and workers.

    Args:
        folder: for certificate, logs and the workers' files.
        workers: how many.
    """

    def __init__(self, folder: Path, workers: int) -> None:
        folder.mkdir(parents=True)
        self._folder, self._workers = folder, workers
        subprocess.run(MAKE, shell=True, check=True, cwd=folder, capture_output=True)
        self.certificates = folder / "cluster"
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = f"127.0.0.1:{probe.getsockname()[1]}"
        self.targets: dict[str, Marked] = {}

    def heal(self) -> None:
        """Start what does not run; workers find a new scheduler at the old address by themselves."""
        _, port = self.address.split(":")
        self._start("scheduler", "scheduler", "--host", "tls://127.0.0.1", "--port", port, "--no-dashboard")
        for number in range(self._workers):
            local = ("--local-directory", str(self._folder / f"worker{number}"), "--no-dashboard", "--nthreads", "1")
            self._start(f"worker {number}", "worker", f"tls://{self.address}", "--host", "tls://127.0.0.1", *local)

    def end(self) -> int:
        """Ask all of it to end; returns the number of processes that do not."""
        for one in reversed(self.targets.values()):
            one.process.send_signal(signal.SIGTERM)
        for one in self.targets.values():
            one.process.wait()
        return sum(one.outlived() for one in self.targets.values())

    def _start(self, name: str, *words: str) -> None:
        running = self.targets.get(name)
        if running is not None and running.process.poll() is None:
            return
        if running is not None:
            running.outlived()
        certificate, key = self.certificates / "cert.pem", self.certificates / "key.pem"
        files = (f"--tls-ca-file={certificate}", f"--tls-cert={certificate}", f"--tls-key={key}")
        with (self._folder / f"{name}.log").open("ab") as log:
            self.targets[name] = Marked([sys.executable, "-m", "dask", *words, *files], self._folder, log)


HEAL_EVERY_S = 0.5


@dataclass
class Campaign:
    """A campaign in its own folder.

    Attributes:
        folder: of the campaign.
        words: mutants, situations and options of the command.
        cluster: what flies; None for processes of this machine.
        study: its folder.
        call: verb, and the option that names the campaign.
    """

    folder: Path
    words: Sequence[str]
    cluster: Cluster | None = None
    study: Path = ROOT
    call: tuple[str, str] = ("run", "--campaign")

    def run(self, kill_after_s: float | None, draw: random.Random) -> tuple[bool, str, int]:
        """Run the command, and kill it if it still runs after `kill_after_s`.

        Returns whether the command ended by itself with success, what was killed, and how many processes outlived it.
        """
        verb, into = self.call
        words = self._call(verb, *self.words, "--quiet", into, str(self.folder))
        if self.cluster:
            self.cluster.heal()
        run = Marked(words, ROOT)
        killed = ""
        try:
            run.process.wait(kill_after_s)
        except subprocess.TimeoutExpired:
            targets = {"run": run, **(self.cluster.targets if self.cluster else {})}
            target = draw.choice(list(targets))
            what = targets[target].kill(draw)
            killed = what if target == "run" or not what else f"{target}: {what}"
        while self.cluster and run.process.poll() is None:
            self.cluster.heal()  # again and again, because a killed process takes a moment to end
            time.sleep(HEAL_EVERY_S)
        code = run.process.wait()
        if not killed and code:
            raise SystemExit(f"{' '.join(words)}: exit code {code}")
        return code == 0, killed, run.outlived()

    def sound(self) -> bool:
        """Whether the store is intact according to SQLite, or does not exist yet."""
        path = self.folder / STORE_NAME
        if not path.exists():
            return True
        with closing(sqlite3.connect(path)) as connection:
            return bool(connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)])

    def export(self) -> bytes:
        """The finds of a search, and the export of the campaign."""
        finds, call = self.study / "sim" / "found.yaml", self._call("export", "--campaign", str(self.folder))
        told = finds.read_bytes() if self.study != ROOT and finds.exists() else b""
        return told + subprocess.run(call, cwd=ROOT, check=True, capture_output=True).stdout

    def _call(self, *words: str) -> list[str]:
        return [sys.executable, "-m", "scaloft_fi", *words, "--study", str(self.study)]


def search(folder: Path, words: Sequence[str], cluster: Cluster | None) -> Campaign:
    """A search in a copy of the study of its own, without finds."""
    study = folder.parent / f"{folder.name}_study"
    for part in FOLDERS:
        shutil.copytree(ROOT / part, study / part, ignore=shutil.ignore_patterns("found.yaml"))
    return Campaign(folder, words, cluster, study, ("seek", "--into"))


def outside(folder: Path, words: Sequence[str], cluster: Cluster | None) -> Campaign:
    """A campaign of the example whose planner runs in a process of its own."""
    study = folder.parent / "study"
    if not study.exists():
        write_new(study, example_files("outside_planner"))
    return Campaign(folder, words, cluster, study)


MUTANTS = ("LATE-human", "MORE-goal", "UNINTENDED-collision@20s")
OUTSIDE = ("LATE-human", "REVERSE-drive")
SITUATIONS = ("T0O0W0D0H[01]",)


def measure(
    words: Sequence[str],
    kills: int,
    seed: int,
    folder: Path,
    cluster: Cluster | None = None,
    kind: Callable[[Path, Sequence[str], Cluster | None], Campaign] = Campaign,
) -> dict[str, Any]:
    """Fly, kill and resume campaigns of a kind until the number of kills is reached."""
    if cluster:
        words = [*words, "--executor", f"dask://{cluster.address}", "--cluster-security", str(cluster.certificates)]
    draw = random.Random(seed)
    calm = kind(folder / "calm", words, cluster)
    calm.run(None, draw)  # once before, so that the timed run compiles nothing
    shutil.rmtree(calm.folder)
    begin_s = time.monotonic()
    calm.run(None, draw)
    whole_s, expected = time.monotonic() - begin_s, calm.export()
    killed: Counter[str] = Counter()
    campaigns = right = sound = outlived = 0
    while killed.total() < kills:
        campaign, its_kills = kind(folder / f"campaign{campaigns}", words, cluster), Counter[str]()
        done = False
        while not done:
            moment_s = draw.uniform(0.0, whole_s) if (killed + its_kills).total() < kills else None
            done, what, left = campaign.run(moment_s, draw)
            outlived += left
            if what:
                its_kills[what] += 1
                sound += campaign.sound()
        killed += its_kills
        campaigns += 1
        right += campaign.export() == expected
    if cluster:
        outlived += cluster.end()
    return {
        "kills": killed.total(),
        "killed": dict(sorted(killed.items())),
        "campaigns": campaigns,
        "right": right,
        "sound": sound,
        "outlived": outlived,
        "flights": expected.count(b'"mutant"'),
        "undisturbed_s": round(whole_s, 1),
    }


def main() -> None:
    """Kill, resume, compare; exits with 1 when anything was lost."""
    asked = parser(__doc__)
    asked.add_argument("--kills", type=int, default=20, help="how many (default: 20)")
    asked.add_argument("--seed", type=int, default=0, help="of the moments and the victims (default: 0)")
    asked.add_argument("--mutant", action="append", default=[], help="id or glob, repeatable")
    asked.add_argument("--situation", action="append", default=[], help="key or glob, repeatable")
    asked.add_argument("--baseline-seeds", type=int, default=10, help="of the baseline pool (default: 10)")
    asked.add_argument("--jobs", type=int, default=2, help="worker processes (default: 2)")
    other = asked.add_mutually_exclusive_group()
    other.add_argument("--cluster", action="store_true", help="fly on a Dask cluster, and kill its processes too")
    other.add_argument("--seek", metavar="BUDGET", help="kill a search with this budget, such as 300flights")
    other.add_argument("--outside", action="store_true", help="fly a stage outside, and kill it and its guard too")
    options = asked.parse_args()
    mutants = options.mutant or (OUTSIDE if options.outside else MUTANTS)
    if options.seek:
        words = [*mutants, "--budget", options.seek]
    else:
        words = [word for mutant in mutants for word in ("--mutant", mutant)]
        words += [word for key in options.situation or SITUATIONS for word in ("--situation", key)]
        words += ["--baseline-seeds", str(options.baseline_seeds)]
    with tempfile.TemporaryDirectory(prefix="kill") as made:
        words += [] if options.cluster else ["--jobs", str(options.jobs)]
        cluster = Cluster(Path(made) / "cluster", options.jobs) if options.cluster else None
        kind = search if options.seek else outside if options.outside else Campaign
        figures = measure(words, options.kills, options.seed, Path(made), cluster, kind)
    json.dump(figures, sys.stdout, indent=2)
    print()
    whole = figures["right"] == figures["campaigns"] and figures["sound"] == figures["kills"]
    sys.exit(not whole or bool(figures["outlived"]))


if __name__ == "__main__":
    main()
