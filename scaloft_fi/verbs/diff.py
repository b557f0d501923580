"""`scaloft-fi diff`: hold two campaigns against each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

from scaloft_fi.analysis.roster import Roster, by_field
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Facts, facts_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.names import campaigns
from scaloft_fi.verbs.options import Option
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output, count, listing, optional, record, text, texts
from scaloft_fi.views.table import Table

_FACTS = record(
    "what a campaign says of the flight",
    {
        "status": text("beside its baseline; of a baseline `held`, `violated` or `invalid`"),
        "ending": text("how the flight ended; empty when invalid"),
        "violated": texts("the violated requirements"),
    },
)
DIFF = Output(
    "diff",
    "1.0",
    "the flights of which two campaigns do not say the same",
    {
        "first": text("the first campaign, as it was named"),
        "second": text("the second campaign, as it was named"),
        "same": count("flights that are the same bit for bit"),
        "other_bits": count("flights with other bits and the same status, ending and violations"),
        "differences": listing(
            "the flights that differ, ordered by mutant, situation and seed",
            record(
                "one flight",
                {
                    "mutant": text("`baseline`, `PLACEBO` or the id of a mutant"),
                    "situation": text("key of the situation"),
                    "seed": count("seed of the flight"),
                    "first": optional(_FACTS, "the first campaign has no such flight"),
                    "second": optional(_FACTS, "the second campaign has no such flight"),
                },
            ),
        ),
    },
    rows="differences",
)


@dataclass(frozen=True)
class Difference:
    """A flight of which two campaigns do not say the same; None = the campaign does not have it."""

    mutant: str
    situation: str
    seed: int
    first: Facts | None
    second: Facts | None


@dataclass(frozen=True)
class Comparison:
    """Two campaigns beside each other.

    Attributes:
        same: flights of which both say the same, with the same bits.
        other_bits: flights of which both say the same, with other bits.
        differences: the rest, ordered by mutant, situation, seed.
    """

    same: int
    other_bits: int
    differences: tuple[Difference, ...]


def compare(first: Iterable[Outcome], second: Iterable[Outcome], roster: Roster, space: Space) -> Comparison:
    """Hold the flights of two campaigns, each flight once, against each other by mutant, situation and seed."""
    here, there = _said(first), _said(second)
    same = other_bits = 0
    differences = []
    for name in sorted(here.keys() | there.keys(), key=lambda n: (roster.rank(n[0]), space.rank(n[1]), n[2])):
        one, other = here.get(name), there.get(name)
        if one is None or other is None or one[0] != other[0]:
            differences.append(Difference(*name, one[0] if one else None, other[0] if other else None))
        elif one[1] == other[1]:
            same += 1
        else:
            other_bits += 1
    return Comparison(same, other_bits, tuple(differences))


def comparison_table(comparison: Comparison, first: str, second: str) -> Table:
    """The differences; `first` and `second` name the campaigns."""
    rows = tuple(
        (d.mutant, d.situation, d.seed, str(d.first) if d.first else "", str(d.second) if d.second else "")
        for d in comparison.differences
    )
    note = (
        f"{comparison.same} flights are the same bit for bit, {comparison.other_bits} more have the same status, "
        f"ending and violations; {len(rows)} differ."
    )
    return Table(f"{first} and {second}", ("mutant", "situation", "seed", first, second), rows, (note,))


def comparison_values(comparison: Comparison, first: str, second: str) -> dict[str, Any]:
    """Plain JSON values of the form `DIFF`; `first` and `second` name the campaigns."""
    return {"first": first, "second": second, **by_field(comparison)}


def _said(outcomes: Iterable[Outcome]) -> dict[tuple[str, str, int], tuple[Facts, str]]:
    listed = list(outcomes)
    facts = facts_of(listed)
    return {(o.mutant, o.situation, o.seed): (facts[o.name], o.digest) for o in listed}


Compared = Annotated[str, Option("Name of a campaign.", "", metavar="CAMPAIGN", complete=campaigns)]


def diff(study: Study, campaign: Compared, other: Compared) -> Answer:
    """The flights of which two campaigns do not say the same.

    What was flown with other data or code counts too, unless the campaign has the flight as the study describes it now.

    Raises:
        InputError: there is no such campaign, or the two were flown over different grids.
    """
    with snapshot(study, campaign) as here, snapshot(study, other) as there:
        if here.study.grid.name != there.study.grid.name:
            grids = here.study.grid.name, there.study.grid.name
            raise InputError(
                f"campaign {campaign!r} was flown over grid {grids[0]!r}, {other!r} over grid {grids[1]!r}; only "
                "campaigns of one grid have the same flights"
            )
        compared = compare(here.latest, there.latest, here.study.roster, here.study.space)
    return Answer(
        DIFF,
        lambda: comparison_values(compared, campaign, other),
        lambda: (comparison_table(compared, campaign, other),),
    )


diff_command = verb(
    "diff",
    examples=(
        ("Compare two campaigns", "scaloft-fi diff default night"),
        ("Compare with a folder from another machine", "scaloft-fi diff default /data/night/campaign"),
        ("Keep the comparison as a table in a document", "scaloft-fi diff default night --format markdown"),
    ),
)(diff)
