from __future__ import annotations

import shutil
from pathlib import Path

from builders import GRID, SIGNALS, space_of, with_range
from refused import refusal

from scaloft_fi.judge.space import Realisation, Space
from scaloft_fi.sim.load import load

SIM = Path(__file__).resolve().parents[2] / "sim"
STUDY = load(SIM).grid


def test_the_space_of_the_study_is_its_grid():
    space = Space.of(STUDY)
    assert (space.axes, space.values) == (GRID.axes, GRID.values)
    assert [key for key, _ in space.points] == [situation.key for situation in STUDY.situations]
    assert space.points == GRID.points
    assert (space.word(3, "0"), space.word(4, "1")) == ("light", "human")
    assert space.rank("T0O0W0D0H1") < space.rank("T1O0W0D0H0") < space.rank("nowhere")


def test_the_values_of_the_study_come_true_by_its_own_formulas():
    realisation = Realisation.read(STUDY, SIGNALS)
    calm = {name: [0.0, 0.0] for name in SIGNALS}
    calm |= {"light": [1.0, 1.0], "person_sight_m": [100.0, 100.0], "waypoint_wall_m": [100.0, 100.0]}
    assert all(true for _, true in realisation.of("T0O0W0D0H0", calm))
    assert not any(true for _, true in realisation.of("T1O1W1D1H1", calm))
    full = calm | {"x_m": [0.0, -1.5], "obstacle_pixels": [9.0, 0.0], "waypoint_wall_m": [100.0, 0.3]}
    full |= {"light": [0.003, 0.003], "person_sight_m": [100.0, 2.9]}
    assert all(true for _, true in realisation.of("T1O1W1D1H1", full))
    assert not any(true for _, true in realisation.of("T0O0W0D0H0", full))


def test_a_predicate_that_is_no_formula_is_named_with_file_and_line(tmp_path: Path):
    sim = shutil.copytree(SIM, tmp_path / "sim")
    path = sim / "situations.yaml"
    text = path.read_text(encoding="utf-8").replace("eventually(x_m < -1)", "eventually(x < -1)")
    path.write_text(text, encoding="utf-8")
    line = 1 + next(number for number, row in enumerate(text.splitlines()) if "eventually(x < -1)" in row)
    said = refusal(Realisation.read, load(sim).grid, SIGNALS)
    assert said.startswith(f"{path}:{line}: realised names the unknown signal 'x'")


def test_drawn_situations_have_the_point_of_their_bins_and_come_after_it(tmp_path: Path):
    grid = load(with_range(shutil.copytree(SIM, tmp_path / "sim"))).grid
    space = Space.of(grid)
    fast, slow, bin_ = "T0O0W0D0H0C2=0.95", "T0O0W0D0H0C2=0.81", "T0O0W0D0H0C2"
    assert space.point[fast] == space.point[slow] == space.point[bin_] == ("0", "0", "0", "0", "0", "2")
    assert set(space.point) == {situation.key for situation in grid.situations}
    for key in ("T0O0W0D0H0C1=0.95", "T0O0W0D0H0C2=0.950", "T0=1O0W0D0H0C2", "C2=0.95", "nowhere", 7):
        assert key not in space.point
    listed = [key for key, _ in space.holding([fast, slow, "nowhere", bin_]).situations]
    assert listed.index(bin_) + 1 == listed.index(slow) == listed.index(fast) - 1
    assert len(listed) == len(grid) + 2
    assert space.words_of(fast) == (*space.words_of(bin_)[:-1], "0.95 m/s")
    assert space.rank(fast) < space.rank("T0O0W0D0H0C3") < space.rank("nowhere")


def test_a_drawn_number_came_true_by_the_formula_of_that_number(tmp_path: Path):
    grid = load(with_range(shutil.copytree(SIM, tmp_path / "sim"))).grid
    realisation = Realisation.read(grid, SIGNALS)
    signals = {name: [0.0, 0.0] for name in SIGNALS} | {"speed_mps": [0.7, 0.7]}
    came_true = {number: dict(realisation.of(f"T0O0W0D0H0C2={number}", signals))["C"] for number in ("0.86", "0.89")}
    assert came_true == {"0.86": True, "0.89": False}  # 0.8 * 0.86 = 0.688, 0.8 * 0.89 = 0.712


def test_a_large_grid_lists_the_situations_that_were_flown_and_a_small_one_all():
    large = space_of([2] * 9)
    flown = [large.points[300][0], large.points[7][0]]
    assert len(large.situations) == len(large.points) == 512
    held = large.holding(flown)
    assert [key for key, _ in held.situations] == [large.points[7][0], large.points[300][0]]
    assert held.points == large.points
    assert set(held.point) == set(large.point)
    small = space_of([2] * 8)
    assert len(small.holding([small.points[7][0]]).situations) == 256


def test_to_hold_twice_is_to_hold_both():
    large = space_of([2] * 9)
    first, second = large.points[7][0], large.points[300][0]
    assert [key for key, _ in large.holding([first, second]).holding([first]).situations] == [first, second]
