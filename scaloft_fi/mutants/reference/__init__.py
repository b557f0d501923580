"""Operators on messages that only the reference stack has; its declaration names this package."""

from scaloft_fi.mutants.reference import collision, goal, limits, mapping, pose, route

__all__ = ["collision", "goal", "limits", "mapping", "pose", "route"]
