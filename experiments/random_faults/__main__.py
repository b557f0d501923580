"""Is HAZOP worth its name?  As many random faults as default mutants, under the same test.

    python -m experiments.random_faults --draw
    python -m experiments.random_faults --plan [--output results/published/random_faults.md]
    python -m experiments.random_faults [--jobs N] [--draws N] [--flights FILE] [--output FILE]

`--draw` writes the faults into `experiments/random_faults/faults.jsonl`, `--plan` the page without results; both fly
nothing.  Finished flights are kept in the file `--flights`, at the latest after ten seconds; the same command flies
only the flights that are missing there.  Delete the file after a change of the study or of the code.  `--draws N` flies
the first N draws of seed and situation only.
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
import json
from collections.abc import Sequence

from experiments.kept_flights import complete, flights_of, read
from experiments.published_outcomes import outcomes, rows_of
from experiments.random_faults.arm import Arm
from experiments.random_faults.draw import Draw
from experiments.random_faults.page import flown
from experiments.random_faults.plan import FAULTS, PLAN, names_of
from scaloft_fi.campaign.processes import cores
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import catalogue_lines, realise
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.study import Study

FILE = Path(__file__).parent / "faults.jsonl"
PUBLISHED = ROOT / "results" / "published"
ARM = "random"
"""Name of the arm in the file of flights."""


def drawn(study: Study) -> tuple[Mutant, ...]:
    """The random faults of the experiment."""
    return Draw.of(study).faults(FAULTS)


def text_of(faults: Sequence[Mutant]) -> str:
    """The file of faults, one line of JSON for each."""
    return "".join(f"{line}\n" for line in catalogue_lines(faults))


def read_faults() -> tuple[Mutant, ...]:
    """The faults of the committed file."""
    return tuple(Mutant.from_json(json.loads(line)) for line in FILE.read_text(encoding="utf-8").splitlines())


def fly(study: Study, faults: Sequence[Mutant], path: Path, jobs: int, draws: int | None = None) -> list[Outcome]:
    """Fly what is missing in the file of flights; returns all flights of the file.

    Args:
        study: the study.
        faults: the random faults.
        path: the file of flights.
        jobs: number of processes.
        draws: number of draws of seed and situation; None = all.
    """
    kept, keys = read(path), [situation.key for situation in study.grid.situations]
    names = names_of([fault.id for fault in faults], keys, draws)
    planned = flights_of(study, {fault.id: fault for fault in faults}, names)
    complete(path, kept, ARM, study, planned, jobs)
    return list(kept[ARM].values())


def hazop_arm(study: Study) -> Arm:
    """The default mutants, from the published flights."""
    published = outcomes(study, rows_of(PUBLISHED / "reference" / "outcomes.parquet"))
    return Arm.of("HAZOP", published, study.roster.defaults.values(), study.space)


def results(study: Study, faults: Sequence[Mutant], flights: Sequence[Outcome]) -> str:
    """The section with the results."""
    defaults = [realise(study.matrix, mutant) for mutant in study.roster.defaults.values()]
    random = Arm.of("random", flights, [fault.id for fault in faults], study.space)
    return flown(hazop_arm(study), random, {mutant.id: mutant for mutant in (*defaults, *faults)})


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the faults, or the page: its plan and, without `--plan`, its results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draw", action="store_true", help="fly nothing: the file of faults")
    parser.add_argument("--plan", action="store_true", help="fly nothing: the page without results")
    parser.add_argument("--jobs", type=int, default=cores(), help="number of processes")
    parser.add_argument("--output", type=Path, help="a Markdown file (default: print)")
    kept = PUBLISHED / "random_faults_flights.jsonl.gz"
    parser.add_argument("--flights", type=Path, default=kept, help="the file of flights (default: published)")
    parser.add_argument("--draws", type=int, help="of seed and situation (default: all)")
    options = parser.parse_args(arguments)
    if options.draw:
        FILE.write_text(text_of(drawn(Study.open(ROOT))), encoding="utf-8")
        return
    text = PLAN
    if not options.plan:
        study, faults = Study.open(ROOT), read_faults()
        text += results(study, faults, fly(study, faults, options.flights, options.jobs, options.draws))
    if options.output:
        options.output.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
