"""Fault-injection mutation testing of an autonomous drone: HAZOP mutants flown over a grid of situations."""

__version__ = "0.1.0"
