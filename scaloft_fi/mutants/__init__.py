"""Mutants: what is patched into which seam, derived from the deviation matrix."""
