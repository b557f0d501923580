"""Families: the mutants of one parameter search together, and rest where they come no nearer."""

from __future__ import annotations

from pathlib import Path

from scaloft_fi.campaign.seeking.proposals import Proposals
from scaloft_fi.campaign.seeking.seek import EACH, GENERATION, LONGEST_REST, Quest, families
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

STUDY = Study.open(Path(__file__).parents[3], "search")


def quest(name: str) -> Quest:
    mutant = realise(STUDY.matrix, name)
    return Quest(mutant, Proposals(STUDY.grid, lambda _situation: True, 0, mutant.id))


def test_the_mutants_of_one_parameter_are_a_family():
    found = families(map(quest, ("LATE-human", "MORE-goal", "NO-human", "LESS-goal")))
    assert [[one.mutant.parameter for one in family.quests] for family in found] == [["human"] * 2, ["goal"] * 2]


def test_a_family_proposes_at_least_a_generation_and_something_for_each_mutant():
    (alone,), (many,) = families([quest("LATE-human")]), families(map(quest, STUDY.roster.defaults.values()))[:1]
    assert len(alone.ask()) == GENERATION
    assert len(many.quests) > GENERATION / EACH
    assert len(many.ask()) == EACH * len(many.quests)


def test_a_mutant_with_a_find_proposes_nothing():
    (family,) = families(map(quest, ("LATE-human", "NO-human")))
    family.quests[0].shown_in = STUDY.grid.situations[0]
    assert [one.mutant.id for one in family.sought] == [family.quests[1].mutant.id]


def test_a_family_that_comes_no_nearer_rests_twice_as_long_each_time_and_progress_ends_that():
    (family,) = families([quest("LATE-human")])
    rests = []
    for _ in range(5):
        family.rest_after(family.nearest)
        rests.append(family.pauses)
    assert rests == [1, 2, 4, LONGEST_REST, LONGEST_REST]
    family.rest_after([one + 0.1 for one in family.nearest])
    assert family.pauses == 0
