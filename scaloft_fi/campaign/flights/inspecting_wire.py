"""A wire that watches every poll of every seam, and says what is not as the stack declares it."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from scaloft_fi.stack.declaration import Declaration, Seam

S = TypeVar("S")

LEAST_POLLS = 0.9
"""A seam is polled at its rate if it is polled at this share of its ticks or steps; a stack may begin late."""


@dataclass
class _Polls:
    """What was seen on one seam."""

    seam: Seam
    count: int = 0
    carried: int = 0
    last_s: float = -math.inf
    twice_s: float | None = None
    wrong: str = ""
    written: bool = False
    kept: Any = None
    copied: Any = None


class InspectingWire:
    """Carries every sample as it is, listens on every seam, and watches each poll."""

    def __init__(self, declared: Declaration) -> None:
        self._polls = {seam.name: _Polls(seam) for seam in declared.seams}
        self._strange: dict[str, None] = {}

    def listens(self, seam: str) -> bool:
        """Everywhere."""
        return True

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample`."""
        polls = self._polls.get(seam)
        if polls is None:
            self._strange[seam] = None
            return sample
        if t_s <= polls.last_s and polls.twice_s is None:
            polls.twice_s = t_s
        polls.count, polls.last_s = polls.count + 1, t_s
        polls.carried += sample is not None
        if polls.kept is not None and polls.seam.differ(polls.kept, polls.copied):
            polls.written = True
        polls.kept, polls.copied = sample, copy.deepcopy(sample)
        if sample is not None and not isinstance(sample, polls.seam.message):
            polls.wrong = type(sample).__name__
        return sample

    @property
    def silent(self) -> tuple[str, ...]:
        """The seams that are polled and carried no sample."""
        return tuple(name for name, polls in self._polls.items() if polls.count and not polls.carried)

    @property
    def polled(self) -> int:
        """Number of declared seams that are polled."""
        return sum(polls.count > 0 for polls in self._polls.values())

    def complaints(self, duration_s: float) -> list[str]:
        """A sentence for each thing that is not as declared."""
        from scaloft_fi.stack.declaration import TICK_HZ

        sentences = [f"seam {name!r} is used, but not declared" for name in self._strange]
        for name, polls in self._polls.items():
            due = duration_s * polls.seam.rate_hz
            if not polls.count:
                sentences.append(f"seam {name!r} is declared, but never polled")
            elif polls.twice_s is not None:
                sentences.append(f"seam {name!r} is polled twice for the time {polls.twice_s:g} s")
            elif polls.count < LEAST_POLLS * due - 1.0 or polls.count > due + polls.seam.rate_hz / TICK_HZ + 1.0:
                rate_hz = polls.count / duration_s
                sentences.append(
                    f"seam {name!r} declares rate_hz={polls.seam.rate_hz:g}, but is polled {rate_hz:.3g} times a second"
                )
            if polls.wrong:
                sentences.append(
                    f"seam {name!r} declares the message {polls.seam.message.__name__}, but carries {polls.wrong}"
                )
            if polls.written:
                sentences.append(f"a sample of seam {name!r} is written to after it was sent; send a new one")
        return sentences
