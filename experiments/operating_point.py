"""Test two assumptions behind the paper's rows: the speed of the mission, and a planner that turns before it moves.

    python -m experiments.operating_point [--jobs N] [--output FILE]

The page states the flights and the rule of decision.
"""

from __future__ import annotations

import itertools
import multiprocessing
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from experiments.flights import Beside, flown, flown_draws
from experiments.pages import Row, blocks, table, write
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import flight_of
from scaloft_fi.study import Study

LIGHT = tuple(f"T{t}O{o}W{w}D0H{h}" for t, o, w, h in itertools.product((0, 1), repeat=4))
CRUISE, CRUISES_MPS = "world.mission.cruise_mps", (0.5, 1.0, 1.2, 1.8)
PLAIN = "T0O0W0D0H0"
NO_TURN = {"stack.planner.full_off_axis_rad": 3.2, "stack.planner.stop_off_axis_rad": 3.5}
"""Settings that keep full speed at any angle between the path and the camera's axis (at most 3.1416 rad)."""
MUTANTS = ("MORE-goal@0.6m", "MORE-goal@1m", "MORE-goal@3m")
TURNING = tuple(key for key in LIGHT if key.startswith("T1") and key.endswith("H0"))
SEEDS = (0, 1)
APART = 5


class Speed(NamedTuple):
    """Results of a baseline: whether it held SR1 and SR2, greatest speed in all and level flight [m/s], range of y."""

    held: bool
    greatest_mps: float
    level_mps: float
    near_m: float
    far_m: float


def speed(beside: Beside) -> Speed:
    """Fly one baseline."""
    ((outcome, log),) = flown(beside)
    y_m, level_mps = log.signals["y_m"], np.hypot(log.signals["vx_mps"], log.signals["vy_mps"])
    greatest_mps = log.signals["speed_mps"]
    held = outcome.first_violation is None
    return Speed(held, *(float(n) for n in (greatest_mps.max(), level_mps.max(), y_m.min(), y_m.max())))


def results(study: Study, jobs: int, _folder: Path) -> str:
    """Fly, and write the section with the results."""
    with multiprocessing.Pool(jobs) as pool:
        speeds = {
            cruise: pool.map(speed, [Beside(study.folder, {CRUISE: cruise}, key, 0) for key in LIGHT], chunksize=1)
            for cruise in CRUISES_MPS
        }
    besides = [Beside(study.folder, NO_TURN, key, n, MUTANTS if key in TURNING else ()) for key in LIGHT for n in SEEDS]
    draws = flown_draws(besides, jobs)
    turning = [draw for draw in draws if len(draw) > 1]
    violated = [{v.requirement for v in draw[0].violations} for draw in draws]
    person = [names for draw, names in zip(draws, violated, strict=True) if draw[0].situation.endswith("H1")]
    sr1, sr2 = (sum(name not in names for names in found) for name, found in (("SR1", violated), ("SR2", person)))
    return blocks(
        "## Flown",
        f"Speeds of the fastest of the 16 baselines; y in {PLAIN}.",
        table(
            ("cruise [m/s]", "hold SR1 and SR2", "greatest speed [m/s]", "level [m/s]", "y [m]"),
            (_cruise(*found) for found in speeds.items()),
        ),
        f"Without turning first {sr1} of {len(draws)} light baselines hold SR1, "
        f"{sr2} of {len(person)} with a person hold SR2.",
        (_masks(number, mutant, turning) for number, mutant in enumerate(MUTANTS, start=1)),
        table(("situation", "seed", "baseline violates", *MUTANTS), map(_draw, turning)),
    )


def _cruise(cruise_mps: float, found: Sequence[Speed]) -> Row:
    plain = found[LIGHT.index(PLAIN)]
    speeds = (f"{max(getattr(one, name) for one in found):.2f}" for name in ("greatest_mps", "level_mps"))
    held = sum(one.held for one in found)
    return f"{cruise_mps:g}", f"{held} of {len(found)}", *speeds, f"{plain.near_m:.2f} to {plain.far_m:.2f}"


def _masks(number: int, mutant: str, turning: Sequence[Sequence[Outcome]]) -> str:
    seeds = [draw[0].seed for draw in turning if "SR1" in flight_of(draw[number], draw[0]).revealed]
    verb = "masks" if len(seeds) >= APART else "is not shown to mask"
    told = (
        f"{len(seeds)} of {len(turning)} flights without it, {' and '.join(str(seeds.count(n)) for n in SEEDS)} by seed"
    )
    return f"- Turning first {verb} {mutant}: SR1 reveals it in {told}."


def _draw(draw: Sequence[Outcome]) -> Row:
    names = "+".join(v.requirement for v in draw[0].violations) or "-"
    return draw[0].situation, draw[0].seed, names, *(_end(outcome, draw[0]) for outcome in draw[1:])


def _end(outcome: Outcome, baseline: Outcome) -> str:
    first = outcome.first_violation
    if first is None or "SR1" not in flight_of(outcome, baseline).revealed:
        return "-"
    return f"SR1 at {first.t_s:.1f} s, ({first.x:.1f}, {first.y:.1f}) m, {first.struck}"


if __name__ == "__main__":
    write(__doc__, "operating_point", results)
