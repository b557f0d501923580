"""Calibration: how the baselines behave with the chosen values and with values around them.

    python -m experiments.calibration [--jobs N] [--seeds 0-1] [--output FILE]

Targets: in light all 16 baselines hold SR1 and SR2; in the dark most turning missions strike the bar, and straight
missions hold SR1.  This script flies no mutant.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Mapping
from pathlib import Path

from experiments.pages import Row, blocks, parser, table
from scaloft_fi.campaign.plan import parse_seeds as seeds_of
from scaloft_fi.judge.requirement import judge
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.load import load
from scaloft_fi.stack.declaration import PlainWire
from scaloft_fi.study import Study

LATENCY, SHEEN, THICKNESS = "sensors.depth.latency_s", "world.bodies.bar.reflectivity", "world.bodies.bar.radius_m"
SWEEP: tuple[Mapping[str, float], ...] = (
    {},
    *({LATENCY: latency_s} for latency_s in (0.1, 0.2)),
    *({SHEEN: sheen} for sheen in (0.002, 0.004, 0.006, 0.01)),
    {LATENCY: 0.1, SHEEN: 0.004},
    *({THICKNESS: radius_m} for radius_m in (0.02, 0.04)),
    *({"stack.memory.min_pixels": pixels} for pixels in (1, 3)),
    *({"stack.planner.dilation_bins": bins} for bins in (7, 8, 10)),
    *({"stack.planner.obstacle_m": obstacle_m} for obstacle_m in (1.0, 1.2)),
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


def summary(overrides: Mapping[str, float], flown: list[Flown]) -> Row:
    """One row of the table."""
    light = [f for f in flown if "D0" in f[0]]
    turning = [f for f in flown if "D1" in f[0] and "T1" in f[0]]
    straight = [f for f in flown if "D1" in f[0] and "T0" in f[0]]
    return (
        ", ".join(f"{path} = {value:g}" for path, value in overrides.items()) or "**as chosen**",
        f"{sum(not (f[2] or f[3]) for f in light)}/{len(light)}",
        f"{min(f[1] for f in light):.2f}",
        f"{sum(f[4] == 'bar' for f in turning)}/{len(turning)}",
        f"{sum(not f[2] for f in straight)}/{len(straight)}",
    )


def main() -> None:
    """Fly the sweep and write the table."""
    asked = parser(__doc__, "calibration")
    asked.add_argument("--seeds", default="0-1", help="as `scaloft-fi run --seeds`")
    options = asked.parse_args()
    study, seeds = Study.open(None), seeds_of(options.seeds)
    draws = [(situation.key, seed) for situation in study.sim.grid.situations for seed in seeds]
    with multiprocessing.Pool(options.jobs) as pool:
        rows = [
            summary(overrides, pool.map(baseline, [(study.folder, overrides, *draw) for draw in draws], chunksize=1))
            for overrides in SWEEP
        ]
    head = (
        "value", "light: hold SR1, SR2", "least clearance [m]", "dark, turning: strike the bar", "straight: hold SR1",
    )  # fmt: skip
    text = blocks(
        "# Calibration: what the clean baselines do around the chosen values",
        f"Seeds {options.seeds}, no mutant.  Made by `python -m experiments.calibration`.",
        table(head, rows),
    )
    options.output.write_text(text.lstrip(), encoding="utf-8")


if __name__ == "__main__":
    main()
