"""Roles of the bodies in the mine: detector, observer and map treat a body by its role.

A plugin declares a role in a module that its entry point in the group `scaloft_fi.plugins` names:

    ROLES.declare("dog", Role("an animal that may stand in the way", label="dog", fill="#d6d3d1"))

A body in a study's `world.yaml` gets the role with `role: dog`.
"""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.registry import Registry


@dataclass(frozen=True)
class Role:
    """A role of bodies.

    Attributes:
        meaning: the role in a few words.
        label: class label of the detector's boxes for such a body; "" if the detector ignores it.
        is_person: whether `person_range_m` and `person_sight_m` measure the distance to the body, and whether the
            nominal flight uses the slow speed if such a body is present.
        is_obstacle: whether `obstacle_pixels` counts the pixels of the body.
        fill, stroke: colours of the body on a map.
        stroke_px: width of the body's outline on a map [px].
    """

    meaning: str
    label: str = ""
    is_person: bool = False
    is_obstacle: bool = False
    fill: str = "#a8a29e"
    stroke: str = "#44403c"
    stroke_px: float = 1.4

    @property
    def seen_as(self) -> tuple[str, bool, bool]:
        """The part that can change a flight: how detector and observer treat the body."""
        return self.label, self.is_person, self.is_obstacle


ROLES = Registry[Role]("role of a body")
ROLES.declare("obstacle", Role("stands on the path", is_obstacle=True))
ROLES.declare(
    "person",
    Role("a person, whom SR2 protects", label="person", is_person=True, fill="#fdba74", stroke="#9a3412"),
)
ROLES.declare("structure", Role("part of the mine's fittings", fill="#111827", stroke="#111827", stroke_px=3.0))
