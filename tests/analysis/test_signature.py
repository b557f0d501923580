"""Signatures: what a violation strikes, where, and which stage was the most wrong before it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scaloft_fi.analysis.seeking import Breach, Signature, breaches
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import Violation
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.sim.log import Ending, FlightLog
from scaloft_fi.stack.declaration import Claim, Instant

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


def told(flight: FlightLog, *claims: Claim, of: tuple[Violation, ...] = (violation(),), **samples: Any) -> list[Breach]:
    return list(breaches(flight, of, (SR1, SR2), WORLD, claims, samples))


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
    assert breach.signature == Signature("SR1", "bar", "corner to end", "bar", "position")
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
