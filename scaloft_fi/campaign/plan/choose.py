"""Parse seeds, shards and mutants from the command line."""

from __future__ import annotations

import re
from collections.abc import Sequence

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.mutants.catalogue import defaults, select
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.study import Study

MOST_SEEDS = 100_000


def seeds(text: str, option: str = "--seeds") -> tuple[int, ...]:
    """`N` means 0..N-1, `A-B` means A to B, both included.

    >>> seeds("3"), seeds("4-5")
    ((0, 1, 2), (4, 5))

    Raises:
        InputError: the text has another form, or names no seed.
    """
    match = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", text.strip())
    if match:
        first, last = (0, int(match[1]) - 1) if match[2] is None else (int(match[1]), int(match[2]))
        if 0 <= last - first < MOST_SEEDS:
            return tuple(range(first, last + 1))
    raise InputError(f"{option}={text!r} must be N for seeds 0..N-1 (N >= 1), or A-B with A <= B")


def shard(text: str) -> tuple[int, int]:
    """`k/n`: the k-th of n shards.

    >>> shard("2/3")
    (2, 3)

    Raises:
        InputError: the text is no such pair.
    """
    match = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text.strip())
    if match and 1 <= int(match[1]) <= int(match[2]):
        return int(match[1]), int(match[2])
    raise InputError(f"--shard={text!r} must be K/N with 1 <= K <= N, as in 1/4")


def mutants(study: Study, patterns: Sequence[str]) -> tuple[Mutant, ...]:
    """The mutants to fly in addition to PLACEBO: those that match, or by default every cell's default and the controls.

    Raises:
        InputError: a pattern matches no mutant.
    """
    if not patterns:
        return defaults(study.matrix)
    wanted = [pattern for pattern in patterns if pattern != PLACEBO.id]
    return select(wanted, study.matrix, study.catalogue)


def canary(study: Study) -> Mutant | None:
    """The control whose flight proves that faults reach the drone; None in a study without controls."""
    controls = [mutant for mutant in defaults(study.matrix) if is_control(study, mutant)]
    seams = study.stack.canaries
    steady = sorted((m for m in controls if m.seam in seams), key=lambda m: seams.index(m.seam))
    return next(iter([*steady, *controls]), None)


def is_control(study: Study, mutant: Mutant) -> bool:
    """Whether the mutant realises a control cell."""
    return study.matrix.cell(mutant.cell).status is CellStatus.CONTROL
