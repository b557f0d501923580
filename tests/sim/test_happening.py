from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.sim.happenings import HAPPENINGS, Effect, HappeningKind, Start, Surroundings, Walk
from scaloft_fi.sim.load import load as load_sim
from scaloft_fi.sim.world import World, read_world

SIM = Path(__file__).parents[2] / "sim"
Make = Callable[..., World]


@pytest.fixture
def world(tmp_path: Path) -> Make:
    """The reference world with these happenings, one line of YAML each."""

    def make(*happenings: str, **present: bool) -> World:
        text = (SIM / "world.yaml").read_text()
        for body in present:
            head, tail = text.split(f"\n  {body}:", 1)
            text = f"{head}\n  {body}:{tail.replace('present: false', 'present: true', 1)}"
        lines = "".join(f"\n  h{number}: {{active: true, {line}}}" for number, line in enumerate(happenings))
        (tmp_path / "world.yaml").write_text(f"{text}\nhappenings:{lines or ' {}'}\n")
        return read_world(load(tmp_path / "world.yaml"))

    return make


def at(around: Surroundings, now_s: float, x_m: float = 0.0, y_m: float = 0.0) -> dict[str, float]:
    around.update(now_s, x_m, y_m)
    return dict(zip(around.names, around.row(), strict=True))


def test_in_a_world_without_happenings_nothing_changes_and_nothing_is_recorded(world: Make) -> None:
    plain = world()
    around = plain.surroundings()
    assert at(around, 10.0) == {}
    assert around.scene is plain.scene
    assert (around.light, around.haze_per_m, around.top_body_mps, around.top_wind_mps) == (0.9, 0.0, 0.0, 0.0)
    assert not around.wind_mps.any()
    assert not around.drift_m.any()


def test_a_happening_that_is_not_active_is_read_and_left_out(tmp_path: Path) -> None:
    (tmp_path / "world.yaml").write_text(
        (SIM / "world.yaml").read_text() + "\nhappenings: {dark: {kind: light, active: false, light: 0.1}}\n"
    )
    assert read_world(load(tmp_path / "world.yaml")).happenings == ()


def test_light_changes_while_the_happening_lasts(world: Make) -> None:
    around = world("kind: light, light: 0.003, start: {at_s: 5}, lasts_s: 2").surroundings()
    lights = []
    for now_s in (0.0, 4.95, 5.0, 7.0, 7.05):
        around.update(now_s, 0.0, 0.0)
        lights.append(around.light)
    assert lights == [0.9, 0.9, 0.003, 0.003, 0.9]


def test_a_happening_at_a_place_starts_when_the_vehicle_first_comes_near_and_only_once(world: Make) -> None:
    around = world("kind: light, light: 0.1, start: {near: [0, 5], within_m: 1}, lasts_s: 1").surroundings()
    lights = []
    for now_s, y_m in ((0.0, 0.0), (1.0, 3.9), (2.0, 4.1), (2.9, 6.5), (3.1, 5.0), (9.0, 5.0)):
        around.update(now_s, 0.0, y_m)
        lights.append(around.light)
    assert lights == [0.9, 0.9, 0.1, 0.1, 0.9, 0.9]


def test_winds_dust_and_drifts_add_up_and_are_recorded(world: Make) -> None:
    around = world(
        "kind: wind, velocity_mps: [1, 0, 0]",
        "kind: wind, velocity_mps: [0, 2, 0], start: {at_s: 1}",
        "kind: dust, haze_per_m: 0.2",
        "kind: dust, haze_per_m: 0.3, start: {at_s: 1}, lasts_s: 1",
        "kind: drift, rate_mps: [0.01, 0, -0.02], start: {at_s: 2}",
    ).surroundings()
    assert around.top_wind_mps == 3.0
    at(around, 1.0)
    assert around.wind_mps.tolist() == [1.0, 2.0, 0.0]
    assert around.haze_per_m == 0.5
    row = at(around, 12.0)
    assert around.drift_m.tolist() == pytest.approx([0.1, 0.0, -0.2])
    assert row == {
        "wind_x_mps": 1.0,
        "wind_y_mps": 2.0,
        "wind_z_mps": 0.0,
        "haze_per_m": 0.2,
        "drift_x_m": pytest.approx(0.1),
        "drift_y_m": 0.0,
        "drift_z_m": pytest.approx(-0.2),
    }


def test_a_walking_person_moves_alone_in_the_scene_and_stays_at_the_end(world: Make) -> None:
    still = world(person=True)
    around = world("kind: walk, body: person, path: [[-0.5, 4.25], [0.5, 4.25]], speed_mps: 0.5", person=True)
    flight = around.surroundings()
    assert at(flight, 1.0) == {"person_x_m": pytest.approx(-0.5), "person_y_m": pytest.approx(3.75)}
    assert at(flight, 3.0) == {"person_x_m": pytest.approx(0.0), "person_y_m": pytest.approx(4.25)}
    assert at(flight, 60.0) == {"person_x_m": pytest.approx(0.5), "person_y_m": pytest.approx(4.25)}
    scene = flight.scene
    person = np.unique(scene.faces[scene.owner == scene.names.index("person")])
    moved = scene.vertices - still.scene.vertices
    assert np.allclose(moved[person], (1.0, 1.0, 0.0))
    assert not np.delete(moved, person, axis=0).any()
    assert np.array_equal(around.scene.vertices, still.scene.vertices)  # another flight begins anew


def test_a_body_that_appears_is_out_of_reach_before(world: Make) -> None:
    around = world("kind: appear, body: obstacle, start: {at_s: 3}", obstacle=True).surroundings()
    scene = around.scene
    obstacle = scene.faces[scene.owner == scene.names.index("obstacle")]
    around.update(2.95, 0.0, 0.0)
    assert scene.vertices[obstacle][..., 2].max() < -900
    around.update(3.0, 0.0, 0.0)
    assert scene.vertices[obstacle][..., 2].min() >= 0.0


@given(
    st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3)), min_size=1, max_size=5),
    st.floats(0.1, 3.0),
    st.floats(0.0, 20.0),
    st.floats(0.0, 1.0),
)
def test_a_walk_is_never_faster_than_its_speed(
    path: list[tuple[float, float]], speed_mps: float, t_s: float, later_s: float
) -> None:
    walk = Walk("person", tuple(path), speed_mps)
    before, after = walk.shift((0.0, 0.0), t_s), walk.shift((0.0, 0.0), t_s + later_s)
    assert math.dist(before, after) <= speed_mps * later_s + 1e-9


def test_a_start_needs_its_time_and_its_place() -> None:
    both = Start(at_s=5.0, near=(0.0, 0.0), within_m=1.0)
    assert [both.has_come(*when) for when in ((4.9, 0.0, 0.0), (5.0, 2.0, 0.0), (5.0, 0.5, 0.5))] == [
        False,
        False,
        True,
    ]


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("kind: lihgt, light: 0.1", "kind='lihgt' is not known; did you mean 'light'?"),
        ("kind: light, light: 1.5", "light=1.5 must be >= 0 and <= 1"),
        ("kind: light, light: 0.1, ligth: 2", "unknown key 'ligth' in h0"),
        ("kind: light, light: 0.1, start: {at_s: -1}", "at_s=-1 must be >= 0"),
        ("kind: light, light: 0.1, start: {near: [0, 5]}", "start must have at_s, or near and within_m"),
        ("kind: light, light: 0.1, start: {}", "start must have at_s, or near and within_m"),
        (
            "kind: light, light: 0.1, start: {near: [9, 9], within_m: 1}",
            "near=[9.0, 9.0] must be in the open space of the mine, or happening 'h0' cannot come",
        ),
        ("kind: light, light: 0.1, lasts_s: 0", "lasts_s=0 must be > 0"),
        ("kind: dust, haze_per_m: 0", "haze_per_m=0 must be > 0 and <= 10"),
        ("kind: wind, velocity_mps: [0, 99, 0]", "velocity_mps[1]=99 must be >= -30 and <= 30"),
        ("kind: walk, body: persn, path: [[0, 1]], speed_mps: 1", "no body 'persn'; did you mean 'person'?"),
        ("kind: walk, body: person, path: [[0, 1]], speed_mps: 1", "body='person' must be present for the happening"),
        ("kind: appear, body: obstacle", "body='obstacle' must be present for the happening 'h0'"),
        ("kind: walk, body: bar, path: [], speed_mps: 1", "path=[...] must be a list of 1 to 1000 places [x, y]"),
        (
            "kind: walk, body: bar, path: [[-3.0, 7.5], [0.5, 3.0]], speed_mps: 1",
            "path of 'bar' from [-3.0, 7.5] to [0.5, 3.0] must not lead through a wall",
        ),
        ("kind: walk, body: bar, path: [[-9, 7.7]], speed_mps: 1", "must not lead through a wall"),
        ("kind: walk, body: bar, path: [[-1.9, 8.0]], speed_mps: 99", "speed_mps=99 must be > 0 and <= 10"),
    ],
)
def test_a_happening_that_cannot_be_is_refused_with_its_line(world: Make, line: str, sentence: str) -> None:
    with pytest.raises(InputError) as error:
        world(line)
    assert sentence in str(error.value)
    assert "world.yaml:" in str(error.value)


def test_two_happenings_that_move_one_body_are_refused(world: Make) -> None:
    walk = "kind: walk, body: person, path: [[-0.5, 4.0]], speed_mps: 1"
    with pytest.raises(InputError, match=r"world.yaml:\d+: body 'person' is moved by happening 'h0' already"):
        world(walk, "kind: appear, body: person", person=True)


def test_a_happening_after_the_time_limit_is_refused_when_its_situation_is_built(tmp_path: Path) -> None:
    import shutil

    study = Path(shutil.copytree(SIM, tmp_path / "sim"))
    with (study / "world.yaml").open("a") as file:
        file.write("\nhappenings: {late: {kind: light, active: true, light: 0.1, start: {at_s: 140}}}\n")
    config = load_sim(study)
    assert config.scenario(config.grid.situation("T0O0W0D0H1")).t_max_s > 140  # slow beside a person
    with pytest.raises(InputError, match=r"at_s=140 must be before the time limit of situation T0O0W0D0H0, 80.2 s"):
        config.scenario(config.grid.situation("T0O0W0D0H0"))


def test_a_kind_of_another_author_is_one_declaration(world: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    class Rain(Effect):
        def apply(self, around: Surroundings, since_s: float) -> None:
            around.haze_per_m += 0.1
            around.note(rain_per_m=0.1)

    monkeypatch.setitem(HAPPENINGS._entries, "rain", HappeningKind(Rain, signals=("rain_per_m",)))
    around = world("kind: rain").surroundings()
    assert at(around, 0.0) == {"rain_per_m": 0.1}
    assert around.haze_per_m == 0.1
