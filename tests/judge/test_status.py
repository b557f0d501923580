from __future__ import annotations

import pytest
from builders import outcome

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Ruling, Status, baseline_status, counting, furthest, rule

M = "LATE-human@3s"
HELD = outcome()
# struck the bar at 30 s: what it did not violate is open
CUT = outcome(violated={"SR1": 30.0}, struck="bar")


def ruling(flight: Outcome, baseline: Outcome | None = HELD) -> Ruling:
    return rule(flight, counting(baseline))


@pytest.mark.parametrize(
    ("flight", "baseline", "expected"),
    [
        (outcome(M, invalid="worker died"), HELD, "invalid"),
        (outcome(M), None, "invalid"),
        (outcome(M), outcome(invalid="worker died"), "invalid"),
        (outcome(M, carried=0, altered=0), HELD, "not_reached"),
        (outcome(M, altered=0), HELD, "not_infected"),
        (outcome(M, altered=0, violated={"SR1": 1.0}), HELD, "not_infected"),
        (outcome(M, digest="clean"), HELD, "masked"),
        (outcome(M), HELD, "survived"),
        (outcome(M, violated={"SR2": 20.0}), HELD, "revealed"),
        (outcome(M, violated={"SR1": 20.0}, struck="wall"), HELD, "revealed"),
        (outcome(M, violated={"OP1": 60.0}), HELD, "survived"),
        (outcome(M, violated={"SR2-literal": 20.0}), HELD, "survived"),
        # the baseline breaks the same requirement later, at the same moment, earlier; on another body, on the same
        (outcome(M, violated={"SR1": 29.0}, struck="wall"), CUT, "revealed"),
        (outcome(M, violated={"SR1": 29.0}, struck="bar"), CUT, "baseline_red"),
        (outcome(M, violated={"SR1": 31.0}, struck="wall"), CUT, "baseline_red"),
        (outcome(M, violated={"SR2": 9.0}), outcome(violated={"SR2": 10.0}), "baseline_red"),
        (outcome(M, violated={"SR1": 30.0}, struck="bar"), CUT, "baseline_red"),
        (outcome(M, violated={"SR1": 31.0}, struck="bar"), CUT, "baseline_red"),
        # the baseline left it open: up to its end it held, beyond nothing is known
        (outcome(M, violated={"SR2": 30.0}), CUT, "revealed"),
        (outcome(M, violated={"SR2": 30.5}), CUT, "baseline_red"),
        (outcome(M), CUT, "survived"),
        # the baseline held to its end: a later violation is the mutant's own
        (outcome(M, violated={"SR2": 80.0}, duration_s=90.0), HELD, "revealed"),
        # one requirement is the baseline's too, the other is not
        (outcome(M, violated={"SR2": 20.0, "SR1": 25.0}), outcome(violated={"SR2": 10.0}), "revealed"),
        (outcome(M, violated={"SR2": 20.0}), outcome(violated={"SR2": 10.0}), "baseline_red"),
    ],
)
def test_the_first_status_that_fits(flight: Outcome, baseline: Outcome | None, expected: str) -> None:
    assert ruling(flight, baseline).status.value == expected


def test_a_spurious_sample_on_a_silent_seam_infects() -> None:
    assert ruling(outcome(M, carried=0, altered=3)).status is Status.SURVIVED


def test_what_is_revealed_names_its_requirements_earliest_first() -> None:
    revealed = ruling(outcome(M, violated={"SR1": 25.0, "SR2": 20.0, "OP1": 50.0}))
    assert revealed.revealed == ("SR2", "SR1")
    assert revealed.operability_revealed == ("OP1",)
    assert revealed.violated == ("SR1", "SR2", "OP1")


def test_a_requirement_that_the_baseline_breaks_too_is_not_revealed() -> None:
    revealed = ruling(outcome(M, violated={"SR1": 25.0, "SR2": 20.0}), outcome(violated={"SR2": 10.0}))
    assert (revealed.revealed, revealed.violated) == (("SR1",), ("SR1", "SR2"))


def test_a_flight_that_changes_nothing_still_says_what_it_violates() -> None:
    assert ruling(outcome(M, altered=0, violated={"SR2": 20.0}), outcome(violated={"SR2": 20.0})).violated == ("SR2",)


def test_a_baseline_is_held_or_violated_by_its_safety_requirements() -> None:
    assert baseline_status(HELD) == "held"
    assert baseline_status(CUT) == "violated"
    assert baseline_status(outcome(violated={"OP1": 60.0, "SR2-literal": 3.0})) == "held"
    assert baseline_status(outcome(invalid="x")) == "invalid"


def test_a_mutants_status_is_the_furthest_stage_that_a_flight_reached() -> None:
    flights = [outcome(M, altered=0), outcome(M, digest="clean"), outcome(M, invalid="x")]
    assert furthest(ruling(flight).status for flight in flights) is Status.MASKED
    assert furthest([]) is Status.INVALID
