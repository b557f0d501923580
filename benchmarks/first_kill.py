"""What `run --first-kill` saves, measured on a sample of the default catalogue.

    python benchmarks/first_kill.py [--json] [--situation KEY|GLOB]... [--every N]

sim_s_first_kill, sim_s_full: seconds simulated until it is known which mutants are killed, and for the whole kill
matrix with shared beginnings, counted in the flight loop of every process.  answers_equal: whether both name the same
mutants.  flights_first_kill, flights_full: flights of mutants.
"""

from __future__ import annotations

import checkout  # noqa: F401 - first: it sets the path and the threads

# isort: split

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from campaign import TickCounter

from scaloft_fi.campaign.plan.plan import plan
from scaloft_fi.campaign.progress.progress import Silence
from scaloft_fi.campaign.runs.first_kill import first_kills
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.mutants.derive import defaults
from scaloft_fi.results.scoring.score import score
from scaloft_fi.study import Study

SITUATIONS = ("T0O0W0D0H?", "T0O1W0D?H0", "T1O0W0D0H0")
TICK_HZ = 20


def measure(study: Study, keys: Sequence[str], every: int) -> dict[str, Any]:
    """All figures."""
    planned = plan(study.grid.select(keys), (0,), defaults(study.matrix)[::every], None)
    options = RunOptions(max_invalid=1.0)
    with tempfile.TemporaryDirectory() as folder:
        few, all_ = TickCounter(), TickCounter()
        with few.counting():
            found = first_kills(study, planned, Path(folder) / "few", options, progress=Silence())
        with all_.counting():
            report = run(study, planned, Path(folder) / "all", options, progress=Silence())
    scored = score(report.outcomes, study.roster, study.space)
    killed = {mutant.subject.id for mutant in scored.mutants if mutant.killed}
    answers = {answer.subject.id for answer in found.answers if answer.killed}
    controls = {answer.subject.id for answer in found.answers if study.roster.is_control(answer.subject)}
    return {
        "situations": len(planned.baselines),
        "mutants": len(found.answers),
        "killed": len(answers),
        "answers_equal": answers - controls == killed,
        "flights_first_kill": found.flown,
        "flights_full": len(planned.mutants) - len(planned.baselines),
        "sim_s_first_kill": few.ticks / TICK_HZ,
        "sim_s_full": all_.ticks / TICK_HZ,
        "share": round(few.ticks / all_.ticks, 3),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--situation", action="append", default=[], help="key or glob, repeatable")
    parser.add_argument("--every", type=int, default=8, help="fly every N-th default mutant (default: 8)")
    options = parser.parse_args()
    figures = measure(Study.open(None), options.situation or SITUATIONS, options.every)
    if options.json:
        json.dump(figures, sys.stdout, indent=2)
        print()
        return
    for name, figure in figures.items():
        print(f"{name:24} {figure}")


if __name__ == "__main__":
    main()
