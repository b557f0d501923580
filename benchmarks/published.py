r"""The published tables of the paper's rows and of where each number comes from.

    scaloft-fi run --campaign paper --seeds 3 --mutant 'LATE-human*' --mutant 'MORE-goal*' \
        --mutant 'UNINTENDED-collision@20s*'
    python benchmarks/published.py [--campaign paper]

Writes `paper_table.md` and `parameters.md` into `results/published/`, and the flights behind them as `paper.csv`.
"""

from __future__ import annotations

import checkout  # noqa: F401 - first: it sets the path and the threads

# isort: split

import argparse
import csv
import fnmatch
import io
import statistics
import subprocess
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.document import load
from scaloft_fi.mutants.select import select
from scaloft_fi.study import Study

PUBLISHED = Path(__file__).resolve().parents[1] / "results" / "published"
FREEZE = "ee10286"
Flight = dict[str, str]


@dataclass(frozen=True)
class Row:
    """A row of the paper's table and the mutants that stand for it."""

    name: str
    paper: str
    requirement: str
    predicted: str
    mutants: tuple[str, ...]
    light: str

    def is_light(self, flight: Flight) -> bool:
        """Whether the flight's situation is one the prediction speaks of."""
        return fnmatch.fnmatchcase(flight["situation"], self.light)


def rows(study: Study) -> list[Row]:
    """The rows of `results/published/predictions.yaml`."""
    found = []
    for name, item in load(PUBLISHED / "predictions.yaml").need("rows").mapping().items():
        patterns = [pattern.text() for pattern in item.need("mutants")]
        mutants = tuple(mutant.id for mutant in select(patterns, study.matrix, study.catalogue))
        texts = {key: item.need(key).text() for key in ("paper", "requirement", "predicted", "light")}
        found.append(Row(name=name, mutants=mutants, **texts))
    return found


def flights_of(campaign: str) -> tuple[list[Flight], str]:
    """The campaign's flights, as `scaloft-fi export` gives them, and that text."""
    call = [sys.executable, "-m", "scaloft_fi", "export", "--campaign", campaign, "--format", "csv"]
    text = subprocess.run(call, capture_output=True, text=True, check=True, cwd=PUBLISHED.parents[1]).stdout
    return list(csv.DictReader(io.StringIO(text))), text


def broken(flight: Flight, requirement: str) -> bool:
    """Whether the flight violates the requirement."""
    return requirement in flight["violated"].split(";")


def killed(flights: Iterable[Flight], requirement: str) -> list[Flight]:
    """Those killed by the requirement."""
    return [f for f in flights if f["status"] == "killed" and broken(f, requirement)]


HEAD = """# The paper's table of injected faults, beside ours

Flown with the stack, the world and the requirements of commit `{freeze}`, chosen on clean baselines only; nothing
there changed because of a verdict.  Seeds {seeds}; light situations unless stated.  Made by
`python benchmarks/published.py`; the flights are in `paper.csv`.  The numbers of `sim/` stand since commit `ec7d4e0`,
before any mutant had been flown; a few were flown between the two commits to try the tools.

| row | paper | prediction | ours | first kill |
|---|---|---|---|---|
"""

DETAIL = """
## {name}: {predicted}

`rho` is the robustness of {requirement}; below 0 it is violated.  Eligible: infected, and the baseline held.

| mutant | light: killed / eligible, per seed | in at least 2 seeds | median change of rho | least rho | dark: killed |
|---|---|---|---|---|---|
"""


def page(study: Study, flights: Sequence[Flight]) -> str:
    """The paper's table beside ours, then each row in detail."""
    seeds = sorted({f["seed"] for f in flights}, key=int)
    text, details = HEAD.format(freeze=FREEZE, seeds=", ".join(seeds)), ""
    for row in rows(study):
        own = [f for f in flights if f["mutant"] in row.mutants and row.is_light(f)]
        kills = sorted(killed(own, row.requirement), key=lambda f: float(f["violated_at_s"]))
        ours = f"{len(kills)} of {len(own)} flights of {len(row.mutants)} mutants killed by {row.requirement}"
        text += f"| {row.name} | {row.paper} | {row.predicted} | {ours} | {moment(kills[0]) if kills else '-'} |\n"
        details += DETAIL.format(name=row.name, predicted=row.predicted, requirement=row.requirement)
        details += "".join(line(row, mutant, flights, seeds) + "\n" for mutant in row.mutants)
        details += "\nKills in light, earliest first (at most 12):\n\n"
        details += "".join(f"- {moment(f)}\n" for f in kills[:12]) or "- none\n"
    return text + details


def moment(flight: Flight) -> str:
    """When and where a flight was first violated."""
    place = f"({float(flight['x']):.2f}, {float(flight['y']):.2f}, {float(flight['z']):.2f}) m"
    struck = f", struck {flight['struck']}" if flight["struck"] else ""
    name = f"`{flight['mutant']}/{flight['situation']}/{flight['seed']}`"
    return f"{name} at {float(flight['violated_at_s']):.2f} s, {place}{struck}"


def line(row: Row, mutant: str, flights: Sequence[Flight], seeds: Sequence[str]) -> str:
    """One mutant: kills by seed, where they repeat, and how robustness moved."""
    clean = {(f["situation"], f["seed"]): f for f in flights if f["mutant"] == "baseline"}
    rho = f"rho_{row.requirement}"
    own = [f for f in flights if f["mutant"] == mutant]
    dark = [f for f in own if not row.is_light(f)]
    dark_kills = f"{sum(f['status'] == 'killed' for f in dark)}/{len(dark)}"
    eligible = [
        f
        for f in own
        if row.is_light(f) and f["infected_at_s"] and not broken(clean[f["situation"], f["seed"]], row.requirement)
    ]
    if not eligible:
        return f"| {mutant} | never eligible | - | - | - | {dark_kills} |"
    by_seed = {seed: [f for f in eligible if f["seed"] == seed] for seed in seeds}
    rates = ", ".join(f"{len(killed(fs, row.requirement))}/{len(fs)}" for fs in by_seed.values())
    hits = [f["situation"] for f in killed(eligible, row.requirement)]
    often = " ".join(sorted({key for key in hits if hits.count(key) >= 2})) or "-"
    told = [(f[rho], clean[f["situation"], f["seed"]][rho]) for f in eligible]
    change = [float(own) - float(before) for own, before in told if own and before]
    least = [float(own) for own, _ in told if own]
    robustness = f"{statistics.median(change):+.2f} | {min(least):.2f}" if change else "- | -"
    return f"| {mutant} | {rates} | {often} | {robustness} | {dark_kills} |"


def parameters(study: Study) -> str:
    """Every number of `sim/` with its source."""
    lines = [
        "# Where the numbers come from",
        "",
        "Every number of `sim/*.yaml`, from `sim/sources.yaml`.  Kinds: published, datasheet, derived, assumption.",
        "",
        "| number | value | kind | source |",
        "|---|---|---|---|",
    ]
    for path, value in study.sim.numbers.items():
        source = study.sim.source_of(path)
        kind, text = (source.kind, source.text) if source else ("-", "-")
        lines.append(f"| {path} | {value:g} | {kind} | {text} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the pages."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--campaign", default="paper")
    options = parser.parse_args()
    study = Study.open(PUBLISHED.parents[1])
    flights, text = flights_of(options.campaign)
    (PUBLISHED / "paper.csv").write_text(text, encoding="utf-8")
    (PUBLISHED / "paper_table.md").write_text(page(study, flights), encoding="utf-8")
    (PUBLISHED / "parameters.md").write_text(parameters(study), encoding="utf-8")


if __name__ == "__main__":
    main()
