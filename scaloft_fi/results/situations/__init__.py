"""Situation coverage, ways to choose situations, and coverage against kills."""
