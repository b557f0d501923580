"""What is said of a verdict and what to do next, case by case, and that every line is true of its mutant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest
from builders import GRID, ROSTER, campaigns, outcome, pool, seeded, thrice
from effort import usually
from finding import flies as command
from finding import found, known
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.score import MutantScore, Score, score
from scaloft_fi.analysis.survivor import Background
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.sim.found import Again
from scaloft_fi.verbs.survivors import survivors
from scaloft_fi.verbs.verdict import (
    Next,
    facts,
    flies,
    flown_in_vain,
    next_command,
    next_find,
    next_steps,
    short_step,
    verdict,
    why,
    would_decide,
)

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
        assert said == command("LATE-human@3s")


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


LATE, NO = "LATE-human@3s", "NO-human@100%"
HUMAN, NOBODY = "T0O0W0D0H1", "T0O0W0D0H0"
FIND = found(LATE)


def scored_late(*flights: Outcome) -> MutantScore:
    return next(mutant for mutant in score([*pool(HUMAN), *flights], ROSTER, GRID).mutants if mutant.subject.id == LATE)


def test_the_find_of_a_mutant_that_is_not_detected_is_to_be_flown_whatever_its_verdict() -> None:
    undecided, tested, untested = outcome(LATE, HUMAN), thrice(LATE, HUMAN), outcome(LATE, HUMAN, altered=0)
    for flights in ([undecided], tested, [untested]):
        assert next_find(scored_late(*flights), known(found(NO), FIND)) == FIND


def test_a_detected_mutant_or_one_that_no_flight_counts_for_has_nothing_to_fly() -> None:
    assert next_find(scored_late(*thrice(LATE, HUMAN, violated={"SR2": 7.0})), known(FIND)) is None
    assert next_find(scored_late(outcome(LATE, HUMAN, invalid="the worker died")), known(FIND)) is None
    assert next_find(scored_late(*thrice(LATE, HUMAN)), known(found(NO))) is None


def test_a_find_that_was_flown_here_with_as_many_seeds_is_not_flown_again() -> None:
    here = found(LATE, HUMAN)
    few, enough = [outcome(LATE, HUMAN, seed) for seed in range(5)], [outcome(LATE, HUMAN, seed) for seed in range(6)]
    assert next_find(scored_late(*few), known(here)) == here
    assert flown_in_vain(scored_late(*few), known(here)) == ()
    assert next_find(scored_late(*enough), known(here)) is None
    assert flown_in_vain(scored_late(*enough), known(here)) == (here,)
    other = found(NO, others=(LATE,))
    assert next_find(scored_late(*enough), known(here, other)) == other


def test_the_command_names_grid_mutant_situation_and_seeds_and_the_campaign_over_that_grid() -> None:
    finds = known(FIND)
    assert flies(FIND, LATE, finds, "default") == command(LATE)
    assert flies(FIND, LATE, finds, "mine", "wide") == command(LATE)
    assert flies(FIND, LATE, finds, "paper+found", "paper+found") == command(LATE)
    assert flies(FIND, LATE, finds, "mine", "paper+found") == command(LATE, campaign="mine")
    named = replace(FIND, name="a person's walk")
    assert "--situation 'a person'\"'\"'s walk' --seeds 6" in flies(named, LATE, finds, "default")


def test_the_facts_are_the_situation_in_words_what_is_struck_and_the_evidence() -> None:
    assert facts(found(LATE, struck="person"), LATE) == (
        f"a search found a situation that shows it, shows-{LATE} (human walks, cruise speed 0.8 m/s): it violates SR2 "
        "and strikes person there, in 6 of 6 flights (p = 0.00025); the unmutated drone holds SR2 in 10 of 10 by more "
        "than its spread.  It is not replicated yet (`scaloft-fi seek --replicate`)."
    )
    again = replace(FIND.shows[LATE], again=Again(100_000, 0.0001, 9, 10, 30, 30, 29))
    replicated = facts(replace(FIND, shows={LATE: again}), LATE)
    assert replicated.endswith("On seeds that nothing before used it held again: 9 of 10 (p = 0.0001).")


WEAK, LAST = Background("person", ("SR2",), stronger=("LATE-human@5s",), laddered=True), Background("person", ("SR2",))


def _known(outcomes: list[Outcome], background: Background) -> Mapping[str, Background]:
    return dict.fromkeys([flight.mutant for flight in outcomes], background)


@settings(deadline=None, max_examples=usually(25, release=100))
@given(
    st.one_of(campaigns(), seeded()),
    st.sampled_from([WEAK, LAST, Background("person", ("OP1",)), Background("person", expected="declared")]),
)
def test_kills_the_first_screen_and_the_exports_agree(outcomes: list[Outcome], background: Background) -> None:
    scored, known = score(outcomes, ROSTER, GRID), _known(outcomes, background)
    told = survivors(outcomes, scored, kill_matrix(scored, ROSTER, GRID), known, {})
    mutants = {mutant.subject.id: mutant for mutant in scored.mutants}
    for survivor in told:
        mutant = mutants[survivor.mutant]
        steps = next_steps(mutant, scored, known[survivor.mutant])
        assert survivor.next in steps
        assert short_step(mutant, steps, background)
        flies = next_command(mutant, scored.lacking, "c").startswith("scaloft-fi run")
        assert flies == (survivor.next in (Next.POOL, Next.SEEDS))


@pytest.mark.parametrize(("background", "step"), [(WEAK, Next.MAGNITUDE), (LAST, Next.SITUATION)])
def test_more_seeds_are_not_asked_of_a_fault_that_flies_the_same_to_the_bit(background: Background, step: Next) -> None:
    scored = score([*pool(HUMAN), outcome(LATE, HUMAN, digest="clean")], ROSTER, GRID)
    (mutant,) = scored.mutants
    assert mutant.safety.needed
    assert next_steps(mutant, scored, background) == (step,)
