"""The parameters, to which the guidewords are applied."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """One quantity that flows through the stack, with its design intent.

    Attributes:
        id: the name as it stands in a mutant's id, small letters.
        title: the name as it is spoken.
        intent: the design intent every deviation is a deviation from.
        node: the stages of the stack between which it flows.
        unit: what it is measured in.
    """

    id: str
    title: str
    intent: str
    node: str
    unit: str
