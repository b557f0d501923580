from __future__ import annotations

from itertools import pairwise

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.sim.load import load


def test_the_reference_grid_has_32_situations_in_order(config):
    keys = [situation.key for situation in config.grid.situations]
    assert len(config.grid) == len(set(keys)) == 32
    assert keys == sorted(keys)
    assert keys[0] == "T0O0W0D0H0"


def test_situations_of_the_paper_go_by_their_numbers(config):
    grid = config.grid
    assert [grid.situation(number).key for number in ("1", "2", "3", "32")] == [
        "T0O0W0D0H1",
        "T0O0W0D1H0",
        "T0O0W1D0H0",
        "T1O1W1D1H0",
    ]
    assert grid.aliases_of(grid.situation("T1O1W1D1H0")) == ("32",)


def test_globs_keys_and_aliases_select_together_in_the_order_of_the_grid(config):
    selected = config.grid.select(["T1O1W1D*H0", "3", "T0O0W1D0H0"])
    assert [s.key for s in selected] == ["T0O0W1D0H0", "T1O1W1D0H0", "T1O1W1D1H0"]
    assert len(config.grid.select([])) == 32
    assert len(config.grid.select(["T1*"])) == 16
    assert len(config.grid.select(["T?O0W0D[0]H*"])) == 4


@pytest.mark.parametrize("name", ["T2*", "T0O0W0D0H2", "t0o0w0d0h0", "99", "", "T0O0W0D0"])
def test_a_situation_that_is_none_is_refused_with_the_nearest(config, name):
    with pytest.raises(InputError, match=r"^no situation .* did you mean 'T.O.W.D.H.'\?$"):
        config.grid.select([name])


def test_gray_order_visits_every_situation_once_one_axis_at_a_time(config):
    walk = config.grid.gray_order()
    assert {situation.key for situation in walk} == {situation.key for situation in config.grid.situations}
    for before, after in pairwise(walk):
        changed = [abs(a - b) for (_, a), (_, b) in zip(before.levels, after.levels, strict=True) if a != b]
        assert changed == [1]


def test_titles_say_a_situation_in_words(config):
    titles = config.grid.titles(config.grid.situation("T1O0W0D1H1"))
    assert titles == ("corner", "free path", "open space", "dark", "human")


AIR = """
  Air:
    title: air
    category: environment, dust
    values:
      - {id: 0, title: clear}
      - {id: 1, title: hazy, set: {light: 0.5}, realised: always(light <= 0.5)}
      - {id: 2, title: dusty, set: {light: 0.2, mission.cruise_mps: 0.3}, realised: always(light <= 0.2)}
"""


def test_a_users_axis_with_three_values_joins_the_grid(edited):
    grid = load(edited("situations.yaml", "\naliases:", f"{AIR}\naliases:")).grid
    assert len(grid) == 96
    world = grid.scenario(grid.situation("T1O0W0D0H0Air2")).world
    assert world.light == 0.2
    assert world.mission.cruise_mps == 0.3
    assert grid.axes[-1].predicate(0) == "(not (always(light <= 0.5))) and (not (always(light <= 0.2)))"
    assert len({situation.key for situation in grid.gray_order()}) == 96
    assert grid.situation("32").key == "T1O1W1D1H0Air0"  # the paper's numbers outlive a new axis


def test_values_that_do_not_go_together_are_refused_when_their_scenario_is_asked_for(edited):
    grid = load(edited("world.yaml", "position: [-0.15, 5.0]", "position: [0.865, 7.0]")).grid
    grid.scenario(grid.situation("T0O1W0D0H0"))
    with pytest.raises(InputError, match=r"situations.yaml:\d+: corner=.* not inside 'obstacle'"):
        grid.scenario(grid.situation("T0O1W1D0H0"))
