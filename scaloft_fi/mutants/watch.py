"""The wire of a baseline with mutants watched alongside: each leaves it where its first sample differs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from scaloft_fi.mutants.wire import SeamCount, TapError, TappedWire

S = TypeVar("S")


class WatchingWire:
    """Carries the baseline's samples as they are, and runs the taps of the watched wires on the same samples.

    Where a watched wire first delivers something that differs, the flight branches: in the branch this wire becomes
    that one, counts and all, and delivers what it delivers; in the trunk it is watched no longer.

    Args:
        watched: fresh wires by name.
        branch: called with the name of a wire that differs, and when [s]; returns True in the branch, False in the
            trunk.
        failed: called with the name of a wire whose tap failed, and why; it is watched no longer.
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
        """Return `sample` in the trunk, what the taken wire makes of it in a branch.

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
                self._tell(name, error)
                continue
            if wire.altered:
                self._drop(name)
                if self._leaves(name, t_s):
                    self._taken = wire
                    self._watched.clear()
                    return delivered
        return sample

    @property
    def counts(self) -> Mapping[str, SeamCount]:
        """What happened so far on each seam that the taken wire taps; nothing in the trunk."""
        return {} if self._taken is None else self._taken.counts

    @property
    def silent(self) -> Mapping[str, Mapping[str, SeamCount]]:
        """By name, what each wire counted that is still watched: nothing it delivered has differed."""
        return {name: wire.counts for name, wire in self._watched.items()}

    def _leaves(self, name: str, t_s: float) -> bool:
        try:
            return self._branch(name, t_s)
        except Exception as error:  # whatever it is, the stack under test did not raise it
            raise TapError(f"branch of {name}: {type(error).__name__}: {error}") from error

    def _tell(self, name: str, error: TapError) -> None:
        try:
            self._failed(name, error)
        except Exception as worse:
            raise TapError(f"report on {name}: {type(worse).__name__}: {worse}") from worse

    def _drop(self, name: str) -> None:
        del self._watched[name]
        self._sort()

    def _sort(self) -> None:
        """Note who is watched on which seam, in the order given."""
        seams = dict.fromkeys(seam for wire in self._watched.values() for seam in wire.seams)
        self._by_seam = {seam: tuple(n for n, w in self._watched.items() if seam in w.seams) for seam in seams}
