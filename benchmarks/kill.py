"""Whether a campaign survives being killed: at random moments, all of it or one of its processes, again and again.

    python benchmarks/kill.py [--json] [--kills N] [--seed N] [--mutant ID]... [--situation KEY|GLOB]...
        [--baseline-seeds N] [--jobs N]

A small campaign is flown undisturbed, and its export kept.  Then it is begun anew and killed with SIGKILL after a
random part of the time that it took: half the time its whole process group, else one of its processes.  The same
command is given again, and killed again, until the campaign is done; its export must be the undisturbed one's, byte
for byte.  The next campaign is begun, until there were enough kills.

kills: how many, by what was killed.  campaigns: how many were brought to their end.  equal: of how many the export was
equal.  sound: after how many kills SQLite found its file sound.  outlived: how many processes lived on after the run
they belong to had ended.
"""

from __future__ import annotations

import checkout  # first: it sets the path and the threads

# isort: split

import argparse
import json
import os
import random
import shutil
import signal
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

MUTANTS = ("LATE-human", "MORE-goal", "UNINTENDED-collision@20s")
SITUATIONS = ("T0O0W0D0H[01]",)
GRACE_S = 5.0
"""How long after the end of a run its processes may take to end [s, wall]."""


class Campaign:
    """A campaign in a folder of its own, flown by commands that can be killed."""

    def __init__(self, folder: Path, words: Sequence[str]) -> None:
        self.folder = folder
        self._words = ["run", *words, "--quiet", "--campaign", str(folder)]

    def run(self, kill_after_s: float | None, draw: random.Random) -> tuple[bool, str, int]:
        """Give the command, and kill it if it still runs by then.

        Returns whether it ended by itself and well, what was killed, and how many processes outlived it.
        """
        # a session of its own, by which all of its processes are known
        run = subprocess.Popen(
            _call(*self._words), cwd=checkout.ROOT, stdout=subprocess.DEVNULL, start_new_session=True
        )
        killed = ""
        try:
            run.wait(kill_after_s)
        except subprocess.TimeoutExpired:
            killed = _kill(run.pid, draw)
        run.wait()
        if not killed and run.returncode:
            raise SystemExit(f"{' '.join(self._words)}: exit code {run.returncode}")
        outlived = _outlived(run.pid)
        return run.returncode == 0, killed, outlived

    def sound(self) -> bool:
        """Whether SQLite finds nothing wrong with the store, if there is one yet."""
        path = self.folder / STORE_NAME
        if not path.exists():
            return True
        with closing(sqlite3.connect(path)) as connection:
            return bool(connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)])

    def export(self) -> bytes:
        """What is exported of it."""
        call = _call("export", "--campaign", str(self.folder))
        return subprocess.run(call, cwd=checkout.ROOT, check=True, capture_output=True).stdout


def _call(*words: str) -> list[str]:
    return [sys.executable, "-m", "scaloft_fi", *words, "--study", str(checkout.ROOT)]


def _kill(session: int, draw: random.Random) -> str:
    """Kill a session's processes, or one of them; returns which."""
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
    """How many of a session's processes are still there when they have had their time; they are ended."""
    until_s = time.monotonic() + GRACE_S
    while (left := _processes(session)) and time.monotonic() < until_s:
        time.sleep(0.05)
    for process in left:
        os.kill(process, signal.SIGKILL)
    return len(left)


def measure(words: Sequence[str], kills: int, seed: int, folder: Path) -> dict[str, Any]:
    """Kill so often."""
    draw = random.Random(seed)
    calm = Campaign(folder / "calm", words)
    calm.run(None, draw)  # once before, so that nothing is compiled while the time is taken
    shutil.rmtree(calm.folder)
    begin_s = time.monotonic()
    calm.run(None, draw)
    whole_s, expected = time.monotonic() - begin_s, calm.export()
    killed: Counter[str] = Counter()
    campaigns = equal = sound = outlived = 0
    while killed.total() < kills:
        campaign = Campaign(folder / f"campaign{campaigns}", words)
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
    options = parser.parse_args()
    words = [word for mutant in options.mutant or MUTANTS for word in ("--mutant", mutant)]
    words += [word for key in options.situation or SITUATIONS for word in ("--situation", key)]
    folder = Path(tempfile.mkdtemp(prefix="kill"))
    try:
        words += ["--baseline-seeds", str(options.baseline_seeds), "--jobs", str(options.jobs)]
        figures = measure(words, options.kills, options.seed, folder)
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
