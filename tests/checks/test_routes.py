from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.checks.parts import crossed_ways, depth, gaps, overlaps
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.sim.mesh import box
from scaloft_fi.sim.world import Box, Turned, World

GRID = load_grid(Path(__file__).parents[2] / "sim")


def world_with(size: tuple[float, float, float], centre: tuple[float, float, float]) -> Any:
    """A world of one box in the open, far from the rock."""
    far = box((1.0, 1.0, 1.0)).moved((500.0, 500.0, 500.0))
    body = SimpleNamespace(name="box", mesh=box(size).moved(centre))
    return SimpleNamespace(mine=SimpleNamespace(wall=far, ground=far), present=[body])


@pytest.mark.parametrize(
    ("size", "centre", "gap_m"),
    [
        ((1.0, 1.0, 1.0), (0.9, 0.0, 1.0), 0.4),
        ((1.0, 1.0, 1.0), (0.9, 0.9, 1.0), 0.4 * 2**0.5),
        ((1.0, 1.0, 0.04), (0.8, 0.0, 1.03), 0.3),  # thinner than the hull is high
        ((1.0, 1.0, 0.1), (0.0, 0.0, 1.0), 0.0),  # all around the point
        ((1.0, 1.0, 0.2), (0.6, 0.0, 1.5), None),  # above the hull
        ((1.0, 1.0, 1.0), (2.0, 0.0, 1.0), None),  # too far away
    ],
)
def test_the_gap_of_a_place_is_level_and_counts_what_stands_at_the_height_of_the_hull(
    size: tuple[float, float, float], centre: tuple[float, float, float], gap_m: float | None
):
    found = dict(gaps(world_with(size, centre), [(0.0, 0.0, 1.0)], 0.055, 0.7))
    assert found == ({} if gap_m is None else {"box": pytest.approx(gap_m)})


def test_the_gap_of_a_leg_is_that_of_its_nearest_point():
    leg = [(-3.0, 0.0, 1.0), (3.0, 0.0, 1.0)]
    assert dict(gaps(world_with((0.2, 0.2, 1.0), (1.0, 0.4, 1.0)), leg, 0.055, 0.5)) == {"box": pytest.approx(0.3)}


def test_a_leg_that_climbs_passes_below_what_hangs_above_its_beginning():
    leg = [(-3.0, 0.0, 1.0), (3.0, 0.0, 3.0)]
    low, high = (world_with((0.2, 0.2, 0.2), (x, 0.0, 2.6)) for x in (-2.5, 1.8))
    assert dict(gaps(low, leg, 0.055, 0.5)) == {}
    assert dict(gaps(high, leg, 0.055, 0.5)) == {"box": pytest.approx(0.0)}


def test_the_wall_of_the_reference_mine_is_where_the_waypoint_near_it_says():
    world = GRID.world(GRID.situation("T0O0W1D0H0"))
    assert dict(gaps(world, [world.waypoints["corner"]], 0.055, 1.0))["wall"] == pytest.approx(0.635, abs=0.061)


def body_in(world: World, name: str, size: tuple[float, float, float], at: tuple[float, ...], yaw_deg: float) -> World:
    """The world with one more box."""
    made = Box(name, "structure", at, 0.3, True, "box", size, yaw_deg=yaw_deg)
    return replace(world, bodies={**world.bodies, name: made})


def overlaps_of(world: World, name: str) -> set[str]:
    """What a body reaches into."""
    return {other for other, _, _ in overlaps(world, world.bodies[name])}


WORLD = GRID.world(GRID.situation("T0O0W0D0H0"))


@pytest.mark.parametrize(
    ("size", "at", "yaw_deg", "into"),
    [
        ((0.4, 0.4, 1.0), (0.0, 1.0), 0.0, set()),  # on the floor
        ((0.4, 0.4, 1.0), (0.0, 1.0, 0.5), 0.0, set()),  # in the air
        ((0.4, 0.4, 1.0), (0.0, 1.0, -0.5), 0.0, {"ground"}),
        ((4.0, 0.4, 1.0), (0.0, 1.0), 0.0, {"wall"}),  # across the tunnel
        ((4.0, 0.4, 1.0), (0.0, 1.0), 90.0, set()),  # the same, turned along it
        ((0.4, 0.4, 1.0), (0.0, 1.0, 2.0), 0.0, {"wall"}),  # through the roof
    ],
)
def test_a_body_is_held_against_rock_as_it_stands_and_is_turned(
    size: tuple[float, float, float], at: tuple[float, ...], yaw_deg: float, into: set[str]
):
    assert overlaps_of(body_in(WORLD, "extra", size, at, yaw_deg), "extra") == into


@pytest.mark.parametrize(
    ("at", "yaw_deg", "touch"), [((0.45, 1.0), 0.0, False), ((0.45, 1.0), 45.0, True), ((0.0, 1.0, 1.0), 0.0, False)]
)
def test_two_bodies_overlap_unless_one_carries_the_other(at: tuple[float, ...], yaw_deg: float, touch: bool):
    world = body_in(body_in(WORLD, "a", (0.4, 0.4, 1.0), (0.0, 1.0), yaw_deg), "b", (0.4, 0.4, 1.0), at, yaw_deg=0.0)
    assert (overlaps_of(world, "a") | overlaps_of(world, "b")) == ({"a"} if touch else set())


@given(x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0))
def test_outlines_overlap_by_the_least_shift_that_parts_them(x: float, y: float):
    square = box((1.0, 1.0, 1.0)).vertices[[0, 4, 6, 2], :2]
    assert depth(square, np.add(square, (x, y))) == pytest.approx(1.0 - max(abs(x), abs(y)))


@pytest.mark.parametrize(
    ("stops", "into"),
    [([(0.0, 3.0)], set()), ([(0.0, 5.0)], {"a"}), ([(0.9, 2.0), (0.0, 1.0)], set()), ([(1.3, 2.0)], {"wall"})],
)
def test_what_a_body_sweeps_on_its_way_is_held_against_rock_and_bodies(
    stops: list[tuple[float, float]], into: set[str]
):
    world = body_in(body_in(WORLD, "a", (0.4, 0.4, 1.0), (0.3, 4.0), 45.0), "b", (0.6, 0.6, 1.0), (0.0, 1.0), 0.0)
    walk = SimpleNamespace(effect=SimpleNamespace(moved="b", path=tuple(stops)))
    assert overlaps_of(replace(world, happenings=(walk,)), "b") == into


@pytest.mark.parametrize(
    ("first", "second", "at", "told"),
    [
        ([(0.0, 4.0)], [(0.5, 1.0)], (0.5, 4.0), False),  # beside each other
        ([(0.0, 4.0)], [(-0.5, 2.0)], (0.5, 3.0), True),  # across
        ([(0.0, 1.5), (0.0, 4.0)], [(0.0, 3.5)], (0.0, 5.5), True),  # towards each other
        ([(0.0, 4.0)], [(-0.5, 2.0)], (0.5, 3.0, 1.5), False),  # above its head
        ([(0.0, 4.0)], [], (0.0, 2.5), False),  # the other one stands: `overlaps` tells
    ],
)
def test_ways_of_two_bodies_that_cross_are_told_once(
    first: list[tuple[float, float]], second: list[tuple[float, float]], at: tuple[float, ...], told: bool
):
    world = body_in(body_in(WORLD, "a", (0.3, 0.3, 1.0), (0.0, 1.0), 30.0), "b", (0.3, 0.3, 1.0), at, 0.0)
    ways = (("a", first), ("b", second))
    walks = tuple(SimpleNamespace(effect=SimpleNamespace(moved=name, path=tuple(path))) for name, path in ways if path)
    world = replace(world, happenings=walks)
    assert [name for name, _ in crossed_ways(world, world.bodies["a"])] == ["b"] * told
    assert not list(crossed_ways(world, world.bodies["b"]))


@pytest.mark.parametrize("role", ["person", "obstacle", "structure"])
@pytest.mark.parametrize(("at", "into"), [((0.0, 2.0), set()), ((1.4, 2.0), {"wall"}), ((0.0, 2.0, -0.3), {"ground"})])
def test_persons_are_held_against_rock_as_any_other_body(role: str, at: tuple[float, ...], into: set[str]):
    made = Turned("extra", role, at, 0.3, True, "capsule", 0.25, 1.7)
    world = replace(WORLD, bodies={**WORLD.bodies, "extra": made})
    assert overlaps_of(world, "extra") == into
    walk = SimpleNamespace(effect=SimpleNamespace(moved="extra", path=((0.0, 3.0), (1.35, 3.0))))
    assert overlaps_of(replace(world, happenings=(walk,)), "extra") == {*into, "wall"}
