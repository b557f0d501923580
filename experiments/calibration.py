"""Calibration: how the baselines behave with the chosen values and with values around them.

    python -m experiments.calibration [--jobs N] [--seeds 0-1] [--output results/published/calibration.md]

Targets: in light all 16 baselines hold SR1 and SR2; in the dark most turning missions strike the bar, and straight
missions hold SR1.  This script flies no mutant.
"""

from __future__ import annotations

# isort: split

import argparse
import multiprocessing
from collections.abc import Mapping
from pathlib import Path

from scaloft_fi.campaign.plan import parse_seeds as seeds_of
from scaloft_fi.judge.requirement import judge
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.load import load
from scaloft_fi.stack.declaration import PlainWire
from scaloft_fi.study import Study

LATENCY, SHEEN, THICKNESS = "sensors.depth.latency_s", "world.bodies.bar.reflectivity", "world.bodies.bar.radius_m"
SWEEP: tuple[Mapping[str, float], ...] = (
    {},
    {LATENCY: 0.1},
    {LATENCY: 0.2},
    {SHEEN: 0.002},
    {SHEEN: 0.004},
    {SHEEN: 0.006},
    {SHEEN: 0.01},
    {LATENCY: 0.1, SHEEN: 0.004},
    {THICKNESS: 0.02},
    {THICKNESS: 0.04},
    {"stack.memory.min_pixels": 1},
    {"stack.memory.min_pixels": 3},
    {"stack.planner.dilation_bins": 7},
    {"stack.planner.dilation_bins": 8},
    {"stack.planner.dilation_bins": 10},
    {"stack.planner.obstacle_m": 1.0},
    {"stack.planner.obstacle_m": 1.2},
    {"stack.estimator.fix_sigma_m": 0.02},
)

Flown = tuple[str, float, bool, bool, str]


def baseline(task: tuple[Path, Mapping[str, float], str, int]) -> Flown:
    """Fly one baseline; returns (key, least clearance [m], SR1 violated, SR2 violated, struck)."""
    folder, overrides, key, seed = task
    config = load(folder / "sim", overrides)
    log = fly(config, config.grid.situation(key), seed, PlainWire())
    broken = {r.name: judge(r, log).violated for r in Study.open(folder).requirements}
    return key, float(log.signals["clearance_m"].min()), broken["SR1"], broken["SR2"], log.struck


def summary(overrides: Mapping[str, float], flown: list[Flown]) -> str:
    """One row of the table."""
    light = [f for f in flown if "D0" in f[0]]
    turning = [f for f in flown if "D1" in f[0] and "T1" in f[0]]
    straight = [f for f in flown if "D1" in f[0] and "T0" in f[0]]
    change = ", ".join(f"{path} = {value:g}" for path, value in overrides.items()) or "**as chosen**"
    cells = (
        f"{sum(not (f[2] or f[3]) for f in light)}/{len(light)}",
        f"{min(f[1] for f in light):.2f}",
        f"{sum(f[4] == 'bar' for f in turning)}/{len(turning)}",
        f"{sum(not f[2] for f in straight)}/{len(straight)}",
    )
    return f"| {change} | " + " | ".join(cells) + " |"


def main() -> None:
    """Fly the sweep and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=multiprocessing.cpu_count())
    parser.add_argument("--seeds", default="0-1", help="as `scaloft-fi run --seeds`")
    parser.add_argument("--output", type=Path, help="a Markdown file (default: print)")
    options = parser.parse_args()
    study, seeds = Study.open(None), seeds_of(options.seeds)
    keys = [situation.key for situation in study.sim.grid.situations]
    lines = [
        "# Calibration: what the clean baselines do around the chosen values",
        "",
        f"Seeds {options.seeds}, no mutant.  Made by `python -m experiments.calibration`.",
        "",
        "| value | light: hold SR1, SR2 | least clearance [m] | dark, turning: strike the bar | straight: hold SR1 |",
        "|---|---|---|---|---|",
    ]
    with multiprocessing.Pool(options.jobs) as pool:
        for overrides in SWEEP:
            tasks = [(study.folder, overrides, key, seed) for key in keys for seed in seeds]
            lines.append(summary(overrides, pool.map(baseline, tasks, chunksize=1)))
            print(lines[-1], flush=True)
    if options.output:
        options.output.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
