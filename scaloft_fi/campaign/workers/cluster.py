"""The executor for a Dask cluster: connect to its scheduler, and trust nobody there without the key of the cluster."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.workers.bundle import packed
from scaloft_fi.campaign.workers.cluster_run import ClusterRun, disconnecting
from scaloft_fi.campaign.workers.executor import Workers
from scaloft_fi.campaign.workers.inbox import Inbox
from scaloft_fi.campaign.workers.key import topic_of
from scaloft_fi.campaign.workers.security import security_of
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study

CONNECT_S = 10.0
"""Greatest time to wait for an answer of the scheduler [s, wall]."""


@dataclass(frozen=True)
class Cluster:
    """The workers of a scheduler that have the key.

    Attributes:
        address: of the scheduler, as HOST:PORT.
        key: key of the cluster.
        certificates: folder of the certificates; None = Dask does not encrypt.
    """

    address: str
    key: bytes = field(repr=False)
    certificates: Path | None = None

    @contextmanager
    def workers(
        self, study: Study, flyer: Flyer, *, stop: Callable[[], bool], say: Callable[[str], None]
    ) -> Iterator[Workers]:
        """Connect to the scheduler; each worker that proves that it has the key gets the study, also if it joins later.

        Raises:
            InputError: `distributed` is not installed, or the scheduler cannot be reached.
        """
        try:
            from distributed import Client

            from scaloft_fi.campaign.workers.inert import inert_scheme
        except ImportError as error:
            how = "pip install 'scaloft-fi[cluster]'"
            raise InputError(f"--executor=dask://{self.address} needs the package distributed: {how}") from error
        for name in ("distributed", "distributed.client"):  # this package prints its own messages
            logging.getLogger(name).setLevel(logging.CRITICAL)
        bundle, inbox = packed(study.folder), Inbox(self.key)
        with inert_scheme(tls=self.certificates is not None, skipped=inbox.skip) as scheme:
            try:
                client = Client(
                    f"{scheme}://{self.address}",
                    timeout=CONNECT_S,
                    set_as_default=False,
                    name="scaloft-fi",
                    security=security_of(self.certificates),
                )
            except (OSError, ValueError, TypeError, LookupError, AttributeError, AssertionError) as error:
                reason = f"no Dask scheduler answers there within {CONNECT_S:g} s"
                if self.certificates is not None:
                    reason += f" with the certificates in {self.certificates}"
                raise InputError(f"--executor=dask://{self.address} cannot be reached: {reason}") from error
            with client:
                try:
                    with disconnecting():
                        client.subscribe_topic(topic_of(self.key), inbox.receive)
                    yield ClusterRun(client, inbox, bundle, study, flyer, stop, say)
                finally:
                    for line in inbox.summary():
                        say(line)
