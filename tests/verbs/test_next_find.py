"""What to do next about a fault that was not shown is to fly its find, where there is one: decided in one place."""

from __future__ import annotations

from dataclasses import replace

from builders import GRID, ROSTER, outcome, pool, thrice
from finding import flies as command
from finding import found, known

from scaloft_fi.analysis.score import MutantScore, score
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.sim.found import Again
from scaloft_fi.verbs.verdict import facts, flies, flown_in_vain, next_find

LATE, NO = "LATE-human@3s", "NO-human@100%"
HUMAN, NOBODY = "T0O0W0D0H1", "T0O0W0D0H0"
FIND = found(LATE)


def scored(*flights: Outcome) -> MutantScore:
    return next(mutant for mutant in score([*pool(HUMAN), *flights], ROSTER, GRID).mutants if mutant.subject.id == LATE)


def test_the_find_of_a_mutant_that_is_not_detected_is_to_be_flown_whatever_its_verdict() -> None:
    undecided, tested, untested = outcome(LATE, HUMAN), thrice(LATE, HUMAN), outcome(LATE, HUMAN, altered=0)
    for flights in ([undecided], tested, [untested]):
        assert next_find(scored(*flights), known(found(NO), FIND)) == FIND


def test_a_detected_mutant_or_one_that_no_flight_counts_for_has_nothing_to_fly() -> None:
    assert next_find(scored(*thrice(LATE, HUMAN, violated={"SR2": 7.0})), known(FIND)) is None
    assert next_find(scored(outcome(LATE, HUMAN, invalid="the worker died")), known(FIND)) is None
    assert next_find(scored(*thrice(LATE, HUMAN)), known(found(NO))) is None


def test_a_find_that_was_flown_here_with_as_many_seeds_is_not_flown_again() -> None:
    here = found(LATE, HUMAN)
    few, enough = [outcome(LATE, HUMAN, seed) for seed in range(5)], [outcome(LATE, HUMAN, seed) for seed in range(6)]
    assert next_find(scored(*few), known(here)) == here
    assert flown_in_vain(scored(*few), known(here)) == ()
    assert next_find(scored(*enough), known(here)) is None
    assert flown_in_vain(scored(*enough), known(here)) == (here,)
    other = found(NO, others=(LATE,))
    assert next_find(scored(*enough), known(here, other)) == other


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
