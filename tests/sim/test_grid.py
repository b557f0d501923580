from __future__ import annotations

import itertools
from itertools import pairwise

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.sim.load import load
from scaloft_fi.sim.situation import Situation


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
    config = load(edited("situations.yaml", "\naliases:", f"{AIR}\naliases:"))
    grid = config.grid
    assert len(grid) == 96
    world = config.scenario(grid.situation("T1O0W0D0H0Air2")).world
    assert world.light == 0.2
    assert world.mission.cruise_mps == 0.3
    assert grid.axes[-1].predicate(0) == "(not (always(light <= 0.5))) and (not (always(light <= 0.2)))"
    assert len({situation.key for situation in grid.gray_order()}) == 96
    assert grid.situation("32").key == "T1O1W1D1H0Air0"  # the paper's numbers outlive a new axis


def test_values_that_do_not_go_together_are_refused_when_their_scenario_is_asked_for(edited):
    config = load(edited("world.yaml", "position: [-0.15, 5.0]", "position: [0.865, 7.0]"))
    config.scenario(config.grid.situation("T0O1W0D0H0"))
    with pytest.raises(InputError, match=r"situations.yaml:\d+: corner=.* not inside 'obstacle'"):
        config.scenario(config.grid.situation("T0O1W1D0H0"))


CONSTRAINT = """
constraints:
  - exclude: {T: 0, W: 1}
    reason: no wall is near a straight corridor's waypoint
  - {exclude: {D: 1, H: 1}, reason: people carry lamps}

aliases:"""


@pytest.fixture
def constrained(edited):
    edited("situations.yaml", '\n  "32": T1O1W1D1H0', "")
    edited("situations.yaml", '\n  "3": T0O0W1D0H0', "")
    return load(edited("situations.yaml", "\naliases:", CONSTRAINT)).grid


def test_no_situation_has_an_excluded_combination(constrained):
    wanted = [
        s.key
        for s in itertools.product(range(2), repeat=5)
        for s in [Situation.of(dict(zip("TOWDH", s, strict=True)))]
        if not (s["T"] == 0 and s["W"] == 1) and not (s["D"] == 1 and s["H"] == 1)
    ]
    assert [situation.key for situation in constrained.situations] == wanted
    assert len(constrained) == 18
    assert {situation.key for situation in constrained.gray_order()} == set(wanted)


def test_an_excluded_situation_is_refused_with_its_reason(constrained):
    with pytest.raises(InputError, match=r"'T0O0W1D0H0' is excluded by .*situations.yaml:\d+: no wall is near"):
        constrained.situation("T0O0W1D0H0")


@pytest.mark.parametrize(
    ("constraint", "sentence"),
    [
        ("{exclude: {T: 0, X: 1}, reason: r}", "exclude names the unknown axis 'X'"),
        ("{exclude: {T: 0, W: 2}, reason: r}", "W=2 must be values of axis 'W', 0 to 1"),
        ("{exclude: {T: 0, W: []}, reason: r}", r"W=\[...\] must be values of axis 'W', 0 to 1"),
        ("{exclude: {T: 0}, reason: r}", "exclude must name the values of at least 2 axes"),
        ("{exclude: {T: 0, W: 1}}", "lacks the key 'reason'"),
        ("{exclude: {T: 0, W: 1}, reason: r, why: x}", "unknown key 'why'"),
        ("{exclude: {T: 1, W: [0, 1]}, reason: r}", "must leave every value a situation, T1 has none"),
    ],
)
def test_a_constraint_that_means_nothing_is_refused(edited, constraint, sentence):
    study = edited("situations.yaml", "\naliases:", f"\nconstraints:\n  - {constraint}\naliases:")
    with pytest.raises(InputError, match=rf"situations.yaml:\d+: .*{sentence}"):
        load(study)


def test_an_alias_of_an_excluded_situation_is_refused(edited):
    with pytest.raises(InputError, match="alias '3': situation 'T0O0W1D0H0' is excluded by"):
        load(edited("situations.yaml", "\naliases:", CONSTRAINT))


def test_axes_that_make_too_many_situations_are_refused(edited):
    many = "".join(
        f"\n  A{chr(97 + i)}: {{title: t, category: c, values: [{{id: 0, title: a}}, "
        "{id: 1, title: b, realised: always(light <= 1)}]}"
        for i in range(16)
    )
    with pytest.raises(InputError, match=r"axes make 2097152 situations, they must make at most 1000000"):
        load(edited("situations.yaml", "\naliases:", f"{many}\n\naliases:"))
