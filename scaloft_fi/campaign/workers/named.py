"""Parse `--executor`."""

from __future__ import annotations

import re

from scaloft_fi.campaign.processes.start import cores
from scaloft_fi.campaign.workers.cluster import Cluster
from scaloft_fi.campaign.workers.executor import Executor
from scaloft_fi.campaign.workers.local import Local
from scaloft_fi.errors import InputError

LOCAL = "local"
_DASK = re.compile(r"dask://(?P<address>[^/\s:@]+:[0-9]{1,5}|\[[0-9A-Fa-f:.]+\]:[0-9]{1,5})/?")


def executor_named(name: str, jobs: int | None) -> Executor:
    """The executor for the values of `--executor` and `--jobs`.

    Raises:
        InputError: the name is no executor, or `--jobs` is given for a cluster.
    """
    if name == LOCAL:
        return Local(jobs or cores())
    match = _DASK.fullmatch(name)
    if match is None:
        raise InputError(f"--executor={name!r} must be 'local' or 'dask://HOST:PORT', the address of a Dask scheduler")
    if jobs is not None:
        raise InputError(f"--jobs={jobs} is for --executor=local; how many fly on {name} is up to its workers")
    return Cluster(match["address"])
