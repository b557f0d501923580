"""What the line about a verdict says, case by case, and that every line is true of its mutant."""

from __future__ import annotations

from typing import Any

import pytest
from builders import GRID, ROSTER, campaigns, outcome, pool, seeded
from effort import usually
from finding import flies, found, known
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.score import Score, score
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.verdict import next_command, verdict, why, would_decide

M = "LATE-human@3s"
HERE, THERE, RED = "T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H1"
RED_POOL = pool(RED, red=10, violated={"SR1": 20.0, "SR2": 20.0})


def scored(*flights: Outcome) -> Score:
    return score(flights, ROSTER, GRID, Spending())


def flown(
    situation: str = HERE, seeds: int = 3, violating: int = 0, name: str = "SR2", *, masked: bool = False, **how: Any
) -> list[Outcome]:
    """Flights of the mutant, the first of which violate a requirement."""
    return [
        outcome(
            *(M, situation, seed),
            violated={name: 9.0} if seed < violating else {},
            digest="clean" if masked else None,
            **how,
        )
        for seed in range(seeds)
    ]


def line(*flights: Outcome) -> str:
    found = scored(*flights)
    return verdict(found.mutants[0], found.lacking)


def test_a_detected_mutant_is_killed_in_situations_by_requirements() -> None:
    said = line(*pool(HERE, THERE), *flown(HERE, violating=3), *flown(THERE))
    assert said == "detected: killed in 1 of 2 situations that test it (SR2 in 1 of 2); hangs on a seed"


def test_a_detected_mutant_without_a_kill_says_by_what_it_is_detected() -> None:
    keys = [key for key, _ in GRID.points[:6]]
    said = line(*pool(*keys), *(flight for key in keys for flight in flown(key, violating=1)))
    assert said.startswith("detected: it violates SR2 (p = 0.000")
    assert said.endswith(
        "more often than chance explains, but nowhere in most of its flights; seen in 6 of 6 situations that test it; "
        "hangs on a seed"
    )


def test_an_undecided_mutant_says_what_was_seen_and_how_many_seeds_would_decide() -> None:
    said = line(*pool(HERE), *flown(seeds=1, violating=1))
    assert said == (
        "undecided: it violates SR2 in 1 of 1 situation that tests it, which chance may explain (p = 0.18); "
        "5 seeds would decide, if this goes on"
    )


def test_too_few_flights_to_tell_are_told_from_nothing_seen() -> None:
    assert line(*pool(HERE), *flown(seeds=1)) == (
        "undecided: nothing seen in 1 situation that tests it, with too few flights to tell; 5 seeds would decide"
    )
    assert line(*pool(HERE), *flown()) == (
        "not detected: nothing seen in 1 situation that tests it; "
        "the flights that changed violate no safety requirement"
    )


def test_a_campaign_without_a_pool_says_what_was_seen_and_that_baselines_would_decide() -> None:
    assert line(*pool(HERE, seeds=3), *flown(violating=2)) == (
        "undecided: too few baseline flights to tell; 2 of its 3 flights violate a safety requirement that the "
        "baseline beside them holds; 10 baseline flights in each situation would decide"
    )
    assert line(*pool(HERE), *pool(THERE, seeds=3), *flown(HERE), *flown(THERE)) == (
        "undecided: nothing seen in 1 situation that tests it, and others have too few baseline flights to tell; "
        "10 baseline flights in each situation would decide"
    )


def test_a_mutant_whose_flights_did_not_change_is_told_from_one_that_violates_only_in_red_situations() -> None:
    assert line(*pool(HERE), *flown(masked=True)).endswith("; samples changed, no flight did")
    assert line(*pool(HERE), *RED_POOL, *flown(), *flown(RED, violating=3)) == (
        "not detected: nothing seen in 1 situation that tests it; violations only where the unmutated drone does not "
        "hold the requirement steadily"
    )


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"situation": RED}, "it changes no sample where the unmutated drone holds a safety requirement steadily"),
        ({"altered": 0}, "it changes no sample in any situation flown"),
        ({"altered": 0, "carried": 0}, "no sample crosses the patched interface in any situation flown"),
        ({"invalid": "the worker died"}, "the harness failed in every flight"),
    ],
)
def test_a_mutant_that_was_not_tested_says_why(how: dict[str, Any], says: str) -> None:
    assert line(*pool(HERE), *RED_POOL, *flown(**how)) == f"not tested: {says}"


def test_detection_by_operability_stands_behind_the_verdict() -> None:
    assert line(*pool(HERE), *flown(violating=3, name="OP1")).endswith("; by operability it is detected")


def test_the_next_command_flies_what_would_decide_with_the_seeds_that_were_asked_for() -> None:
    def called(*flights: Outcome) -> str:
        found = scored(*flights)
        return next_command(found.mutants[0], found.lacking, "mine")

    own = "scaloft-fi run --campaign mine --mutant LATE-human@3s"
    assert called(*pool(HERE), *flown(seeds=1)) == f"{own} --seeds 5"
    assert called(*pool(HERE, seeds=3), *flown()) == f"{own} --seeds 3"
    another = own.replace("mine", "ANOTHER")
    assert called(*pool(HERE), *flown(seeds=10, violating=4)) == f"{another} --seeds 20"
    assert called(*pool(HERE), *flown(altered=0)) == "scaloft-fi kills --campaign mine LATE-human@3s --show survivors"


def test_the_find_of_a_mutant_is_the_next_command_before_any_seeds() -> None:
    for flights in (flown(seeds=1), flown(altered=0)):
        found_ = scored(*pool(HERE), *flights)
        said = next_command(found_.mutants[0], found_.lacking, "mine", "", known(found("LATE-human@3s")))
        assert said == flies("LATE-human@3s")


@settings(deadline=None, max_examples=usually(25, release=50))
@given(st.one_of(campaigns(), seeded()))
def test_every_line_begins_with_the_verdict_and_only_an_open_one_says_what_would_decide(
    outcomes: list[Outcome],
) -> None:
    found = scored(*outcomes)
    for mutant in (*found.mutants, *found.controls):
        said = verdict(mutant, found.lacking)
        assert said == f"{mutant.verdict.words}: {why(mutant, found.lacking)}"
        assert ("would decide" in said) == (mutant.verdict is Verdict.UNDECIDED)
        assert bool(would_decide(mutant, found.lacking)) == (mutant.verdict is Verdict.UNDECIDED)
        assert ("killed" in said) == bool(mutant.kills)
        assert next_command(mutant, found.lacking, "c").startswith("scaloft-fi ")
