"""How the paper's rows move when the study's assumptions vary by 30 %.

    python benchmarks/sensitivity.py [--jobs N] [--only PATH_GLOB] [--output results/published/sensitivity.md]

Each number that `sim/sources.yaml` calls an assumption is multiplied by 0.7 and by 1.3, one at a time (whole numbers
are rounded; the corridor's and the branch's widths vary as a whole).  Per variation the baseline and the row's mutants
fly the row's situation; the table says whether the verdict is that of the study as it stands.
"""

from __future__ import annotations

import checkout  # noqa: F401 - first: it sets the path and the threads

# isort: split

import argparse
import fnmatch
import multiprocessing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.campaign.flights.fly import facts
from scaloft_fi.errors import ScaloftError
from scaloft_fi.mutants.derive import realise
from scaloft_fi.mutants.wire import contexts, wire_for
from scaloft_fi.results.flights import flight_of
from scaloft_fi.results.outcome import Outcome, Subject, outcome_of
from scaloft_fi.results.requirement import Kind
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.load import load
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.study import Study

SHARES = (0.7, 1.3)
WHOLE = {"expansions", "children", "plan_every", "min_pixels", "sectors", "dilation_bins"}


@dataclass(frozen=True)
class Row:
    """One row of the paper's table, in the one situation where it is watched."""

    name: str
    situation: str
    mutants: tuple[str, ...]


PHASES = ("", "#5s", "#10s", "#15s")
ROWS = (
    Row("LATE-human@3s", "T0O0W0D0H1", ("LATE-human@3s",)),
    Row("UNINTENDED-collision@20s", "T1O0W1D0H0", tuple(f"UNINTENDED-collision@20s{p}" for p in PHASES)),
    Row("MORE-goal", "T1O1W0D0H0", ("MORE-goal@0.6m", "MORE-goal@1m", "MORE-goal@3m")),
)  # fmt: skip


@dataclass(frozen=True)
class Variation:
    """Overrides of the study's numbers, and what to call them."""

    name: str
    change: str
    overrides: Mapping[str, float]

    def touches(self, pattern: str) -> bool:
        """Whether it changes a number whose path matches."""
        return any(fnmatch.fnmatch(path, pattern) for path in self.overrides)


@dataclass(frozen=True)
class Finding:
    """What a variation does to a row: safety violations of the baseline, kills by mutant, least clearance by mutant."""

    baseline: str
    kills: tuple[str, ...]
    clearance_m: tuple[float, ...]


def variations(numbers: Mapping[str, float]) -> Iterator[Variation]:
    """Each assumption down and up; the footprint by its widths."""
    yield Variation("as it stands", "", {})
    for path, value in numbers.items():
        if ".footprint." in path or value == 0.0:
            continue
        for share in SHARES:
            changed = value * share
            if path.rsplit(".", 1)[-1] in WHOLE:
                changed = round(changed)
            if changed != value:
                yield Variation(path, f"{value:g} -> {changed:g}", {path: changed})
    for share in SHARES:
        half = 1.2 * share
        low, high = 8.0 - half, 8.0 + half
        corners = {"4": high, "5": high, "6": low, "7": low}
        moved = {f"world.mine.footprint.{k}.1": y for k, y in corners.items()}
        yield Variation("width of the branch", f"2.4 -> {2 * half:g}", moved)
        half = 1.5 * share
        sides = {"0": -half, "1": half, "2": half, "3": -half, "4": -half, "7": -half}
        moved = {f"world.mine.footprint.{k}.0": x for k, x in sides.items()}
        yield Variation("width of the corridor", f"3 -> {2 * half:g}", moved)


def fly_row(task: tuple[Path, Variation, Row]) -> Finding | str:
    """Fly the row under the variation; a sentence when the study does not allow it."""
    folder, variation, row = task
    study = Study.open(folder)
    try:
        config = load(folder / "sim", variation.overrides)
        scenario = config.scenario(config.grid.situation(row.situation))
    except ScaloftError as error:
        return str(error).rsplit(": ", 1)[-1]
    sigma = config.sensors.imu

    def outcome(mutant_id: str | None) -> tuple[Outcome, FlightLog]:
        mutant = realise(study.matrix, mutant_id) if mutant_id else None
        context = contexts(mutant_id or "baseline", row.situation, 0, scenario.nominal_s, facts(scenario, sigma))
        log = fly(config, scenario.situation, 0, wire_for(mutant, context))
        judged = outcome_of(
            log, Subject.of(mutant), row.situation, 0, requirements=study.requirements, realisation=None
        )
        return judged, log

    clean, clean_log = outcome(None)
    kills, clearances = [], [float(clean_log.signals["clearance_m"].min())]
    for mutant_id in row.mutants:
        flown, log = outcome(mutant_id)
        kills.append("+".join(flight_of(flown, clean).kills) or "-")
        clearances.append(float(log.signals["clearance_m"].min()))
    red = "+".join(r.requirement for r in clean.readings if r.violated and r.kind is Kind.SAFETY)
    return Finding(red or "-", tuple(kills), tuple(clearances))


def main() -> None:
    """Fly all variations and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=multiprocessing.cpu_count())
    parser.add_argument("--only", default="*", help="glob over the assumptions' paths")
    parser.add_argument("--output", type=Path, help="a Markdown file (default: print)")
    options = parser.parse_args()
    study = Study.open(None)
    chosen = [v for v in variations(study.sim.assumptions) if not v.overrides or v.touches(options.only)]
    tasks = [(study.folder, variation, row) for variation in chosen for row in ROWS]
    with multiprocessing.Pool(options.jobs) as pool:
        findings = list(pool.imap(fly_row, tasks))
    text = table([task[1:] for task in tasks], findings)
    if options.output:
        options.output.write_text(text, encoding="utf-8")
    else:
        print(text)


def table(tasks: list[tuple[Variation, Row]], findings: list[Finding | str]) -> str:
    """The Markdown page: per row a count, then every variation that moves its verdict."""
    lines = ["# Sensitivity: each assumption varied by 30 %, one at a time", ""]
    lines += ["Seed 0; one situation a row.  `-`: not killed.  Made by `python benchmarks/sensitivity.py`.", ""]
    for row in ROWS:
        own = [(v, f) for (v, r), f in zip(tasks, findings, strict=True) if r is row]
        stands = own[0][1]
        assert isinstance(stands, Finding)
        flown = [(v, f) for v, f in own[1:] if isinstance(f, Finding)]
        same = [f for _, f in flown if f.kills == stands.kills and f.baseline == stands.baseline]
        some = [f for _, f in flown if any(k != "-" for k in f.kills)]
        lines += [
            f"## {row.name} in {row.situation}",
            "",
            f"As it stands: baseline violates {stands.baseline}; "
            + ", ".join(f"{m}: {k}" for m, k in zip(row.mutants, stands.kills, strict=True))
            + "; least clearance "
            + ", ".join(f"{c:.2f}" for c in stands.clearance_m)
            + " m (baseline first).",
            "",
            (
                f"{len(flown)} variations flown, {len(own) - 1 - len(flown)} not possible: {len(same)} leave baseline "
                f"and verdicts as they are; in {len(some)} at least one mutant of the row is killed."
            ),
            "",
            "| assumption | from -> to | baseline | " + " | ".join(row.mutants) + " |",
            "|---|---|---|" + "---|" * len(row.mutants),
        ]
        for variation, finding in own[1:]:
            if isinstance(finding, str):
                lines.append(
                    f"| {variation.name} | {variation.change} | not possible: {finding} |{' |' * len(row.mutants)}"
                )
            elif finding.kills != stands.kills or finding.baseline != stands.baseline:
                cells = " | ".join(finding.kills)
                lines.append(f"| {variation.name} | {variation.change} | {finding.baseline} | {cells} |")
        lines.append("")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
