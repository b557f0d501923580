"""The reference stack with a planner of your own."""
