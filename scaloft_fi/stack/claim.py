"""Claims: what the stages of a stack believe of the world, held against the ground truth after a flight."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from scaloft_fi.stack.fields import Array, Point


@dataclass(frozen=True, eq=False)
class Instant:
    """A moment of a flight that violates a requirement, at the violation or before it.

    Attributes:
        signals: (T,) ground truth and beliefs by name, at 20 Hz from the start to this moment.
        sample: newest sample that the claim's seam delivered; None without one.
        place: (3,) centre of the vehicle when it violates the requirement [m, world].
        struck: name of what it strikes then; "" for nothing.
    """

    signals: Mapping[str, Array]
    sample: Any
    place: Point
    struck: str


@dataclass(frozen=True)
class Claim:
    """What a stage believes of the world; it decides no flight and no verdict, and tells who was wrong before one.

    Attributes:
        stage: the stage and what it believes, in a few words.
        unit: of the error.
        within: greatest error of a belief that is right [unit].
        error: how far the belief is from the truth [unit]; 0 where it says nothing.
        about: signals of the ground truth; the claim matters to a requirement that speaks of one of them, and to every
            requirement when there are none.
        seam: whose newest sample `error` needs; "" for none.

    Raises:
        ValueError: `within` is not positive.
    """

    stage: str
    unit: str
    within: float
    error: Callable[[Instant], float]
    about: tuple[str, ...] = ()
    seam: str = ""

    def __post_init__(self) -> None:
        if not self.within > 0.0:
            raise ValueError(f"claim {self.stage!r}: within={self.within:g} must be positive")
