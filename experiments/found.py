"""Which tests are missing?  `seek` for all that the paper's grid does not detect; its finds, on fresh seeds.

    python -m experiments.found --search [--budget 10610flights] [--seed 0] [--jobs N]
    python -m experiments.found --replicate [--jobs N]
    python -m experiments.found [--output FILE]

`--search` searches a copy of the study without finds, and writes the finds into `sim/found.yaml` and what it says of
itself into `results/published/found_search.json`; give it an empty `--campaigns` to time it.  `--replicate` flies the
finds of `sim/found.yaml` on fresh seeds, keeps those that hold, and writes `found_replication.json`.  Their flights are
published as `found_flights.jsonl.gz`.  Each writes the page from these files; without an option nothing is flown.
"""

from __future__ import annotations

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

import json
import resource
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from experiments import ROOT
from experiments.flights import GRIDS, published, read, stored, write
from experiments.pages import blocks, parser, registered, table
from experiments.search_arms import survivors
from scaloft_fi.analysis.seeking import Effort, Replica, replicas
from scaloft_fi.campaign.seeking.finds import Sought
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.sim.grid import Evidence as Shown
from scaloft_fi.sim.grid import Find, Finds, read_finds
from scaloft_fi.study import Study
from scaloft_fi.verbs.seek import why_not

PARTS = ("hazop", "mutants", "sim")
FILE = "found.yaml"
GRID = "search"
Record = dict[str, Any]


@dataclass(frozen=True)
class Place:
    """Where the flights are.

    Attributes:
        folder: holds a campaign for the search and one for the replication of its finds.
        jobs: number of processes.
    """

    folder: Path
    jobs: int

    @property
    def study(self) -> Path:
        """A copy of the study without finds, made where it is missing."""
        copy = self.folder / "study"
        if not copy.exists():
            for part in PARTS:
                shutil.copytree(ROOT / part, copy / part)
            (copy / "sim" / FILE).unlink(missing_ok=True)
        return copy

    def call(self, study: Path, *words: str) -> str:
        """The output of `scaloft-fi WORDS`."""
        call = [sys.executable, "-m", "scaloft_fi", *words, "--study", str(study), "--jobs", str(self.jobs)]
        return subprocess.run(call, cwd=ROOT, stdout=subprocess.PIPE, check=True).stdout.decode()


def search(place: Place, mutants: Sequence[str], budget: str, seed: int) -> Record:
    """Search for mutants, and take the finds over into the study of the checkout; what the search says of itself."""
    words = ("seek", *mutants, "--grid", GRID, "--into", str(place.folder / "search"), "--seed", str(seed))
    begin_s, before_s = time.monotonic(), _processor_s()
    report = json.loads(place.call(place.study, *words, "--budget", budget, "--format", "json"))
    took = {"wall_s": round(time.monotonic() - begin_s), "processor_s": round(_processor_s() - before_s)}
    shutil.copyfile(place.study / "sim" / FILE, ROOT / "sim" / FILE)
    return {"budget": budget, "seed": seed, "jobs": place.jobs, **took, **report}


def replicate(place: Place) -> Record:
    """Fly the finds of the checkout on fresh seeds, and keep those that hold; what the replication says of itself."""
    where = ("--grid", GRID, "--into", str(place.folder / "replication"))
    record: Record = json.loads(place.call(ROOT, "seek", "--replicate", *where, "--quiet", "--format", "json"))
    return record


def _processor_s() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


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
    text = registered("found", end="\n## Searched")
    if evidence.search:
        text += blocks(_searched(evidence))
    if evidence.replication:
        text += blocks(_summary(evidence), _by_parameter(evidence), _finds(evidence))
    return text + blocks(_lacking(evidence)) if evidence.search else text


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


FLIGHTS = "found_flights.jsonl.gz"


def evidence(folder: Path) -> Evidence:
    """The evidence in a folder of published files."""
    paper, wide = (Study.open(ROOT, name) for name in GRIDS)
    return Evidence(
        study=paper,
        finds=read_finds(ROOT / "sim") or Finds(GRID, ()),
        search=_read(folder / "found_search.json"),
        replication=_read(folder / "found_replication.json"),
        flights=read(folder / FLIGHTS),
        survivors=survivors(paper, published()),
        wide=survivors(wide, published("wide")),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, or write the page."""
    asked = parser(__doc__, "found")
    what = asked.add_mutually_exclusive_group()
    what.add_argument("--search", action="store_true", help="search for the mutants")
    what.add_argument("--replicate", action="store_true", help="fly the finds on fresh seeds")
    asked.add_argument("--budget", default="10610flights", help="of the search (default: 10610flights)")
    asked.add_argument("--seed", type=int, default=0, help="of the search (default: 0)")
    asked.add_argument("--campaigns", type=Path, default=ROOT / "results" / "campaigns" / "found")
    options = asked.parse_args(arguments)
    place, folder = Place(options.campaigns, options.jobs), options.output.parent
    if options.search:
        sought = survivors(Study.open(ROOT), published())
        _publish(folder, "search", place, search(place, sought, options.budget, options.seed))
    if options.replicate:
        _publish(folder, "replication", place, replicate(place))
    options.output.write_text(page(evidence(folder)), encoding="utf-8")


def _publish(folder: Path, name: str, place: Place, record: Record) -> None:
    (folder / f"found_{name}.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    write(folder / FLIGHTS, read(folder / FLIGHTS) | {name: stored(Study.open(ROOT, GRID), place.folder / name)})


def _read(path: Path) -> Record:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


if __name__ == "__main__":
    main()
