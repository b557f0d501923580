"""The finds of a study, for the verbs that read results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scaloft_fi.console import say

if TYPE_CHECKING:
    from scaloft_fi.sim.known_finds import KnownFinds


def told(finds: KnownFinds) -> KnownFinds:
    """The finds of a study, after a warning of those that do not fit it any more."""
    for sentence in finds.warnings:
        say(f"warning: {sentence}")
    return finds
