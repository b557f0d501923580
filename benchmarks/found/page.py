"""The page of the finds: what was found, each find flown alone, why the others were not found, false finds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from scaloft_fi.analysis.scoring.mutant_score import MutantScore
from scaloft_fi.analysis.scoring.pool import LEAST
from scaloft_fi.analysis.scoring.score import score
from scaloft_fi.analysis.seeking.effort import Effort
from scaloft_fi.campaign.runs.seeking.seek import Sought
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.sim.found import Find, Finds
from scaloft_fi.study import Study
from scaloft_fi.views.runs.seek import why_not

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
        study: the study with the finds beside the paper's grid.
        finds: of the study.
        search: what the search says of itself; empty before it was flown.
        false: what each search for the unmutated drone says of itself.
        again: the flights of the finds, flown again, by name.
        survivors: mutants that the paper's grid does not detect; wide: those that the wide grid does not detect.
    """

    study: Study
    finds: Finds
    search: Mapping[str, Any]
    false: Sequence[Mapping[str, Any]]
    again: Mapping[str, Outcome]
    survivors: Sequence[str]
    wide: Sequence[str]

    @property
    def shown(self) -> list[tuple[Find, str]]:
        """Each find with each mutant that it shows."""
        return [(find, mutant) for find in self.finds.finds for mutant in find.shows]

    @cached_property
    def alone(self) -> Mapping[tuple[str, str], MutantScore]:
        """The score of each mutant by the flights of one find alone, by name of the find and mutant."""
        scores: dict[tuple[str, str], MutantScore] = {}
        for find, mutant in self.shown:
            seeds = find.shows[mutant].flights
            most = {mutant: seeds, BASELINE: max(seeds, LEAST)}
            flown = [
                one
                for one in self.again.values()
                if one.situation == find.situation and one.seed < most.get(one.mutant, 0)
            ]
            own = score(flown, self.study.roster, self.study.space).mutants
            scores.update(((find.name, mutant), one) for one in own if one.subject.id == mutant)
        return scores

    @property
    def detected(self) -> list[str]:
        """The mutants that a find detects alone when it is flown again."""
        return [mutant for (_, mutant), scored in self.alone.items() if scored.detected]


def page(evidence: Evidence) -> str:
    """The page."""
    lines = [PLAN]
    if evidence.search:
        lines += [*_summary(evidence), "", *_by_parameter(evidence), "", *_finds(evidence), "", *_lacking(evidence)]
    if evidence.false:
        lines += ["", *_false(evidence.false)]
    return "\n".join(lines) + "\n"


def _summary(evidence: Evidence) -> Iterator[str]:
    search, total = evidence.search, len(evidence.study.roster.defaults)
    found, again = len(evidence.shown), len(evidence.detected)
    before = total - len(evidence.survivors)
    yield "## Found"
    yield ""
    yield f"The search took {search['wall_s'] / 60:.0f} min, {search['processor_s'] / 60:.0f} min of processor time, on"
    yield f"{search['jobs']} processors, for {search['flown']:,} flights with seed {search['seed']}; it began with an"
    yield f"empty store.  {len(evidence.finds.finds)} situations show {found} of {len(evidence.survivors)} mutants."
    yield ""
    yield "| detected | of | by |"
    yield "|---|---|---|"
    yield f"| {before} | {total} | the paper's 32 situations |"
    yield f"| **{before + again}** | {total} | these, and each of the others by its find alone, flown again |"
    wide = set(evidence.survivors) - set(evidence.wide)
    yield f"| {before + len(wide)} | {total} | the paper's situations, and the wide grid (43 situations, three seeds) |"
    yield f"| {before + len(wide | set(evidence.detected))} | {total} | all three |"
    yield ""
    yield f"{found - again} of {found} were not detected again; {_equal(evidence)} violated as often as in the search."


def _equal(evidence: Evidence) -> int:
    """Finds that violate as often when they are flown again."""
    same = 0
    for find, mutant in evidence.shown:
        told = find.shows[mutant]
        flown = [
            one
            for one in evidence.again.values()
            if (one.mutant, one.situation) == (mutant, find.situation) and one.seed < told.flights
        ]
        violated = sum(any(own.requirement == told.requirement for own in one.violations) for one in flown)
        same += (violated, len(flown)) == (told.violated, told.flights)
    return same


def _by_parameter(evidence: Evidence) -> Iterator[str]:
    sought = Counter(mutant.split("@")[0].split("-")[1] for mutant in evidence.survivors)
    found = Counter(mutant.split("@")[0].split("-")[1] for mutant in evidence.detected)
    yield from _table(
        ("parameter", "sought", "found"), ((name, number, found[name]) for name, number in sought.items())
    )


def _finds(evidence: Evidence) -> Iterator[str]:
    yield "## The finds"
    yield ""
    yield "flights: violating of the confirming ones; alone: the score's verdict on the find's flights, flown again."
    yield ""
    rows = []
    for find, mutant in evidence.shown:
        told, scored = find.shows[mutant], evidence.alone.get((find.name, mutant))
        rows.append(
            (
                find.situation if mutant == find.mutant else "same",
                mutant,
                f"{told.requirement} {told.struck}".strip(),
                f"{told.violated}/{told.flights}",
                f"{told.p:.1g}",
                f"{told.held}/{told.baselines}",
                scored.verdict.value if scored else "not flown",
            )
        )
    yield from _table(("situation", "mutant", "violates", "flights", "p", "baselines", "alone"), rows)
    yield ""
    for find in evidence.finds.finds:
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


def _false(searches: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    found = sum(bool(one["finds"]) for one in searches)
    yield "## False finds"
    yield ""
    yield f"{len(searches)} searches for the unmutated drone under other seeds, treated as a mutant, each with a seed"
    yield f"of its own: **{found}** found anything."
    yield ""
    rows = (
        (one["seed"], one["used"], own["effort"]["situations"], own["effort"]["showed"], own["candidates"])
        for one in searches
        for own in one["sought"]
    )
    yield from _table(("seed", "flights", "situations", "violated with the first seed", "candidates"), rows)


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> Iterator[str]:
    for row in (head, ["---"] * len(head), *rows):
        yield f"| {' | '.join(map(str, row))} |"
