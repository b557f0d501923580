from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from builders import GRID, SIGNALS

from scaloft_fi.errors import InputError
from scaloft_fi.judge.space import Realisation, Space
from scaloft_fi.sim.load import load

SIM = Path(__file__).resolve().parents[2] / "sim"
STUDY = load(SIM).grid


def test_the_space_of_the_study_is_its_grid() -> None:
    space = Space.of(STUDY)
    assert (space.axes, space.values) == (GRID.axes, GRID.values)
    assert [key for key, _ in space.points] == [situation.key for situation in STUDY.situations]
    assert space.points == GRID.points
    assert (space.word(3, "0"), space.word(4, "1")) == ("light", "human")
    assert space.rank("T0O0W0D0H1") < space.rank("T1O0W0D0H0") < space.rank("nowhere")


def test_the_values_of_the_study_come_true_by_its_own_formulas() -> None:
    realisation = Realisation.read(STUDY, SIGNALS)
    calm = {name: [0.0, 0.0] for name in SIGNALS}
    calm |= {"light": [1.0, 1.0], "person_sight_m": [100.0, 100.0], "waypoint_wall_m": [100.0, 100.0]}
    assert all(true for _, true in realisation.of("T0O0W0D0H0", calm))
    assert not any(true for _, true in realisation.of("T1O1W1D1H1", calm))
    full = calm | {"x_m": [0.0, -1.5], "obstacle_pixels": [9.0, 0.0], "waypoint_wall_m": [100.0, 0.3]}
    full |= {"light": [0.003, 0.003], "person_sight_m": [100.0, 2.9]}
    assert all(true for _, true in realisation.of("T1O1W1D1H1", full))
    assert not any(true for _, true in realisation.of("T0O0W0D0H0", full))


def test_a_predicate_that_is_no_formula_is_named_with_file_and_line(tmp_path: Path) -> None:
    sim = shutil.copytree(SIM, tmp_path / "sim")
    path = sim / "situations.yaml"
    text = path.read_text(encoding="utf-8").replace("eventually(x_m < -1)", "eventually(x < -1)")
    path.write_text(text, encoding="utf-8")
    line = 1 + next(number for number, row in enumerate(text.splitlines()) if "eventually(x < -1)" in row)
    with pytest.raises(InputError) as caught:
        Realisation.read(load(sim).grid, SIGNALS)
    assert str(caught.value).startswith(f"{path}:{line}: realised names the unknown signal 'x'")
