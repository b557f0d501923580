"""Sensitivity of the paper's rows to the study's assumptions.

    python -m experiments.sensitivity [--jobs N] [--output FILE]

The script multiplies each number that `sim/sources.yaml` calls an assumption by 0.7 and by 1.3, one at a time (whole
numbers are rounded; the widths of corridor and branch vary as a whole).  A number that is 0 takes the values declared
in `ZEROS`; without a declaration the script stops.  For each variation the baseline and the row's mutants fly the row's
situation once, so the results are observations of single flights beside their baseline.

Findings are kept beside the page, in `sensitivity.csv`; the same command flies only what is missing there.  Delete
lines after a change of the study or of the code.
"""

from __future__ import annotations

import csv
import multiprocessing
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from experiments.flights import Beside, flown
from experiments.pages import blocks, table
from experiments.pages import write as write_page
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import flight_of
from scaloft_fi.study import Study

SHARES = (0.7, 1.3)
WHOLE = {"expansions", "children", "plan_every", "min_pixels", "sectors", "dilation_bins"}
FOOTPRINT = "world.mine.footprint."


@dataclass(frozen=True)
class Zero:
    """Values for an assumption that is 0, in place of 70 % and 130 %, with their unit and the reason."""

    values: tuple[float, ...]
    unit: str
    reason: str


ZEROS: Mapping[str, Zero] = {
    "world.mission.yaw_deg": Zero(
        (-90.0, -27.0, 27.0, 90.0), "deg", "a right angle to either side, which is along the corridor, and 30 % of it"
    ),
    "sensors.detector.false_positives": Zero(
        (0.003, 0.3), "per picture", "30 % of one picture in a hundred (5 pictures a second), and of every picture"
    ),
}
"""The values by path; a value is below 0 only where the study allows it."""


@dataclass(frozen=True)
class Row:
    """One row of the paper's table, and the situation in which it is flown."""

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
    """Overrides of the study's numbers, and their name; without overrides, the unchanged study."""

    name: str
    change: str
    overrides: Mapping[str, float]


@dataclass(frozen=True)
class Finding:
    """The result of a variation for a row.

    Attributes:
        baseline: safety requirements that the baseline violates; `-` for none.
        revealed: safety requirements that reveal each mutant.
        clearance_m: least clearance of the baseline and of each mutant; empty where only the page was kept.
        impossible: why the study cannot be flown with the variation.
    """

    baseline: str = ""
    revealed: tuple[str, ...] = ()
    clearance_m: tuple[str, ...] = ()
    impossible: str = ""

    @property
    def says(self) -> tuple[str, ...]:
        """The values that are compared."""
        return (self.baseline, *self.revealed)


Findings = dict[tuple[str, str, str], Finding]
"""By row, assumption and change."""


def variations(numbers: Mapping[str, float]) -> Iterator[Variation]:
    """Yield each assumption decreased and increased, or with its declared values; the footprint varies by widths."""
    yield Variation("as it stands", "", {})
    for path, value in numbers.items():
        if not path.startswith(FOOTPRINT):
            for changed in changes(path, value):
                yield Variation(path, f"{value:g} -> {changed:g}", {path: changed})
    for share in SHARES:
        half = 1.2 * share
        low, high = 8.0 - half, 8.0 + half
        corners = {"4": high, "5": high, "6": low, "7": low}
        moved = {f"{FOOTPRINT}{k}.1": y for k, y in corners.items()}
        yield Variation("width of the branch", f"2.4 -> {2 * half:g}", moved)
        half = 1.5 * share
        sides = {"0": -half, "1": half, "2": half, "3": -half, "4": -half, "7": -half}
        moved = {f"{FOOTPRINT}{k}.0": x for k, x in sides.items()}
        yield Variation("width of the corridor", f"3 -> {2 * half:g}", moved)


def changes(path: str, value: float) -> Sequence[float]:
    """The varied values of a number."""
    if value == 0.0:
        if path not in ZEROS:
            raise SystemExit(f"{path} is 0, which has no 30 %: declare in ZEROS which values it takes, and why")
        return ZEROS[path].values
    whole = path.rsplit(".", 1)[-1] in WHOLE
    found = [round(value * share) if whole else value * share for share in SHARES]
    return [changed for changed in found if changed != value]


def fly_row(task: tuple[Path, Variation, Row]) -> Finding:
    """Fly the row under the variation."""
    folder, variation, row = task
    try:
        baseline, *mutants = flown(Beside(folder, variation.overrides, row.situation, 0, row.mutants))
    except ScaloftError as error:
        return Finding(impossible=str(error).rsplit(": ", 1)[-1])
    clean = baseline[0]
    red = "+".join(r.requirement for r in clean.readings if r.violated and r.kind is Kind.SAFETY)
    revealed = tuple("+".join(flight_of(outcome, clean).revealed) or "-" for outcome, _ in mutants)
    clearances = tuple(f"{log.signals['clearance_m'].min():.2f}" for _, log in (baseline, *mutants))
    return Finding(red or "-", revealed, clearances)


def read(path: Path) -> Findings:
    """The findings of a CSV."""
    with path.open(encoding="utf-8", newline="") as file:
        return {
            (line["row"], line["assumption"], line["change"]): Finding(
                line["baseline"], _split(line["revealed"]), _split(line["clearance_m"]), line["impossible"]
            )
            for line in csv.DictReader(file)
        }


def _split(cell: str) -> tuple[str, ...]:
    return tuple(cell.split(";")) if cell else ()


def write(path: Path, findings: Findings, order: Iterable[Variation]) -> None:
    """Write the findings as CSV; each row in the order of the variations."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("row", "assumption", "change", "baseline", "revealed", "clearance_m", "impossible"))
        for row, v in product(ROWS, order):
            found = findings.get((row.name, v.name, v.change))
            if found:
                joined = (";".join(found.revealed), ";".join(found.clearance_m))
                writer.writerow((row.name, v.name, v.change, found.baseline, *joined, found.impossible))


def _section(row: Row, findings: Findings, order: Sequence[Variation]) -> str:
    own = [(v, found) for v in order if (found := findings.get((row.name, v.name, v.change)))]
    stands = next(found for v, found in own if not v.overrides)
    varied = [(v, found) for v, found in own if v.overrides]
    flew = [found for _, found in varied if not found.impossible]
    same = sum(found.says == stands.says for found in flew)
    some = sum(any(names != "-" for names in found.revealed) for found in flew)
    shown = ", ".join(f"{mutant}: {names}" for mutant, names in zip(row.mutants, stands.revealed, strict=True))
    gap = [""] * len(row.mutants)
    rows = (
        (v.name, v.change, *([f"not possible: {found.impossible}", *gap] if found.impossible else found.says))
        for v, found in varied
        if found.says != stands.says
    )
    return blocks(
        f"## {row.name} in {row.situation}",
        f"As it stands: baseline violates {stands.baseline}; {shown}; least clearance\n"
        f"{', '.join(stands.clearance_m)} m (baseline first).",
        f"{len(flew)} variations flown, {len(varied) - len(flew)} not possible: {same} leave all of it as it is;\n"
        f"in {some} at least one mutant of the row is revealed.",
        table(("assumption", "from -> to", "baseline", *row.mutants), rows),
    )


def _zeros(findings: Findings, order: Sequence[Variation]) -> str:
    parts: list[str | Iterable[str]] = [
        "## Numbers that are 0",
        "Every flight of theirs, whether it moves a row or not.",
    ]
    for path, zero in ZEROS.items():
        rows = []
        for row, v in product(ROWS, (v for v in order if v.name == path)):
            found = findings[row.name, v.name, v.change]
            cells = [found.impossible] if found.impossible else [found.baseline, ", ".join(found.revealed)]
            rows.append((row.name, f"{v.overrides[path]:g}", *cells))
        parts += [f"`{path}`: {', '.join(f'{value:g}' for value in zero.values)} {zero.unit}: {zero.reason}."]
        parts += [table(("row", "to", "baseline", "mutants, in the row's order"), rows)]
    return blocks(*parts)


def results(study: Study, jobs: int, folder: Path) -> str:
    """Fly what is missing; for each row a count and every variation that changes it, then the numbers that are 0."""
    order, path = list(variations(study.sim.assumptions)), folder / "sensitivity.csv"
    findings = read(path) if path.exists() else {}
    tasks = [(study.folder, v, row) for v in order for row in ROWS if (row.name, v.name, v.change) not in findings]
    with multiprocessing.Pool(jobs) as pool:
        for (_, variation, row), found in zip(tasks, pool.imap(fly_row, tasks), strict=True):
            findings[row.name, variation.name, variation.change] = found
            print(row.name, variation.name, variation.change, *found.says, found.impossible, file=sys.stderr)
    write(path, findings, order)
    return "".join(_section(row, findings, order) for row in ROWS) + _zeros(findings, order)


if __name__ == "__main__":
    write_page(__doc__, "sensitivity", results, end="\n## ")
