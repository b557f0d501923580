"""Calibration: how the baselines behave with the chosen values and with values around them.

    python -m experiments.calibration [--jobs N] [--output FILE]

Targets: in light all 16 baselines hold SR1 and SR2; in the dark most turning missions strike the bar, and straight
missions hold SR1.  This script flies no mutant.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Mapping
from pathlib import Path

from experiments.pages import Row, blocks, table, write
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

SEED = 0

Flown = tuple[str, float, bool, bool, str]


def baseline(task: tuple[Path, Mapping[str, float], str]) -> Flown:
    """Fly one baseline; returns (key, least clearance [m], SR1 violated, SR2 violated, struck)."""
    folder, overrides, key = task
    config = load(folder / "sim", overrides)
    log = fly(config, config.grid.situation(key), SEED, PlainWire())
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


def results(study: Study, jobs: int, _folder: Path) -> str:
    """Fly the sweep, and tell."""
    keys = [situation.key for situation in study.sim.grid.situations]
    with multiprocessing.Pool(jobs) as pool:
        rows = [
            summary(overrides, pool.map(baseline, [(study.folder, overrides, key) for key in keys], chunksize=1))
            for overrides in SWEEP
        ]
    heads = "light: hold SR1, SR2", "least clearance [m]", "dark, turning: strike the bar", "straight: hold SR1"
    return blocks(table(("value", *heads), rows))


if __name__ == "__main__":
    write(__doc__, "calibration", results, end="\n| value")
