"""Grids in `sim/grids/`, and the wide grid of the reference study."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.judge.space import Realisation, Space
from scaloft_fi.sim.grids import grid_names, load_grid, own_name
from scaloft_fi.sim.load import SimConfig, load
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]
SIM = ROOT / "sim"
LIGHT = """
axes:
  L:
    title: light
    category: environment, light level
    values:
      - {id: 0, title: bright}
      - {id: 1, title: dim, set: {light: 0.2}, realised: always(light <= 0.3)}
"""


@pytest.fixture
def sim(tmp_path: Path) -> Path:
    return Path(shutil.copytree(SIM, tmp_path / "sim", ignore=shutil.ignore_patterns("found.yaml")))


@pytest.fixture(scope="module")
def wide() -> SimConfig:
    return load(SIM, grid=load_grid(SIM, "wide"))


def further(sim: Path, text: str, name: str = "light") -> Path:
    path = sim / "grids" / f"{name}.yaml"
    path.write_text(text)
    return path


def test_the_reference_study_has_the_grid_of_the_paper_two_further_ones_and_that_of_the_finds() -> None:
    assert grid_names(SIM) == ("paper", "search", "wide", "paper+found")
    assert (load_grid(SIM).name, load_grid(SIM, "wide").name) == ("paper", "wide")
    assert (load_grid(SIM).choose, load_grid(SIM, "wide").choose) == ("all", "3-way")


def test_a_study_without_a_name_for_its_own_grid_calls_it_situations(sim: Path) -> None:
    path = sim / "situations.yaml"
    path.write_text(path.read_text().replace("name: paper\n", ""))
    assert own_name(sim) == load_grid(sim).name == "situations"


def test_a_further_grid_has_its_own_axes_over_the_same_world(sim: Path) -> None:
    further(sim, LIGHT)
    grid = load_grid(sim, "light")
    assert [situation.key for situation in grid.situations] == ["L0", "L1"]
    assert grid.world(grid.situation("L1")).light == 0.2
    assert grid.world().bodies.keys() == load_grid(sim).world().bodies.keys()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (f"name: other\n{LIGHT}", "unknown key 'name'"),
        (f"adds: {{world: {{light: 0.5}}}}\n{LIGHT}", "world.light exists already"),
        (f"adds: {{world: {{fog: 0.5}}}}\n{LIGHT}", "unknown key 'fog' in world.yaml"),
        (f"chose: 2-way\n{LIGHT}", "unknown key 'chose' in light.yaml; did you mean 'choose'?"),
    ],
)
def test_a_further_grid_that_is_wrong_is_refused_with_its_place(sim: Path, text: str, sentence: str) -> None:
    path = further(sim, text)
    with pytest.raises(InputError) as refused:
        load_grid(sim, "light")
    assert str(refused.value).startswith(f"{path}:")
    assert sentence in str(refused.value)


def test_what_only_a_further_grid_adds_leaves_the_own_grid_as_it_was(sim: Path) -> None:
    own = Study.open(ROOT)
    assert "belt" not in own.grid.world().bodies
    assert "belt" in Study.open(ROOT, "wide").grid.world().bodies
    assert own.inputs == Study.open(ROOT, "paper").inputs
    assert own.inputs["sim"] != Study.open(ROOT, "wide").inputs["sim"]
    shutil.rmtree(sim / "grids")
    for name in ("hazop", "mutants"):
        shutil.copytree(ROOT / name, sim.parent / name)
    assert Study.open(sim.parent).inputs == own.inputs


def test_the_catalogue_is_the_same_in_every_grid() -> None:
    assert Study.open(ROOT, "wide").catalogue == Study.open(ROOT).catalogue


def test_every_number_of_the_wide_grid_has_a_source_and_every_source_a_number(wide: SimConfig) -> None:
    assert [path for path in wide.numbers if wide.source_of(path) is None] == []
    own = load(SIM).sources
    more = [path for path in wide.sources if path not in own or path.startswith("situations.")]
    assert more
    assert [path for path in more if not any(f"{number}.".startswith(f"{path}.") for number in wide.numbers)] == []
    assert wide.source_of("situations.axes.D.values.1.set.light") is not own["situations.axes"]


def test_the_wide_grid_has_what_the_paper_s_grid_lacks(wide: SimConfig) -> None:
    grid = wide.grid
    paths = {path for axis in grid.axes for value in axis.values for path in value.changes}
    happenings = {path for path in paths if path.startswith("world.happenings")}
    assert {f"world.happenings.{name}.active" for name in ("lamp", "miner", "draught", "wander")} == happenings
    assert {"world.mission.cruise_mps", "sensors.battery.charge", "world.bodies.obstacle.position"} <= paths
    assert {1.0, 1.2} == {grid.world_of(grid.documents_with([v])).mission.cruise_mps for v in grid.axes[5].values[1:]}


def test_a_predicate_may_name_a_signal_of_a_happening_and_fails_where_it_does_not_happen() -> None:
    grid = load_grid(SIM, "wide")
    study = Study.open(ROOT, "wide")
    realisation = Realisation.read(grid, (*study.signals, *grid.passing_signals))
    still, windy = "T0O0W0D0H0C0V0P0B0G0", "T0O0W0D0H0C0V1P0B0G0"
    assert {still, windy} <= set(Space.of(grid).point)
    log = {name: [0.0, 0.0] for name in study.signals} | {"takeoff_charge": [0.95, 0.95]}
    assert "wind_x_mps" not in log
    assert dict(realisation.of(still, log))["V"]
    assert not dict(realisation.of(windy, log))["V"]
    blown = log | {"wind_x_mps": [0.0, 2.0]}
    assert dict(realisation.of(windy, blown))["V"]
    assert not dict(realisation.of(still, blown))["V"]


def test_files_that_are_no_grids_are_passed_over_and_a_name_is_used_once(sim: Path) -> None:
    for name in (".hidden", "my grid", "..", "light"):
        further(sim, LIGHT, name)
    (sim / "grids" / "folder.yaml").mkdir()
    assert set(grid_names(sim)) - {"light"} == set(grid_names(SIM)) - {"paper+found"}
    path = further(sim, LIGHT, "paper")
    with pytest.raises(InputError, match=r"the grid of situations\.yaml is called 'paper' already") as refused:
        grid_names(sim)
    assert str(refused.value).startswith(str(path))


def test_the_name_of_the_own_grid_is_a_name(sim: Path) -> None:
    path = sim / "situations.yaml"
    path.write_text(path.read_text().replace("name: paper", "name: ../paper"))
    with pytest.raises(InputError, match="must be a name of letters, digits, - and _"):
        grid_names(sim)


def test_a_grid_called_as_the_file_of_the_own_one_keeps_its_sources(sim: Path) -> None:
    shutil.copy(sim / "grids" / "wide.yaml", sim / "grids" / "situations.yaml")
    config = load(sim, grid=load_grid(sim, "situations"))
    assert [path for path in config.numbers if config.source_of(path) is None] == []


def test_other_files_among_the_grids_change_no_flight_of_the_own_grid(sim: Path) -> None:
    for name in ("hazop", "mutants"):
        shutil.copytree(ROOT / name, sim.parent / name)
    before = Study.open(sim.parent).inputs
    (sim / "grids" / "notes.txt").write_text("about the grids")
    assert Study.open(sim.parent).inputs == before
