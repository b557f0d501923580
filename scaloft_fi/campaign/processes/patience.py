"""How often a flight is tried, and how long it is waited for."""

ATTEMPTS = 3
"""A flight over which the harness fails is tried this often."""
PATIENCE_S = 300.0
"""A flight that takes longer is hung: a hundred times what it should take [s, wall]."""
