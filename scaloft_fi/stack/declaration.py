"""The declaration of a stack: the framework reads seams and beliefs from it and names none of them itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from scaloft_fi.stack.belief import Belief
from scaloft_fi.stack.contract import Stack, Task
from scaloft_fi.stack.seam import Seam, Wire


@dataclass(frozen=True)
class Declaration:
    """A stack under test, as the framework knows it.

    Attributes:
        name: by which `sim/stack.yaml` names the stack.
        seams: where faults can be patched in; each sample of a seam crosses `Wire.cross`.
        beliefs: the numbers that `Stack.beliefs` returns, in order.
        make: makes the stack, ready for take-off.  It imports heavy modules itself, because verbs that do not fly read
            the declaration too.
        settings: returns the frozen dataclass, or named tuple, that the rest of `sim/stack.yaml` is built into
            (`stack.config.build`); None hands the plain mapping over.
        canaries: seams that carry samples in every situation, the one nearest to the rotors first.  `run --mutant`
            flies a control there, to prove that faults reach the drone.
        operators: modules that declare operators of this stack's own; imported when a study names the stack.
        deterministic: whether two flights of the same subject, situation and seed have the same bits.
        forks: whether a flight may be forked in mid-air.  A stack with threads or other processes cannot: each of its
            flights has a process of its own.
        shape: the declaration that follows from the settings, of a stack whose seams are data; it may raise
            `ConfigError`.
        rehearse: makes a stack for the trial flight before the first flight, without threads or other processes; None =
            `make`.

    Raises:
        ValueError: a name is taken twice, or a canary is no seam.
    """

    name: str
    seams: tuple[Seam, ...]
    beliefs: tuple[Belief, ...]
    make: Callable[[Task, Wire], Stack]
    settings: Callable[[], type] | None = None
    canaries: tuple[str, ...] = ()
    operators: tuple[str, ...] = ()
    deterministic: bool = True
    forks: bool = True
    shape: Callable[[Any], Declaration] | None = None
    rehearse: Callable[[Task, Wire], Stack] | None = None

    def __post_init__(self) -> None:
        for noun, names in (("seam", [s.name for s in self.seams]), ("belief", [b.name for b in self.beliefs])):
            twice = [name for place, name in enumerate(names) if name in names[:place]]
            if twice:
                raise ValueError(f"stack {self.name!r} declares {noun} {twice[0]!r} twice")
        lost = [name for name in self.canaries if name not in self.by_name]
        if lost:
            raise ValueError(f"stack {self.name!r} has no seam {lost[0]!r} for a canary")

    @property
    def rehearsed(self) -> Declaration:
        """The declaration for the trial flight."""
        return replace(self, make=self.rehearse) if self.rehearse else self

    @cached_property
    def by_name(self) -> Mapping[str, Seam]:
        """The seams by name."""
        return {seam.name: seam for seam in self.seams}

    @property
    def caps(self) -> Mapping[str, float]:
        """The greatest value of each belief, where one is declared."""
        return {belief.name: belief.most for belief in self.beliefs if math.isfinite(belief.most)}

    @property
    def belief_names(self) -> tuple[str, ...]:
        """Names of the beliefs, in order."""
        return tuple(belief.name for belief in self.beliefs)
