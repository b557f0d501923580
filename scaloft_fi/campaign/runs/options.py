"""How a run flies, apart from what it flies: nothing here changes an outcome."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.campaign.flights.fork import CAN_FORK
from scaloft_fi.campaign.workers.executor import Executor

MOST_INVALID = 0.1
"""A run in which the harness failed over a larger share of the flights says nothing of the drone."""


@dataclass(frozen=True)
class RunOptions:
    """What the command line decides about the flying.

    Attributes:
        jobs: number of worker processes of this machine.
        executor: who flies instead of them.
        share: whether mutants are flown only from where they leave their baseline.
        part: whether others fly the rest; the gates that need all of it are theirs who merge it.
        budget_s: wall time after which no more flights are begun [s]; None = until all is flown.
        max_invalid: largest share 0..1 of invalid flights with which a run may be believed.
        warnings: whether each violation is shown as it happens, and not only counted.
        command: what the user typed, to resume by; empty when nobody typed anything.
    """

    jobs: int = 1
    executor: Executor | None = None
    share: bool = CAN_FORK
    part: bool = False
    budget_s: float | None = None
    max_invalid: float = MOST_INVALID
    warnings: bool = False
    command: str = ""
