"""Test that a campaign survives SIGKILL of all or one of its processes at random moments, again and again.

    python benchmarks/kill [--json] [--kills N] [--seed N] [--mutant ID]... [--situation KEY|GLOB]...
        [--baseline-seeds N] [--jobs N] [--cluster | --seek BUDGET | --outside]

The script flies a small campaign undisturbed and keeps its export.  Then it starts the campaign again and sends SIGKILL
after a random part of that time: in half of the cases to the whole process group, otherwise to one process.  It repeats
command and kill until the campaign is complete; the export must equal the undisturbed one, byte for byte.  New
campaigns follow until the number of kills is reached.

With `--cluster` a Dask cluster on the loopback interface flies: a scheduler and as many workers as `--jobs`.  Then the
victim is, with equal chance, the run as above, the scheduler, a worker, or a process of a worker.  What was killed of
the cluster is started again; a run outlives its workers, and ends when its scheduler does.

With `--seek` a search for the mutants with this budget is killed and resumed, in a copy of the study without finds; its
finds are compared beside the exports.

With `--outside` the planner of `examples/outside_planner` flies, in a process of its own below a guard; both may be the
victim.

kills: number of kills by target.  campaigns: number of completed campaigns.  right: number of campaigns that lost and
doubled no flight and have the undisturbed export.  sound: number of kills after which SQLite
found its file intact.  outlived: number of processes that outlived their run.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import checkout  # noqa: F401 - first: it sets the path and the threads

# isort: split

import argparse
import json
import random
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

from kill.campaigns import Campaign, Outside, Search
from kill.cluster import Cluster

MUTANTS = ("LATE-human", "MORE-goal", "UNINTENDED-collision@20s")
OUTSIDE = ("LATE-human", "REVERSE-drive")
SITUATIONS = ("T0O0W0D0H[01]",)


def measure(
    words: Sequence[str],
    kills: int,
    seed: int,
    folder: Path,
    cluster: Cluster | None = None,
    kind: type[Campaign] = Campaign,
) -> dict[str, Any]:
    """Fly, kill and resume campaigns of a kind until the number of kills is reached."""
    if cluster:
        words = [*words, "--executor", f"dask://{cluster.address}", "--cluster-security", str(cluster.certificates)]
    draw = random.Random(seed)
    calm = kind(folder / "calm", words, cluster)
    calm.run(None, draw)  # once before, so that the timed run compiles nothing
    shutil.rmtree(calm.folder)
    begin_s = time.monotonic()
    calm.run(None, draw)
    whole_s, expected = time.monotonic() - begin_s, calm.export()
    killed: Counter[str] = Counter()
    campaigns = right = sound = outlived = 0
    while killed.total() < kills:
        campaign, its_kills = kind(folder / f"campaign{campaigns}", words, cluster), Counter[str]()
        done = False
        while not done:
            moment_s = draw.uniform(0.0, whole_s) if (killed + its_kills).total() < kills else None
            done, what, left = campaign.run(moment_s, draw)
            outlived += left
            if what:
                its_kills[what] += 1
                sound += campaign.sound()
        killed += its_kills
        campaigns += 1
        right += campaign.export() == expected
    if cluster:
        outlived += cluster.end()
    return {
        "kills": killed.total(),
        "killed": dict(sorted(killed.items())),
        "campaigns": campaigns,
        "right": right,
        "sound": sound,
        "outlived": outlived,
        "flights": expected.count(b'"mutant"'),
        "undisturbed_s": round(whole_s, 1),
    }


def main() -> None:
    """Kill, resume, compare; exits with 1 when anything was lost."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--kills", type=int, default=20, help="how many (default: 20)")
    parser.add_argument("--seed", type=int, default=0, help="of the moments and the victims (default: 0)")
    parser.add_argument("--mutant", action="append", default=[], help="id or glob, repeatable")
    parser.add_argument("--situation", action="append", default=[], help="key or glob, repeatable")
    parser.add_argument("--baseline-seeds", type=int, default=10, help="of the baseline pool (default: 10)")
    parser.add_argument("--jobs", type=int, default=2, help="worker processes (default: 2)")
    other = parser.add_mutually_exclusive_group()
    other.add_argument("--cluster", action="store_true", help="fly on a Dask cluster, and kill its processes too")
    other.add_argument("--seek", metavar="BUDGET", help="kill a search with this budget, such as 300flights")
    other.add_argument("--outside", action="store_true", help="fly a stage outside, and kill it and its guard too")
    options = parser.parse_args()
    mutants = options.mutant or (OUTSIDE if options.outside else MUTANTS)
    if options.seek:
        words = [*mutants, "--budget", options.seek]
    else:
        words = [word for mutant in mutants for word in ("--mutant", mutant)]
        words += [word for key in options.situation or SITUATIONS for word in ("--situation", key)]
        words += ["--baseline-seeds", str(options.baseline_seeds)]
    folder = Path(tempfile.mkdtemp(prefix="kill"))
    try:
        words += [] if options.cluster else ["--jobs", str(options.jobs)]
        cluster = Cluster(folder / "cluster", options.jobs) if options.cluster else None
        kind = Search if options.seek else Outside if options.outside else Campaign
        figures = measure(words, options.kills, options.seed, folder, cluster, kind)
    finally:
        shutil.rmtree(folder)
    if options.json:
        json.dump(figures, sys.stdout, indent=2)
        print()
    else:
        for name, figure in figures.items():
            print(f"{name:14} {figure}")
    unharmed = (
        figures["right"] == figures["campaigns"] and figures["sound"] == figures["kills"] and not figures["outlived"]
    )
    sys.exit(not unharmed)


if __name__ == "__main__":
    main()
