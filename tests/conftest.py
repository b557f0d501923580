"""Hypothesis draws the same examples in every run, and no wall clock fails a test."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("scaloft-fi", derandomize=True, deadline=None)
settings.load_profile("scaloft-fi")
