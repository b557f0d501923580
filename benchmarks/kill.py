"""Test that a campaign survives SIGKILL of all or one of its processes at random moments, again and again.

    python benchmarks/kill.py [--json] [--kills N] [--seed N] [--mutant ID]... [--situation KEY|GLOB]...
        [--baseline-seeds N] [--jobs N] [--cluster | --seek BUDGET]

The script flies a small campaign undisturbed and keeps its export.  Then it starts the campaign again and sends SIGKILL
after a random part of that time: in half of the cases to the whole process group, otherwise to one process.  It repeats
command and kill until the campaign is complete; the export must equal the undisturbed one, byte for byte.  New
campaigns follow until the number of kills is reached.

With `--cluster` a Dask cluster on the loopback interface flies: a scheduler and as many workers as `--jobs`.  Then the
victim is, with equal chance, the run as above, the scheduler, a worker, or a process of a worker.  What was killed of
the cluster is started again; a run outlives its workers, and ends when its scheduler does.

With `--seek` a search for the mutants with this budget is killed and resumed, in a copy of the study without finds; its
finds are compared beside the exports.

kills: number of kills by target.  campaigns: number of completed campaigns.  equal: number of equal exports.  sound:
number of kills after which SQLite found its file intact.  outlived: number of processes that outlived their run.
"""

from __future__ import annotations

import checkout  # first: it sets the path and the threads

# isort: split

import argparse
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
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from scaloft_fi.campaign.store.folder import STORE_NAME

STUDY = ("hazop", "mutants", "sim")
MUTANTS = ("LATE-human", "MORE-goal", "UNINTENDED-collision@20s")
SITUATIONS = ("T0O0W0D0H[01]",)
HEAL_EVERY_S = 0.5
GRACE_S = 5.0
"""Greatest time from the end of a run to the end of its processes [s, wall]."""


class Campaign:
    """A campaign in its own folder, flown by commands that can be killed."""

    def __init__(self, folder: Path, words: Sequence[str], cluster: Cluster | None = None) -> None:
        self.folder = folder
        self._cluster = cluster
        self._words = _call("run", *words, "--quiet", "--campaign", str(folder))
        self._export = _call("export", "--campaign", str(folder))

    def run(self, kill_after_s: float | None, draw: random.Random) -> tuple[bool, str, int]:
        """Run the command, and kill it if it still runs after `kill_after_s`.

        Returns whether the command ended by itself with success, what was killed, and how many processes outlived it.
        """
        if self._cluster:
            self._cluster.heal()
        # a new session, which identifies all of its processes
        run = subprocess.Popen(self._words, cwd=checkout.ROOT, stdout=subprocess.DEVNULL, start_new_session=True)
        killed = ""
        try:
            run.wait(kill_after_s)
        except subprocess.TimeoutExpired:
            targets = self._cluster.targets if self._cluster else {}
            target = draw.choice(["run", *targets])
            killed = _kill(run.pid, draw) if target == "run" else f"{target}: {_kill(targets[target], draw)}"
        while self._cluster and run.poll() is None:
            self._cluster.heal()  # again and again, because a killed process takes a moment to end
            time.sleep(HEAL_EVERY_S)
        run.wait()
        if not killed and run.returncode:
            raise SystemExit(f"{' '.join(self._words)}: exit code {run.returncode}")
        outlived = _outlived(run.pid)
        return run.returncode == 0, killed, outlived

    def sound(self) -> bool:
        """Whether the store is intact according to SQLite, or does not exist yet."""
        path = self.folder / STORE_NAME
        if not path.exists():
            return True
        with closing(sqlite3.connect(path)) as connection:
            return bool(connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)])

    def export(self) -> bytes:
        """The export of the campaign."""
        return subprocess.run(self._export, cwd=checkout.ROOT, check=True, capture_output=True).stdout


class Search(Campaign):
    """A search in a copy of the study of its own."""

    def __init__(self, folder: Path, words: Sequence[str], _cluster: Cluster | None = None) -> None:
        super().__init__(folder, words)
        self._study = folder.parent / f"{folder.name}_study"
        for part in STUDY:
            shutil.copytree(checkout.ROOT / part, self._study / part)
        self._finds.unlink(missing_ok=True)
        self._words = _call("seek", *words, "--quiet", "--into", str(folder), study=self._study)
        self._export = _call("export", "--campaign", str(folder), study=self._study)

    @property
    def _finds(self) -> Path:
        return self._study / "sim" / "found.yaml"

    def export(self) -> bytes:
        """The finds, and the export of the campaign."""
        finds = self._finds.read_bytes() if self._finds.exists() else b""
        return finds + super().export()


class Cluster:
    """A scheduler and workers of Dask on the loopback interface, each in a session of its own."""

    def __init__(self, folder: Path, workers: int) -> None:
        folder.mkdir(parents=True)
        self._folder, self._workers = folder, workers
        self.key = folder / "cluster.key"
        self.key.write_text(secrets.token_hex(32))
        self.key.chmod(0o600)
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = f"127.0.0.1:{probe.getsockname()[1]}"
        self._processes: dict[str, subprocess.Popen[bytes]] = {}

    @property
    def targets(self) -> dict[str, int]:
        """The sessions that can be killed, by name."""
        return {name: process.pid for name, process in self._processes.items()}

    def heal(self) -> None:
        """Start what does not run; workers find a new scheduler at the old address by themselves."""
        _, port = self.address.split(":")
        self._start("scheduler", "scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")
        for number in range(self._workers):
            local = ("--local-directory", str(self._folder / f"worker{number}"), "--no-dashboard", "--nthreads", "1")
            self._start(f"worker {number}", "worker", f"tcp://{self.address}", "--host", "127.0.0.1", *local)

    def _start(self, name: str, *words: str) -> None:
        running = self._processes.get(name)
        if running is not None and running.poll() is None:
            return
        if running is not None:
            _outlived(running.pid)
        environment = {**os.environ, "PYTHONPATH": str(checkout.ROOT), "SCALOFT_CLUSTER_KEY": str(self.key)}
        with (self._folder / f"{name}.log").open("ab") as log:
            self._processes[name] = subprocess.Popen(
                [sys.executable, "-m", "dask", *words],
                cwd=self._folder,
                env=environment,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )

    def end(self) -> int:
        """Ask all of it to end; returns the number of processes that do not."""
        for process in reversed(self._processes.values()):
            process.send_signal(signal.SIGTERM)
        for process in self._processes.values():
            process.wait()
        return sum(_outlived(process.pid) for process in self._processes.values())


def _call(*words: str, study: Path = checkout.ROOT) -> list[str]:
    return [sys.executable, "-m", "scaloft_fi", *words, "--study", str(study)]


def _kill(session: int, draw: random.Random) -> str:
    """Kill all processes of a session, or one of them; returns which."""
    if draw.random() < 0.5:
        os.killpg(session, signal.SIGKILL)
        return "all"
    victim = draw.choice(sorted(_processes(session)) or [session])
    try:
        os.kill(victim, signal.SIGKILL)
    except ProcessLookupError:  # it has just ended by itself
        return ""
    return "first" if victim == session else "other"


def _processes(session: int) -> set[int]:
    """The processes of a session that have not ended (proc(5): state and session follow the name in brackets)."""
    found = set()
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, its_session, *_ = path.read_text().rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        if int(its_session) == session and state not in "ZX":
            found.add(int(path.parent.name))
    return found


def _outlived(session: int) -> int:
    """End the processes of a session that still run after `GRACE_S`; returns their number."""
    until_s = time.monotonic() + GRACE_S
    while (left := _processes(session)) and time.monotonic() < until_s:
        time.sleep(0.05)
    for process in left:
        os.kill(process, signal.SIGKILL)
    return len(left)


def measure(
    words: Sequence[str],
    kills: int,
    seed: int,
    folder: Path,
    cluster: Cluster | None = None,
    kind: type[Campaign] = Campaign,
) -> dict[str, Any]:
    """Fly, kill and resume campaigns of a kind until the number of kills is reached."""
    if cluster:
        words = [*words, "--executor", f"dask://{cluster.address}", "--cluster-key", str(cluster.key)]
    draw = random.Random(seed)
    calm = kind(folder / "calm", words, cluster)
    calm.run(None, draw)  # once before, so that the timed run compiles nothing
    shutil.rmtree(calm.folder)
    begin_s = time.monotonic()
    calm.run(None, draw)
    whole_s, expected = time.monotonic() - begin_s, calm.export()
    killed: Counter[str] = Counter()
    campaigns = equal = sound = outlived = 0
    while killed.total() < kills:
        campaign = kind(folder / f"campaign{campaigns}", words, cluster)
        done = False
        while not done:
            moment_s = draw.uniform(0.0, whole_s) if killed.total() < kills else None
            done, what, left = campaign.run(moment_s, draw)
            outlived += left
            if what:
                killed[what] += 1
                sound += campaign.sound()
        campaigns += 1
        equal += campaign.export() == expected
    if cluster:
        outlived += cluster.end()
    return {
        "kills": killed.total(),
        "killed": dict(sorted(killed.items())),
        "campaigns": campaigns,
        "equal": equal,
        "sound": sound,
        "outlived": outlived,
        "flights": expected.count(b'"mutant"'),
        "undisturbed_s": round(whole_s, 1),
    }


def main() -> None:
    """Kill, resume, compare; exits with 1 when anything was lost."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--kills", type=int, default=20, help="how many (default: 20)")
    parser.add_argument("--seed", type=int, default=0, help="of the moments and the victims (default: 0)")
    parser.add_argument("--mutant", action="append", default=[], help="id or glob, repeatable")
    parser.add_argument("--situation", action="append", default=[], help="key or glob, repeatable")
    parser.add_argument("--baseline-seeds", type=int, default=10, help="of the baseline pool (default: 10)")
    parser.add_argument("--jobs", type=int, default=2, help="worker processes (default: 2)")
    other = parser.add_mutually_exclusive_group()
    other.add_argument("--cluster", action="store_true", help="fly on a Dask cluster, and kill its processes too")
    other.add_argument("--seek", metavar="BUDGET", help="kill a search with this budget, such as 300flights")
    options = parser.parse_args()
    mutants = options.mutant or MUTANTS
    if options.seek:
        words = [*mutants, "--budget", options.seek]
    else:
        words = [word for mutant in mutants for word in ("--mutant", mutant)]
        words += [word for key in options.situation or SITUATIONS for word in ("--situation", key)]
        words += ["--baseline-seeds", str(options.baseline_seeds)]
    folder = Path(tempfile.mkdtemp(prefix="kill"))
    try:
        words += [] if options.cluster else ["--jobs", str(options.jobs)]
        cluster = Cluster(folder / "cluster", options.jobs) if options.cluster else None
        kind = Search if options.seek else Campaign
        figures = measure(words, options.kills, options.seed, folder, cluster, kind)
    finally:
        shutil.rmtree(folder)
    if options.json:
        json.dump(figures, sys.stdout, indent=2)
        print()
    else:
        for name, figure in figures.items():
            print(f"{name:14} {figure}")
    unharmed = (
        figures["equal"] == figures["campaigns"] and figures["sound"] == figures["kills"] and not figures["outlived"]
    )
    sys.exit(not unharmed)


if __name__ == "__main__":
    main()
