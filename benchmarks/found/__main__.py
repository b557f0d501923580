"""Which tests are missing?  `seek` for all that the paper's grid does not detect; its finds, each flown alone.

    python benchmarks/found --search [--budget 60m] [--seed 0] [--jobs N]
    python benchmarks/found --again [--jobs N]
    python benchmarks/found --false N --flights F [--jobs N]
    python benchmarks/found --pages [--output FILE]

`--search` searches a copy of the study without finds, and writes the finds into `sim/found.yaml` and what it says of
itself into `results/published/found_search.json`; give it an empty `--campaigns` to time it.  `--again` flies the finds
of `sim/found.yaml`, wherever they come from.  `--false` searches N times for the unmutated drone under other seeds,
with F flights each, into `found_false.json`.  Their flights are published as `found_flights.jsonl.gz`.  `--pages`
writes the page from these files and flies nothing.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from checkout import ROOT  # it sets the path and the threads

# isort: split

import published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

import argparse
import json
from collections.abc import Sequence
from typing import Any

from kept_flights import read, write
from published_outcomes import rows_of
from search_or_chance.sample import survivors

from found.flying import AGAIN, GRID, Place, again, false, finds_of, flights_in, search
from found.page import Evidence, page
from scaloft_fi.campaign.processes.start import cores
from scaloft_fi.study import Study

PUBLISHED = ROOT / "results" / "published"
OUTPUT = PUBLISHED / "found.md"
SEARCH, FALSE, FLIGHTS = "found_search.json", "found_false.json", "found_flights.jsonl.gz"


def evidence(folder: Path) -> Evidence:
    """The evidence in a folder of published files."""
    paper, wide = (Study.open(ROOT, name) for name in ("paper", "wide"))
    rows = rows_of(PUBLISHED / "reference" / "outcomes.parquet")
    return Evidence(
        study=Study.open(ROOT, AGAIN),
        finds=finds_of(ROOT),
        search=_read(folder / SEARCH) or {},
        false=_read(folder / FALSE) or [],
        again=read(folder / FLIGHTS).get("again", {}),
        survivors=survivors(paper, rows),
        wide=survivors(wide, rows_of(PUBLISHED / "wide_outcomes.parquet")),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--search", action="store_true", help="search for the mutants")
    what.add_argument("--again", action="store_true", help="fly the finds again")
    what.add_argument("--false", type=int, metavar="N", help="search N times for the unmutated drone")
    what.add_argument("--pages", action="store_true", help="fly nothing: the page")
    parser.add_argument("--budget", default="60m", help="of the search (default: 60m)")
    parser.add_argument("--seed", type=int, default=0, help="of the search (default: 0)")
    parser.add_argument("--flights", type=int, default=400, help="budget of each false search (default: 400)")
    parser.add_argument("--jobs", type=int, default=cores(), help="number of processes")
    parser.add_argument("--campaigns", type=Path, default=ROOT / "results" / "campaigns" / "found")
    parser.add_argument("--output", type=Path, default=OUTPUT, help="the page; the other files stand beside it")
    options = parser.parse_args(arguments)
    place, folder = Place(options.campaigns, options.jobs), options.output.parent
    if options.search:
        rows = rows_of(PUBLISHED / "reference" / "outcomes.parquet")
        sought = survivors(Study.open(ROOT), rows)
        _write(folder / SEARCH, search(place, sought, options.budget, options.seed))
        _publish(folder, "search", place, GRID)
    if options.again:
        again(place)
        _publish(folder, "again", place, AGAIN)
    if options.false:
        seeds = range(1, options.false + 1)
        _write(folder / FALSE, false(place, seeds, options.flights))
        for seed in seeds:
            _publish(folder, f"false{seed}", place, GRID)
    options.output.write_text(page(evidence(folder)), encoding="utf-8")


def _publish(folder: Path, name: str, place: Place, grid: str) -> None:
    write(folder / FLIGHTS, read(folder / FLIGHTS) | {name: flights_in(place, name, grid)})


def _write(path: Path, value: object) -> None:
    path.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


if __name__ == "__main__":
    main()
