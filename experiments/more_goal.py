"""Ask whether MORE-goal is shown: with and without turning first, at three speeds, in all light situations.

    python -m experiments.more_goal --plan [--output results/published/more_goal.md]
    python -m experiments.more_goal [--jobs N] [--output results/published/more_goal.md]
                                   [--flights results/published/more_goal_flights.jsonl.gz] [--draws N]

The page states the flights and the rules of decision; `--plan` writes it without flying.  Finished flights are kept in
the file `--flights`, at the latest after ten seconds; the same command flies only the flights that are missing there.
Delete the file after a change of the study or of the code.  `--draws N` flies the first N draws of each arm only.
"""

from __future__ import annotations

from experiments import ROOT

# isort: split

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

import argparse
from collections.abc import Mapping
from pathlib import Path

from experiments.kept_flights import Flights, complete, flights_of, read
from experiments.more_goal_page import flown
from experiments.more_goal_plan import ARMS, DRAWS, MUTANTS, PLAN, names_of
from experiments.reflown import published
from experiments.varied import Varied
from scaloft_fi.campaign.processes import cores
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study


def fly(study: Study, path: Path, jobs: int, draws: int = DRAWS) -> Flights:
    """Fly what is missing in the file of flights; returns all flights of the file.

    Args:
        study: the study.
        path: the file of flights.
        jobs: number of processes.
        draws: number of draws of each arm.
    """
    kept = read(path)
    for arm in ARMS:
        varied = Varied(study.folder, overrides=arm.overrides)
        mutants = {name: realise(varied.matrix, name) for name in MUTANTS}
        complete(path, kept, arm.name, varied, flights_of(varied, mutants, names_of(draws)), jobs)
    return kept


def reference_digests() -> Mapping[str, str]:
    """The digests of the reference campaign by name of the flight."""
    return {f"{row['mutant']}/{row['situation']}/{row['seed']}": row["digest"] for row in published()}


def main() -> None:
    """Write the page: its plan and, without `--plan`, its results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", action="store_true", help="fly nothing: the page without results")
    parser.add_argument("--jobs", type=int, default=cores())
    parser.add_argument("--output", type=Path, help="a Markdown file (default: print)")
    kept = ROOT / "results" / "published" / "more_goal_flights.jsonl.gz"
    parser.add_argument("--flights", type=Path, default=kept, help="the file of flights (default: published)")
    parser.add_argument("--draws", type=int, default=DRAWS, help=f"of each arm (default: all {DRAWS})")
    options = parser.parse_args()
    text = PLAN
    if not options.plan:
        study = Study.open(ROOT)
        flights = fly(study, options.flights, options.jobs, options.draws)
        text += flown(flights, reference_digests(), study.space)
    if options.output:
        options.output.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
