"""What a body in the mine is to those who look at it: one declared role for each kind of body.

A package of another author declares a role in a module that its entry point in the group `scaloft_fi.plugins` names:

    ROLES.declare("dog", Role("an animal that may stand in the way", label="dog", fill="#d6d3d1"))

and a study's `world.yaml` gives it to a body with `role: dog`.
"""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.registry import Registry


@dataclass(frozen=True)
class Role:
    """A role of bodies.

    Attributes:
        meaning: what such a body is, in a few words.
        label: class label of its boxes from the person detector; "" when the detector does not find it.
        is_person: whether `person_range_m` and `person_sight_m` measure the distance to it, and whether the nominal
            mission is flown slowly where it stands.
        is_obstacle: whether `obstacle_pixels` counts its pixels.
        fill, stroke: its colours on a map.
        stroke_px: width of its outline on a map [px].
    """

    meaning: str
    label: str = ""
    is_person: bool = False
    is_obstacle: bool = False
    fill: str = "#a8a29e"
    stroke: str = "#44403c"
    stroke_px: float = 1.4


ROLES = Registry[Role]("role of a body")
ROLES.declare("obstacle", Role("stands on the path", is_obstacle=True))
ROLES.declare(
    "person",
    Role("a person, whom SR2 protects", label="person", is_person=True, fill="#fdba74", stroke="#9a3412"),
)
ROLES.declare("structure", Role("part of the mine's fittings", fill="#111827", stroke="#111827", stroke_px=3.0))
