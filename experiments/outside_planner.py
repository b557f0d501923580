"""A planner over ROS 2 should get the score that the same planner gets inside.

    python -m experiments.outside_planner [--output FILE]

Flies nothing: the page says by which commands the planner was flown; what `scaloft-fi score` and `scaloft-fi export`
said is kept in `results/published/outside_planner.json`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.pages import Row, blocks, table, write
from scaloft_fi.study import Study

BORDERS = ("inside", "ros2")


def results(_study: Study, _jobs: int, folder: Path) -> str:
    """The tables, from the scores that are kept."""
    kept = json.loads((folder / "outside_planner.json").read_bytes())
    heads = "stack", "code", "flights", "simulated [s]", "verdict", "p of SR2", "kills", "redraws", "steady"
    statuses = sorted({name for one in kept.values() for name in one["statuses"]})
    noise = "requirement", "pairs", "by the stack alone", "between seeds", "apart"
    return blocks(
        table(heads, (_run(border, kept[border]) for border in BORDERS)),
        "## Statuses",
        table(("flights", *BORDERS), ((n, *(kept[one]["statuses"].get(n, 0) for one in BORDERS)) for n in statuses)),
        "## Noise of the stack over ROS 2",
        table(noise, map(_noise, kept["ros2"]["noise"])),
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


if __name__ == "__main__":
    write(__doc__, "outside_planner", results, end="\n| stack")
