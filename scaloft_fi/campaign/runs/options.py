"""Options of a run that do not change any outcome."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.campaign.flights.fork import CAN_FORK
from scaloft_fi.campaign.workers.executor import Executor

MOST_INVALID = 0.1
"""Greatest share of invalid flights; a run with more gives no valid score."""


@dataclass(frozen=True)
class RunOptions:
    """Options from the command line.

    Attributes:
        jobs: number of worker processes on this machine.
        executor: executor that replaces these processes.
        share: whether mutants share the beginning of their baseline.
        part: whether this run is one part of a campaign; `merge` checks the gates that need all parts.
        budget_s: wall time after which no flight begins [s]; None = unlimited.
        max_invalid: greatest share 0..1 of invalid flights.
        warnings: whether each violation is shown when its outcome arrives, instead of only counted.
        same_platform: whether only flights with the bits of this platform count.
        command: the command of the user, named in the message on how to resume; empty without a command line.
    """

    jobs: int = 1
    executor: Executor | None = None
    share: bool = CAN_FORK
    part: bool = False
    budget_s: float | None = None
    max_invalid: float = MOST_INVALID
    warnings: bool = False
    same_platform: bool = False
    command: str = ""
