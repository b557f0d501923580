"""The bugs of the experiment, and the stacks that have them."""

from __future__ import annotations

from experiments.bugs import (
    avoidance_357,
    avoidance_394,
    crazyflie_760,
    mavros_838,
    opendr_275,
    px4_5062,
    px4_6647,
    px4_9182,
    px4_11764,
    px4_11840,
    px4_11866,
    px4_14882,
    px4_20308,
    px4_23047,
)
from experiments.bugs.bug import Bug
from experiments.bugs.staged import declaration
from scaloft_fi.sim.stacks import STACKS, declare_stack

BUGS: tuple[Bug, ...] = tuple(
    module.BUG
    for module in (
        px4_11866,
        px4_23047,
        px4_11840,
        avoidance_394,
        mavros_838,
        px4_9182,
        px4_20308,
        crazyflie_760,
        px4_6647,
        px4_11764,
        opendr_275,
        px4_14882,
        px4_5062,
        avoidance_357,
    )
)
"""The bugs: first those of a list of threads that read like cells, then those that were looked for besides."""
SOUGHT = 6
"""How many of them, at the end, were looked for besides: in cells whose mutant has published kills."""
DROPPED = {
    "PX4-Autopilot 20519": "needs a companion that stops sending, which happens in no flight of this study",
    "PX4-Autopilot 15455": "asks for a shorter time-out; no fix, and fixes never stop in this study",
    "PX4-ECL 450": "needs stamps from the future, which no sensor of this study sends",
    "Fast-Planner 137": "a slow topic on the reporter's machine; no change of code",
}
"""Threads that were looked up and left out, with the reason."""


def declare() -> None:
    """Declare the stack of each bug, and `KEY-mended`, the same code with the defect off; once."""
    for bug in BUGS:
        for name, parts in ((bug.key, bug.parts), (f"{bug.key}-mended", bug.mended)):
            if name not in STACKS:
                declare_stack(declaration(name, parts))
