"""The page of `testbed.py`: what its flights did, measured at the seams of the border and in the logs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from experiments.testbed import Crossing, Flown

SLOW_MPS = 0.25
"""A speed limit up to this is a slow order [m/s]."""
GAP_S = 0.5
"""Goals that pause for longer have another script after the pause [s]."""
BEFORE_S, BRAKED_S = 5.0, 1.0
"""Time before a slow order in which speed is looked at, and after it in which the drone may slow down [s]."""
PLACES = {"(0, 7)": (0.0, 7.0), "(-3, 8)": (-3.0, 8.0)}

HEAD = """# The mission scripts of the SCALOFT testbed above our planner

The testbed's two mission scripts run unmodified, one after the other, as the mission of our drone: over ROS 1, on the
topics `/mavros/global_position/local`, `/darknet_ros/bounding_boxes`, `/gazebo_bumper`, `/move_base_simple/goal`,
`/drone_update_vel`, `/land_command`, with `/clock` and the service `/gazebo/set_model_state`.  Planner, estimator and
flight control below them, sensors and mine are ours, in light.  The person appears when the drone is at (-3, 8), which
is when the second script asks for it.  Made by `python -m experiments.testbed SETUP_SCRIPT TRIAL_SCRIPT`
(`docs/outside_ros1.md`): each flight was flown once with seed 0, and none is left out.

The scripts answer no tick, so simulated time is paced, at most twice as fast as the clock on the wall, and two flights
of one subject differ: a time below is one draw.  What crosses a seam was recorded before and after its tap.

The scripts:
"""


def page(flights: Sequence[Flown], scripts: Mapping[str, str]) -> str:
    """The page of these flights; `scripts` has the SHA-256 of each script by its name."""
    files = [f"- `{name}`, SHA-256 `{digest}`" for name, digest in scripts.items()]
    tables = [*_table_of_flights(flights), "", *_table_of_orders(flights), ""]
    findings = [*_findings(flights), "", *_otherwise(flights), ""]
    return "\n".join([HEAD, *files, "", *tables, *findings])


def _table_of_flights(flights: Sequence[Flown]) -> Iterator[str]:
    yield "## Flights"
    yield ""
    yield "`within`: the least distance to the waypoint, in the plane.  `home`: that of the last sample to (0, 0)."
    yield "`digest`: the first digits of that of the ground truth."
    yield ""
    places = " | ".join(f"within of {place}" for place in PLACES)
    yield f"| flight | ended | {places} | home | SR1 | SR2 | OP1 | simulated | wall | digest | stack error |"
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|"
    for one in flights:
        x, y = one.log.signals["x_m"], one.log.signals["y_m"]
        near = [min(math.hypot(a - px, b - py) for a, b in zip(x, y, strict=True)) for px, py in PLACES.values()]
        cells = [
            f"`{one.name}`",
            one.outcome.ending + (f", struck {one.log.struck}" if one.log.struck else ""),
            *(f"{metres:.2f} m" for metres in near),
            f"{math.hypot(x[-1], y[-1]):.2f} m",
            *(_reading(one, name) for name in ("SR1", "SR2", "OP1")),
            f"{_end_s(one):.2f} s",
            f"{one.wall_s:.0f} s",
            f"`{one.outcome.digest[:8]}`",
            one.log.stack_error or "none",
        ]
        yield f"| {' | '.join(cells)} |"


def _reading(one: Flown, name: str) -> str:
    reading = next(r for r in one.outcome.readings if r.requirement == name)
    said = "not triggered" if not reading.triggered else f"{reading.rho:+.2f}"
    at = "" if reading.violated_at_s is None else f", violated at {reading.violated_at_s:.2f} s"
    return f"{'open' if reading.open else said}{at}"


def _end_s(one: Flown) -> float:
    return float(one.log.signals["elapsed_s"][-1])


def _first(one: Flown, seam: str, holds: Callable[[Crossing], bool]) -> Crossing | None:
    return next((c for c in one.crossings if c.seam == seam and holds(c)), None)


def second_script(one: Flown) -> float | None:
    """When the first goal after the longest pause came: that of the second script [s]."""
    times = [c.t_s for c in one.crossings if c.seam == "destination" and c.sent is not None]
    later = [(b - a, b) for a, b in pairwise(times) if b - a > GAP_S]
    return max(later)[1] if later else None


def seen(one: Flown) -> Crossing | None:
    """The first message of the detector with a person."""
    return _first(one, "person", lambda c: c.sent is not None and bool(c.sent.persons))


def told(one: Flown) -> Crossing | None:
    """The first one that the script could get."""
    return _first(one, "person", lambda c: c.delivered is not None and bool(c.delivered.persons))


def slowed(one: Flown) -> Crossing | None:
    """The first slow order."""
    return _first(one, "speed", lambda c: c.delivered is not None and c.delivered.limit_mps <= SLOW_MPS)


def touched(one: Flown) -> list[float]:
    """When the contacts began that the script could hear of [s]."""
    times = [c.t_s for c in one.crossings if c.seam == "contact" and c.delivered is not None and c.delivered.hull]
    return [t_s for place, t_s in enumerate(times) if place == 0 or t_s - times[place - 1] > GAP_S]


def last_goal(one: Flown) -> Crossing | None:
    """The last goal that the planner got."""
    goals = [c for c in one.crossings if c.seam == "destination" and c.delivered is not None]
    return goals[-1] if goals else None


def landing(one: Flown) -> Crossing | None:
    """The order to land."""
    return _first(one, "landing", lambda c: c.delivered is not None)


def _table_of_orders(flights: Sequence[Flown]) -> Iterator[str]:
    yield "## Orders"
    yield ""
    yield "Simulated time, and in brackets wall time since the first message.  `seen`: the detector's first message"
    yield "with a person; `told`: the first one that the script could get; `slow`: its first slow order at the planner."
    yield ""
    heads = "second script's first goal", "seen", "told", "slow", "seen to slow", "contacts told", "last goal", "land"
    yield f"| flight | {' | '.join(heads)} |"
    yield "|---" * (1 + len(heads)) + "|"
    for one in flights:
        started_s = second_script(one)
        cells = [
            f"`{one.name}`",
            "none" if started_s is None else f"{started_s:.2f} s",
            *(_at(crossing) for crossing in (seen(one), told(one), slowed(one))),
            _seconds(delay(one)),
            ", ".join(f"{t_s:.2f} s" for t_s in touched(one)) or "none",
            _at(last_goal(one)),
            _at(landing(one)),
        ]
        yield f"| {' | '.join(cells)} |"


def _at(crossing: Crossing | None) -> str:
    return "none" if crossing is None else f"{crossing.t_s:.2f} s ({crossing.wall_s:.2f} s)"


def _seconds(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f} s"


def delay(one: Flown) -> float | None:
    """From the detector's first person to the first slow order [s, simulated]."""
    begin, end = seen(one), slowed(one)
    return None if begin is None or end is None else end.t_s - begin.t_s


def _findings(flights: Sequence[Flown]) -> Iterator[str]:
    by_name = {one.name: one for one in flights}
    yield "## What was shown"
    yield ""
    for one in flights:
        if one.name.startswith("baseline"):
            yield f"- `{one.name}`: {_slowed(one)}{_course(one)}"
    yield from _late(by_name.get("baseline/H1/0"), by_name.get("LATE-human@3s/H1/0"))
    for one in flights:
        if one.name.startswith("UNINTENDED"):
            yield f"- `{one.name}`: {_given_up(one)}{_course(one)}"
        if one.name.startswith("MORE"):
            goal = last_goal(one)
            said = (
                ""
                if goal is None
                else f"the last place ordered was {_place(goal.sent)}, {_place(goal.delivered)} arrived; "
            )
            yield f"- `{one.name}`: {said}{_course(one)}"


def _course(one: Flown) -> str:
    ends = {"landed": "it landed", "timed_out": "it was still in the air at the time limit", "struck": "it struck"}
    what = ends.get(one.outcome.ending, one.outcome.ending) + (f" {one.log.struck}" if one.log.struck else "")
    x, y = (float(one.log.signals[name][-1]) for name in ("x_m", "y_m"))
    broken = [v.requirement for v in one.outcome.violations]
    return f"{what} at ({x:.2f}, {y:.2f}) after {_end_s(one):.2f} s; violated: {', '.join(broken) or 'nothing'}."


def _slowed(one: Flown) -> str:
    """How fast it was before and after the slow order; "" without one."""
    order = slowed(one)
    if order is None:
        return ""
    times, speeds = one.log.signals["elapsed_s"], one.log.signals["speed_mps"]
    before = float(speeds[(times <= order.t_s) & (times > order.t_s - BEFORE_S)].max())
    after = float(speeds[times >= order.t_s + BRAKED_S].max())
    return (
        f"it flew at most {before:.2f} m/s in the {BEFORE_S:g} s before the slow order, and {after:.2f} m/s from "
        f"{BRAKED_S:g} s after it; "
    )


def _late(baseline: Flown | None, late: Flown | None) -> Iterator[str]:
    usual_s, late_s = (None if one is None else delay(one) for one in (baseline, late))
    if usual_s is None or late_s is None or late is None:
        yield "- LATE-human@3s: a slow order is missing, so that no delay was measured."
        return
    yield (
        f"- `{late.name}`: the slow order comes {late_s:.2f} s of simulated time after the detector's first person, "
        f"{usual_s:.2f} s in the baseline: {late_s - usual_s:.2f} s later; {_slowed(late)}{_course(late)}"
    )


def _given_up(one: Flown) -> str:
    started_s, goal = second_script(one), last_goal(one)
    heard = [t_s for t_s in touched(one) if started_s is not None and t_s >= started_s]
    if not heard or goal is None:
        return "no false contact fell into the second script's time; "
    return (
        f"the false contact at {heard[0]:.2f} s was the first one in the second script's time, the last goal came at "
        f"{goal.t_s:.2f} s, for {_place(goal.delivered)}; "
    )


def _place(sample: Any) -> str:
    return "none" if sample is None else f"({sample.point[0]:g}, {sample.point[1]:g}, {sample.point[2]:g})"


def _otherwise(flights: Sequence[Flown]) -> Iterator[str]:
    """What is not as the paper, or an even stack, would have it."""
    yield "## What was not"
    yield ""
    for name in ("UNINTENDED-collision", "MORE-goal"):
        own = [one for one in flights if one.name.startswith(name)]
        struck = [one for one in own if any(v.requirement == "SR1" for v in one.outcome.violations)]
        yield (
            f"- {name}: the paper saw SR1 violated; here {len(struck)} of {len(own)} flights violate it. {WHY[name]}"
        )
    by_name = {one.name: one for one in flights}
    baseline, placebo = by_name.get("baseline/H1/0"), by_name.get("PLACEBO/H1/0")
    if baseline is not None and placebo is not None:
        alike = "is" if placebo.outcome.digest == baseline.outcome.digest else "is not"
        yield f"- PLACEBO's flight {alike} that of the baseline to the bit; nothing promises it: flights are paced."


WHY: Mapping[str, str] = {
    "UNINTENDED-collision": "The topic ends the mission alone: our planner holds the last place that was ordered.",
    "MORE-goal": "The topic carries places and no goal test, so the fault moves the places.  From a factor of "
    "1.02 on (-3, 8) is moved beyond the 0.1 m within which the first script counts it as reached.",
}
"""What of a fault the topic allows."""
