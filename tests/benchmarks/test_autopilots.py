"""The autopilots' baselines: what was registered, what accepts them, and the page that they make."""

from __future__ import annotations

from builders import outcome

from experiments import PUBLISHED
from experiments.autopilots import ACCEPTED, ARMS, EMPTY, FURTHER, KINDS, NAME, SEEDS, accepted, names, told
from experiments.flights import read
from experiments.pages import registered
from scaloft_fi.judge.outcome import Outcome


def flown(broken: dict[tuple[str, int], str]) -> dict[str, Outcome]:
    made = {}
    for name in names("px4"):
        _, key, seed = name.split("/")
        violated = {broken[key, int(seed)]: 9.0} if (key, int(seed)) in broken else {}
        made[name] = outcome("baseline", key, int(seed), violated=violated)
    return made


def test_the_plan_tells_the_numbers_of_programs_situations_and_seeds():
    assert f"{len(KINDS)} programs x {len(EMPTY)} light situations without a person x {len(SEEDS)} seeds" in registered(
        NAME
    )


def test_one_of_ten_may_fail_in_each_situation_and_one_situation_altogether():
    assert accepted(flown({}))
    assert accepted(flown({(key, 3004): "SR1" for key in EMPTY}))
    assert accepted(flown({(EMPTY[2], seed): "OP1" for seed in SEEDS}))
    two = {(key, seed): "SR1" for key in EMPTY[:2] for seed in (3000, 3001)}
    assert not accepted(flown(two))


def test_the_page_is_what_its_flights_make():
    flights = read(PUBLISHED / ACCEPTED)
    assert (PUBLISHED / f"{NAME}.md").read_text(encoding="utf-8") == registered(NAME) + told(flights)
    assert all(accepted(flights[arm]) for arm in ARMS if arm in flights)
    assert {name.rpartition("/")[2] for arm in FURTHER for name in names(arm)} == {str(3010 + n) for n in range(20)}
