"""A role of another author's package: one declaration."""

from __future__ import annotations

import pytest

from scaloft_fi.sim.load import load
from scaloft_fi.sim.world import ROLES, Role
from scaloft_fi.views.picture import body_style


@pytest.fixture
def dog(monkeypatch):
    monkeypatch.setitem(ROLES._entries, "dog", Role("an animal", label="dog", is_obstacle=True, fill="#123456"))


def test_a_declared_role_says_what_detector_signals_and_map_make_of_a_body(dog, edited):
    config = load(edited("world.yaml", "role: person", "role: dog"))
    scenario = config.scenario(config.grid.situation("T0O0W0D0H1"))
    assert scenario.labels == {"person": "dog"}
    assert scenario.persons == ()
    assert "person" in scenario.world.bodies_with(lambda role: role.is_obstacle)
    assert 'fill="#123456"' in body_style("dog")


def test_a_person_is_one_for_detector_and_signals(config):
    scenario = config.scenario(config.grid.situation("T0O1W0D0H1"))
    assert scenario.labels == {"person": "person"}
    assert scenario.persons == ("person",)
    assert scenario.world.bodies_with(lambda role: role.is_obstacle) == ("obstacle",)
