"""Ask whether the situations that kill a mutant detect a real bug of its kind.

    python -m experiments.bugs --plan [--output results/published/bugs.md]
    python -m experiments.bugs [--jobs N] [--output results/published/bugs.md]
                           [--flights results/published/bugs_flights.jsonl.gz] [--situations N]

The page states the bugs, the flights and the rules; `--plan` writes it without flying.  Finished flights are kept in
the file `--flights`, at the latest after ten seconds; the same command flies only the flights that are missing there.
Delete the file after a change of the study or of the code.  `--situations N` flies the first N situations only, and
writes no results.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from experiments import ROOT

# isort: split

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

import argparse
from collections.abc import Sequence

from experiments.bugs.bug import Bug
from experiments.bugs.evidence import published
from experiments.bugs.page import flown
from experiments.bugs.registry import BUGS, declare
from experiments.bugs.study import StackStudy
from experiments.bugs_plan import PLAN, REFERENCE, names_of
from experiments.kept_flights import Flights, complete, flights_of, read
from experiments.published_outcomes import rows_of
from scaloft_fi.campaign.processes import cores
from scaloft_fi.study import Study

PUBLISHED = ROOT / "results" / "published"


def fly(study: Study, bugs: Sequence[Bug], situations: Sequence[str], path: Path, jobs: int) -> Flights:
    """Fly what is missing in the file of flights; returns all flights of the file.

    Args:
        study: the reference study.
        bugs: the bugs, whose stacks are declared.
        situations: keys.
        path: the file of flights.
        jobs: number of processes.
    """
    kept = read(path)
    stacks = {bug.key: StackStudy(study.folder, stack_name=bug.key) for bug in bugs}
    for arm, copy in {REFERENCE: study, **stacks}.items():
        complete(path, kept, arm, copy, flights_of(copy, {}, names_of(situations)), jobs)
    return kept


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the page: its plan and, without `--plan`, its results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", action="store_true", help="fly nothing: the page without results")
    parser.add_argument("--jobs", type=int, default=cores(), help="number of processes")
    parser.add_argument("--output", type=Path, default=PUBLISHED / "bugs.md", help="the page")
    parser.add_argument("--flights", type=Path, default=PUBLISHED / "bugs_flights.jsonl.gz", help="the file of flights")
    parser.add_argument("--situations", type=int, help="fly the first N only, and write no results (default: all)")
    options = parser.parse_args(arguments)
    if options.plan:
        options.output.write_text(PLAN, encoding="utf-8")
        return
    declare()
    study = Study.open(ROOT)
    situations = [situation.key for situation in study.grid.situations][: options.situations]
    flights = fly(study, BUGS, situations, options.flights, options.jobs)
    if options.situations is None:
        seen = published(study, rows_of(PUBLISHED / "reference" / "outcomes.parquet"))
        options.output.write_text(PLAN + flown(BUGS, flights, seen), encoding="utf-8")


if __name__ == "__main__":
    main()
