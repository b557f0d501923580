"""A Dask cluster on the loopback interface, whose processes are killed and started again."""

from __future__ import annotations

import secrets
import signal
import socket
import sys
from pathlib import Path

from checkout import ROOT

from kill.victims import Marked


class Cluster:
    """A scheduler and workers.

    Args:
        folder: for key, logs and the workers' files.
        workers: how many.
    """

    def __init__(self, folder: Path, workers: int) -> None:
        folder.mkdir(parents=True)
        self._folder, self._workers = folder, workers
        self.key = folder / "cluster.key"
        self.key.write_text(secrets.token_hex(32))
        self.key.chmod(0o600)
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = f"127.0.0.1:{probe.getsockname()[1]}"
        self.targets: dict[str, Marked] = {}

    def heal(self) -> None:
        """Start what does not run; workers find a new scheduler at the old address by themselves."""
        _, port = self.address.split(":")
        self._start("scheduler", "scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")
        for number in range(self._workers):
            local = ("--local-directory", str(self._folder / f"worker{number}"), "--no-dashboard", "--nthreads", "1")
            self._start(f"worker {number}", "worker", f"tcp://{self.address}", "--host", "127.0.0.1", *local)

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
        environment = {"PYTHONPATH": str(ROOT), "SCALOFT_CLUSTER_KEY": str(self.key)}
        with (self._folder / f"{name}.log").open("ab") as log:
            self.targets[name] = Marked([sys.executable, "-m", "dask", *words], self._folder, environment, log)
