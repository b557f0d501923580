"""`scaloft-fi diff`: hold two campaigns against each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Facts, facts_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.names import campaigns
from scaloft_fi.verbs.options import Option
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table


@dataclass(frozen=True)
class Difference:
    """One flight.

    Attributes:
        mutant: `baseline`, `PLACEBO` or the id of a mutant.
        situation: key of the situation.
        seed: seed of the flight.
        first: what the first campaign says of it; null: the first campaign has no such flight.
        second: what the second campaign says of it; null: the second campaign has no such flight.
    """

    mutant: str
    situation: str
    seed: int
    first: Facts | None
    second: Facts | None


@dataclass(frozen=True)
class Comparison:
    """The flights of which two campaigns do not say the same.

    Attributes:
        first: the first campaign, as it was named.
        second: the second campaign, as it was named.
        same: flights that are the same bit for bit.
        other_bits: flights with other bits and the same status, ending and violations.
        differences: the flights that differ, ordered by mutant, situation and seed.
    """

    first: str
    second: str
    same: int
    other_bits: int
    differences: tuple[Difference, ...]


DIFF = Output("diff", "1.0", Comparison, rows="differences")


def compare(
    names: tuple[str, str], first: Iterable[Outcome], second: Iterable[Outcome], roster: Roster, space: Space
) -> Comparison:
    """Hold the flights of two campaigns, each flight once, against each other by mutant, situation and seed."""
    here, there = _said(first), _said(second)
    equal: Counter[bool] = Counter()
    differences = []
    for name in sorted(here.keys() | there.keys(), key=lambda n: (roster.rank(n[0]), space.rank(n[1]), n[2])):
        (one, bits), (other, other_bits) = here.get(name, _LACKING), there.get(name, _LACKING)
        if one != other:
            differences.append(Difference(*name, one, other))
        else:
            equal[bits == other_bits] += 1
    return Comparison(*names, equal[True], equal[False], tuple(differences))


def comparison_table(told: Comparison) -> Table:
    """The differences."""
    rows = tuple(
        (one.mutant, one.situation, one.seed, str(one.first or ""), str(one.second or "")) for one in told.differences
    )
    note = (
        f"{told.same} flights are the same bit for bit, {told.other_bits} more have the same status, "
        f"ending and violations; {len(rows)} differ."
    )
    title, headers = f"{told.first} and {told.second}", ("mutant", "situation", "seed", told.first, told.second)
    return Table(title, headers, rows, (note,))


_LACKING: tuple[Facts | None, str] = None, ""


def _said(outcomes: Iterable[Outcome]) -> dict[tuple[str, str, int], tuple[Facts | None, str]]:
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
        told = compare((campaign, other), here.latest, there.latest, here.study.roster, here.study.space)
    return Answer(DIFF, lambda: told, lambda: (comparison_table(told),))


diff_command = verb(
    "diff",
    examples=(
        ("Compare two campaigns", "scaloft-fi diff default night"),
        ("Compare with a folder from another machine", "scaloft-fi diff default /data/night/campaign"),
        ("Keep the comparison as a table in a document", "scaloft-fi diff default night --format markdown"),
    ),
)(diff)
