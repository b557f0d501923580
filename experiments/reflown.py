"""Flies published flights again and compares them with their file in `results/published/`.

    python -m experiments.reflown [--grid wide] [--sample N | --shard K/N] [--jobs N]

Without options it flies all of them: 13,821 flights; 6,645 of them took 17 minutes on two processors.  `--sample` flies
the N flights that `sample` chooses, always the same ones.  `--shard` flies every N-th pair of situation and seed.
`--grid wide` takes the flights of the wide grid.  Mutants share the beginning of their baseline, as in a campaign.

The published flights were flown with OpenBLAS's kernels for SkylakeX.  The choice of kernel decides the last bits of a
flight, so this script asks OpenBLAS for these kernels where the processor has AVX-512.  Where it gets them, the digests
must be equal; elsewhere only statuses, endings and violated requirements must be.

Exit code 1: a flight differs from the published one.
"""

from __future__ import annotations

from experiments import ROOT

# isort: split

from experiments.published_kernels import CHOSEN, KERNELS  # it must be imported before numpy

# isort: split

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

from experiments.flights import GRIDS, Row, name_of, own_s, published, shared
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.processes import cores
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.campaign.store.platforms import fingerprint
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.dossier import export_rows

BITS = ("status", "ending", "violated", "duration_s", "digest")
FACTS = ("status", "ending", "violated")
"""The columns that must be equal with the same kernels, and with others."""
SAMPLE_SEED = 0
"""The seed with which every published mutant was flown."""
ROUNDS = (slice(1), slice(1, 3), slice(3, None))
"""Groups of the mutants' choices, by rank."""
NEWS_EVERY = 500
"""A line on standard error after this number of flights."""


def sample(rows: Sequence[Row], number: int) -> list[Row]:
    """A fixed choice of `number` rows.

    First the baselines of all situations, then the first choice of each mutant, then their second and third choices,
    then the rest, each time the cheapest first.  A mutant's choices are its flights in different situations: those
    whose digest is not their baseline's come first, and of these the cheapest.
    """
    drawn = [row for row in rows if row["seed"] == SAMPLE_SEED]
    baselines = {row["situation"]: row for row in drawn if row["mutant"] == "baseline"}

    def rank(row: Row) -> tuple[bool, float]:
        return row["digest"] == baselines[row["situation"]]["digest"], own_s(row)

    choices: dict[str, list[Row]] = {}
    for row in drawn:
        if row["mutant"] != "baseline":
            choices.setdefault(row["mutant"], []).append(row)
    ranked = [sorted(flights, key=rank) for flights in choices.values()]
    rounds = (chain.from_iterable(flights[own] for flights in ranked) for own in ROUNDS)
    ordered = chain.from_iterable(sorted(flights, key=own_s) for flights in rounds)
    return [*baselines.values(), *ordered][:number]


def shard(rows: Sequence[Row], number: int, shards: int) -> list[Row]:
    """The rows of every `shards`-th pair of situation and seed, from the `number`-th (counted from 1) on."""
    draws = list(dict.fromkeys((row["situation"], row["seed"]) for row in rows))
    own = set(draws[number - 1 :: shards])
    return [row for row in rows if (row["situation"], row["seed"]) in own]


def flown(rows: Sequence[Row], jobs: int, grid: str = "paper") -> dict[str, Row]:
    """Fly the flights of the rows again; returns their rows in the form of `export`, by name."""
    study, outcomes = Study.open(ROOT, grid), []
    flights = [flight_named(study, row["mutant"], row["situation"], row["seed"]) for row in rows]
    baselines = [Flight(None, flight.situation, flight.seed) for flight in flights]  # a status needs its baseline
    wanted = tuple(dict.fromkeys((*baselines, *flights)))
    for outcome in shared(study, wanted, jobs):
        outcomes.append(outcome)
        if len(outcomes) % NEWS_EVERY == 0:
            print(f"{len(outcomes)} of {len(wanted)} flights are flown", file=sys.stderr, flush=True)
    return {name_of(row): row for row in export_rows(outcomes, study.roster, study.space)}


def differences(rows: Sequence[Row], again: Mapping[str, Row], columns: Sequence[str]) -> Iterator[str]:
    """Yield a line for each difference of flight and column."""
    for row in rows:
        name = name_of(row)
        if name not in again:
            yield f"{name}: not flown"
            continue
        for column in columns:
            if row[column] != again[name][column]:
                yield f"{name}: {column} {row[column]!r} published, {again[name][column]!r} flown again"


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly and compare; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--sample", type=int, metavar="N", help="fly a fixed choice of N flights")
    part.add_argument("--shard", metavar="K/N", help="fly every N-th pair of situation and seed, from the K-th on")
    parser.add_argument("--grid", choices=GRIDS, default="paper", help="whose flights (default: paper)")
    parser.add_argument("--jobs", type=int, help="number of processes; by default one for each processor")
    options = parser.parse_args(arguments)
    rows = published(options.grid)
    if options.sample:
        rows = sample(rows, options.sample)
    elif options.shard:
        rows = shard(rows, *map(int, options.shard.split("/")))
    kernels = {fingerprint()[name] for name in ("numpy kernels", "scipy kernels")}
    columns = BITS if kernels == {KERNELS} else FACTS
    asked = f"{KERNELS.upper()} is set: the processor has" if CHOSEN else "is left as it is: the processor lacks"
    print(f"OPENBLAS_CORETYPE {asked} AVX-512")
    print(f"kernels: {', '.join(sorted(kernels))}; published: {KERNELS}; compared: {', '.join(columns)}", flush=True)
    found = list(differences(rows, flown(rows, options.jobs or cores(), options.grid), columns))
    for line in found:
        print(line)
    print(f"{len(rows)} flights flown again, {len({line.split(': ')[0] for line in found})} differ")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
