"""Situation coverage for readers."""
