from __future__ import annotations

import itertools

import pytest
from ranges import CRUISE, with_range

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


def test_titles_say_a_situation_in_words(config):
    titles = config.grid.titles(config.grid.situation("T1O0W0D1H1"))
    assert titles == ("corner", "free path", "open space", "dark", "human")


AIR = """
  Air:
    title: air
    category: environment, dust
    values:
      - {id: 0, title: clear}
      - {id: 1, title: hazy, set: {sensors.depth.max_m: 6}, realised: always(speed_mps <= 0.9)}
      - id: 2
        title: dusty
        set: {sensors.depth.max_m: 4.5, vehicle.mass_kg: 1.6, mission.cruise_mps: 0.3}
        realised: always(speed_mps <= 0.5)
"""


def test_a_users_axis_with_three_values_joins_the_grid(edited):
    config = load(edited("situations.yaml", "\naliases:", f"{AIR}\naliases:"))
    grid = config.grid
    assert len(grid) == 96
    dusty = config.scenario(grid.situation("T1O0W0D0H0Air2"))
    assert (dusty.sensors.depth.max_m, dusty.vehicle.mass_kg, dusty.world.mission.cruise_mps) == (4.5, 1.6, 0.3)
    clear = config.scenario(grid.situation("T1O0W0D0H0Air0"))
    assert (clear.sensors.depth.max_m, clear.vehicle.mass_kg, clear.world.mission.cruise_mps) == (8.0, 1.5, 0.5)
    assert grid.axes[-1].predicate(0) == "(not (always(speed_mps <= 0.9))) and (not (always(speed_mps <= 0.5)))"
    assert grid.situation("32").key == "T1O1W1D1H0Air0"  # the paper's numbers outlive a new axis


def test_values_that_do_not_go_together_are_refused_when_their_scenario_is_asked_for(edited):
    config = load(edited("world.yaml", "position: [-0.15, 5.0]", "position: [0.865, 7.0]"))
    config.scenario(config.grid.situation("T0O1W0D0H0"))
    sentence = (
        r"situations.yaml:\d+: corner=.* not inside 'obstacle': O1 and W1 cannot be combined, "
        r"as in situation T0O1W1D0H0; "
        r"exclude them under constraints: \{exclude: \{O: 1, W: 1\}, reason: ...\}"
    )
    with pytest.raises(InputError, match=sentence):
        config.scenario(config.grid.situation("T0O1W1D0H0"))


@pytest.mark.parametrize(
    ("first", "second", "path"),
    [
        ("light: 0.5", "world.light: 0.2", "world.light"),
        ("waypoints.end.0: -2.5", "waypoints.end: [-2.0, 8.0]", "world.waypoints.end"),
        ("vehicle.mass_kg: 1.4", "vehicle.mass_kg: 1.6", "vehicle.mass_kg"),
    ],
)
def test_two_axes_that_set_one_path_are_refused_until_a_constraint_excludes_them(edited, first, second, path):
    axes = "".join(
        f"""
  {name}:
    title: air
    category: environment
    values: [{{id: 0, title: a}}, {{id: 1, title: b, set: {{{change}}}, realised: always(light >= 0)}}]"""
        for name, change in (("Q", first), ("R", second))
    )
    folder = edited("situations.yaml", "\naliases:", f"{axes}\naliases:")
    pairs = "[{exclude: {Q: 1, R: 1}, reason: never}, {exclude: {D: 1, Q: 1}, reason: never}"
    pairs += ", {exclude: {D: 1, R: 1}, reason: never}]"
    sentence = rf"situations.yaml:\d+: Q1 and R1 both set {path}.*, in situation T0O0W0D0H0Q1R1; exclude them under"
    edited("situations.yaml", "\naliases:", f"\nconstraints: {pairs.replace('Q: 1, R: 1', 'T: 1, O: 1')}\naliases:")
    edited("situations.yaml", '\n  "32": T1O1W1D1H0', "")
    with pytest.raises(InputError, match=sentence):
        load(folder)
    edited("situations.yaml", "T: 1, O: 1", "Q: 1, R: 1")
    assert load(folder).grid.situation("T0O0W0D0H0Q1R0").key


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ("vehicle.mass_kg: -1", "mass_kg=-1 must be >= 1e-06"),
        ("sensors.depth.max_m: 0.1", "max_m=0.1 must be"),
        ("stack.planner.range_m: 3", "'stack.planner.range_m' belongs to the stack under test"),
    ],
)
def test_a_value_that_vehicle_or_sensors_refuse_is_refused_when_the_study_is_read(edited, change, sentence):
    folder = edited("situations.yaml", "set: {light: 0.003}", f"set: {{light: 0.003, {change}}}")
    with pytest.raises(InputError, match=rf"situations.yaml:\d+: {sentence}"):
        load(folder)


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


def test_an_excluded_situation_is_refused_with_its_reason(constrained):
    with pytest.raises(InputError, match=r"'T0O0W1D0H0' is excluded by .*situations.yaml:\d+: no wall is near"):
        constrained.situation("T0O0W1D0H0")


@pytest.mark.parametrize(
    ("constraint", "sentence"),
    [
        ("{exclude: {T: 0, X: 1}, reason: r}", "exclude names the unknown axis 'X'"),
        ("{exclude: {T: 0, W: 2}, reason: r}", "W=2 must be values of axis 'W', 0 to 1"),
        ("{exclude: {T: 0, W: []}, reason: r}", r"W=\[...\] must be the id of a value"),
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


@pytest.fixture
def ranged(study):
    return load(with_range(study))


def test_a_grid_has_a_range_as_bins_with_the_benign_one_first(ranged):
    grid = ranged.grid
    assert len(grid) == 128
    values = grid.axes[-1].values
    assert [(value.id, value.title) for value in values] == [
        (0, "0.4 to 0.6 m/s"),
        (1, "0.6 to 0.8 m/s"),
        (2, "0.8 to 1 m/s"),
        (3, "1 to 1.2 m/s"),
    ]
    flown = [value.changes["world.mission.cruise_mps"].value for value in values]
    assert flown == pytest.approx([0.5, 0.7, 0.9, 1.1], abs=0.001)
    assert values[0].realised == "eventually(speed_mps >= 0.8 * 0.5)"
    assert grid.situation("32").key == "T1O1W1D1H0C0"


def test_a_drawn_situation_flies_its_number(ranged):
    drawn = ranged.grid.situation("T1O0W0D0H0C2=0.871")
    assert ranged.grid.titles(drawn)[-1] == "0.871 m/s"
    assert ranged.scenario(drawn).world.mission.cruise_mps == 0.871
    assert ranged.grid.world(drawn).mission.cruise_mps == 0.871
    assert ranged.grid.values(drawn)["C"].realised == "eventually(speed_mps >= 0.8 * 0.871)"


def test_an_alias_may_name_a_drawn_number(study, edited):
    with_range(study)
    grid = load(edited("situations.yaml", "\naliases:", "\naliases:\n  fast: T1C3=1.15")).grid
    assert grid.situation("fast").key == "T1O0W0D0H0C3=1.15"
    assert grid.aliases_of(grid.situation("fast")) == ("fast",)
    with pytest.raises(InputError, match=r"alias 'fast': .*situations.yaml:\d+: situation .* must have 'C3=1.15'"):
        load(edited("situations.yaml", "C3=1.15", "C2=1.15"))


def test_drawn_situations_are_selected_by_key_after_their_bin(ranged):
    keys = ["T0O0W0D0H0C2=0.9", "T0O0W0D0H0C2=0.85", "T0O0W0D0H0C*", "T0O0W0D0H0C2=0.9"]
    assert [situation.key for situation in ranged.grid.select(keys)] == [
        "T0O0W0D0H0C0",
        "T0O0W0D0H0C1",
        "T0O0W0D0H0C2",
        "T0O0W0D0H0C2=0.85",
        "T0O0W0D0H0C2=0.9",
        "T0O0W0D0H0C3",
    ]


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("T0O0W0D0H0C1=0.871", r"situations.yaml:\d+: situation .* must have 'C2=0.871', the bin of that number"),
        ("T0O0W0D0H0C3=1.3", r"situations.yaml:\d+: C=1.3 of .* must be 0.4 to 1.2"),
        ("T0O0W0D0H0C2=0.8710", "must be written 'T0O0W0D0H0C2=0.871'"),
        ("T0O0W0D0H0C2=0.87123", "must be written 'T0O0W0D0H0C2=0.8712'"),
        ("T0O0W0D0H0=0.5C2", "has a number for axis 'H', which is no range"),
        ("T0O0W0D0C2=0.871", "no situation .* did you mean 'T0O0W0D0H0C2'"),
        ("T0O0W0D0H0C9=0.871", "no situation"),
    ],
)
def test_a_number_that_cannot_be_is_refused(ranged, name, sentence):
    with pytest.raises(InputError, match=sentence) as error:
        ranged.grid.situation(name)
    assert "\n" not in str(error.value)


def test_a_drawn_number_in_an_excluded_bin_is_refused_with_the_reason(study, edited):
    constraint = "constraints: [{exclude: {T: 1, C: 2}, reason: too fast to turn}]"
    with_range(study)
    config = load(edited("situations.yaml", "\naliases:", f"\n{constraint}\naliases:"))
    with pytest.raises(InputError, match=r"excluded by .*situations.yaml:\d+: too fast to turn"):
        config.grid.situation("T1O0W0D0H0C2=0.871")


def test_a_number_between_the_ends_that_the_world_refuses_is_named(study, edited):
    edited("world.yaml", "end: [-3.0, 8.0]", "end: [-1.9, 8.0]")  # the bar stands at [-1.9, 7.7]
    axis = CRUISE.replace("mission.cruise_mps", "waypoints.end.1").replace("bins: 4", "bins: 2")
    axis = axis.replace("from: 0.4", "from: 7.2").replace("to: 1.2", "to: 8.6").replace("benign: 0.5", "benign: 8")
    config = load(with_range(study, axis))
    sentence = "C1=7.7 is not possible, as in situation T0O0W0D0H0C1=7.7; the range at .*situations.yaml:"
    with pytest.raises(InputError, match=rf"not inside 'bar': {sentence}"):
        config.scenario(config.grid.situation("T0O0W0D0H0C1=7.7"))


def test_a_number_that_another_axis_excludes_is_named_with_it(study):
    axis = CRUISE.replace("mission.cruise_mps", "bodies.obstacle.position.1").replace("bins: 4", "bins: 2")
    axis = axis.replace("from: 0.4", "from: 4").replace("to: 1.2", "to: 8.6").replace("benign: 0.5", "benign: 5")
    config = load(with_range(study, axis))
    sentence = r"O1 and C1=7 cannot be combined, .*constraints: \{exclude: \{O: 1, C: 1\}, reason: ...\}"
    with pytest.raises(InputError, match=sentence):
        config.scenario(config.grid.situation("T0O1W0D0H0C1=7"))
