from __future__ import annotations

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.sim.load import KINDS, load


def test_every_number_has_a_source(config):
    assert [path for path in config.numbers if config.source_of(path) is None] == []
    assert all(source.text for source in config.sources.values())


def test_every_source_covers_a_value(config):
    covered = set(config.numbers)
    assert [path for path in config.sources if not any(f"{n}.".startswith(f"{path}.") for n in covered)] == []


def test_the_longest_path_decides_on_the_source(config):
    assert config.source_of("world.bodies.bar.radius_m").kind == "assumption"
    assert config.source_of("world.bodies.person.position.0").kind == "published"
    assert config.source_of("vehicle.mass_kg").kind == "datasheet"
    assert config.source_of("nowhere.at.all") is None


def test_assumptions_are_the_numbers_that_are_ours(config):
    assert config.assumptions["sensors.depth.active"] == 32
    assert "vehicle.mass_kg" not in config.assumptions
    assert {config.source_of(path).kind for path in config.numbers} <= set(KINDS)


def test_the_stack_is_a_name_and_plain_parameters(config):
    assert config.stack.name == "reference"
    assert "name" not in config.stack.parameters
    assert isinstance(config.stack.parameters["control"]["rotors"], list)


@pytest.mark.parametrize(
    ("path", "value", "read"),
    [
        ("sensors.depth.latency_s", 0.13, lambda c: c.sensors.depth.latency_s),
        ("world.bodies.bar.position.0", -2.1, lambda c: float(c.world.bodies["bar"].mesh.vertices[:, 0].mean())),
        ("vehicle.mass_kg", 1.7, lambda c: c.vehicle.mass_kg),
        ("stack.planner.range_m", 3.0, lambda c: c.stack.parameters["planner"]["range_m"]),
        (
            "situations.axes.D.values.1.set.light",
            0.01,
            lambda c: c.scenario(c.grid.situation("T0O0W0D1H0")).world.light,
        ),
        (
            "world.mission.cruise_mps",
            0.6,
            lambda c: c.scenario(c.grid.situation("T1O0W0D1H0")).world.mission.cruise_mps,
        ),
    ],
)
def test_single_values_can_be_overridden(study, path, value, read):
    assert read(load(study, {path: value})) == pytest.approx(value)


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        (
            "sensors.depth.latncy_s",
            0.1,
            "no path 'sensors.depth.latncy_s' in the study; did you mean 'sensors.depth.latency_s'",
        ),
        ("sensor.depth.latency_s", 0.1, "did you mean 'sensors.depth.latency_s'"),
        ("sensors.depth.latency_s", -0.1, "latency_s=-0.1 must be >= 0"),
    ],
)
def test_an_override_that_cannot_be_is_refused(study, path, value, sentence):
    with pytest.raises(InputError) as error:
        load(study, {path: value})
    assert sentence in str(error.value)


BAD = [
    ("vehicle.yaml", "mass_kg: 1.5", "mass_kg: -1.5", "mass_kg=-1.5 must be >= 1e-06"),
    ("vehicle.yaml", "mass_kg: 1.5", "mass_kg: heavy", "mass_kg='heavy' must be a number"),
    ("vehicle.yaml", "max_thrust_n: 10.35", "max_thrust_n: 3", "max_thrust_n=3 must be > 3.68 to lift off"),
    ("vehicle.yaml", "hull_m: [0.47, 0.47, 0.11]", "hull_m: [0.47, 0, 0.11]", "hull_m[1]=0 must be >= 1e-06"),
    ("vehicle.yaml", "hull_m: [0.47, 0.47, 0.11]", "hull_m: [0.47, 0.11]", "must be a list of 3 numbers"),
    ("vehicle.yaml", "spins: [1, 1, -1, -1]", "spins: [1, 1, -1, 0]", "spins[3]=0 must be 1 or -1"),
    ("vehicle.yaml", "  - [0.0935, 0.107]\n", "", "rotors_m=[...] must be a list of 4 values"),
    ("vehicle.yaml", "drag_ns_per_m: 0.15", "drag: 0.15", "lacks the key 'drag_ns_per_m'"),
    ("vehicle.yaml", "spin_up_s: 0.0125", "spin_up_s: 0", "spin_up_s=0 must be >= 1e-06"),
    ("sensors.yaml", "width: 64", "width: 64.5", "width=64.5 must be a whole number >= 2"),
    ("sensors.yaml", "fov_deg: 59.0", "fov_deg: 180", "fov_deg=180 must be >= 1 and <= 150"),
    ("sensors.yaml", "max_m: 8.0", "max_m: 0.2", "max_m=0.2 must be > 0.3"),
    ("sensors.yaml", "latency_s: 0.3", "latency_s: -3", "latency_s=-3 must be >= 0"),
    ("sensors.yaml", "best: 0.99", "best: 99", "best=99 must be >= 0 and <= 1"),
    ("sensors.yaml", "imu:", "inertial:", "lacks the key 'imu'"),
    ("sensors.yaml", "mid: 0.5", "mid: 0.5\n  middle: 1", "unknown key 'middle' in metering"),
    ("sensors.yaml", "full_cell_v: 4.2", "full_cell_v: 3", "full_cell_v=3"),
    (
        "sources.yaml",
        'kind: published, source: "paper, table 2"',
        "kind: guess, source: x",
        "kind='guess' is not known",
    ),
    ("sources.yaml", "vehicle.spins:", "vehicel.spins:", "no document for 'vehicel.spins'; did you mean 'vehicle'"),
    ("stack.yaml", "name: reference", "label: reference", "lacks the key 'name'"),
]


@pytest.mark.parametrize(("file", "old", "new", "sentence"), BAD)
def test_bad_input_is_refused_in_one_sentence_with_file_and_line(edited, file, old, new, sentence):
    study = edited(file, old, new)
    with pytest.raises(InputError) as error:
        load(study)
    message = str(error.value)
    assert sentence in message
    assert "\n" not in message
    path, line, _ = message.split(":", 2)
    assert path.endswith(file)
    assert int(line) >= 1


def test_a_study_need_not_name_the_sources_of_its_numbers(study):
    (study / "sources.yaml").unlink()
    assert load(study).sources == {}


@pytest.mark.parametrize("file", ["world", "vehicle", "sensors", "situations", "stack"])
def test_a_missing_file_is_named(study, file):
    (study / f"{file}.yaml").unlink()
    with pytest.raises(InputError, match=rf"{file}.yaml: cannot be read: No such file"):
        load(study)
