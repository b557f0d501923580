"""Test two assumptions behind the paper's rows: the speed of the mission, and a planner that turns before it moves.

    python -m experiments.operating_point [--plan] [--jobs N] [--output results/published/operating_point.md]

The page states the flights and the rule of decision; `--plan` writes it without flying.
"""

from __future__ import annotations

# isort: split

import itertools
import multiprocessing
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from experiments.varied import Beside, flown, main, outcomes
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
DRAWS = len(TURNING) * len(SEEDS)
APART = 5

PLAN = f"""# Two assumptions behind the paper's rows: speed, and turning first

Questions, arms and rule were written down, and committed without the section *Flown*, before these flights were flown.
They are no blind test: an earlier look, without a plan, had found most of it.  Made by
`python -m experiments.operating_point`.

**Speed.**  The paper's script asks for 0.5 m/s, and the study flies so.  The published log of positions
(`drone_mission_log.txt` of github.com/uoy-research/SCALOFT) has the drone at 1.8 m/s on its way out and at 2.1 m/s on
its way back (each over half a second, at 158.3 and 210.7 s), past y = 8.3 m behind the waypoint at 7 m, and at
y = -0.97 m or less past home.

- Flown: the baselines of the 16 light situations, seed 0, at a cruise speed (`{CRUISE}`) of
  {", ".join(f"{speed:g}" for speed in CRUISES_MPS)} m/s; nothing else is changed.
- Reported, without a rule: how many hold SR1 and SR2, the greatest speed (of it all and, added when the climb was seen
  to be the fastest part at 0.5 m/s, of its level part), and how far past waypoint and home the drone flies in {PLAIN}.

**Turning first.**  The planner slows down where the way is off the camera's axis, and from 0.5 rad on turns on the
spot.  The paper does not say whether its navigator does so.

- Flown without it (`{"`, `".join(NO_TURN)}` above any angle):
  {", ".join(MUTANTS)} in
  {", ".join(TURNING)} with seeds {", ".join(map(str, SEEDS))} ({DRAWS} flights a mutant),
  and the baselines of all 16 light situations with both seeds.
- With it: the same {DRAWS} draws of `paper.csv`, in none of which SR1 reveals MORE-goal.
- Rule: turning first *masks* a mutant where SR1 reveals it in at least {APART} of the {DRAWS} flights without it.
  The baselines tell what the drone would be without it; nothing in the study is changed for them.
"""


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


def results(study: Study, jobs: int) -> str:
    """Fly, and write the section with the results."""
    lines = ["", "## Flown", "", f"Speeds of the fastest of the 16 baselines; y in {PLAIN}.", ""]
    lines += [
        "| cruise [m/s] | hold SR1 and SR2 | greatest speed [m/s] | level [m/s] | y [m] |",
        "|---|---|---|---|---|",
    ]
    with multiprocessing.Pool(jobs) as pool:
        for cruise in CRUISES_MPS:
            found = pool.map(speed, [Beside(study.folder, {CRUISE: cruise}, key, 0) for key in LIGHT], chunksize=1)
            lines.append(_cruise(cruise, found))
    besides = [
        Beside(study.folder, NO_TURN, key, seed, MUTANTS if key in TURNING else ()) for key in LIGHT for seed in SEEDS
    ]
    return "\n".join(lines) + "\n" + _turning(outcomes(besides, jobs))


def _cruise(cruise_mps: float, found: Sequence[Speed]) -> str:
    plain = found[LIGHT.index(PLAIN)]
    held = f"{sum(one.held for one in found)} of {len(found)}"
    speeds = f"{max(one.greatest_mps for one in found):.2f} | {max(one.level_mps for one in found):.2f}"
    return f"| {cruise_mps:g} | {held} | {speeds} | {plain.near_m:.2f} to {plain.far_m:.2f} |"


def _turning(draws: Sequence[Sequence[Outcome]]) -> str:
    turning = [draw for draw in draws if len(draw) > 1]
    violated = [{v.requirement for v in draw[0].violations} for draw in draws]
    person = [names for draw, names in zip(draws, violated, strict=True) if draw[0].situation.endswith("H1")]
    sr1, sr2 = (sum(name not in names for names in found) for name, found in (("SR1", violated), ("SR2", person)))
    held = f"{sr1} of {len(draws)} light baselines hold SR1, {sr2} of {len(person)} with a person hold SR2."
    lines = ["", f"Without turning first {held}", ""]
    for number, mutant in enumerate(MUTANTS, start=1):
        seen = sum("SR1" in flight_of(draw[number], draw[0]).revealed for draw in turning)
        verb = "masks" if seen >= APART else "is not shown to mask"
        lines.append(f"- Turning first {verb} {mutant}: SR1 reveals it in {seen} of {len(turning)} flights without it.")
    lines += ["", "| situation | seed | baseline violates | " + " | ".join(MUTANTS) + " |", "|---|---|---|---|---|---|"]
    for draw in turning:
        cells = " | ".join(_end(outcome, draw[0]) for outcome in draw[1:])
        names = "+".join(v.requirement for v in draw[0].violations) or "-"
        lines.append(f"| {draw[0].situation} | {draw[0].seed} | {names} | {cells} |")
    return "\n".join(lines) + "\n"


def _end(outcome: Outcome, baseline: Outcome) -> str:
    first = outcome.first_violation
    if first is None or "SR1" not in flight_of(outcome, baseline).revealed:
        return "-"
    return f"SR1 at {first.t_s:.1f} s, ({first.x:.1f}, {first.y:.1f}) m, {first.struck}"


if __name__ == "__main__":
    main(__doc__, PLAN, results)
