r"""Write the published tables of the paper's rows and of the sources of all numbers.

    scaloft-fi run --campaign paper --seeds 3 --mutant 'LATE-human*' --mutant 'MORE-goal*' \
        --mutant UNINTENDED-collision@20s --mutant 'UNINTENDED-collision@20s#*s'
    scaloft-fi run --campaign paper --seeds 3 --situation '*D0*' \
        $(printf -- '--mutant UNINTENDED-collision@20s#%ss ' 2.5 7.5 12.5 17.5)
    scaloft-fi export --campaign paper --format csv --output results/published/paper.csv
    python -m experiments.published

Writes `paper_table.md` and `parameters.md` into `results/published/`.  The verdicts use the baseline pool of the
reference campaign.
"""

from __future__ import annotations

import csv
import fnmatch
import statistics
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import starmap

from scipy.stats import binomtest

from experiments import PUBLISHED, ROOT
from experiments.false_detections import baselines
from experiments.pages import blocks, registered, table
from scaloft_fi.analysis.detection import Detection, Pool, Sample, Spending, State, detect, firmness
from scaloft_fi.document import load
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import select
from scaloft_fi.study import Study

PULSE, PERIOD_S = "UNINTENDED-collision@20s", 20.0
LIGHT = "*D0*"
Flight = dict[str, str]


@dataclass(frozen=True)
class Row:
    """A row of the paper's table and the mutants that represent it."""

    name: str
    paper: str
    requirement: str
    predicted: str
    mutants: tuple[str, ...]
    light: str


@dataclass(frozen=True)
class Shown:
    """The results of one mutant.

    Attributes:
        flights: flights of the mutant, by situation and seed.
        detection: verdict by safety requirements.
        verdict: in words, and of a mutant that is detected what remains when one seed is left out.
        tested: situations in which the row's requirement is steady and the mutant infects.
        kills: tested situations in which most flights violate the requirement; empty unless the mutant is detected.
    """

    flights: Sequence[Flight]
    detection: Detection
    verdict: str
    tested: tuple[str, ...]
    kills: tuple[str, ...]


def rows(study: Study) -> list[Row]:
    """The rows of `results/published/predictions.yaml`; they speak of faults that strike at times."""
    found = []
    for name, item in load(PUBLISHED / "predictions.yaml").need("rows").mapping().items():
        patterns = [pattern.text() for pattern in item.need("mutants")]
        chosen = select(patterns, study.matrix, study.catalogue)
        mutants = tuple(mutant.id for mutant in chosen if not mutant.event)
        texts = {key: item.need(key).text() for key in ("paper", "requirement", "predicted", "light")}
        found.append(Row(name=name, mutants=mutants, **texts))
    return found


def shown(row: Row, mutant: str, flights: Sequence[Flight], pool: Pool, spending: Spending) -> Shown:
    """The results of a mutant beside the pool."""
    own = [flight for flight in flights if flight["mutant"] == mutant]
    situations: dict[str, list[Flight]] = {}
    for flight in own:
        situations.setdefault(flight["situation"], []).append(flight)
    samples = [
        Sample(
            key, tuple(map(violated, some)), any(f["infected_at_s"] for f in some), tuple(int(f["seed"]) for f in some)
        )
        for key, some in situations.items()
    ]
    detection = detect(mutant, samples, pool, spending, Kind.SAFETY)
    remains = f", {firmness(mutant, samples, pool, spending, Kind.SAFETY).words}" if detection.detected else ""
    steady = {place for place, state in pool.states.items() if state is State.STEADY}
    tested = [s for s in samples if s.infected and (s.situation, row.requirement) in steady]
    most = [s.situation for s in tested if 2 * s.count(row.requirement) > len(s.violated)]
    verdict, keys = detection.verdict.words + remains, tuple(sample.situation for sample in tested)
    return Shown(own, detection, verdict, keys, tuple(most) if detection.detected else ())


def violated(flight: Flight) -> tuple[str, ...]:
    """The requirements that the flight violates."""
    return tuple(flight["violated"].split(";"))


def revealed(flights: Iterable[Flight], requirement: str) -> list[Flight]:
    """The flights in which the requirement reveals the fault."""
    return [f for f in flights if f["status"] == "revealed" and requirement in violated(f)]


DETAIL = """
## {name}: {predicted}

`rho` is the robustness of {requirement}; below 0 it is violated.  Told of situations that test the mutant by it: steady
in the pool, and the fault changed a sample.

| mutant | verdict | p | light: revealed, per seed | kills in light | in dark | median change of rho, light | least |
|---|---|---|---|---|---|---|---|
"""


def page(study: Study, flights: Sequence[Flight]) -> str:
    """The page: the paper's table beside ours, caveats, each row in detail, and the phases."""
    pool_flights = baselines(study)
    pool, spending = Pool.of(pool_flights), Spending(study.alpha)
    seeds = sorted({f["seed"] for f in flights}, key=int)
    found = {row: [shown(row, mutant, flights, pool, spending) for mutant in row.mutants] for row in rows(study)}
    pool_seeds = len({outcome.seed for outcome in pool_flights})
    told = ((row.name, row.paper, row.predicted, ours(row, mutants)) for row, mutants in found.items())
    text = registered("paper_table", end="\n| row") + blocks(table(("row", "paper", "prediction", "ours"), told))
    text += registered("paper_table", "\n## What to know before", "\n## LATE")
    for row, mutants in found.items():
        text += DETAIL.format(name=row.name, predicted=row.predicted, requirement=row.requirement)
        text += "".join(line(row, one, flights, seeds) + "\n" for one in mutants)
        own = [flight for one in mutants for flight in one.flights if fnmatch.filter([flight["situation"]], row.light)]
        seen = sorted(revealed(own, row.requirement), key=lambda f: float(f["violated_at_s"]))
        text += "\nWhere the fault is revealed in light, earliest first (at most 12):\n\n"
        text += "".join(f"- {moment(f)}\n" for f in seen[:12]) or "- nowhere\n"
    clean = [outcome for outcome in pool_flights if fnmatch.filter([outcome.situation], LIGHT)]
    struck = sum(any(v.requirement == "SR1" for v in outcome.violations) for outcome in clean)
    return text + phases(flights) + f"| light baselines, {pool_seeds} seeds | {counted(struck, len(clean))} |\n"


def ours(row: Row, mutants: Sequence[Shown]) -> str:
    """The result of a row as a cell of the table."""
    own = [flight for one in mutants for flight in one.flights if fnmatch.filter([flight["situation"]], row.light)]
    detected = [one for one in mutants if row.requirement in one.detection.by]
    text = f"{len(detected)} of {len(mutants)} mutants detected by {row.requirement}"
    killing = [len(fnmatch.filter(one.kills, row.light)) for one in detected]
    if killing:
        text += f", with kills in {min(killing)} to {max(killing)} light situations"
    return f"{text}; {len(revealed(own, row.requirement))} of {len(own)} light flights revealed by it"


def moment(flight: Flight) -> str:
    """Requirement, time and place of a flight's first violation."""
    place = f"({float(flight['x']):.2f}, {float(flight['y']):.2f}, {float(flight['z']):.2f}) m"
    struck = f", struck {flight['struck']}" if flight["struck"] else ""
    name = f"`{flight['mutant']}/{flight['situation']}/{flight['seed']}`"
    return f"{name} at {float(flight['violated_at_s']):.2f} s, {place}{struck}"


def line(row: Row, one: Shown, flights: Sequence[Flight], seeds: Sequence[str]) -> str:
    """The table row of a mutant: verdict, flights by seed, kills, change of robustness."""
    clean = {(f["situation"], f["seed"]): f for f in flights if f["mutant"] == "baseline"}
    column = f"rho_{row.requirement}"
    tested = fnmatch.filter(one.tested, row.light)
    own = [f for f in one.flights if f["situation"] in tested]
    flown = [[f for f in own if f["seed"] == seed] for seed in seeds]
    kills = fnmatch.filter(one.kills, row.light)
    # a flight that did not put the requirement to the test has no robustness
    told = [(float(f[column]), clean[f["situation"], f["seed"]][column]) for f in own if f[column]]
    change = [rho - float(before) for rho, before in told if before]
    by_seed = ", ".join(f"{len(revealed(some, row.requirement))}/{len(some)}" for some in flown)
    in_dark = f"{len(one.kills) - len(kills)}/{len(one.tested) - len(tested)}"
    p = f"{one.detection.p[row.requirement]:.2g}"
    median = f"{statistics.median(change):+.2f}" if change else "-"
    least = f"{min(rho for rho, _ in told):.2f}" if told else "-"
    cells = one.flights[0]["mutant"], one.verdict, p, by_seed, f"{len(kills)}/{len(tested)}", in_dark, median, least
    return f"| {' | '.join(cells)} |"


def phases(flights: Sequence[Flight]) -> str:
    """The section on false collisions with a random phase: how often the drone strikes something."""
    own = [f for f in flights if f["mutant"].startswith(PULSE) and fnmatch.filter([f["situation"]], LIGHT)]
    listed = {f["mutant"]: float(f["mutant"].partition("#")[2].removesuffix("s") or 0) for f in own}
    ranked = sorted(listed, key=listed.__getitem__)
    flown, struck = (Counter(f["situation"] for f in some) for some in (own, [f for f in own if "SR1" in violated(f)]))
    cells = Counter((f["situation"], f["mutant"], "SR1" in violated(f)) for f in own)
    places = {(situation, mutant) for situation, mutant, _ in cells}
    by_phase = Counter(f["mutant"] for f in own if "SR1" in violated(f))
    seeds = ", ".join(sorted({f["seed"] for f in own}))
    told = ", ".join(f"{by_phase[mutant]} at {listed[mutant]:g} s" for mutant in ranked)
    text = f"""
## UNINTENDED with a phase drawn at random

Where the drone is when a false collision comes depends on the phase, so that chance decides this row.  Flown: \
{len(ranked)}
evenly spaced phases of the {PERIOD_S:g} s with seeds {seeds}, {max(flown.values())} flights in each of \
{len(flown)} light situations.

The intervals (Clopper-Pearson, 95 %) are over phases and seeds, taken as independent draws.  They are too narrow: the
seeds of a phase agree in {2 * len(places) - len(cells)} of {len(places)} situations x phases.  \
The situations are all light ones of the grid, a
census, so no interval speaks of others.  By phase, of {len(own) // len(ranked)}:
{told}.

| situation | violates SR1 | share | interval over phases and seeds |
|---|---|---|---|
"""
    text += "".join(f"| {key} | {counted(struck[key], flown[key])} |\n" for key in flown)
    return text + f"| all of them | {counted(struck.total(), flown.total())} |\n"


def counted(part: int, whole: int) -> str:
    """Cells: part of whole, the share, and its interval."""
    low, high = binomtest(part, whole).proportion_ci(method="exact")
    return f"{part} of {whole} | {100 * part / whole:.0f} % | {100 * low:.1f} to {100 * high:.1f} %"


def parameters(study: Study) -> str:
    """Every number of `sim/` with its source."""

    def row(path: str, value: float) -> Sequence[object]:
        source = study.sim.source_of(path)
        return path, f"{value:g}", *((source.kind, source.text) if source else ("-", "-"))

    return blocks(
        "# Where the numbers come from",
        "Every number of `sim/*.yaml`, from `sim/sources.yaml`.  Kinds: published, datasheet, derived, assumption.",
        table(("number", "value", "kind", "source"), starmap(row, study.sim.numbers.items())),
    ).lstrip()


def main() -> None:
    """Write the pages."""
    study = Study.open(ROOT)
    with (PUBLISHED / "paper.csv").open(encoding="utf-8", newline="") as file:
        flights = list(csv.DictReader(file))
    (PUBLISHED / "paper_table.md").write_text(page(study, flights), encoding="utf-8")
    (PUBLISHED / "parameters.md").write_text(parameters(study), encoding="utf-8")


if __name__ == "__main__":
    main()
