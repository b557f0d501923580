"""A Dask cluster on the loopback interface, whose processes are killed and started again."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from pathlib import Path

from checkout import ROOT

from kill.victims import Marked
from scaloft_fi.campaign.workers.cluster import MAKE


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
        environment = {"PYTHONPATH": str(ROOT)}
        with (self._folder / f"{name}.log").open("ab") as log:
            self.targets[name] = Marked([sys.executable, "-m", "dask", *words, *files], self._folder, environment, log)
