"""Stored flights that no longer count: how many, why, and the command that flies them again."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scaloft_fi.analysis.scoring.pool import LEAST
from scaloft_fi.campaign.runs.choice import remembered
from scaloft_fi.campaign.store.held import stale_in
from scaloft_fi.campaign.store.selection import Flown
from scaloft_fi.hazop.name import cell_of
from scaloft_fi.judge.outcome import BASELINE, PLACEBO
from scaloft_fi.mutants.derive import defaults
from scaloft_fi.sim.grid import ALL
from scaloft_fi.views.outputs.shape import count, listing, optional, record, text
from scaloft_fi.views.score.commands import MOST_NAMED, in_campaign

if TYPE_CHECKING:
    from scaloft_fi.analysis.roster import Roster
    from scaloft_fi.views.snapshot import Snapshot

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


def stale_of(now: Snapshot) -> Stale:
    """The stale flights of a campaign."""
    found = stale_in(now.now, now.store)
    return Stale(found.why, _again(now, found.flown) if found.flown else "")


def _again(now: Snapshot, stale: Sequence[Flown]) -> str:
    """The `run` that flies these flights; of what it asks for besides, the campaign holds the flights that count."""
    held = now.store.flights()
    study, known = now.study, {flight.mutant for flight in held}
    asking = stale if _mutants(stale, study.roster) else held  # baselines alone are flown again beside their mutants
    mutants = _mutants(asking, study.roster) or [PLACEBO]
    seeds = {flight.seed for flight in asking if flight.mutant in mutants} or {flight.seed for flight in stale}
    pool = {flight.seed for flight in stale if flight.mutant == BASELINE}
    words = [f"scaloft-fi run{in_campaign(now.name)}"]
    ids = {mutant.id for mutant in defaults(study.matrix)}
    if len(mutants) <= MOST_NAMED or not (ids.issuperset(mutants) and known.issuperset(ids)):
        words += [f"--mutant {shlex.quote(id_)}" for id_ in mutants]
    words += _situations(now, {flight.situation for flight in stale}, {flight.situation for flight in held})
    words += [] if seeds == {0} else [f"--seeds {_range(seeds)}"]
    words += [f"--baseline-seeds {_range(pool)}"] if pool - seeds - set(range(LEAST)) else []
    return " ".join(words)


def _mutants(flights: Sequence[Flown], roster: Roster) -> list[str]:
    """The mutants among `flights`, in the canonical order; a control that was flown once comes with every run."""
    flown = Counter(flight.mutant for flight in flights)
    canaries = {id_ for id_, number in flown.items() if number == 1 and cell_of(id_) in roster.controls}
    return sorted(flown.keys() - canaries - {BASELINE, PLACEBO}, key=roster.rank)


def _situations(now: Snapshot, stale: Collection[str], held: Collection[str]) -> list[str]:
    """The options that choose these situations, among others of which the campaign holds flights."""
    grid = now.study.grid
    if grid.choose == ALL and set(grid.by_key) <= set(held):
        return []
    for one in remembered(now.store):
        if len(stale) > MOST_NAMED and {key for key, _ in one.draws}.issuperset(stale):
            return [f"--choose {shlex.quote(one.text)}", *([f"--choose-seed {one.seed}"] if one.seed else [])]
    return [f"--situation {shlex.quote(key)}" for key in sorted(stale, key=now.study.space.rank)]


def _range(seeds: Collection[int]) -> str:
    """The seeds as `--seeds` takes them, with those between."""
    least, most = min(seeds), max(seeds)
    return f"{least}-{most}" if least else str(most + 1)
