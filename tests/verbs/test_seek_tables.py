"""What is printed of a search."""

from __future__ import annotations

import pytest

from scaloft_fi.analysis.seeking import Effort
from scaloft_fi.campaign.seeking.seek import SeekReport, Sought
from scaloft_fi.verbs.seek import seek_tables, why_not

NEAR = Effort(5, 4, 3, 2, 0, 0.83, "SR1", "T1O0W0D0H1")


@pytest.mark.parametrize(
    ("effort", "candidates", "why"),
    [
        (Effort(), 0, "not flown"),
        (Effort(5), 0, "its seam carried no sample"),
        (Effort(5, 4), 0, "it changed no sample"),
        (Effort(5, 4, 3), 0, "it changed samples in 3, and the drone flew the same to the bit"),
        (Effort(5, 4, 3, 2), 0, "no safety requirement is held with room in the 3 where it changed samples"),
        (NEAR, 0, "it kept 83% of the robustness of SR1 in T1O0W0D0H1"),
        (Effort(5, 4, 3, 2, 1, -0.1, "SR1", "T1"), 0, "it violated SR1 in 1, not with every seed of the search"),
        (Effort(5, 4, 3, 2, 1, -0.1, "SR1", "T1"), 1, "1 candidate that fresh seeds did not confirm"),
        (NEAR, 2, "2 candidates that fresh seeds did not confirm"),
    ],
)
def test_a_mutant_without_a_find_says_where_it_stopped(effort: Effort, candidates: int, why: str):
    sought = Sought("LATE-depth@0.4s", "", 0, candidates, 0.005 * candidates, effort)
    assert why_not(sought) == why
    _, lacking = seek_tables(SeekReport((), (sought,), 9, 9, spent=True, alpha=0.01, anyhow=False), "paper")
    assert lacking.rows == (("LATE-depth@0.4s", effort.situations, why),)
