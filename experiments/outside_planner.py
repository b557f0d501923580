"""A planner over ROS 2 should get the score that the same planner gets inside.

    python -m experiments.outside_planner --fly ros2|inside --study DIR [--jobs N]
    python -m experiments.outside_planner --page

`--fly` makes the study of `examples/outside_planner` in DIR, or goes on with the one that is there, flies LATE-human
and PLACEBO over the whole grid, beside a pool of twenty baseline seeds where there is no corner and the fault
acts, and keeps the score in `results/published/outside_planner.json`.  `ros2` needs a Python with rclpy.  `--page`
writes `results/published/outside_planner.md` from these scores and flies nothing.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments import ROOT
from experiments.pages import Row, blocks, registered, table
from scaloft_fi.verbs.new import example_files, write_new

KEPT = ROOT / "results" / "published" / "outside_planner.json"
PAGE = KEPT.with_suffix(".md")
EDITS = {
    "inside": (("name: outside", "name: planner_inside"),),
    "ros2": (
        ("border: lines", "border: ros2"),
        ("over_lines.py", "over_ros2.py"),
        ("deterministic: true", "deterministic: false"),
    ),
}
"""What of `sim/stack.yaml` flies the planner elsewhere."""
BORDERS = tuple(EDITS)
POOL = 20
"""Baseline seeds; redraws of the unmutated drone need that many."""
STARTED = "import sys; sys.path.insert(0, sys.argv.pop(1)); import inside; from scaloft_fi.cli import main; main()"
"""A start of the command that declares the stack `planner_inside`, which no installed package does."""
RUNS = (("--situation", "T0*", "--baseline-seeds", str(POOL)), ("--baseline-seeds", "1"))
"""What is flown: the pool where there is no corner, then the rest of the grid."""


def fly(border: str, study: Path, jobs: int) -> dict[str, Any]:
    """Fly the grid; returns the score, and how the flights ended."""
    if not study.exists():
        write_new(study, example_files("outside_planner"))
        settings = study / "sim" / "stack.yaml"
        text = settings.read_text(encoding="utf-8")
        for old, new in EDITS[border]:
            text = text.replace(old, new)
        settings.write_text(text, encoding="utf-8")
    inside = [sys.executable, "-c", STARTED, str(study / "sim")]
    start = inside if border == "inside" else [sys.executable, "-m", "scaloft_fi"]
    place = ("--study", str(study))
    for words in RUNS:
        flown = [*start, "run", "--mutant", "LATE-human", *words, "--jobs", str(jobs), *place]
        code = subprocess.run(flown, cwd=ROOT, stdout=subprocess.DEVNULL, check=False).returncode
        if code:
            break
    score, rows = (
        json.loads(
            subprocess.run(
                [*start, verb, *place, "--format", "json"], cwd=ROOT, check=True, capture_output=True, text=True
            ).stdout
        )
        for verb in ("score", "export")
    )
    return {
        "code": code,
        "flights": len(rows),
        "simulated_s": round(sum(row["duration_s"] for row in rows)),
        "statuses": dict(sorted(Counter(f"{row['mutant']}: {row['status']}" for row in rows).items())),
        "mutants": score["mutants"],
        "redraw": score["redraw"],
        "steady": sum(pair["state"] == "steady" for pair in score["pairs"]),
        "pairs": len(score["pairs"]),
        "noise": score.get("noise", []),
    }


def page(kept: Mapping[str, Mapping[str, Any]]) -> str:
    """The page, in Markdown."""
    heads = "stack", "code", "flights", "simulated [s]", "verdict", "p of SR2", "kills", "redraws", "steady"
    statuses = sorted({name for one in kept.values() for name in one["statuses"]})
    return registered("outside_planner", end="\n| stack") + blocks(
        table(heads, (_run(border, kept[border]) for border in BORDERS)),
        "## Statuses",
        table(
            ("flights", *BORDERS), ((n, *(kept[border]["statuses"].get(n, 0) for border in BORDERS)) for n in statuses)
        ),
        "## Noise of the stack over ROS 2",
        table(
            ("requirement", "pairs", "by the stack alone", "between seeds", "apart"), map(_noise, kept["ros2"]["noise"])
        ),
    )


def _run(border: str, one: Mapping[str, Any]) -> Row:
    (late,) = one["mutants"]
    kills, redraws = late["kill_rate"], one["redraw"]["safety"]
    shares = f"{kills['part']}/{kills['whole']}", f"{redraws['part']} of {redraws['whole']}"
    flown = (one[name] for name in ("code", "flights", "simulated_s"))
    p, steady = f"{late['p']['SR2']:.2g}", f"{one['steady']} of {one['pairs']} pairs"
    return f"`{border}`", *flown, late["verdict"], p, *shares, steady


def _noise(noise: Mapping[str, Any]) -> Row:
    figures = (f"{noise[name]:.2g}" if noise[name] is not None else "none" for name in ("stack", "seeds"))
    return noise["requirement"], noise["pairs"], *figures, noise["apart"]


def main() -> int:
    """Fly or write the page; the exit code is that of the run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--fly", choices=BORDERS)
    what.add_argument("--page", action="store_true")
    parser.add_argument("--study", type=Path, help="where the study is, or is made")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    if options.page:
        PAGE.write_text(page(kept))
        return 0
    if options.study is None:
        parser.error("--fly needs --study DIR")
    kept[options.fly] = fly(options.fly, options.study, options.jobs)
    KEPT.write_text(json.dumps({name: kept[name] for name in BORDERS if name in kept}, indent=1) + "\n")
    return int(kept[options.fly]["code"])


if __name__ == "__main__":
    sys.exit(main())
