"""The wire of a baseline that mutants share: each mutant leaves the baseline at its first sample that differs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from scaloft_fi.mutants.wire import SeamCount, TapError, TappedWire

S = TypeVar("S")


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
