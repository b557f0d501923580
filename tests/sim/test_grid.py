"""Situations of the study's own grid, of ranges, of further grids and of free axes around them."""

from __future__ import annotations

import itertools
import shutil
from dataclasses import replace

import pytest
from builders import CRUISE, with_range
from finding import BAR, found, small_study
from studies import GRIDS

from scaloft_fi.campaign.runs.request import choose_situations
from scaloft_fi.campaign.seeking.finds import break_saver, saver, text
from scaloft_fi.errors import InputError
from scaloft_fi.judge.space import Realisation, Space
from scaloft_fi.sim.grid import Evidence, Find, Finds, grid_names, load_grid, own_name, read_finds
from scaloft_fi.sim.load import load
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import NO_FINDS, Study, known_finds
from tests.sim.conftest import SIM

ROOT = SIM.parent


def keys(situations):
    return [situation.key for situation in situations]


def test_the_reference_grid_has_32_situations_in_order(config):
    found = keys(config.grid.situations)
    assert len(config.grid) == len(set(found)) == 32
    assert found == sorted(found)


def test_globs_keys_and_numbers_of_the_paper_select_together_in_the_order_of_the_grid(config):
    grid = config.grid
    named = {"1": "T0O0W0D0H1", "2": "T0O0W0D1H0", "3": "T0O0W1D0H0", "32": "T1O1W1D1H0"}
    assert {number: grid.situation(number).key for number in named} == named
    assert grid.aliases_of(grid.situation("T1O1W1D1H0")) == ("32",)
    assert keys(grid.select(["T1O1W1D*H0", "3", "T0O0W1D0H0"])) == ["T0O0W1D0H0", "T1O1W1D0H0", "T1O1W1D1H0"]
    assert [len(grid.select(patterns)) for patterns in ([], ["T1*"], ["T?O0W0D[0]H*"])] == [32, 16, 4]
    titles = grid.titles(grid.situation("T1O0W0D1H1"))
    assert titles == ("corner", "free path", "open space", "dark", "human")


@pytest.mark.parametrize("name", ["T2*", "T0O0W0D0H2", "t0o0w0d0h0", "99", "", "T0O0W0D0"])
def test_a_situation_that_is_none_is_refused_with_the_nearest(config, name):
    with pytest.raises(InputError, match=r"^no situation .* did you mean 'T.O.W.D.H.'\?$"):
        config.grid.select([name])


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
    grid, changed = config.grid, []
    for value in (2, 0):
        one = config.scenario(grid.situation(f"T1O0W0D0H0Air{value}"))
        changed.append((one.sensors.depth.max_m, one.vehicle.mass_kg, one.world.mission.cruise_mps))
    assert (len(grid), changed) == (96, [(4.5, 1.6, 0.3), (8.0, 1.5, 0.5)])
    assert grid.axes[-1].predicate(0) == "(not (always(speed_mps <= 0.9))) and (not (always(speed_mps <= 0.5)))"
    assert grid.situation("32").key == "T1O1W1D1H0Air0"  # the paper's numbers outlive a new axis


def test_values_that_do_not_go_together_are_refused_when_their_scenario_is_asked_for(edited):
    config = load(edited("world.yaml", "position: [-0.15, 5.0]", "position: [0.865, 7.0]"))
    config.scenario(config.grid.situation("T0O1W0D0H0"))
    sentence = (
        r"situations.yaml:\d+: corner=.* not inside 'obstacle': O1 and W1 cannot be combined, as in situation "
        r"T0O1W1D0H0; exclude them under constraints: \{exclude: \{O: 1, W: 1\}, reason: ...\}"
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
        f"\n  {name}: {{title: air, category: environment, values: "
        f"[{{id: 0, title: a}}, {{id: 1, title: b, set: {{{change}}}, realised: always(light >= 0)}}]}}"
        for name, change in (("Q", first), ("R", second))
    )
    pairs = "".join(f"\n  - {{exclude: {{{pair}}}, reason: never}}" for pair in ("D: 1, Q: 1", "D: 1, R: 1"))
    folder = edited("situations.yaml", "\naliases:", f"{axes}\nconstraints:{pairs}\naliases:")
    edited("situations.yaml", '\n  "32": T1O1W1D1H0', "")
    sentence = rf"situations.yaml:\d+: Q1 and R1 both set {path}.*, in situation T0O0W0D0H0Q1R1; exclude them under"
    with pytest.raises(InputError, match=sentence):
        load(folder)
    edited("situations.yaml", "D: 1, R: 1", "D: 1, R: 1}, reason: never}\n  - {exclude: {Q: 1, R: 1")
    assert load(folder).grid.situation("T0O0W0D0H0Q1R0").key


def test_no_situation_has_an_excluded_combination(edited):
    constraints = "[{exclude: {T: 0, W: 1}, reason: no wall is near}, {exclude: {D: 1, H: 1}, reason: lamps}]"
    edited("situations.yaml", '\n  "32": T1O1W1D1H0', "")
    edited("situations.yaml", '\n  "3": T0O0W1D0H0', "")
    grid = load(edited("situations.yaml", "\naliases:", f"\nconstraints: {constraints}\naliases:")).grid
    every = [Situation.of(dict(zip("TOWDH", point, strict=True))) for point in itertools.product(range(2), repeat=5)]
    wanted = [s.key for s in every if (s["T"], s["W"]) != (0, 1) and (s["D"], s["H"]) != (1, 1)]
    assert (keys(grid.situations), len(grid)) == (wanted, 18)
    with pytest.raises(InputError, match=r"'T0O0W1D0H0' is excluded by .*situations.yaml:\d+: no wall is near"):
        grid.situation("T0O0W1D0H0")


@pytest.fixture
def ranged(study):
    return load(with_range(study))


def test_a_grid_has_a_range_as_bins_with_the_benign_one_first(ranged):
    values = ranged.grid.axes[-1].values
    titles = ["0.4 to 0.6 m/s", "0.6 to 0.8 m/s", "0.8 to 1 m/s", "1 to 1.2 m/s"]
    assert [(value.id, value.title) for value in values] == list(enumerate(titles))
    flown = [value.changes["world.mission.cruise_mps"].value for value in values]
    assert flown == pytest.approx([0.5, 0.7, 0.9, 1.1], abs=0.001)
    assert values[0].realised == "eventually(speed_mps >= 0.8 * 0.5)"
    assert (len(ranged.grid), ranged.grid.situation("32").key) == (128, "T1O1W1D1H0C0")


def test_a_drawn_situation_flies_its_number_and_is_selected_by_key_after_its_bin(ranged):
    grid, drawn = ranged.grid, ranged.grid.situation("T1O0W0D0H0C2=0.871")
    assert grid.titles(drawn)[-1] == "0.871 m/s"
    assert ranged.scenario(drawn).world.mission.cruise_mps == grid.world(drawn).mission.cruise_mps == 0.871
    assert grid.values(drawn)["C"].realised == "eventually(speed_mps >= 0.8 * 0.871)"
    asked = [f"T0O0W0D0H0C{value}" for value in ("2=0.9", "2=0.85", "*", "2=0.9")]
    assert keys(grid.select(asked)) == [f"T0O0W0D0H0C{value}" for value in ("0", "1", "2", "2=0.85", "2=0.9", "3")]


def test_an_alias_may_name_a_drawn_number(study, edited):
    with_range(study)
    grid = load(edited("situations.yaml", "\naliases:", "\naliases:\n  fast: T1C3=1.15")).grid
    assert grid.situation("fast").key == "T1O0W0D0H0C3=1.15"
    assert grid.aliases_of(grid.situation("fast")) == ("fast",)
    with pytest.raises(InputError, match=r"alias 'fast': .*situations.yaml:\d+: situation .* must have 'C3=1.15'"):
        load(edited("situations.yaml", "C3=1.15", "C2=1.15"))


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
    with_range(study)
    constraint = "constraints: [{exclude: {T: 1, C: 2}, reason: too fast to turn}]"
    config = load(edited("situations.yaml", "\naliases:", f"\n{constraint}\naliases:"))
    with pytest.raises(InputError, match=r"excluded by .*situations.yaml:\d+: too fast to turn"):
        config.grid.situation("T1O0W0D0H0C2=0.871")


@pytest.mark.parametrize(
    ("path", "low", "benign", "key", "sentence"),
    [
        # the bar stands at [-1.9, 7.7]
        ("waypoints.end.1", 7.2, 8, "T0O0W0D0H0C1=7.7", r"C1=7.7 is not possible, .*; the range at .*situations.yaml:"),
        ("bodies.obstacle.position.1", 4, 5, "T0O1W0D0H0C1=7", r"O1 and C1=7 cannot be combined, .*\{O: 1, C: 1\}"),
    ],
)
def test_a_number_that_the_world_or_another_axis_refuses_is_named(edited, study, path, low, benign, key, sentence):
    axis = CRUISE.replace("mission.cruise_mps", path).replace("bins: 4", "bins: 2").replace("from: 0.4", f"from: {low}")
    edited("world.yaml", "end: [-3.0, 8.0]", "end: [-1.9, 8.0]")
    config = load(with_range(study, axis.replace("to: 1.2", "to: 8.6").replace("benign: 0.5", f"benign: {benign}")))
    with pytest.raises(InputError, match=sentence):
        config.scenario(config.grid.situation(key))


@pytest.fixture(scope="module")
def wide():
    return load(SIM, grid=load_grid(SIM, "wide"))


def test_the_reference_study_has_the_grid_of_the_paper_two_further_ones_and_that_of_the_finds(study):
    assert grid_names(SIM) == ("paper", "search", "wide", "paper+found")
    grids = [load_grid(SIM), load_grid(SIM, "wide")]
    assert [(grid.name, grid.choose) for grid in grids] == [("paper", "all"), ("wide", "3-way")]
    assert Study.open(ROOT, "wide").catalogue == Study.open(ROOT).catalogue


def test_a_further_grid_has_its_own_axes_over_the_same_world(study):
    shutil.copy(GRIDS / "light.yaml", study / "grids")
    grid = load_grid(study, "light")
    assert keys(grid.situations) == ["L0", "L1", "L2"]
    assert grid.world(grid.situation("L1")).light == 0.2
    assert grid.world().bodies.keys() == load_grid(study).world().bodies.keys()


def test_the_name_of_the_own_grid_is_a_name_or_situations(edited):
    path = edited("situations.yaml", "name: paper", "")
    assert own_name(path) == load_grid(path).name == "situations"
    with pytest.raises(InputError, match="must be a name of letters, digits, - and _"):
        grid_names(edited("situations.yaml", "axes:", "name: ../paper\naxes:"))


def test_files_that_are_no_grids_are_passed_over_and_a_name_is_used_once(study):
    for name in (".hidden", "my grid", "..", "light"):
        shutil.copy(GRIDS / "light.yaml", study / "grids" / f"{name}.yaml")
    (study / "grids" / "folder.yaml").mkdir()
    assert set(grid_names(study)) - {"light"} == set(grid_names(SIM)) - {"paper+found"}
    path = study / "grids" / "paper.yaml"
    shutil.copy(GRIDS / "light.yaml", path)
    with pytest.raises(InputError, match=rf"^{path}: the grid of situations\.yaml is called 'paper' already"):
        grid_names(study)


def test_what_only_a_further_grid_adds_and_other_files_leave_the_own_grid_as_it_was(study):
    own = Study.open(ROOT)
    assert ["belt" in one.grid.world().bodies for one in (own, Study.open(ROOT, "wide"))] == [False, True]
    assert own.inputs == Study.open(ROOT, "paper").inputs
    assert own.inputs["sim"] != Study.open(ROOT, "wide").inputs["sim"]
    for name in ("hazop", "mutants"):
        shutil.copytree(ROOT / name, study.parent / name)
    (study / "grids" / "notes.txt").write_text("about the grids")
    assert Study.open(study.parent).inputs == own.inputs
    shutil.rmtree(study / "grids")
    assert Study.open(study.parent).inputs == own.inputs


def test_every_number_of_the_wide_grid_has_a_source_and_every_source_a_number(wide, config, study):
    assert [path for path in wide.numbers if wide.source_of(path) is None] == []
    more = [path for path in wide.sources if path not in config.sources or path.startswith("situations.")]
    assert more
    assert [path for path in more if not any(f"{number}.".startswith(f"{path}.") for number in wide.numbers)] == []
    assert wide.source_of("situations.axes.D.values.1.set.light") is not config.sources["situations.axes"]
    shutil.copy(study / "grids" / "wide.yaml", study / "grids" / "situations.yaml")
    same = load(study, grid=load_grid(study, "situations"))
    assert [path for path in same.numbers if same.source_of(path) is None] == []


def test_the_wide_grid_has_what_the_paper_s_grid_lacks(wide):
    grid = wide.grid
    paths = {path for axis in grid.axes for value in axis.values for path in value.changes}
    happenings = {path for path in paths if path.startswith("world.happenings")}
    assert {f"world.happenings.{name}.active" for name in ("lamp", "miner", "draught", "wander")} == happenings
    assert {"world.mission.cruise_mps", "sensors.battery.charge", "world.bodies.obstacle.position"} <= paths
    assert {1.0, 1.2} == {grid.world_of(grid.documents_with([v])).mission.cruise_mps for v in grid.axes[5].values[1:]}


def test_a_predicate_may_name_a_signal_of_a_happening_and_fails_where_it_does_not_happen(wide):
    grid, study = wide.grid, Study.open(ROOT, "wide")
    realisation = Realisation.read(grid, (*study.signals, *grid.passing_signals))
    still, windy = "T0O0W0D0H0C0V0P0B0G0", "T0O0W0D0H0C0V1P0B0G0"
    assert {still, windy} <= set(Space.of(grid).point)
    log = {name: [0.0, 0.0] for name in study.signals} | {"takeoff_charge": [0.95, 0.95]}
    assert "wind_x_mps" not in log
    met = [dict(realisation.of(key, one))["V"] for one in (log, log | {"wind_x_mps": [0, 2]}) for key in (still, windy)]
    assert met == [True, False, False, True]


@pytest.fixture(scope="module")
def searched():
    return Study.open(ROOT, "search")


def test_a_free_axis_at_its_benign_value_is_left_out_and_changes_nothing(searched):
    own = Study.open(ROOT)
    for situation in own.grid.situations:
        same = searched.grid.situation(situation.key)
        assert (same, searched.changes(same)) == (situation, own.changes(situation))
    assert searched.grid.at({"T": 0, "O": 0, "W": 0, "D": 0, "H": 1}, {"Cs": 0.5}).key == "T0O0W0D0H1"


def test_an_optional_body_has_a_signal_only_where_it_stands(tmp_path):
    own = small_study(tmp_path)
    shutil.copy(GRIDS / "belt.yaml", tmp_path / "sim" / "grids")
    belt = Study.open(tmp_path, "belt")
    without, with_ = (belt.scenario(belt.grid.situation(f"T0D0H0{number}")) for number in ("", "Be=0.8"))
    assert "belt" not in without.world.surfaces
    assert with_.world.surfaces[-1] == "belt"
    assert belt.signals == own.signals
    assert "clearance_belt_m" in belt.grid.passing_signals


def test_another_number_stands_at_the_end_of_the_key_and_is_flown(searched):
    situation = searched.grid.situation("T1O1W0D2H1Cs=0.87Vy=2")
    assert Situation.parse(situation.key) == situation
    assert situation.point.key == "T1O1W0D2H1"
    world = searched.scenario(situation).world
    assert world.mission.cruise_mps == 0.87
    assert [happening.name for happening in world.happenings] == ["lamp", "draught"]
    assert searched.grid.titles(situation)[-2:] == ("cruise speed 0.87 m/s", "wind along the corridor 2 m/s")
    assert searched.space.words_of(situation.key) == searched.grid.titles(situation)
    assert searched.space.point[situation.key] == searched.space.point["T1O1W0D2H1"]


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("T0O1W0D0H0Vy=2Cs=0.8", "must be written 'T0O1W0D0H0Cs=0.8Vy=2'"),
        ("T0O0W0D0H0Ox=1", r"search.yaml:\d+: Ox=1 goes only with O=\[1\]"),
        ("T0O0W0D0H0Cs=0.5", "must be written 'T0O0W0D0H0'"),
        ("T0O0W0D0H0Cs=0.2", r"search.yaml:\d+: Cs=0.2 must be 0.3 to 1.2"),
        ("T0O0W0D0H0Zs=0.2", "there is no free axis 'Zs'; did you mean"),
    ],
)
def test_a_number_that_the_grid_does_not_have_is_refused_with_what_it_must_be(searched, key, message):
    with pytest.raises(InputError, match=message):
        searched.grid.situation(key)
    assert key not in searched.space.point or "must be written" in message


@pytest.mark.parametrize("how", ["random:40", "sobol:40", "draws:40"])
def test_a_choice_draws_numbers_of_free_axes_and_leaves_most_of_them_benign(searched, how):
    drawn, again = (
        choose_situations(how, searched.grid.situations, (0,), 0, searched.space).situations for _ in range(2)
    )
    assert drawn == again
    assert all(searched.grid.situation(situation.key) == situation for situation in drawn)
    assert 2 < sum(len(situation.numbers) for situation in drawn) / len(drawn) < len(searched.grid.free) / 2


SHOWN = Evidence("SR2", 1, 0.00025, 0.005, 6, 6, "person", 10, 10, 0.071, 0.02, 10)
FIND = Find("shows-A@1", "T0O0W0D0H2Cs=0.8", ("human walks", "cruise speed 0.8 m/s"), "A@1", {"A@1": SHOWN}, 0)
BLIND = replace(
    BAR, name="breaks-SR2-nothing-home_to_corner-near_home-no_belief", struck="", belief="", error=0.0, unit=""
)
PAPERS = Find("shows-B", "T0O0W0D0H1", ("human",), "B", {"B": SHOWN, "A@1": SHOWN}, 3)


def test_what_is_written_is_read_again_and_earlier_finds_stay_but_for_those_of_the_same_mutant(study):
    assert read_finds(study) is None
    saver(study, "search")([FIND, PAPERS])
    assert read_finds(study) == Finds("search", (FIND, PAPERS))
    newer = Find("shows-B", "T1O0W0D0H0", ("corner",), "B", {"B": SHOWN}, 4)
    saver(study, "search")([newer])
    assert read_finds(study) == Finds("search", (FIND, newer))
    with pytest.raises(InputError, match=r"found.yaml: grid='search' must be 'wide', the grid that is searched"):
        saver(study, "wide")


def test_a_find_for_placebo_is_not_written(study):
    saver(study, "search")([Find("shows-PLACEBO", "T0O0W0D0H0", (), "PLACEBO", {"PLACEBO": SHOWN}, 0)])
    assert read_finds(study) == Finds("search", ())


def test_the_grid_with_the_found_situations_has_the_own_ones_and_those(study):
    assert "paper+found" not in grid_names(study)
    saver(study, "search")([FIND, PAPERS])
    assert grid_names(study)[-1] == "paper+found"
    grid, own = load_grid(study, "paper+found"), load_grid(study)
    assert [one.key for one in grid.situations] == [*own.by_key, FIND.situation]
    assert [grid.situation(name).key for name in ("shows-A@1", "1")] == [FIND.situation, "T0O0W0D0H1"]
    assert [one.key for one in grid.select(["shows-A@1", "T1*H1"])][-1] == FIND.situation
    assert [one.key for one in grid.select(["shows-*"])] == [PAPERS.situation, FIND.situation]
    assert grid.selected == load_grid(study, "search").selected == {FIND.situation}
    assert own.selected == frozenset()


def test_breaks_stand_beside_finds_and_each_search_keeps_those_of_others(study):
    for save, those in ((break_saver, [BAR]), (saver, [FIND]), (break_saver, [BLIND])):
        save(study, "search")(those)
    assert read_finds(study) == Finds("search", (FIND,), (BAR, BLIND))
    newer = replace(BAR, situation="T1O0W0D1H0", words=("corner", "dark"))
    break_saver(study, "search")([newer])
    assert read_finds(study) == Finds("search", (FIND,), (newer, BLIND))


def test_a_break_is_flown_by_name_over_the_grid_that_was_searched_and_not_beside_the_papers_situations(study):
    saver(study, "search")([FIND])
    break_saver(study, "search")([BAR])
    grid, beside = load_grid(study, "search"), load_grid(study, "paper+found")
    assert [grid.situation(one.name).key for one in (BAR, FIND)] == [BAR.situation, FIND.situation]
    assert grid.selected == {BAR.situation, FIND.situation}
    assert [one.key for one in beside.situations] == [*load_grid(study).by_key, FIND.situation]
    assert BAR.name not in beside.aliases


def test_a_break_that_the_study_has_outgrown_has_no_name_in_the_grid(study):
    (study / "found.yaml").write_text(text(Finds("search", (), (replace(BAR, situation="T1O0W0D1H0Cs=8"),))))
    assert BAR.name not in load_grid(study, "search").aliases


LATE, MORE, NO = "LATE-depth@0.4s", "MORE-goal@0.6m", "NO-depth@3s"


@pytest.fixture(scope="module")
def known():
    matrix = Study.open().matrix
    return lambda folder: known_finds(folder, matrix, ["SR1", "SR2", "OP1"])


def test_the_finds_of_a_mutant_are_those_that_show_it_its_own_first(study, known):
    assert known(study) == NO_FINDS
    finds = (found(LATE, others=(MORE,)), found(MORE, "T0O0W0D0H1"))
    saver(study, "search")(finds)
    told = known(study)
    assert (told.finds, told.misfits, told.grid, told.searched.name) == (finds, {}, "paper+found", "search")
    assert [find.name for find in told.of(MORE)] == [f"shows-{MORE}", f"shows-{LATE}"]
    assert (told.of(LATE), told.of(NO)) == (finds[:1], ())


def judged_by(requirement):
    find = found(LATE)
    return replace(find, shows={LATE: replace(find.shows[LATE], requirement=requirement)})


@pytest.mark.parametrize(
    ("stale", "why"),
    [
        (found(LATE, "T0O0W0D0H9"), "no situation 'T0O0W0D0H9' in keys like 'T0O0W0D0H0'"),
        (found(LATE, "T0O0W0D0H2Cs=8"), "Cs=8 must be 0.3 to 1.2"),
        (found(LATE, others=("LATE-depth@1kg",)), "'1kg' is no magnitude of LATE-depth"),
        (judged_by("SR9"), "no requirement 'SR9'; did you mean 'SR"),
    ],
)
def test_a_find_of_another_version_of_the_study_is_left_out_with_the_reason(study, known, stale, why):
    kept = found(MORE, "T0O0W0D0H1")
    saver(study, "search")([stale, kept])
    told = known(study)
    assert told.finds == (kept,)
    assert why in told.misfits[stale.name]
    (warning,) = told.warnings
    assert warning.startswith(f"sim/found.yaml: left out, because the study has changed since: {stale.name}: ")


def test_without_the_grid_that_was_searched_every_find_is_left_out_in_one_sentence(study, known):
    saver(study, "gone")([found(LATE), found(MORE)])
    told = known(study)
    (warning,) = told.warnings
    assert told.finds == ()
    assert f"shows-{LATE}, shows-{MORE}: " in warning
    assert "grid='gone' must be a grid of the study" in warning


def test_breaks_are_known_beside_the_finds_and_old_ones_are_left_out(study, known):
    stale = replace(BAR, name="breaks-SR9-bar", requirement="SR9"), replace(BAR, name="breaks-gone", situation="T7")
    break_saver(study, "search")([BAR, *stale])
    told = known(study)
    assert (told.finds, told.breaks, set(told.misfits)) == ((), (BAR,), {one.name for one in stale})
