"""Names, units and meanings of the signals that the flight log records at 20 Hz."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from scaloft_fi.sim.measures import SIGNALS
from scaloft_fi.stack.declaration import Belief

SAMPLE_HZ = 20.0
FAR_M = 100.0
"""Value of a distance to something absent [m]."""
CLEARANCE_CAP_M = 1.0
"""Greatest measured clearance [m]."""
TOUCH_M = -0.001
"""Greatest clearance during a contact [m]."""


class Side(StrEnum):
    """Whether a signal is ground truth or a belief of the stack."""

    TRUTH = "truth"
    PERCEIVED = "perceived"


@dataclass(frozen=True)
class Signal:
    """One column of the log.  unit: "" for a dimensionless number."""

    name: str
    unit: str
    meaning: str
    side: Side


def _signals(side: Side, table: str) -> tuple[Signal, ...]:
    rows = (line.split("|") for line in table.strip().splitlines())
    return tuple(Signal(name.strip(), unit.strip(), meaning.strip(), side) for name, unit, meaning in rows)


TRUTH = _signals(
    Side.TRUTH,
    """
    elapsed_s          | s   | time since the start
    remaining_s        | s   | time left until the time limit
    x_m                | m   | position of the vehicle's centre, world
    y_m                | m   | position, world
    z_m                | m   | position, world
    vx_mps             | m/s | velocity, world
    vy_mps             | m/s | velocity, world
    vz_mps             | m/s | velocity, world
    qx                 |     | attitude quaternion, body to world
    qy                 |     | attitude quaternion
    qz                 |     | attitude quaternion
    qw                 |     | attitude quaternion
    yaw_rad            | rad | heading, world
    speed_mps          | m/s | greatest speed since the last sample
    clearance_m        | m   | least of the clearances below; at most -0.001 after any contact since the last sample
    person_range_m     | m   | from the vehicle's centre to the nearest person's surface; 100 without one
    person_sight_m     | m   | the same where a free straight line exists; 100 otherwise
    waypoints_left     |     | waypoints of the route, home last, not yet passed within 0.5 m in order
    home_m             | m   | level distance from home
    landed             |     | 1 from the first excused touch of the ground after take-off
    light              |     | brightness of visible light, 0..1
    obstacle_pixels    |     | pixels of obstacles in the range of the depth camera
    waypoint_wall_m    | m   | hull to wall while within 0.5 m of a waypoint other than home; 100 otherwise
    """,
)

TRUTH_NAMES = tuple(signal.name for signal in TRUTH)


def clearance_name(surface: str) -> str:
    """The signal of the clearance to one surface.

    >>> clearance_name("wall")
    'clearance_wall_m'
    """
    return f"clearance_{surface}_m"


def truth_signals(surfaces: Iterable[str], declared: Iterable[str] = ()) -> tuple[Signal, ...]:
    """The signals of the ground truth.

    Args:
        surfaces: surfaces of the world (`World.surfaces`); each has a clearance.
        declared: names of the optional signals that the world lists (`World.signals`).
    """
    clearances = tuple(
        Signal(clearance_name(name), "m", f"hull to {name}, at most 1; 1 where it is not there or excused", Side.TRUTH)
        for name in surfaces
    )
    optional = (SIGNALS[name] for name in declared)
    return TRUTH + clearances + tuple(Signal(one.name, one.unit, one.meaning, Side.TRUTH) for one in optional)


def signal_names(surfaces: Iterable[str], beliefs: Iterable[Belief], declared: Iterable[str] = ()) -> tuple[str, ...]:
    """The signal names of a flight log: ground truth, then beliefs; see `truth_signals` and `belief_signals`."""
    return tuple(signal.name for signal in (*truth_signals(surfaces, declared), *belief_signals(beliefs)))


def belief_signals(beliefs: Iterable[Belief]) -> tuple[Signal, ...]:
    """The signals of a stack's beliefs."""
    return tuple(Signal(belief.name, belief.unit, belief.meaning, Side.PERCEIVED) for belief in beliefs)
