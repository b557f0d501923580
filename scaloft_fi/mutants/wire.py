"""The wire of a mutated stack, and the one of a baseline that mutants share.

The first carries every sample through the mutant's tap and counts the altered samples.  Each mutant leaves the shared
baseline at its first sample that differs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from scaloft_fi.aside import foreign
from scaloft_fi.mutants.mutant import EVERY_SEAM, Mutant
from scaloft_fi.mutants.operator import OPERATORS, Facts, Occurrences, Tap, TapContext, TapError
from scaloft_fi.stack.declaration import Declaration, PlainWire, Seam, Wire
from scaloft_fi.stack.messages import misshapen
from scaloft_fi.streams import generator

S = TypeVar("S")


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
            if differs and delivered is not None:
                if not isinstance(delivered, self.seam.message):
                    raise TypeError(f"it delivers {type(delivered).__name__}, not {self.seam.message.__name__} or None")
                if wrong := misshapen(sample, delivered):
                    raise ValueError(wrong)
        except foreign() as error:
            sentence = f"tap on {self.seam.name} at {t_s:.3f} s: {type(error).__name__}: {error}"
            raise TapError(sentence, getattr(self.tap, "__module__", "")) from error
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


class WatchingWire:
    """Delivers the baseline's samples unchanged, and runs the taps of the watched wires on the same samples.

    When a watched wire first delivers a sample that differs, the flight branches.  In the branch this wire acts as the
    watched wire from then on, with its counts; in the trunk it no longer watches that wire.

    Args:
        watched: fresh wires by name.
        branch: called with the name of a wire that differs and the time [s]; returns True in the branch, False in the
            trunk.
        failed: called with the name of a wire whose tap failed and the error; the wire is no longer watched.
    """

    def __init__(
        self,
        watched: Mapping[str, TappedWire],
        branch: Callable[[str, float], bool],
        failed: Callable[[str, TapError], None],
    ) -> None:
        self._watched = dict(watched)
        self._branch, self._failed = branch, failed
        self._by_seam: dict[str, tuple[str, ...]] = {}
        self._taken: TappedWire | None = None
        self._sort()

    def listens(self, seam: str) -> bool:
        """Whether a watched wire, or the taken one, has a tap on `seam`."""
        return bool(self._by_seam.get(seam)) if self._taken is None else self._taken.listens(seam)

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample` in the trunk, the taken wire's sample in a branch.

        Raises:
            TapError: the tap of the taken wire failed, or the flight could not branch.
        """
        if self._taken is not None:
            return self._taken.cross(seam, t_s, sample)
        for name in self._by_seam.get(seam, ()):
            wire = self._watched[name]
            try:
                delivered = wire.cross(seam, t_s, sample)
            except TapError as error:
                self._drop(name)
                self._report(name, error)
                continue
            if wire.altered:
                self._drop(name)
                if self._leaves(name, t_s):
                    self._taken = wire
                    self._watched.clear()
                    return delivered
        return sample

    @property
    def awaited(self) -> frozenset[str]:
        """Names of the events that the watched wires await."""
        return frozenset(event for wire in self._watched.values() for event in wire.awaited)

    def occur(self, event: str, t_s: float) -> None:
        """Tell the watched wires, or the taken one, that an event of the flight occurs at `t_s` [s]."""
        for wire in self._watched.values() if self._taken is None else (self._taken,):
            wire.occur(event, t_s)

    @property
    def counts(self) -> Mapping[str, SeamCount]:
        """Counts so far for each seam that the taken wire taps; empty in the trunk."""
        return {} if self._taken is None else self._taken.counts

    @property
    def silent(self) -> Mapping[str, Mapping[str, SeamCount]]:
        """Counts by name of the wires that are still watched: none of their samples has differed."""
        return {name: wire.counts for name, wire in self._watched.items()}

    def _leaves(self, name: str, t_s: float) -> bool:
        try:
            return self._branch(name, t_s)
        except Exception as error:  # the stack under test did not raise this error
            raise TapError(f"branch of {name}: {type(error).__name__}: {error}") from error

    def _report(self, name: str, error: TapError) -> None:
        try:
            self._failed(name, error)
        except Exception as worse:
            raise TapError(f"report on {name}: {type(worse).__name__}: {worse}") from worse

    def _drop(self, name: str) -> None:
        del self._watched[name]
        self._sort()

    def _sort(self) -> None:
        """List the watched wires by seam, in the order given."""
        seams = dict.fromkeys(seam for wire in self._watched.values() for seam in wire.seams)
        self._by_seam = {seam: tuple(n for n, w in self._watched.items() if seam in w.seams) for seam in seams}
