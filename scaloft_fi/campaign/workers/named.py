"""Parse `--executor` and what belongs to it."""

from __future__ import annotations

import re
from pathlib import Path

from scaloft_fi.campaign.processes import cores
from scaloft_fi.campaign.workers.cluster import MAKE, VARIABLE, Cluster, check_certificates, read_key
from scaloft_fi.campaign.workers.local import Executor, Local
from scaloft_fi.errors import InputError

LOCAL = "local"
_DASK = re.compile(r"dask://(?P<address>[^/\s:@]+:[0-9]{1,5}|\[[0-9A-Fa-f:.]+\]:[0-9]{1,5})/?")


def executor_named(
    name: str, jobs: int | None, key_file: Path | None = None, certificates: Path | None = None
) -> Executor:
    """The executor for the values of `--executor`, `--jobs`, `--cluster-key` and `--cluster-security`.

    Raises:
        InputError: the name is no executor, an option does not belong to it, or the key or a certificate is missing.
    """
    if name == LOCAL:
        if certificates is not None:
            raise InputError(f"--cluster-security={certificates} is for --executor=dask://HOST:PORT")
        return Local(jobs or cores())
    match = _DASK.fullmatch(name)
    if match is None:
        raise InputError(f"--executor={name!r} must be 'local' or 'dask://HOST:PORT', the address of a Dask scheduler")
    if jobs is not None:
        raise InputError(f"--jobs={jobs} is for --executor=local; how many fly on {name} is up to its workers")
    if key_file is None:
        raise InputError(
            f"--executor={name} needs a key that only its workers have: make one with `{MAKE}`, start each worker with "
            f"{VARIABLE}=cluster.key, and give run --cluster-key=cluster.key or the same variable"
        )
    key = read_key(key_file)
    if certificates is not None:
        check_certificates(certificates)
    return Cluster(match["address"], key, certificates)
