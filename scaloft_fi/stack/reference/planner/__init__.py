"""Local planner of the 3DVFH* kind: histogram, costs and look-ahead tree; then from a direction to a velocity."""

from scaloft_fi.stack.reference.planner.config import PlannerConfig
from scaloft_fi.stack.reference.planner.planner import LocalPlan, Planner
from scaloft_fi.stack.reference.planner.velocity import shape_velocity

__all__ = ["LocalPlan", "Planner", "PlannerConfig", "shape_velocity"]
