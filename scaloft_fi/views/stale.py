"""Stored flights that no longer count: how many, why, and the command that flies them again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from scaloft_fi.views.outputs.shape import count, listing, optional, record, text

REASONS = 2
"""How many reasons a sentence names before it counts the rest."""
KEYS = {
    "stale": record(
        "the stored flights that no longer count and were not flown again",
        {
            "flights": count("how many"),
            "reasons": listing(
                "why they no longer count, the commonest reason first",
                record("one reason", {"why": text("the reason, in words"), "flights": count("how many")}),
            ),
            "command": optional(text("what flies them again"), "there are none that the study still has"),
        },
    )
}
"""What the forms of all verbs that read a campaign have besides."""


@dataclass(frozen=True)
class Stale:
    """The stored flights that no longer count and were not flown again.

    Attributes:
        why: number of them by reason; the commonest reason is first.
        command: what flies them again; empty where the study has none of them any more.
    """

    why: Mapping[str, int] = field(default_factory=dict)
    command: str = ""

    @property
    def values(self) -> dict[str, Any]:
        """Plain JSON values of `KEYS`."""
        reasons = [{"why": why, "flights": flights} for why, flights in self.why.items()]
        return {"stale": {"flights": sum(self.why.values()), "reasons": reasons, "command": self.command or None}}

    @property
    def sentences(self) -> tuple[str, ...]:
        """The same for people; empty when every flight counts.

        >>> Stale({"operator delay changed": 3}, "scaloft-fi run --mutant LATE-human@3s").sentences
        ('3 stored flights no longer count: operator delay changed; `scaloft-fi run --mutant LATE-human@3s` flies \
them again',)
        """
        if not self.why:
            return ()
        flights, counted = sum(self.why.values()), len(self.why) > 1
        reasons = [f"{why} ({number})" if counted else why for why, number in self.why.items()]
        rest = [f"{len(reasons) - REASONS} more reasons (`scaloft-fi status`)"] if len(reasons) > REASONS else []
        told = f"{flights} stored flight{'s' * (flights != 1)} no longer count{'s' * (flights == 1)}"
        again = f"`{self.command}` flies {'them' if flights != 1 else 'it'} again"
        ends = again if self.command else "the study has no such flight any more"
        return (f"{told}: {', '.join([*reasons[:REASONS], *rest])}; {ends}",)


NONE = Stale()
"""Every stored flight counts."""
