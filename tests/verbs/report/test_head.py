"""What the unmutated drone fails, and what is not claimed, at the top of the page."""

from __future__ import annotations

from dataclasses import replace

import pytest
from papers import BAR, SHAKY, campaign

from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import Score, score
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import Evidence
from scaloft_fi.verbs.report.page import MODEL, NO_POOL, WHOLE, head
from scaloft_fi.verbs.verdict import NOT_COMPARED

ALL = Ratio(32, 32)


@pytest.fixture(scope="module")
def scored(evidence: Evidence) -> Score:
    return score(evidence.outcomes, evidence.study.roster, evidence.study.space)


def test_the_drone_without_a_fault_fails_what_most_or_some_of_its_flights_violate(scored: Score) -> None:
    # SR1 is red at the bar, unsteady where three of ten strike a wall; SR2 is red in the dark with a person
    assert {scored.pool.states[key, "SR1"].value for key in (BAR, SHAKY)} == {"red", "unsteady"}
    assert head(scored, ALL, 0)["fails"] == [
        "It violates SR1 in most flights of 1 and now and then in 1 of 32 situations.",
        "It violates SR2 in most flights of 8 of 32 situations.",
        "No fault is put to the safety test in 2 of these 32 situations: no safety requirement is steady there.",
    ]


def test_breaks_around_the_grid_are_counted(scored: Score) -> None:
    assert head(scored, ALL, 1)["fails"][-1] == "A search around the grid found 1 situation more that breaks it."


def test_a_drone_that_fails_nothing_is_said_to(study: Study) -> None:
    clean = [o for o in campaign(study, ("NO-depth@3s",)) if o.situation in ("T0O0W1D0H0", "T0O0W0D0H1")]
    (said,) = head(score(clean, study.roster, study.space), ALL, 0)["fails"]
    assert said == "In none of the 2 situations with a pool does it violate a safety requirement often."


def test_without_a_pool_nothing_is_known_of_the_drone(study: Study) -> None:
    few = score(campaign(study, ("LATE-human@3s",), range(1), range(1)), study.roster, study.space)
    assert head(few, ALL, 0) == {"fails": [NO_POOL], "claims": [WHOLE, NOT_COMPARED, MODEL]}


def test_what_is_not_claimed_names_the_undecided_the_selected_and_what_was_not_flown(scored: Score) -> None:
    assert head(scored, ALL, 0)["claims"] == [
        WHOLE,
        NOT_COMPARED,
        "Nothing is said of the faults that are not decided: 1 undecided, 1 never put to the test.",
        MODEL,
    ]
    some = replace(scored, selected=("T0O0W0D0H1",))
    claims = head(some, Ratio(3, 32), 0)["claims"]
    assert "1 situation was chosen because of verdicts." in claims
    assert "Only 3 of 32 situations of the grid were flown." in claims
