"""A plan from its first flight to its gates, whole or as far as it was asked for."""
