"""Limits of a flight: number of attempts, and wall time."""

ATTEMPTS = 3
"""Number of attempts for a flight that fails in the harness."""
PATIENCE_S = 300.0
"""A flight that takes longer is hung; a hundred times the usual time [s, wall]."""
