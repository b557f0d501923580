"""The system under test: perception, estimation, memory, mission, planner, flight control.

It imports nothing of the rest of the package and does not know that mutants exist.
"""
