"""The page of the finds: what was found, what held on fresh seeds, and why the others were not found."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from scaloft_fi.analysis.seeking import Effort, Replica, replicas
from scaloft_fi.campaign.seeking.seek import Sought
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.sim.found import Evidence as Shown
from scaloft_fi.sim.found import Find, Finds
from scaloft_fi.study import Study
from scaloft_fi.verbs.seek import why_not

PLAN = """# Which tests are missing?

This is the second search; its rules were committed before its first flight.

**Why again.**  The first search (10,610 flights) showed 46 of 82 mutants by 22 situations, 78 of 114 detected with the
paper's grid.  In twelve of the 22 the unmutated drone does not do its own mission, in six a value of an axis does not
come true; charge at take-off, drift per metre flown and the belt conveyor went beyond what their sources say, or were
put there with verdicts in sight; and it was "flown again" on its own seeds, which replicates nothing.  Ten situations,
20 mutants (52 of 114) were free of all that.

**Question.**  For how many of the 82 default mutants that the paper's grid does not detect (three seeds, pool of ten)
is there a situation that an engineer would accept, which shows the mutant on seeds that nothing before used?

**Search.**  `scaloft-fi seek` for all 82, in the order of the matrix, over `sim/grids/search.yaml`, seed 0, empty
store, 10,610 flights: as many as the first search.  A situation counts only where nine of ten baselines hold each
operability requirement and meet the value of each axis.  A candidate spends its share of alpha before its pool is
looked at.

**Replication.**  `scaloft-fi seek --replicate`: each pair of find and mutant on ten seeds of the mutant and thirty of
the baseline, from seed 100,000 on, which no other flight uses.  A pair holds where the requirement of the find is
steady in the thirty, the mission is done in nine of ten of them, and the exact p of that one requirement passes
Holm's test over all pairs at alpha 0.01.  Only what holds is a find, whatever its number; the rest leaves
`sim/found.yaml`.

**Arms.**  One: all 82.  Nothing is flown a second time for a better result.
"""


@dataclass(frozen=True)
class Evidence:
    """The published files.

    Attributes:
        study: the study with the paper's grid.
        finds: of the study: what held.
        search: what the search says of itself; empty before it was flown.
        replication: what the replication says of itself; empty before it was flown.
        flights: of both, by arm and name.
        survivors: mutants that the paper's grid does not detect; wide: those that the wide grid does not detect.
    """

    study: Study
    finds: Finds
    search: Mapping[str, Any]
    replication: Mapping[str, Any]
    flights: Mapping[str, Mapping[str, Outcome]]
    survivors: Sequence[str]
    wide: Sequence[str]

    @cached_property
    def found(self) -> tuple[Find, ...]:
        """What the search found, before the replication."""
        return tuple(
            Find(
                **{key: one[key] for key in ("name", "situation", "mutant", "seed")},
                words=tuple(one["words"]),
                shows={row["mutant"]: _shown(row) for row in one["shows"]},
            )
            for one in self.search["finds"]
        )

    @cached_property
    def replicas(self) -> Sequence[Replica]:
        """Each pair of find and mutant, judged again from the published flights of the replication."""
        flown = list(self.flights.get("replication", {}).values())
        pairs = {
            (find.name, mutant): [one for one in flown if (one.mutant, one.situation) == (mutant, find.situation)]
            for find in self.found
            for mutant in find.shows
        }
        pools: dict[str, list[Outcome]] = {find.situation: [] for find in self.found}
        for one in flown:
            if one.mutant == BASELINE:
                pools[one.situation].append(one)
        first = self.replication["first"]
        return replicas(self.found, pairs, pools, first, self.study.alpha) if flown else ()

    @property
    def held(self) -> list[str]:
        """The mutants that a find shows after the replication."""
        return [one.mutant for one in self.replicas if one.holds]

    @cached_property
    def left_out(self) -> tuple[int, int]:
        """Least and greatest number of pairs that hold when one seed is left out of all flights of the replication."""
        flown = self.flights["replication"]
        counts = []
        for seed in sorted({one.seed for one in flown.values()}):
            rest = {name: one for name, one in flown.items() if one.seed != seed}
            counts.append(len(replace(self, flights={"replication": rest}).held))
        return min(counts), max(counts)


def _shown(row: Mapping[str, Any]) -> Shown:
    return Shown(**{key: value for key, value in row.items() if key not in ("mutant", "again")})


def page(evidence: Evidence) -> str:
    """The page."""
    lines = [PLAN]
    if evidence.search:
        lines += [*_searched(evidence)]
    if evidence.replication:
        lines += ["", *_summary(evidence), "", *_by_parameter(evidence), "", *_finds(evidence)]
    if evidence.search:
        lines += ["", *_lacking(evidence)]
    return "\n".join(lines) + "\n"


def _searched(evidence: Evidence) -> Iterator[str]:
    search = evidence.search
    shown = sum(len(find.shows) for find in evidence.found)
    tested = [one for one in search["sought"] if one["candidates"]]
    yield "## Searched"
    yield ""
    yield f"The search took {search['wall_s'] / 60:.0f} min, {search['processor_s'] / 60:.0f} min of processor time, on"
    yield f"{search['jobs']} processors, for {search['flown']:,} flights."
    yield f"{len(evidence.found)} situations show {shown} of {len(evidence.survivors)} mutants."
    yield f"It tested {sum(one['candidates'] for one in tested)} candidates of"
    yield f"{len(tested)} mutants, which spent {sum(one['spent'] for one in tested):.2g} of alpha summed over all,"
    yield f"at most {max(one['spent'] for one in tested):.2g} of {search['alpha']:g} for one mutant."


def _summary(evidence: Evidence) -> Iterator[str]:
    total, held = len(evidence.study.roster.defaults), set(evidence.held)
    before = total - len(evidence.survivors)
    least, most = evidence.left_out
    yield "## Replicated"
    yield ""
    yield f"{len(evidence.flights['replication'])} flights on the seeds from {evidence.replication['first']:,} on:"
    yield f"**{len(held)} of {len(evidence.replicas)} pairs hold**, in {len(evidence.finds.finds)} situations;"
    yield f"with any one seed left out of all of them {least if least == most else f'{least} to {most}'}."
    yield ""
    yield "| detected | of | by |"
    yield "|---|---|---|"
    yield f"| {before} | {total} | the paper's 32 situations |"
    yield f"| **{before + len(held)}** | {total} | these, and each of the others by its find alone, replicated |"
    wide = set(evidence.survivors) - set(evidence.wide)
    yield f"| {before + len(wide)} | {total} | the paper's situations, and the wide grid (43 situations, three seeds) |"
    yield f"| {before + len(wide | held)} | {total} | all three |"
    yield f"| 78 | {total} | as the first row but one, by the first search, whose finds nobody should use |"
    yield f"| 52 | {total} | by those of its finds that were free of the faults above; none of them was replicated |"


def _by_parameter(evidence: Evidence) -> Iterator[str]:
    sought = Counter(mutant.split("@")[0].split("-")[1] for mutant in evidence.survivors)
    found = Counter(mutant.split("@")[0].split("-")[1] for mutant in evidence.held)
    yield from _table(
        ("parameter", "sought", "found"), ((name, number, found[name]) for name, number in sought.items())
    )


def _finds(evidence: Evidence) -> Iterator[str]:
    yield "## The finds"
    yield ""
    yield "flights: violating of those that confirmed it in the search; again: of those of the replication; p: of the"
    yield "replication; baseline, mission: of its thirty baselines those that hold the requirement by more than their"
    yield "spread, and those that do the mission."
    yield ""
    rows = []
    for one in evidence.replicas:
        find = next(find for find in evidence.found if find.name == one.find)
        told = find.shows[one.mutant]
        rows.append(
            (
                find.situation if one.mutant == find.mutant else "same",
                one.mutant,
                f"{told.requirement} {told.struck}".strip(),
                f"{told.violated}/{told.flights}",
                f"{one.again.violated}/{one.again.flights}",
                f"{one.again.p:.1g}",
                f"{one.again.held}/{one.again.baselines}",
                f"{one.again.mission}/{one.again.baselines}",
                "yes" if one.holds else f"no: {one.why}",
            )
        )
    head = ("situation", "mutant", "violates", "flights", "again", "p", "baseline", "mission", "holds")
    yield from _table(head, rows)
    yield ""
    for find in evidence.found:
        yield f"- `{find.situation}`: {', '.join(find.words)}"


def _lacking(evidence: Evidence) -> Iterator[str]:
    left = [
        Sought(**{**one, "effort": Effort(**one["effort"])}) for one in evidence.search["sought"] if not one["shown_in"]
    ]
    wide = set(evidence.survivors) - set(evidence.wide)
    yield f"## Not found: {len(left)}"
    yield ""
    yield "situations: flown with one seed, where the unmutated drone holds a safety requirement with room.  wide:"
    yield "whether the wide grid detects the mutant."
    yield ""
    yield from _table(
        ("mutant", "situations", "why", "wide"),
        ((one.mutant, one.effort.situations, why_not(one), "yes" * (one.mutant in wide)) for one in left),
    )


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> Iterator[str]:
    for row in (head, ["---"] * len(head), *rows):
        yield f"| {' | '.join(map(str, row))} |"
