from __future__ import annotations

from dataclasses import replace

from builders import ROSTER, SPACE, outcome

from scaloft_fi.results.compare import Difference, Said, compare, comparison_table

M = "LATE-human@3s"
