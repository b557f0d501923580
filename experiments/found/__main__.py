"""Which tests are missing?  `seek` for all that the paper's grid does not detect; its finds, on fresh seeds.

    python -m experiments.found --search [--budget 10610flights] [--seed 0] [--jobs N]
    python -m experiments.found --replicate [--jobs N]
    python -m experiments.found --pages [--output FILE]

`--search` searches a copy of the study without finds, and writes the finds into `sim/found.yaml` and what it says of
itself into `results/published/found_search.json`; give it an empty `--campaigns` to time it.  `--replicate` flies the
finds of `sim/found.yaml` on fresh seeds, keeps those that hold, and writes `found_replication.json`.  Their flights are
published as `found_flights.jsonl.gz`.  `--pages` writes the page from these files and flies nothing.
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
from typing import Any

from experiments.found.flying import Place, finds_of, flights_in, replicate, search
from experiments.found.page import Evidence, page
from experiments.kept_flights import read, write
from experiments.published_outcomes import rows_of
from experiments.search_or_chance.sample import survivors
from scaloft_fi.campaign.processes import cores
from scaloft_fi.study import Study

PUBLISHED = ROOT / "results" / "published"
OUTPUT = PUBLISHED / "found.md"
SEARCH, REPLICATION, FLIGHTS = "found_search.json", "found_replication.json", "found_flights.jsonl.gz"


def evidence(folder: Path) -> Evidence:
    """The evidence in a folder of published files."""
    paper, wide = (Study.open(ROOT, name) for name in ("paper", "wide"))
    rows = rows_of(PUBLISHED / "reference" / "outcomes.parquet")
    return Evidence(
        study=paper,
        finds=finds_of(ROOT),
        search=_read(folder / SEARCH) or {},
        replication=_read(folder / REPLICATION) or {},
        flights=read(folder / FLIGHTS),
        survivors=survivors(paper, rows),
        wide=survivors(wide, rows_of(PUBLISHED / "wide_outcomes.parquet")),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--search", action="store_true", help="search for the mutants")
    what.add_argument("--replicate", action="store_true", help="fly the finds on fresh seeds")
    what.add_argument("--pages", action="store_true", help="fly nothing: the page")
    parser.add_argument("--budget", default="10610flights", help="of the search (default: 10610flights)")
    parser.add_argument("--seed", type=int, default=0, help="of the search (default: 0)")
    parser.add_argument("--jobs", type=int, default=cores(), help="number of processes")
    parser.add_argument("--campaigns", type=Path, default=ROOT / "results" / "campaigns" / "found")
    parser.add_argument("--output", type=Path, default=OUTPUT, help="the page; the other files stand beside it")
    options = parser.parse_args(arguments)
    place, folder = Place(options.campaigns, options.jobs), options.output.parent
    if options.search:
        rows = rows_of(PUBLISHED / "reference" / "outcomes.parquet")
        sought = survivors(Study.open(ROOT), rows)
        _write(folder / SEARCH, search(place, sought, options.budget, options.seed))
        _publish(folder, "search", place)
    if options.replicate:
        _write(folder / REPLICATION, replicate(place))
        _publish(folder, "replication", place)
    options.output.write_text(page(evidence(folder)), encoding="utf-8")


def _publish(folder: Path, name: str, place: Place) -> None:
    write(folder / FLIGHTS, read(folder / FLIGHTS) | {name: flights_in(place, name)})


def _write(path: Path, value: object) -> None:
    path.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


if __name__ == "__main__":
    main()
