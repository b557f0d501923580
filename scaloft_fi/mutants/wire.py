"""The wire of a mutated stack: carries every sample through the mutant's tap and counts the altered samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from scaloft_fi.errors import ScaloftError
from scaloft_fi.mutants.mutant import EVERY_SEAM, Mutant
from scaloft_fi.mutants.operator import OPERATORS, Facts, Occurrences, Tap, TapContext
from scaloft_fi.stack.declaration import Declaration, PlainWire, Seam, Wire
from scaloft_fi.streams import generator

S = TypeVar("S")


class TapError(ScaloftError):
    """A tap failed: a failure of the harness, not of the stack under test."""


class SeamCount(NamedTuple):
    """Counts for one seam.

    carried: polls at which a sample was sent or arrived; altered: polls at which the delivered sample differs from the
    sent one; first_altered_s: time of the first of these [s], None = never.
    """

    carried: int
    altered: int
    first_altered_s: float | None


@dataclass
class _Tally:
    seam: Seam
    tap: Tap
    carried: int = 0
    altered: int = 0
    first_altered_s: float | None = None

    def carry(self, t_s: float, sample: Any | None) -> Any | None:
        try:
            delivered = self.tap(t_s, sample)
            differs = self.seam.differ(sample, delivered)
        except Exception as error:
            raise TapError(f"tap on {self.seam.name} at {t_s:.3f} s: {type(error).__name__}: {error}") from error
        self.carried += sample is not None or delivered is not None
        if not differs:
            return sample
        self.altered += 1
        if self.first_altered_s is None:
            self.first_altered_s = t_s
        return delivered


class TappedWire:
    """Carries samples through taps; seams without a tap deliver them unchanged.

    A sample that does not differ is delivered as the object that was sent, so that a flight has the bits of its
    baseline until the first sample that differs.

    Args:
        taps: each with its seam.
        events: the occurrences that the taps await, by name of the event.
    """

    def __init__(
        self, taps: Iterable[tuple[Seam, Tap]], events: Mapping[str, Occurrences] = MappingProxyType({})
    ) -> None:
        self._tallies = {seam.name: _Tally(seam, tap) for seam, tap in taps}
        self._events = events

    def listens(self, seam: str) -> bool:
        """Whether `seam` has a tap."""
        return seam in self._tallies

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample` after the seam's tap, if the seam has one.

        Raises:
            TapError: the tap failed.
        """
        tally = self._tallies.get(seam)
        return sample if tally is None else tally.carry(t_s, sample)

    @property
    def awaited(self) -> frozenset[str]:
        """Names of the events that its taps await."""
        return frozenset(self._events)

    def occur(self, event: str, t_s: float) -> None:
        """Tell the taps that an event of the flight occurs at `t_s` [s]."""
        if event in self._events:
            self._events[event].occur(t_s)

    @property
    def seams(self) -> tuple[str, ...]:
        """The tapped seams."""
        return tuple(self._tallies)

    @property
    def altered(self) -> bool:
        """Whether a delivered sample differed from the sent one."""
        return any(tally.altered for tally in self._tallies.values())

    @property
    def counts(self) -> Mapping[str, SeamCount]:
        """Counts so far for each tapped seam."""
        return {name: SeamCount(t.carried, t.altered, t.first_altered_s) for name, t in self._tallies.items()}


def contexts(mutant_id: str, situation: str, seed: int, facts: Facts) -> Callable[[Seam], TapContext]:
    """Contexts by seam for one flight; random numbers depend on mutant, situation, seed and seam only."""

    def context(seam: Seam) -> TapContext:
        noise = generator(mutant_id, situation, seed, seam.name)
        return TapContext(1.0 / seam.rate_hz, noise, facts)

    return context


def wire_for(subject: Mutant | None, stack: Declaration, context: Callable[[Seam], TapContext]) -> Wire:
    """A fresh wire for one flight of `subject`; None stands for the baseline, PLACEBO has a tap on every seam."""
    if subject is None:
        return PlainWire()
    import_module("scaloft_fi.mutants.operators")  # by name: the keys of baselines leave operators out
    operator = OPERATORS[subject.operator]
    seams = stack.seams if subject.seam == EVERY_SEAM else (stack.by_name[subject.seam],)
    event = Occurrences() if subject.event else None
    return TappedWire(
        [(seam, operator.tap(replace(context(seam), event=event), subject.arguments)) for seam in seams],
        {subject.event: event} if event else {},
    )
