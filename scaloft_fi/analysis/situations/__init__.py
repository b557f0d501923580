"""Situation coverage, and situations chosen to cover."""
