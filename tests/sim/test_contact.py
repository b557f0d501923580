from __future__ import annotations

import math

import numpy as np
import pytest

from scaloft_fi.sim.build import build
from scaloft_fi.sim.contact import Feeler, contacts
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.vehicle import Airframe

pytestmark = pytest.mark.flight


@pytest.mark.parametrize(
    ("position", "velocity", "spin"),
    [
        ((-0.5, 2.2, 0.9), (0.0, 2.0, 0.5), (3.0, 0.0, 8.0)),  # into the person
        ((0.0, 4.0, 1.0), (5.0, 0.0, 1.0), (0.0, 9.0, 0.0)),  # into the wall
        ((0.0, 1.0, 0.6), (0.0, 0.5, -1.0), (5.0, 5.0, 0.0)),  # onto the ground near home
    ],
)
def test_feeling_only_where_something_is_near_finds_every_touch(client, config, position, velocity, spin):
    import pybullet

    scenario = config.scenario(config.grid.situation("T1O1W0D0H1"))
    ids, vehicle = build(client, scenario.world), config.vehicle
    airframe = Airframe(client, vehicle, position, 0.0)
    pybullet.resetBaseVelocity(airframe.number, velocity, spin, physicsClientId=client)
    airframe.read()
    observer = Observer(client, ids, airframe.number, vehicle, scenario, scenario.world.surroundings())
    feeler = Feeler(client, airframe.number, vehicle, ids.name_of)
    felt = []
    for step in range(240):
        if step % 12 == 0:
            observer.sample(step / 240, airframe.state, None)
            feeler.look(airframe.truth, observer.room_m)
        airframe.step(lambda _step: airframe.actuate(np.zeros(4)), 0, 1)
        touches = feeler.feel(airframe.truth, airframe.state)
        assert touches == contacts(client, airframe.number, ids.name_of, airframe.state, vehicle.half_height_m)
        observer.step((step + 1) / 240, airframe.truth, touches)
        felt += touches
        assert not (feeler.out_of_reach and touches)
    assert felt


def truth_at(y=4.0, velocity=(0.0, 0.0, 0.0), rate=(0.0, 0.0, 0.0)):
    return (0.0, y, 1.65, 0.0, 0.0, 0.0, 1.0, *velocity, *rate)


def test_it_asks_again_once_the_vehicle_may_have_come_near(client, config):
    build(client, config.world)
    airframe = Airframe(client, config.vehicle, (0, 4, 1.65), 0.0)
    feeler = Feeler(-1, airframe.number, config.vehicle, {})
    free_m = 1.0 - 0.5 * math.hypot(*config.vehicle.hull_m) + 0.5 * min(config.vehicle.hull_m) - 0.05
    feeler.look(truth_at(), 1.0)
    assert feeler.feel((0.0, 4.0 + free_m - 1e-6, 1.65), airframe.state) == ()
    for place in ((0.0, 4.0 + free_m + 1e-6, 1.65), (math.nan, 4.0, 1.65)):
        with pytest.raises(Exception, match="Not connected"):
            feeler.feel(place, airframe.state)


@pytest.mark.parametrize(
    ("truth", "room_m", "out_of_reach"),
    [
        (truth_at(velocity=(0.0, 0.5, 0.0)), 1.0, True),
        (truth_at(velocity=(0.0, 20.0, 0.0)), 1.0, False),
        (truth_at(velocity=(0.0, math.nan, 0.0)), 1.0, False),
        (truth_at(rate=(0.0, 0.0, math.nan)), 0.3, False),
        (truth_at(), 0.1, False),
        (truth_at(), 0.2, True),
        (truth_at(rate=(0.0, 0.0, 8.0)), 0.2, False),
    ],
)
def test_near_fast_or_whirling_it_may_touch_something_within_a_tick(client, config, truth, room_m, out_of_reach):
    feeler = Feeler(client, 0, config.vehicle, {})
    feeler.look(truth, room_m)
    assert feeler.out_of_reach is out_of_reach
