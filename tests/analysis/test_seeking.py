"""The search: distance from showing a fault, confirmation on fresh seeds, effort, replication, shrinking."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from builders import outcome, pool
from finding import found
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis import seeking
from scaloft_fi.analysis.detection import Pool, Sample, Spending, Stratum, detect, p_value
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.sim.log import Ending, FlightLog
from scaloft_fi.stack.declaration import Claim, Instant


def readings(flown: Outcome, **rhos: float) -> Outcome:
    """The outcome with these robustnesses; what is not named is at 0.3."""
    return replace(flown, readings=tuple(replace(r, rho=rhos.get(r.requirement, 0.3)) for r in flown.readings))


def test_the_least_share_of_the_baselines_robustness_that_the_mutant_keeps_counts():
    mutant = readings(outcome("LATE-human@3s"), SR1=0.2, SR2=0.06)
    assert seeking.distance(mutant, readings(outcome())) == pytest.approx(0.2)
    assert seeking.distance(readings(outcome("LATE-human@3s")), readings(outcome())) == 1.0
    assert seeking.shown_by(mutant, readings(outcome())) == ()


def test_a_violation_shows_the_fault():
    mutant = readings(outcome("LATE-human@3s"), SR2=-0.2)
    assert seeking.distance(mutant, readings(outcome())) == pytest.approx(-2 / 3)
    assert seeking.shown_by(mutant, readings(outcome())) == ("SR2",)


@pytest.mark.parametrize("rho", [0.019, 0.0, -0.3, -9.0])
def test_a_baseline_without_room_moves_the_situation_away(rho):
    mutant, baseline = readings(outcome("LATE-human@3s"), SR2=-0.2), readings(outcome(), SR2=rho)
    assert seeking.distance(mutant, baseline) == 1.0  # by SR1, which the mutant holds as the baseline does
    without = [replace(one, readings=one.readings[1:]) for one in (mutant, baseline)]
    assert seeking.distance(*without) == pytest.approx(min(seeking.BEYOND, seeking.WORST + seeking.ROOM - rho))
    assert seeking.shown_by(mutant, readings(outcome(), SR2=rho)) == ()


def test_operability_and_reported_requirements_do_not_count():
    mutant = readings(outcome("LATE-human@3s"), **{"OP1": -1.0, "SR2-literal": -1.0})
    assert seeking.distance(mutant, readings(outcome())) == 1.0


def test_what_says_nothing_is_farthest():
    baseline, mutant = outcome(), readings(outcome("LATE-human@3s"), SR1=-0.2, SR2=-0.2)
    assert seeking.distance(None, baseline) == seeking.distance(mutant, None) == seeking.WORST
    assert seeking.distance(replace(mutant, altered=0), baseline) == seeking.WORST
    assert seeking.distance(replace(mutant, invalid="the worker died"), baseline) == seeking.WORST
    assert seeking.distance(mutant, outcome(violated={"SR1": 3.0}, struck="wall", vacuous=("SR2",))) > 0.0


def test_beside_a_baseline_without_room_no_mutant_need_be_flown():
    assert seeking.is_of_use(readings(outcome()))
    assert seeking.is_of_use(readings(outcome(), SR1=-0.3))
    assert not seeking.is_of_use(readings(outcome(), SR1=0.01, SR2=-0.3))
    assert not seeking.is_of_use(None)
    assert seeking.distance(None, readings(outcome(), SR1=0.01, SR2=-0.3)) == pytest.approx(seeking.WORST + 0.01)


def test_the_robustness_of_the_unmutated_drone_counts_requirement_by_requirement():
    baseline = readings(outcome(), SR1=0.2, SR2=-0.05)
    assert (seeking.breaking(baseline, "SR1"), seeking.breaking(baseline, "SR2")) == (0.2, -0.05)
    assert seeking.breaking(readings(outcome(), SR2=-9.0), "SR2") == -seeking.WORST
    untested = (None, replace(outcome(), invalid="the worker died"), outcome(vacuous=("SR2",)))
    assert [seeking.breaking(one, "SR2") for one in untested] == [seeking.WORST] * 3


HERE, THERE = "T0O0W0D0H1", "T0O0W0D0H0"


def with_rho(flown, rhos, name="SR2"):
    return [
        replace(o, readings=tuple(replace(r, rho=rho) if r.requirement == name else r for r in o.readings))
        for o, rho in zip(flown, rhos, strict=True)
    ]


def mutant(violating: int, flights: int):
    violated = {"SR2": 7.0}
    return [
        outcome("LATE-human@3s", HERE, seed, violated=violated if seed < violating else {}) for seed in range(flights)
    ]


def test_the_shares_of_all_candidates_sum_to_alpha():
    assert sum(seeking.share_of(0.01, candidate) for candidate in range(1, 60)) == pytest.approx(0.01)


@pytest.mark.parametrize("candidate", range(1, 9))
def test_as_many_seeds_are_flown_as_decide_though_one_flight_does_not_violate(candidate):
    share, held = seeking.share_of(0.01, candidate), Pool.of(pool(HERE))
    seeds = seeking.seeds_for(held, HERE, ("SR2",), share)
    assert seeds >= seeking.FEWEST
    for flights, decides in ((seeds, True), (seeds - 1, False)):
        sample = Sample(HERE, ((), *((("SR2",),) * (flights - 1))), infected=True)
        assert detect("", [sample], held, Spending(share), Kind.SAFETY).detected is decides


def test_more_seeds_than_allowed_are_no_candidate():
    assert seeking.seeds_for(Pool.of(pool(HERE)), HERE, ("SR2",), 1e-12) is None
    assert seeking.seeds_for(Pool.of(pool(HERE)), HERE, (), 0.01) is None
    assert seeking.MOST < 100


def test_the_evidence_is_the_scores_own_test():
    baselines = with_rho(pool(HERE), [0.3] * 10)
    told = seeking.confirmed(mutant(6, 6), baselines, ("SR2",), 1, 0.005)
    assert (told.requirement, told.violated, told.flights, told.baselines) == ("SR2", 6, 6, 10)
    violated = tuple(("SR2",) for _ in range(6))
    judged = detect("", [Sample(HERE, violated, True)], Pool.of(baselines), Spending(0.005), Kind.SAFETY)
    assert told.p == judged.p["SR2"] <= told.alpha == 0.005


@pytest.mark.parametrize(("violating", "flights", "good"), [(6, 6, True), (5, 6, True), (2, 6, False), (2, 2, False)])
def test_too_few_violations_or_flights_confirm_nothing(violating, flights, good):
    assert (seeking.confirmed(mutant(violating, flights), pool(HERE), ("SR2",), 1, 0.005) is not None) is good


def test_nine_in_ten_baselines_must_be_above_their_own_spread():
    safe = with_rho(pool(HERE), [0.3, 0.31, 0.32, 0.3, 0.29, 0.3, 0.3, 0.31, 0.3, 0.3])
    edge = with_rho(pool(HERE), [0.01, 0.2, 0.02, 0.3, 0.03, 0.3, 0.01, 0.31, 0.02, 0.3])
    assert seeking.room("SR2", safe).enough
    assert seeking.room("SR2", safe).margin == 0.3
    assert not seeking.room("SR2", edge).enough
    assert seeking.room("SR2", edge).held < 9
    assert seeking.safely_held(Pool.of(safe), HERE, ("SR2",), safe) == ("SR2",)
    assert seeking.safely_held(Pool.of(edge), HERE, ("SR2",), edge) == ()


def test_a_requirement_that_is_not_steady_is_never_tested():
    red = pool(HERE, red=4, violated={"SR2": 5.0})
    assert seeking.safely_held(Pool.of(red), HERE, ("SR2",), red) == ()


@pytest.mark.parametrize(("missed", "good"), [(0, True), (1, True), (2, False)])
def test_the_value_of_each_axis_comes_true_in_nine_of_ten_baselines(missed, good):
    baselines = [
        replace(one, realised=(("light", True), ("person", number >= missed))) for number, one in enumerate(pool(HERE))
    ]
    assert seeking.does_mission(baselines) is good


@pytest.mark.parametrize(("red", "good"), [(0, True), (1, True), (2, False)])
def test_nine_of_ten_baselines_hold_the_operability_requirements(red, good):
    assert seeking.does_mission(pool(HERE, red=red, violated={"OP1": 5.0})) is good


KEYS = ("T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H0", "T0O0W0D1H1", "T0O0W1D0H0", "T0O0W1D0H1")


def flown(subject: str, situation: str, rho: float = 0.3, **more: object) -> Outcome:
    one = replace(outcome(subject), situation=situation, **more)
    return replace(one, readings=tuple(replace(reading, rho=rho) for reading in one.readings))


def test_a_fault_stops_at_a_stage_in_each_situation():
    baselines = {key: flown("baseline", key, -0.3 if key == KEYS[5] else 0.3, digest="b") for key in KEYS}
    flights = [
        flown("LATE-human@3s", KEYS[0], carried=0, altered=0, digest="b"),
        flown("LATE-human@3s", KEYS[1], carried=9, altered=0, digest="b"),
        flown("LATE-human@3s", KEYS[2], carried=9, altered=4, digest="b"),
        flown("LATE-human@3s", KEYS[3], 0.06, carried=9, altered=4, digest="m"),
        flown("LATE-human@3s", KEYS[4], -0.15, carried=9, altered=4, digest="m"),
        flown("LATE-human@3s", KEYS[5], -9.0, carried=9, altered=4, digest="m"),  # its baseline holds nothing
    ]
    effort = seeking.effort_of(flights, baselines)
    assert (effort.situations, effort.reached, effort.infected, effort.diverged, effort.showed) == (5, 4, 3, 2, 1)
    assert (effort.nearest, effort.requirement, effort.situation) == (pytest.approx(-0.5), "SR1", KEYS[4])
    assert seeking.effort_of(flights[:4], baselines).nearest == pytest.approx(0.2)


def test_what_changes_no_sample_comes_nowhere_near_anything():
    flights = [flown("LATE-human@3s", KEYS[0], -1.0, altered=0)]
    effort = seeking.effort_of(flights, {KEYS[0]: flown("baseline", KEYS[0])})
    assert (effort.situations, effort.nearest, effort.requirement) == (1, seeking.WORST, "")


def test_flights_that_say_nothing_are_left_out():
    invalid = flown("LATE-human@3s", KEYS[0], invalid="the worker died")
    assert seeking.effort_of([invalid], {KEYS[0]: flown("baseline", KEYS[0])}) == seeking.Effort()
    assert seeking.effort_of([flown("LATE-human@3s", KEYS[1])], {}) == seeking.Effort()


LATE, LESS = "LATE-human@3s", "LATE-human@1s"
FINDS = (found(LATE, HERE), found(LESS, THERE))


def mutated(name: str, situation: str, violating: int):
    flown = [
        outcome(name, situation, seed, violated={"SR2": 7.0} if seed < violating else {})
        for seed in range(seeking.SEEDS)
    ]
    return [replace(one, seed=100_000 + one.seed) for one in flown]


def baseline(situation: str, red: int = 0, requirement: str = "SR2"):
    return [
        outcome("baseline", situation, seed, violated={requirement: 7.0} if seed < red else {})
        for seed in range(seeking.POOL)
    ]


def replicated(violating: tuple[int, int], pools=None, **more) -> tuple[seeking.Replica, ...]:
    flown = {
        (FINDS[0].name, LATE): mutated(LATE, HERE, violating[0]),
        (FINDS[1].name, LESS): mutated(LESS, THERE, violating[1]),
    }
    return seeking.replicas(
        FINDS, flown, pools or {HERE: baseline(HERE), THERE: baseline(THERE)}, 100_000, 0.01, **more
    )


@given(st.integers(0, seeking.SEEDS), st.integers(0, seeking.SEEDS))
def test_p_is_that_of_the_one_requirement_adjusted_over_all_pairs(first, second):
    raw = [
        p_value([Stratum(violated, seeking.SEEDS, 0, seeking.POOL, seeking.POOL // 10)]) for violated in (first, second)
    ]
    least = min(1.0, 2 * min(raw))
    assert sorted(one.again.p for one in replicated((first, second))) == pytest.approx(
        sorted((least, max(least, max(raw))))
    )


def test_a_pair_holds_where_its_p_is_at_most_alpha():
    one, other = replicated((10, 1))
    assert (one.holds, one.why, one.again.violated, one.again.flights) == (True, "", 10, seeking.SEEDS)
    assert (one.again.held, one.again.baselines, one.again.mission, one.again.seed) == (
        seeking.POOL,
        seeking.POOL,
        seeking.POOL,
        100_000,
    )
    assert not other.holds
    assert "above alpha=0.01" in other.why


@pytest.mark.parametrize(("requirement", "word"), [("SR2", "SR2 steadily"), ("OP1", "its mission")])
def test_a_pool_that_is_not_steady_or_does_not_do_its_mission_shows_nothing(requirement, word):
    pools = {HERE: baseline(HERE, 6, requirement), THERE: baseline(THERE)}
    one, other = replicated((10, 10), pools)
    assert (one.holds, one.again.p) == (False, 1.0)
    assert word in one.why
    assert other.holds
    anyhow, _ = replicated((10, 10), pools, anyhow=True)
    assert anyhow.holds is (requirement == "OP1")


def test_a_fault_that_changes_no_sample_shows_nothing():
    still = [replace(one, altered=0) for one in mutated(LATE, HERE, 10)]
    (one,) = seeking.replicas(FINDS[:1], {(FINDS[0].name, LATE): still}, {HERE: baseline(HERE)}, 0, 0.01)
    assert (one.holds, one.again.p) == (False, 1.0)


SEARCHED = load_grid(Path(__file__).parents[2] / "sim", "search")


def shrink(key: str, rule):
    """The shrunk key, and what was asked on the way."""
    asked: list[str] = []

    def shows(situations, every):
        asked.extend(one.key for one in situations)
        return [rule(one) for one in situations]

    return seeking.shrunk(SEARCHED.situation(key), SEARCHED, shows).key, asked


def test_what_is_not_needed_is_reset():
    found, asked = shrink("T1O1W1D2H1Cs=0.9Ls=3Ox=0.5Vy=2Ba=0.3", lambda one: one["H"] == 1)
    assert found == "T0O0W0D0H1"
    assert len(asked) < 20


def test_what_is_needed_together_stays_together():
    found, _ = shrink("T1O1W1D0H1Ox=0.5Vy=2", lambda one: one["T"] + one["W"] >= 1 and one["O"] == 1)
    assert found in ("T1O1W0D0H0", "T0O1W1D0H0")


def test_numbers_of_an_axis_go_with_the_value_that_they_need():
    found, asked = shrink("T0O1W0D0H0Ox=0.5Oy=3", lambda _one: True)
    assert found == "T0O0W0D0H0"
    assert all("O0" not in key or "Ox" not in key for key in asked)


def test_numbers_are_halved_towards_the_benign_value_while_the_fault_shows():
    found, _ = shrink("T0O0W0D0H0Cs=1.2", lambda one: dict(one.numbers).get("Cs", 0.5) >= 0.65)
    assert found == "T0O0W0D0H0Cs=0.7"  # by halves to 0.68, rounded to one digit, away from the benign 0.5


def test_a_number_that_stays_is_rounded_where_the_fault_still_shows():
    found, _ = shrink("T0O0W0D0H0Cs=0.66", lambda one: 0.6 < dict(one.numbers).get("Cs", 0.5) < 0.67)
    assert found == "T0O0W0D0H0Cs=0.66"


def test_shrinking_ends_by_trying_each_axis_at_its_benign_value():
    """Ry may go only once Cs has gone down: the rounds before the halving have tried it in vain."""

    def rule(one):
        numbers = dict(one.numbers)
        return numbers.get("Cs", 0.5) <= 0.9 or "Ry" in numbers

    def needs_speed(one):
        return rule(one) and dict(one.numbers).get("Cs", 0.5) >= 0.7

    found, _ = shrink("T0O0W0D0H0Cs=1.2Ry=0.002", needs_speed)
    assert "Ry" not in found


@pytest.mark.parametrize("key", ["T0O0W0D0H0", "T0O0W0D0H1"])
def test_what_cannot_be_shrunk_is_as_it_was(key):
    found, _ = shrink(key, lambda one: one.key == key)
    assert found == key


def test_a_shrunk_situation_shows_the_fault_with_every_seed():
    def shows(situations, every):
        return [not every or one["H"] == 1 for one in situations]

    found = seeking.shrunk(SEARCHED.situation("T1O0W0D0H1"), SEARCHED, shows)
    assert (found["T"], found["H"]) == (0, 1)


TICKS = 200
SR1 = Requirement("SR1", Kind.SAFETY, "always(clearance_m > 0)")
SR2 = Requirement(
    "SR2",
    Kind.SAFETY,
    "always(trigger implies speed_mps <= 0.25)",
    trigger="historically[0:2](near)",
    definitions=(("near", "person_sight_m / 3 <= 1"),),
)
WORLD: Any = SimpleNamespace(
    mission=SimpleNamespace(route=("corner", "end", "corner", "home")),
    bodies={"bar": None, "person": None},
    waypoints={"home": (0.0, 0.0, 1.65), "corner": (0.0, 7.0, 1.65), "end": (-3.0, 8.0, 1.65)},
)


def log(left: float = 3.0, **errors: Any) -> FlightLog:
    """A flight of 10 s whose signals `errors` hold how wrong each claim is at each sample."""
    signals = {"elapsed_s": np.arange(TICKS) / 20, "waypoints_left": np.full(TICKS, left)}
    signals |= {name: np.broadcast_to(np.asarray(error, float), TICKS) for name, error in errors.items()}
    return FlightLog(signals, Ending.STRUCK, "bar", 9.0, "", {}, 60.0)


def violation(requirement: str = "SR1", struck: str = "bar", t_s: float = 9.0, **place: float) -> Violation:
    x, y = place.get("x", -2.0), place.get("y", 7.8)
    return Violation(requirement, Kind.SAFETY, t_s, x, y, 1.6, struck)


def claim(name: str, within: float = 1.0, **more: Any) -> Claim:
    return Claim(name, "m", within, lambda now: now.signals[name][-1], **more)


def told(
    flight: FlightLog, *claims: Claim, of: tuple[Violation, ...] = (violation(),), **samples: Any
) -> list[seeking.Breach]:
    return list(seeking.breaches(flight, of, (SR1, SR2), WORLD, claims, samples))


def test_the_leg_is_that_of_the_ground_truth_and_near_its_nearer_end():
    wall = (violation(struck="wall"),)
    legs = {left: told(log(left=left), of=wall)[0].signature for left in (4, 3, 2, 1, 0)}
    assert [one.leg for one in legs.values()] == [
        "home to corner",
        "corner to end",
        "end to corner",
        "corner to home",
        "corner to home",
    ]
    assert [one.near for one in legs.values()] == ["corner", "end", "end", "corner", "corner"]
    assert told(log(), of=(violation(struck="", x=-0.5, y=7.2),))[0].signature.near == "corner"


def test_a_body_that_is_struck_tells_the_place():
    places = [violation(x=-0.5, y=7.2), violation(x=-2.5, y=7.9)]
    assert {told(log(), of=(one,))[0].signature.near for one in places} == {"bar"}


def test_the_stage_that_is_the_most_wrong_for_what_it_may_be_is_named():
    flight = log(position=0.5, map=0.9)
    (breach,) = told(flight, claim("position", 0.1), claim("map", 0.3))
    assert breach.signature == seeking.Signature("SR1", "bar", "corner to end", "bar", "position")
    assert (breach.error, breach.unit, breach.t_s, breach.place) == (0.5, "m", 9.0, (-2.0, 7.8, 1.6))


def test_where_no_belief_was_wrong_it_is_said():
    (breach,) = told(log(position=0.1), claim("position", 0.1))
    assert (breach.signature.belief, breach.error, breach.unit) == ("", 0.0, "")
    assert breach.signature.name == "breaks-SR1-bar-corner_to_end-no_belief"


def test_a_belief_that_was_wrong_more_than_a_second_before_does_not_count():
    early, late = np.zeros(TICKS), np.zeros(TICKS)
    early[159], late[160] = 5.0, 5.0  # the violation is at sample 180
    after = np.where(np.arange(TICKS) >= 180, 5.0, 0.0)  # what is struck moves the drone before its estimate
    assert told(log(position=early), claim("position"))[0].signature.belief == ""
    assert told(log(position=late), claim("position"))[0].signature.belief == "position"
    assert told(log(position=after), claim("position"))[0].signature.belief == ""


def test_a_claim_matters_to_requirements_that_speak_of_what_it_is_about():
    person = claim("person", about=("person_sight_m",))
    of = (violation("SR2", "", 5.0), violation("SR1", "bar", 9.0))
    slow, struck = told(log(person=9.0), person, of=of[::-1])
    assert (slow.signature.requirement, slow.signature.belief) == ("SR2", "person")
    assert (struck.signature.requirement, struck.signature.belief) == ("SR1", "")


def test_who_is_struck_against_two_requirements_is_one_finding():
    person = claim("person", about=("person_sight_m",))
    of = (violation("SR1", "person"), violation("SR2", "person"))
    (breach,) = told(log(person=9.0), person, of=of)
    assert breach.requirements == ("SR1", "SR2")
    assert (breach.signature.requirement, breach.signature.belief) == ("SR1", "person")


def test_a_claim_gets_the_newest_sample_that_was_delivered_before():
    seen: dict[float, Any] = {}

    def error(now: Instant) -> float:
        seen[float(now.signals["elapsed_s"][-1])] = now.sample
        assert (now.place, now.struck) == ((-2.0, 7.8, 1.6), "bar")
        return 0.0

    told(log(), Claim("map", "m", 1.0, error, seam="map"), map=[(8.5, "old"), (8.9, "new")])
    assert (seen[8.5], seen[8.55], seen[8.9], seen[8.95]) == (None, "old", "old", "new")
    assert (min(seen), max(seen)) == (8.0, 8.95)


@pytest.mark.parametrize("error", [lambda _now: math.nan, lambda now: now.signals["nothing"]])
def test_a_claim_that_fails_is_named(error: Any):
    with pytest.raises(ScaloftError, match=r"claim 'map': (error=nan must be a finite number|KeyError: 'nothing')"):
        told(log(), Claim("map", "m", 1.0, error))


def test_a_claim_that_allows_nothing_is_refused():
    with pytest.raises(ValueError, match=r"claim 'map': within=0 must be positive"):
        claim("map", 0.0)
