"""Mutants: faults that are patched into seams, derived from the deviation matrix."""
