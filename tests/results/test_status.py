from __future__ import annotations

import pytest
from builders import outcome

from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.status import Ruling, Status, baseline_status, counting, mutant_status, rule

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
        (outcome(M, violated={"SR2": 20.0}), HELD, "killed"),
        (outcome(M, violated={"SR1": 20.0}, struck="wall"), HELD, "killed"),
        (outcome(M, violated={"OP1": 60.0}), HELD, "survived"),
        (outcome(M, violated={"SR2-literal": 20.0}), HELD, "survived"),
        # the baseline breaks the same requirement later, at the same moment, earlier; on another body, on the same
        (outcome(M, violated={"SR1": 29.0}, struck="wall"), CUT, "killed"),
        (outcome(M, violated={"SR1": 29.0}, struck="bar"), CUT, "baseline_red"),
        (outcome(M, violated={"SR1": 31.0}, struck="wall"), CUT, "baseline_red"),
        (outcome(M, violated={"SR2": 9.0}), outcome(violated={"SR2": 10.0}), "baseline_red"),
        (outcome(M, violated={"SR1": 30.0}, struck="bar"), CUT, "baseline_red"),
        (outcome(M, violated={"SR1": 31.0}, struck="bar"), CUT, "baseline_red"),
        # the baseline left it open: up to its end it held, beyond nothing is known
        (outcome(M, violated={"SR2": 30.0}), CUT, "killed"),
        (outcome(M, violated={"SR2": 30.5}), CUT, "baseline_red"),
        (outcome(M), CUT, "survived"),
        # the baseline held to its end: a later violation is the mutant's own
        (outcome(M, violated={"SR2": 80.0}, duration_s=90.0), HELD, "killed"),
        # one requirement is the baseline's too, the other is not
        (outcome(M, violated={"SR2": 20.0, "SR1": 25.0}), outcome(violated={"SR2": 10.0}), "killed"),
        (outcome(M, violated={"SR2": 20.0}), outcome(violated={"SR2": 10.0}), "baseline_red"),
    ],
)
def test_the_first_rung_that_fits(flight: Outcome, baseline: Outcome | None, expected: str) -> None:
    assert ruling(flight, baseline).status.value == expected


def test_a_spurious_sample_on_a_silent_seam_infects() -> None:
    assert ruling(outcome(M, carried=0, altered=3)).status is Status.SURVIVED


def test_a_kill_names_its_requirements_earliest_first() -> None:
    killed = ruling(outcome(M, violated={"SR1": 25.0, "SR2": 20.0, "OP1": 50.0}))
    assert killed.kills == ("SR2", "SR1")
    assert killed.operability_kills == ("OP1",)


def test_a_requirement_the_baseline_breaks_too_is_no_part_of_the_kill() -> None:
    killed = ruling(outcome(M, violated={"SR1": 25.0, "SR2": 20.0}), outcome(violated={"SR2": 10.0}))
    assert killed.kills == ("SR1",)


def test_a_flight_is_eligible_where_it_is_infected_and_the_baseline_held_a_safety_requirement_to_its_end() -> None:
    assert ruling(outcome(M)).eligible
    assert ruling(outcome(M), outcome(violated={"SR2": 10.0})).eligible
    assert ruling(outcome(M, digest="clean")).eligible
    assert not ruling(outcome(M), CUT).eligible
    assert not ruling(outcome(M, altered=0)).eligible
    assert not ruling(outcome(M, invalid="x")).eligible
    assert not ruling(outcome(M), outcome(violated={"SR1": 9.0, "SR2": 9.0})).eligible


def test_a_kill_before_a_cut_short_baselines_end_is_a_kill_that_is_not_eligible() -> None:
    killed = ruling(outcome(M, violated={"SR1": 9.0}, struck="wall"), CUT)
    assert (killed.status, killed.eligible) == (Status.KILLED, False)


def test_a_baseline_is_held_or_violated_by_its_safety_requirements() -> None:
    assert baseline_status(HELD) == "held"
    assert baseline_status(CUT) == "violated"
    assert baseline_status(outcome(violated={"OP1": 60.0, "SR2-literal": 3.0})) == "held"
    assert baseline_status(outcome(invalid="x")) == "invalid"


def test_a_mutants_status_is_its_highest_rung_over_eligible_flights() -> None:
    red = ruling(outcome(M, violated={"SR1": 9.0}, struck="wall"), CUT)
    masked, survived = ruling(outcome(M, digest="clean")), ruling(outcome(M))
    assert mutant_status([red, masked, survived]) is Status.SURVIVED
    assert mutant_status([red, masked]) is Status.MASKED
    assert mutant_status([red]) is Status.BASELINE_RED
    assert mutant_status([ruling(outcome(M, altered=0))]) is Status.NOT_INFECTED
    assert mutant_status([]) is Status.INVALID
