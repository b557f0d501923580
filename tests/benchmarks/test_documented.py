"""The drone with the published speed law: what was registered, what accepts it, and the page that its flights make."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest
from builders import GRID, outcome

from experiments import PUBLISHED, ROOT, documented
from experiments.flights import holds, names_of, read
from experiments.operating_point import LIGHT
from experiments.pages import registered
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.study import Study


def flown(violated: dict[tuple[str, str], str]) -> dict[str, Outcome]:
    """The flights of an arm; those of a subject in a situation violate a requirement where they are named."""
    made = {}
    for name in names_of(documented.SUBJECTS, LIGHT, documented.SEEDS):
        subject, key, seed = name.split("/")
        broken = {violated[subject, key]: 9.0} if (subject, key) in violated else {}
        made[name] = outcome(subject, key, int(seed), violated=broken)
    return made


def test_the_plan_tells_the_numbers_of_arms_flights_and_tests():
    plan = registered(documented.NAME)
    ladders = {
        m.id for m in Study.open(ROOT).catalogue if m.cell in ("LATE-human", "UNINTENDED-collision", "MORE-goal")
    }
    assert {mutant for mutant in ladders if "#" not in mutant} == set(documented.MUTANTS)
    assert f"= {documented.PER_ARM * len(documented.ARMS):,}." in plan
    assert f"11 x 12 x 2 - 1 = {len(documented.ARMS) * len(documented.MUTANTS) * len(documented.SAFETY) - 1}:" in plan
    assert len({*documented.TUNED, *documented.ASKED, *documented.SEEDS}) == 30


def test_an_arm_differs_from_the_documented_drone_in_one_thing_or_is_the_reference_drone():
    for name, numbers in documented.ARMS.items():
        differing = {
            key for key in {*numbers, *documented.DOCUMENTED} if numbers.get(key) != documented.DOCUMENTED.get(key)
        }
        assert name == "documented" or name.startswith("turning") or len(differing) == 1


def test_the_published_acceptance_is_what_its_flights_say():
    flights = read(PUBLISHED / documented.ACCEPTED)
    assert documented.acceptance(flights) in registered(documented.NAME)
    (outcomes,) = flights.values()
    assert set(outcomes) == set(names_of([BASELINE], LIGHT, documented.ASKED))
    assert documented.is_accepted(outcomes.values())
    assert (
        f"{sum(holds(one, documented.HELD) for one in outcomes.values())} of {len(outcomes)} hold"
        in (ROOT / "CHANGELOG.md").read_text()
    )


def test_a_drone_with_a_situation_in_which_two_of_ten_fail_is_not_accepted():
    for failing, accepted in ((1, True), (2, False)):
        broken = [(LIGHT[3], seed) for seed in documented.ASKED[:failing]]
        draws = product(LIGHT, documented.ASKED)
        made = [outcome(BASELINE, *one, violated={"OP1": 9.0} if one in broken else {}) for one in draws]
        assert documented.is_accepted(made) is accepted
    assert not holds(replace(made[-1], invalid="no simulator"), documented.HELD)
    assert not holds(outcome(violated={"SR1": 9.0}, struck="wall"), documented.HELD)  # which leaves SR2 open


@pytest.mark.release
def test_the_primary_test_is_decided_by_its_own_arm_and_the_secondary_tests_when_every_arm_was_flown():
    arm, mutant, requirement = documented.PRIMARY
    kills = flown({(mutant, key): requirement for key in LIGHT[:3]})
    first = documented.told({arm: kills}, GRID)
    assert f"**{mutant} is shown by {requirement}**: 30/160, pool 0/160" in first
    assert "Not flown yet: 1.5 m/s" in first
    harmless = documented.told({arm: flown({})}, GRID)
    assert f"**{mutant} is not shown by {requirement}**" in harmless
    assert "Not decided" in documented.told({}, GRID)
    every = {name: documented.Flown(kills, GRID, documented.MUTANTS) for name in documented.ARMS}
    shown = {row[1]: row[-1] for row in documented.rows(every, decided=True) if row[2] == mutant}
    assert shown == {name: "SR1, the primary test" if name == arm else "SR1" for name in documented.ARMS}


@pytest.mark.release
def test_the_page_is_what_its_flights_say():
    made = documented.results(Study.open(ROOT), 1, PUBLISHED)
    assert registered(documented.NAME) + made == (PUBLISHED / f"{documented.NAME}.md").read_text()
