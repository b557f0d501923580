"""Which tests are missing?  `seek` for all that the paper's grid does not detect; its finds, on fresh seeds.

    python -m experiments.found [--output FILE]

Flies nothing.  `scaloft-fi seek` searched a copy of the study without `sim/found.yaml`, with seed 0 and a budget of
10,610 flights, and `scaloft-fi seek --replicate` flew its finds on fresh seeds; what each says of itself with
`--format json` is kept in `found_search.json` and `found_replication.json` of `results/published/`, the flights of both
in `found_flights.jsonl.gz`.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from experiments import ROOT
from experiments.flights import GRIDS, published, read
from experiments.pages import blocks, registered, table, write
from experiments.search_arms import survivors
from scaloft_fi.analysis.seeking import Effort, Replica, replicas
from scaloft_fi.campaign.seeking.finds import Sought
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.sim.grid import Evidence as Shown
from scaloft_fi.sim.grid import Find, Finds, read_finds
from scaloft_fi.study import Study
from scaloft_fi.verbs.seek import why_not


@dataclass(frozen=True)
class Evidence:
    """The published files.

    Attributes:
        study: the study with the paper's grid.
        finds: of the study: what held.
        search, replication: what the search and the replication say of themselves.
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
        found = []
        for one in self.search["finds"]:
            shows = {row["mutant"]: _shown(row) for row in one["shows"]}
            found.append(Find(one["name"], one["situation"], tuple(one["words"]), one["mutant"], shows, one["seed"]))
        return tuple(found)

    @cached_property
    def replicas(self) -> Sequence[Replica]:
        """Each pair of find and mutant, judged again from the published flights of the replication."""
        flown: dict[tuple[str, str], list[Outcome]] = {}
        for one in self.flights["replication"].values():
            flown.setdefault((one.mutant, one.situation), []).append(one)
        pairs = {(find.name, mutant): flown[mutant, find.situation] for find in self.found for mutant in find.shows}
        pools = {find.situation: flown[BASELINE, find.situation] for find in self.found}
        return replicas(self.found, pairs, pools, self.replication["first"], self.study.alpha)

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


END = "\n## Searched"
"""What follows the plan."""


def results(evidence: Evidence) -> str:
    """The sections with the results."""
    replicated = *_summary(evidence), _by_parameter(evidence), _finds(evidence)
    return blocks(_searched(evidence)) + blocks(*replicated) + blocks(_lacking(evidence))


def _searched(evidence: Evidence) -> Iterator[str]:
    search = evidence.search
    shown = sum(len(find.shows) for find in evidence.found)
    tested = [one for one in search["sought"] if one["candidates"]]
    yield "## Searched\n"
    yield f"The search took {search['wall_s'] / 60:.0f} min, {search['processor_s'] / 60:.0f} min of processor time, on"
    yield f"{search['jobs']} processors, for {search['flown']:,} flights."
    yield f"{len(evidence.found)} situations show {shown} of {len(evidence.survivors)} mutants."
    yield f"It tested {sum(one['candidates'] for one in tested)} candidates of"
    yield f"{len(tested)} mutants, which spent {sum(one['spent'] for one in tested):.2g} of alpha summed over all,"
    yield f"at most {max(one['spent'] for one in tested):.2g} of {search['alpha']:g} for one mutant."


def _summary(evidence: Evidence) -> Iterator[str | Iterable[str]]:
    total, held = len(evidence.study.roster.defaults), set(evidence.held)
    before, wide = total - len(evidence.survivors), set(evidence.survivors) - set(evidence.wide)
    least, most = evidence.left_out
    yield "## Replicated"
    yield f"""{len(evidence.flights["replication"])} flights on the seeds from {evidence.replication["first"]:,} on:
**{len(held)} of {len(evidence.replicas)} pairs hold**, in {len(evidence.finds.finds)} situations;
with any one seed left out of all of them {least if least == most else f"{least} to {most}"}."""
    rows = (
        (before, "the paper's 32 situations"),
        (f"**{before + len(held)}**", "these, and each of the others by its find alone, replicated"),
        (before + len(wide), "the paper's situations, and the wide grid (43 situations, three seeds)"),
        (before + len(wide | held), "all three"),
        (78, "as the first row but one, by the first search, whose finds nobody should use"),
        (52, "by those of its finds that were free of the faults above; none of them was replicated"),
    )
    yield table(("detected", "of", "by"), ((shown, total, by) for shown, by in rows))


def _by_parameter(evidence: Evidence) -> Iterator[str]:
    sought = Counter(mutant.split("@")[0].split("-")[1] for mutant in evidence.survivors)
    found = Counter(mutant.split("@")[0].split("-")[1] for mutant in evidence.held)
    yield from table(("parameter", "sought", "found"), ((name, n, found[name]) for name, n in sought.items()))


def _finds(evidence: Evidence) -> Iterator[str]:
    yield registered("found", "## The finds", "\n| situation")
    rows = []
    for one in evidence.replicas:
        find, again = next(find for find in evidence.found if find.name == one.find), one.again
        told = find.shows[one.mutant]
        place = find.situation if one.mutant == find.mutant else "same"
        shown = f"{told.requirement} {told.struck}".strip(), f"{told.violated}/{told.flights}"
        flown = f"{again.violated}/{again.flights}", f"{again.p:.1g}"
        clean = f"{again.held}/{again.baselines}", f"{again.mission}/{again.baselines}"
        rows.append((place, one.mutant, *shown, *flown, *clean, "yes" if one.holds else f"no: {one.why}"))
    head = ("situation", "mutant", "violates", "flights", "again", "p", "baseline", "mission", "holds")
    yield from table(head, rows)
    yield ""
    for find in evidence.found:
        yield f"- `{find.situation}`: {', '.join(find.words)}"


def _lacking(evidence: Evidence) -> Iterator[str]:
    left = [
        Sought(**{**one, "effort": Effort(**one["effort"])}) for one in evidence.search["sought"] if not one["shown_in"]
    ]
    wide = set(evidence.survivors) - set(evidence.wide)
    yield f"## Not found: {len(left)}"
    yield registered("found", "\nsituations: flown", "\n| mutant")
    rows = ((one.mutant, one.effort.situations, why_not(one), "yes" * (one.mutant in wide)) for one in left)
    yield from table(("mutant", "situations", "why", "wide"), rows)


def evidence(folder: Path) -> Evidence:
    """The evidence in a folder of published files."""
    paper, wide = (Study.open(ROOT, name) for name in GRIDS)
    search, replication = (
        json.loads((folder / f"found_{name}.json").read_text(encoding="utf-8")) for name in ("search", "replication")
    )
    return Evidence(
        study=paper,
        finds=read_finds(ROOT / "sim") or Finds("search", ()),
        search=search,
        replication=replication,
        flights=read(folder / "found_flights.jsonl.gz"),
        survivors=survivors(paper, published()),
        wide=survivors(wide, published("wide")),
    )


if __name__ == "__main__":
    write(__doc__, "found", lambda _study, _jobs, folder: results(evidence(folder)), end=END)
