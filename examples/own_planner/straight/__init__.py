"""The reference stack with another planner."""
