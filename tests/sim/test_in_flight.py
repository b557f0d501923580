"""Happenings in whole flights of the cheapest stack, which hovers at home."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from tiny_stack import SOUND

from scaloft_fi.sim.contact import Feeler
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.load import load
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.stack.declaration import STEP_S, TICK_S, PlainWire

pytestmark = pytest.mark.flight

SIM = Path(__file__).parents[2] / "sim"
Fly = Callable[[str], FlightLog]


@pytest.fixture
def flown(tmp_path: Path) -> Fly:
    """Fly beside a person in a world with one happening."""
    study = Path(shutil.copytree(SIM, tmp_path / "sim"))
    (study / "stack.yaml").write_text("name: hop\nmass_kg: 1.5\n")
    head, person = (study / "world.yaml").read_text().split("\n  person:", 1)
    world = f"{head}\n  person:{person.replace('present: false', 'present: true', 1)}"

    def in_world(happening: str) -> FlightLog:
        (study / "world.yaml").write_text(f"{world}\nhappenings: {{h: {{active: true, {happening}}}}}\n")
        config = load(study)
        return fly(config, config.grid.situation("T0O0W0D0H1"), 0, PlainWire(), SOUND)

    return in_world


@pytest.mark.parametrize("start_s", [0.5, 0.51, 0.52, 0.53, 0.54])
@pytest.mark.parametrize("speed_mps", [1.3, 2.9, 9.5])
def test_a_body_that_walks_into_the_drone_strikes_at_the_step_in_which_it_arrives(
    flown: Fly, speed_mps: float, start_s: float
) -> None:
    log = flown(f"kind: walk, body: person, path: [[0.0, 0.0]], speed_mps: {speed_mps}, start: {{at_s: {start_s}}}")
    assert log.struck == "person"
    walked_m = speed_mps * (log.struck_at_s - start_s)
    share = walked_m / math.hypot(0.5, 3.25)
    x, y = -0.5 * (1 - share), 3.25 * (1 - share)
    i = log.at(log.struck_at_s)
    gaps = (abs(x - log.signals["x_m"][i]) - 0.235, abs(y - log.signals["y_m"][i]) - 0.235)
    overlap_m = 0.25 - math.hypot(*(max(0.0, gap) for gap in gaps))
    assert -0.02 < overlap_m < 3 * speed_mps * STEP_S + 0.005


def test_the_free_room_of_a_tick_is_smaller_by_what_a_body_can_walk_in_it(
    flown: Fly, monkeypatch: pytest.MonkeyPatch
) -> None:
    rooms: list[float] = []
    look = Feeler.look

    def noted(feeler: Feeler, truth: Sequence[float], room_m: float) -> None:
        rooms.append(room_m)
        look(feeler, truth, room_m)

    monkeypatch.setattr(Feeler, "look", noted)
    walk = "kind: walk, body: person, path: [[0.0, 0.0]], start: {at_s: 20}"  # after the landing
    slow, fast = flown(f"{walk}, speed_mps: 1"), flown(f"{walk}, speed_mps: 9")
    assert slow.digest == fast.digest
    first, second = rooms[: len(rooms) // 2], rooms[len(rooms) // 2 :]
    assert [a - b for a, b in zip(first, second, strict=True)] == pytest.approx([8 * TICK_S] * len(first))


def test_wind_pushes_the_drone_and_stands_in_the_log(flown: Fly) -> None:
    calm, windy = flown("kind: light, light: 0.5"), flown("kind: wind, velocity_mps: [0.6, 0, 0]")
    assert windy.signals["x_m"][-1] > calm.signals["x_m"][-1] + 0.1
    assert set(windy.signals["wind_x_mps"].tolist()) == {0.6}
    assert "wind_x_mps" not in calm.signals
    assert set(calm.signals["light"].tolist()) == {0.5}


def test_a_happening_is_marked_when_it_begins(flown: Fly) -> None:
    log = flown("kind: light, light: 0.1, start: {at_s: 1.0}")
    assert [(event.t_s, event.text) for event in log.events if event.kind == "happening"] == [(1.0, "h begins")]
