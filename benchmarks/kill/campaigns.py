"""A campaign that is flown by commands which are killed: as `run` flies it, as a search, or with a stage outside."""

from __future__ import annotations

import random
import shutil
import sqlite3
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from checkout import ROOT

from kill.cluster import Cluster
from kill.victims import Marked
from scaloft_fi.campaign.store.archive import STORE_NAME

STUDY = ("hazop", "mutants", "sim")
HEAL_EVERY_S = 0.5


class Campaign:
    """A campaign in its own folder.

    Args:
        folder: of the campaign.
        words: mutants, situations and options of the command.
        cluster: what flies; None for processes of this machine.
        study: its folder.
    """

    verb, into = "run", "--campaign"

    def __init__(self, folder: Path, words: Sequence[str], cluster: Cluster | None = None, study: Path = ROOT) -> None:
        self.folder = folder
        self._cluster = cluster
        self._words = _call(self.verb, *words, "--quiet", self.into, str(folder), study=study)
        self._export = _call("export", "--campaign", str(folder), study=study)

    def run(self, kill_after_s: float | None, draw: random.Random) -> tuple[bool, str, int]:
        """Run the command, and kill it if it still runs after `kill_after_s`.

        Returns whether the command ended by itself with success, what was killed, and how many processes outlived it.
        """
        if self._cluster:
            self._cluster.heal()
        run = Marked(self._words, ROOT)
        killed = ""
        try:
            run.process.wait(kill_after_s)
        except subprocess.TimeoutExpired:
            targets = {"run": run, **(self._cluster.targets if self._cluster else {})}
            target = draw.choice(list(targets))
            what = targets[target].kill(draw)
            killed = what if target == "run" or not what else f"{target}: {what}"
        while self._cluster and run.process.poll() is None:
            self._cluster.heal()  # again and again, because a killed process takes a moment to end
            time.sleep(HEAL_EVERY_S)
        code = run.process.wait()
        if not killed and code:
            raise SystemExit(f"{' '.join(self._words)}: exit code {code}")
        return code == 0, killed, run.outlived()

    def sound(self) -> bool:
        """Whether the store is intact according to SQLite, or does not exist yet."""
        path = self.folder / STORE_NAME
        if not path.exists():
            return True
        with closing(sqlite3.connect(path)) as connection:
            return bool(connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)])

    def export(self) -> bytes:
        """The export of the campaign."""
        return subprocess.run(self._export, cwd=ROOT, check=True, capture_output=True).stdout


class Search(Campaign):
    """A search in a copy of the study of its own, without finds."""

    verb, into = "seek", "--into"

    def __init__(self, folder: Path, words: Sequence[str], cluster: Cluster | None = None) -> None:
        study = folder.parent / f"{folder.name}_study"
        for part in STUDY:
            shutil.copytree(ROOT / part, study / part)
        self._finds = study / "sim" / "found.yaml"
        self._finds.unlink(missing_ok=True)
        super().__init__(folder, words, cluster, study)

    def export(self) -> bytes:
        """The finds, and the export of the campaign."""
        finds = self._finds.read_bytes() if self._finds.exists() else b""
        return finds + super().export()


class Outside(Campaign):
    """A campaign of the example whose planner runs in a process of its own."""

    def __init__(self, folder: Path, words: Sequence[str], cluster: Cluster | None = None) -> None:
        study = folder.parent / "study"
        if not study.exists():
            make = ROOT / "examples" / "outside_planner" / "make_study.py"
            subprocess.run([sys.executable, str(make), str(study)], check=True, cwd=ROOT, env={"PYTHONPATH": str(ROOT)})
        super().__init__(folder, words, cluster, study)


def _call(*words: str, study: Path) -> list[str]:
    return [sys.executable, "-m", "scaloft_fi", *words, "--study", str(study)]
