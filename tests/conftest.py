"""Makes the helpers in `support` importable; Hypothesis draws the same examples in every run, at any speed."""

from __future__ import annotations

import sys
from pathlib import Path

from hypothesis import settings

import scaloft_fi.mutants.reference  # noqa: F401 - a study that names the reference stack declares its operators so

sys.path.insert(0, str(Path(__file__).parent / "support"))

settings.register_profile("scaloft-fi", derandomize=True, deadline=None)
settings.load_profile("scaloft-fi")
