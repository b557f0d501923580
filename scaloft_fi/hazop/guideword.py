"""The guidewords, which are applied to every parameter."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Guideword:
    """One way to deviate from the design intent.

    Attributes:
        id: the word as it stands in a mutant's id, capital letters.
        title: the word as people write it.
        meaning: which deviation it stands for.
        extension: True when it is not one of IEC 61882.
        reason: why an extension is needed, else empty.
    """

    id: str
    title: str
    meaning: str
    extension: bool = False
    reason: str = ""
