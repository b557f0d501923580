"""Situation coverage as it is told."""
