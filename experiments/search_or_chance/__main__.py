"""Does search beat chance?  `seek` beside random, low-discrepancy and 2-way situations, at equal flights.

    python -m experiments.search_or_chance --draw
    python -m experiments.search_or_chance --plan [--output results/published/search_or_chance.md]
    python -m experiments.search_or_chance [--jobs N] [--blocks N] [--output FILE]
    python -m experiments.search_or_chance --pages [--output FILE]

`--draw` writes the blocks of mutants into `experiments/search_or_chance/blocks.txt`, `--plan` the page without results,
`--pages` the page of the published searches and flights; these fly nothing.  Else the searches are flown, one after the
other.  The campaigns of the blocks (`--campaigns`) hold their flights, and finished searches are kept in the file
`--searches`: the same command goes on where it stopped.  Delete both after a change of the study or of the code.  At
the end the flights are published in `--flights`.  `--blocks N` flies the first N blocks only, `--budget N` only so many
flights for each mutant; then nothing is decided.
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
from collections.abc import Mapping, Sequence

from experiments.kept_flights import read, write
from experiments.published_outcomes import rows_of
from experiments.search_or_chance.page import Evidence, flown
from experiments.search_or_chance.plan import BUDGET, PLAN, seed_of
from experiments.search_or_chance.proposers import ARMS
from experiments.search_or_chance.sample import FILE, Block, at_risk, blocks_of, read_blocks, survivors, text_of
from experiments.search_or_chance.searches import Search, read_searches, search, write_searches
from scaloft_fi.campaign.flights.fly import Flyer
from scaloft_fi.campaign.processes import cores
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

PUBLISHED = ROOT / "results" / "published"
CAMPAIGNS = ROOT / "results" / "campaigns" / "search_or_chance"
GRID = "search"
KEPT = "all arms"
"""Name in the file of flights: arms share flights."""


def drawn(study: Study) -> list[Block]:
    """The blocks of the experiment."""
    rows = rows_of(PUBLISHED / "reference" / "outcomes.parquet")
    return blocks_of(study, at_risk(study, survivors(study, rows)))


def fly(
    study: Study,
    blocks: Sequence[Block],
    campaigns: Path,
    path: Path,
    *,
    jobs: int,
    budget: int = BUDGET,
    flyer: Flyer | None = None,
) -> list[Search]:
    """Fly the searches that the file lacks; returns all searches of the file.

    Args:
        study: the study, with the grid that is searched.
        blocks: the mutants of each block.
        campaigns: folder with a campaign for each block.
        path: the file of searches.
        jobs: number of processes.
        budget: flights of each search for each of its mutants.
        flyer: flies; PyBullet when None.
    """
    searches = read_searches(path)
    done = {(one.block, one.arm, one.budget) for one in searches}
    for number, mutants in enumerate(blocks, 1):
        flights = budget * len(mutants)
        for arm in ARMS:
            if (number, arm, flights) in done:
                continue
            progress = Progress()
            progress.line(f"block {number} of {len(blocks)}, {arm}: {', '.join(mutants)}")
            searches.append(
                search(
                    study,
                    number,
                    mutants,
                    arm,
                    folder_of(campaigns, number),
                    seed=seed_of(number),
                    budget=flights,
                    jobs=jobs,
                    progress=progress,
                    flyer=flyer,
                )
            )
            write_searches(path, searches)
    return searches


def folder_of(campaigns: Path, block: int) -> Path:
    """The campaign with the flights of all arms of a block."""
    return campaigns / f"{block:02}"


def flights_in(study: Study, campaigns: Path, blocks: int) -> Mapping[str, Outcome]:
    """The flights of the first blocks by name."""
    found: dict[str, Outcome] = {}
    for number in range(1, blocks + 1):
        with Store(folder_of(campaigns, number) / STORE_NAME, create=False) as store:
            found |= {outcome.name: outcome for outcome in current_in(study, store)}
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the blocks, or the page: its plan and, without `--plan`, its results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draw", action="store_true", help="fly nothing: the file of blocks")
    parser.add_argument("--plan", action="store_true", help="fly nothing: the page without results")
    parser.add_argument("--pages", action="store_true", help="fly nothing: the page of the published files")
    parser.add_argument("--jobs", type=int, default=cores(), help="number of processes")
    parser.add_argument("--output", type=Path, help="a Markdown file (default: print)")
    parser.add_argument("--campaigns", type=Path, default=CAMPAIGNS, help="a folder with a campaign for each block")
    kept = PUBLISHED / "search_or_chance_searches.jsonl.gz"
    parser.add_argument("--searches", type=Path, default=kept, help="the file of searches (default: published)")
    kept = PUBLISHED / "search_or_chance_flights.jsonl.gz"
    parser.add_argument("--flights", type=Path, default=kept, help="the file of flights (default: published)")
    parser.add_argument("--blocks", type=int, help="the first N only (default: all)")
    parser.add_argument("--budget", type=int, default=BUDGET, help=f"flights for each mutant (default: {BUDGET})")
    options = parser.parse_args(arguments)
    if options.draw:
        FILE.write_text(text_of(drawn(Study.open(ROOT))), encoding="utf-8")
        return
    text = PLAN
    if not options.plan:
        blocks = read_blocks()
        if not options.pages:
            study, chosen = Study.open(ROOT, GRID), blocks[: options.blocks]
            fly(study, chosen, options.campaigns, options.searches, jobs=options.jobs, budget=options.budget)
            write(options.flights, {KEPT: flights_in(study, options.campaigns, len(chosen))})
        flights = read(options.flights).get(KEPT, {})
        text += flown(Evidence(blocks, read_searches(options.searches), flights, options.budget))
    if options.output:
        options.output.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
