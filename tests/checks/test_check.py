from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scaloft_ros1.border  # noqa: F401 - the study of the testbed names it
import trimesh
import yaml
from hypothesis import given
from hypothesis import strategies as st
from options import cases, usually
from printed import invoked
from processes import call, install, install_project
from studies import RECORDS, ROOT, copied, edit_in, example, mission_study, own_simulator

from scaloft_fi.checks import Finding, Findings, Severity
from scaloft_fi.checks.check import Check, check_operators, check_study
from scaloft_fi.checks.parts import crossed_ways, depth, gaps, overlaps
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.sim.mesh import box
from scaloft_fi.sim.world import Box, Turned, World
from scaloft_fi.study import Study
from scaloft_fi.verbs.situations import map_table, plan_of

EXAMPLES = ROOT / "examples"
PROGRAM = """
import sys
from pathlib import Path
from scaloft_fi.checks.check import check_study
found = [str(one) for folder in sys.argv[1:] for one in check_study(Path(folder)).findings]
assert "pybullet" not in sys.modules
print("\\n".join(found))
"""


def errors(check: Check) -> list[str]:
    return [str(finding) for finding in check.findings if finding.severity is Severity.ERROR]


def notes(check: Check) -> list[str]:
    return [finding.what for finding in check.findings if finding.severity is Severity.NOTE]


@pytest.fixture(scope="module")
def reference() -> Check:
    return check_study(ROOT)


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    return copied(tmp_path, "found.yaml", "grids")


def _without_grids(study: Path) -> None:
    """Take away the further grids and finds of the reference study."""
    shutil.rmtree(study / "sim" / "grids")
    (study / "sim" / "found.yaml").unlink()


def test_the_reference_study_has_no_error_an_obstacle_in_the_belt_and_an_unused_seam(reference: Check):
    assert errors(reference) == []
    assert notes(reference) == [
        "body 'obstacle' reaches 0.30 m into 'belt'",
        "no cell of the matrix has a fault at 1 of the stack's 21 seams: fix",
    ]


def test_a_green_check_says_what_was_looked_at(reference: Check):
    checked = reference.checked
    assert (checked.requirements, checked.cells, checked.mutants, checked.seams) == (4, 156, 712, 21)
    assert (checked.polled, checked.found, checked.accepted) == (None, 12, 0)
    grids = {grid.name: (grid.situations, grid.built, grid.pairs) for grid in reference.grids}
    assert grids["paper"] == (32, 32, 40)
    assert grids["wide"][0] == 2304
    assert grids["wide"][1] < 40, "of a large grid as many situations are built as its pairs need"
    assert grids.keys() == {"paper", "search", "wide", "paper+found"}


@pytest.mark.release
def test_the_examples_whose_stages_are_outside_have_no_error(tmp_path: Path):
    script = tmp_path / "mission.py"
    script.write_text("")
    example("outside_planner", tmp_path / "planner")
    mission_study(tmp_path / "testbed", script)
    for kind in RECORDS:
        own_simulator(tmp_path / kind, kind)
    for name in ("planner", "testbed", *RECORDS):
        assert errors(check_study(tmp_path / name)) == [], name


@cases("file", "old", "new", "place", "what")
def test_a_command_that_cannot_fly_is_told(tmp_path: Path, file: str, old: str, new: str, place: str, what: str):
    own_simulator(tmp_path / "own")
    edit_in(tmp_path / "own" / "sim" / file, old, new)
    told = errors(check_study(tmp_path / "own"))
    assert any(place in error and what in error for error in told), told


def test_a_program_of_a_stage_outside_that_is_missing_is_told(tmp_path: Path):
    example("outside_planner", tmp_path / "planner")
    (tmp_path / "planner" / "sim" / "over_lines.py").unlink()
    (error,) = errors(check_study(tmp_path / "planner"))
    assert "stack.yaml:6: error: the study has no file 'sim/over_lines.py'; add it" in error


def test_a_program_of_a_stage_outside_that_cannot_be_run_is_told(tmp_path: Path):
    example("outside_planner", tmp_path / "planner")
    edit_in(tmp_path / "planner" / "sim" / "stack.yaml", '"{python}", "{study}/sim', '"{study}/sim')
    (told,) = [str(one) for one in check_study(tmp_path / "planner").findings if "can be run" in str(one)]
    assert "there is no program '{study}/sim/over_lines.py' on this machine that can be run" in told


@pytest.mark.release
def test_the_examples_of_plugins_have_no_error_and_no_physics_is_imported(tmp_path: Path):
    assert invoked("new", str(tmp_path / "straight"), "--planner").exit_code == 0
    for package in (EXAMPLES / "own_stack", tmp_path / "straight"):
        install_project(tmp_path / "site", package)
    study = tmp_path / "straight" / "study"
    shutil.rmtree(study / "sim" / "grids")
    done = call(tmp_path / "site", "-c", PROGRAM, EXAMPLES / "own_stack" / "study", study, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert [line for line in done.stdout.splitlines() if ": error: " in line] == []


def test_a_plugin_that_does_not_load_is_an_error_and_the_rest_is_checked(tmp_path: Path, copy: Path):
    edit_in(copy / "sim" / "world.yaml", "light: 0.9", "light: 5")
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "broken.py").write_text("raise OSError('no driver')\n")
    install(tmp_path / "site", "their-package", {"theirs": "broken"})
    done = call(tmp_path / "site", "-c", PROGRAM, copy, cwd=tmp_path)
    assert "plugin 'theirs' of package 'their-package' cannot be loaded: OSError: no driver" in done.stdout
    assert "world.yaml:3: error: light=5 must be" in done.stdout


def test_an_operator_that_is_no_good_is_an_error_where_a_cell_uses_it_and_else_a_note(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setitem(OPERATORS._entries, "delay", replace(OPERATORS["delay"], make=lambda *_, **__: 5))
    for cells, severity in ((tuple(Study.open(ROOT).matrix), Severity.ERROR), ((), Severity.NOTE)):
        findings = Findings()
        check_operators(cells, findings)
        what = f"{__name__}: operator 'delay' must return a tap, and returns 5"
        assert tuple(findings) == (Finding(severity, "", None, what, remedy="mend or uninstall it"),)


def test_a_study_without_a_control_is_told_so(copy: Path):
    for path in (copy / "hazop" / "matrix").glob("*.yaml"):
        path.write_text(path.read_text().replace("status: control", "status: credible"))
    check = check_study(copy)
    assert errors(check) == []
    assert any("no cell is a control" in what for what in notes(check))


def test_credible_cells_without_a_class_are_told_where_the_study_has_classes(copy: Path):
    for _ in range(2):
        edit_in(copy / "hazop" / "matrix" / "human.yaml", "  severity: injury\n", "")
    check = check_study(copy)
    assert errors(check) == []
    assert "severity is missing in 2 credible cells: NO-human, MORE-human" in notes(check)


def test_a_broken_list_of_classes_is_one_error_and_cells_are_held_against_its_names(copy: Path):
    edit_in(copy / "hazop" / "severities.yaml", "  title: time is lost\n", "")
    edit_in(copy / "hazop" / "matrix" / "goal.yaml", "severity: mission", "severity: mision")
    assert [found.partition("error: ")[2].partition(";")[0] for found in errors(check_study(copy))] == [
        "delay lacks the key 'title': name of the class for people",
        "severity='mision' is not known",
    ]


def test_controls_away_from_the_seams_that_always_carry_are_told(copy: Path):
    for path in (copy / "hazop" / "matrix").glob("*.yaml"):
        if path.stem != "collision":
            path.write_text(path.read_text().replace("status: control", "status: credible"))
    assert any(
        "no control strikes a seam that carries samples in every situation" in what for what in notes(check_study(copy))
    )


def test_a_find_that_does_not_fit_any_more_is_a_note_at_its_line(copy: Path):
    found = (ROOT / "sim" / "found.yaml").read_text()
    begin = found.index("grid: search")
    second = found.index("\n  shows-", found.index("shows-") + 8)
    (copy / "sim" / "found.yaml").write_text(found[begin:second].replace("grid: search", "grid: paper"))
    (found,) = [finding for finding in check_study(copy).findings if "does not fit the study" in finding.what]
    assert (found.severity, found.line) == (Severity.NOTE, 3)
    assert "seek anew" in found.remedy


ROOM = box((10.0, 20.0, 3.0)).moved((0.0, 8.0, 1.5))
"""A closed room around the route, wound outwards."""


def _room(copy: Path, faces: list[tuple[int, int, int]], unit_m: float = 1.0) -> None:
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in ROOM.vertices / unit_m]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    (copy / "sim" / "room.obj").write_text("\n".join([*lines, ""]))
    world = copy / "sim" / "world.yaml"
    begin, rest = world.read_text().split("  footprint:")
    world.write_text(f"{begin}  mesh: room.obj\n  wall_reflectivity{rest.split('  wall_reflectivity')[1]}")
    edit_in(copy / "sim" / "situations.yaml", "x_m < -1", "y_m > 1")


def _in_mesh(copy: Path) -> list[str]:
    place = f"{copy / 'sim' / 'room.obj'}:"
    return [
        str(finding).removeprefix(place) for finding in check_study(copy).findings if str(finding).startswith(place)
    ]


def test_a_sound_mesh_has_no_flaw(copy: Path):
    _room(copy, ROOM.faces.tolist())
    assert errors(check_study(copy)) == []
    assert _in_mesh(copy) == []


def test_faces_that_are_turned_around_are_named_by_line_and_are_the_cause_of_a_waypoint_in_the_rock(copy: Path):
    faces = ROOM.faces.tolist()
    for turned in (0, 1, 8, 9):
        faces[turned].reverse()
    _room(copy, faces)
    (told,) = _in_mesh(copy)
    assert told.startswith(
        "9: error: 4 of 12 faces are wound the other way than their neighbours, the first at this line"
    )
    assert "turn them around" in told
    caused = [error for error in errors(check_study(copy)) if "world.yaml" in error]
    assert caused
    assert all("the mesh may be the cause: " in error and "room.obj:9: 4 of 12 faces" in error for error in caused)


def test_a_hole_and_a_face_without_area_are_notes(copy: Path):
    _room(copy, [*ROOM.faces.tolist()[:-1], [0, 0, 1]])
    hole, empty = sorted(_in_mesh(copy), key=len, reverse=True)
    assert "note: the surface has holes: 3 edges have no second face" in hole
    assert empty.startswith("20: note: 1 of 12 faces is without area")


def test_the_map_shows_where_a_mesh_has_a_flaw(copy: Path):
    _room(copy, ROOM.faces.tolist()[:-1])
    study = Study.open(copy)
    situation = study.grid.situations[0]
    (shown,) = [one for one in plan_of(study, situation).happenings if one.words.startswith("mesh: ")]
    assert "the surface has holes: 3 edges have no second face" in shown.words
    (row,) = [words for what, words in map_table(study, situation).rows if what == "mesh"]
    assert f"near ({shown.near[0]:.3g}, {shown.near[1]:.3g}, " in row


def test_a_room_in_millimetres_is_noted(copy: Path):
    _room(copy, ROOM.faces.tolist(), unit_m=0.001)
    found = [finding for finding in check_study(copy).findings if "the mine reaches" in finding.what]
    assert [finding.severity for finding in found] == [Severity.NOTE]
    assert "from x -5000 to 5000, y -2000 to 18000, z 0 to 3000 m, and no two waypoints" in found[0].what
    assert found[0].remedy == ("`scale_m` is metres per unit of the file: with 0.001 (millimetres) it is 10 x 20 x 3 m")
    world = copy / "sim" / "world.yaml"
    edit_in(world, "mesh: room.obj", "mesh: room.obj\n  scale_m: 0.001")
    assert errors(check_study(copy)) == []
    assert not [finding for finding in check_study(copy).findings if "the mine reaches" in finding.what]


@pytest.mark.parametrize(
    ("unit_m", "up", "written", "keys"),
    [
        (0.01, "y", "scale_m: 0.001", "`scale_m: 0.01`, `up: y`"),
        *(
            pytest.param(*each, marks=pytest.mark.release)
            for each in (
                (1.0, "y", "up: z", "`up: y`"),
                (0.001, "y", "up: z", "`up: y`"),
                (1.0, "z", "up: y", "`up: z`"),
                (1.0, "z", "scale_m: 0.001", "`scale_m: 1`"),
                (0.01, "z", "scale_m: 0.001", "`scale_m: 0.01`"),
            )
        ),
    ],
)
def test_a_unit_or_an_axis_that_puts_every_waypoint_into_the_open_space_is_the_remedy(
    copy: Path, unit_m: float, up: str, written: str, keys: str
):
    _room(copy, ROOM.faces.tolist(), unit_m)
    obj = trimesh.load(copy / "sim" / "room.obj", process=False)
    if up == "y":
        obj.vertices = obj.vertices @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    obj.export(copy / "sim" / "room.ply")
    edit_in(copy / "sim" / "world.yaml", "mesh: room.obj", f"mesh: room.ply\n  {written}")
    told = [error for error in errors(check_study(copy)) if "world.yaml" in error]
    assert told
    assert all(error.endswith(f"; {keys} beside `mesh` puts every waypoint into its open space") for error in told)
    for key in keys.replace("`", "").split(", "):
        world = copy / "sim" / "world.yaml"
        kept = [line for line in world.read_text().splitlines() if not line.startswith(f"  {key.split(':')[0]}:")]
        world.write_text("\n".join(kept).replace("mesh: room.ply", f"mesh: room.ply\n  {key}"))
    assert errors(check_study(copy)) == []


@cases("keys", "told")
def test_a_unit_and_an_axis_that_are_not_stated_are_told(copy: Path, keys: str, told: str):
    _room(copy, ROOM.faces.tolist())
    edit_in(copy / "sim" / "world.yaml", "mesh: room.obj", f"mesh: room.obj\n  {keys}")
    (note,) = [str(one) for one in check_study(copy).findings if "so the mine is" in one.what]
    assert told in note
    missing = [key for key in ("up", "scale_m") if key not in keys]
    assert f"state {' and '.join(f'`{key}`' for key in missing)} beside `mesh`" in note


def test_a_roof_that_is_not_there_is_the_cause_of_a_waypoint_outside(copy: Path):
    _room(copy, ROOM.faces[ROOM.triangles.mean(axis=1)[:, 2] < 1.1].tolist())
    caused = [error for error in errors(check_study(copy)) if "must be in the open space" in error]
    assert any("no face of the mesh is a roof of it, so it is open there: close it" in error for error in caused)


def test_a_floor_below_the_start_is_told_with_the_shift_that_raises_it(copy: Path):
    _room(copy, ROOM.faces.tolist())
    world = copy / "sim" / "world.yaml"
    edit_in(world, "mesh: room.obj", "mesh: room.obj\n  shift_m: [0, 0, -0.5]")
    (low,) = [error for error in errors(check_study(copy)) if "must have the floor at z=0" in error]
    assert "it is at z=-0.50 m" in low
    assert "`shift_m: [0, 0, 0.5]` beside `mesh` moves it" in low
    edit_in(world, "shift_m: [0, 0, -0.5]", "shift_m: [0, 0, 0]")
    assert errors(check_study(copy)) == []


@pytest.mark.release
def test_what_a_large_mesh_costs_is_told_and_decimated_if_the_study_asks(copy: Path):
    _room(copy, ROOM.faces.tolist())
    large = trimesh.load(copy / "sim" / "room.obj")
    for _ in range(7):
        large = large.subdivide()
    large.export(copy / "sim" / "room.ply")
    world = copy / "sim" / "world.yaml"
    edit_in(world, "mesh: room.obj", "mesh: room.ply")
    told = [str(one) for one in check_study(copy).findings if "triangles" in one.what]
    assert len(told) == 1
    assert "the mesh has 196,608 triangles; each 100,000 triangles add" in told[0]
    assert told[0].endswith("`decimate_to: 50000` makes fewer")
    edit_in(world, "mesh: room.ply", "mesh: room.ply\n  mesh_limits: {triangles: 100_000}")
    (error,) = errors(check_study(copy))
    assert "the mesh must have at most 100,000 triangles; `mesh_limits: {triangles: ...}` beside `mesh` allows" in error
    edit_in(world, "mesh: room.ply", "mesh: room.ply\n  decimate_to: 1000")
    assert not [one for one in check_study(copy).findings if "triangles" in one.what]
    assert errors(check_study(copy)) == []


@pytest.mark.parametrize("ending", usually(["obj"], release=["obj", "stl", "ply", "dae"]))
def test_a_hull_around_the_mine_is_the_cause_and_without_it_the_mine_can_be_flown(copy: Path, ending: str):
    _room(copy, ROOM.faces.tolist())
    room = trimesh.load(copy / "sim" / "room.obj", process=False)
    block = trimesh.creation.box((40.0, 60.0, 13.0))
    for parts, count in (((block, room), 2), ((room,), 0)):
        whole = trimesh.util.concatenate([*parts[:-1], trimesh.Trimesh(room.vertices, room.faces[:, ::-1])])
        whole.export(copy / "sim" / f"hull.{ending}")
        world = copy / "sim" / "world.yaml"
        text = world.read_text().replace("mesh: room.obj", f"mesh: hull.{ending}\n  up: z\n  scale_m: 1.0")
        world.write_text(text)
        caused = [error for error in errors(check_study(copy)) if "world.yaml" in error]
        assert len(caused) >= count
        assert all("this closed surface of 12 faces lies around the mine" in error for error in caused)
        assert bool(caused) == bool(count)


def test_the_map_shows_the_flaws_of_a_mesh_that_cannot_be_flown(copy: Path, tmp_path: Path):
    _room(copy, [*ROOM.faces.tolist(), *ROOM.faces[:, ::-1].tolist()])
    picture = tmp_path / "map.svg"
    result = invoked("map", "--study", str(copy), "--output", str(picture))
    assert result.exit_code == 2
    assert "12 of 24 faces are there twice" in result.stderr
    assert "mesh: 12 of 24 faces are there twice" in picture.read_text()


def test_a_waypoint_beyond_the_mine_is_told_how_far_the_mine_reaches(copy: Path):
    _room(copy, ROOM.faces.tolist(), unit_m=100.0)
    caused = [error for error in errors(check_study(copy)) if "must be in the open space" in error]
    assert caused
    assert all("; the mine reaches from x -0.05 to 0.05, y -0.02 to 0.18, z 0 to 0.03 m: z must" in e for e in caused)


def test_nothing_in_the_study_is_written(copy: Path):
    before = {path: path.stat().st_mtime_ns for path in [copy, *copy.rglob("*")]}
    check_study(copy)
    assert {path: path.stat().st_mtime_ns for path in [copy, *copy.rglob("*")]} == before


@pytest.mark.parametrize(("up", "told"), [("", True), ("\n  up: z", False), ("\n  up: y", False)])
def test_an_axis_that_is_up_by_guess_is_told(copy: Path, up: str, told: bool):
    _room(copy, ROOM.faces.tolist())
    world = copy / "sim" / "world.yaml"
    trimesh.load(copy / "sim" / "room.obj").export(copy / "sim" / "room.glb")
    world.write_text(world.read_text().replace("room.obj", f"room.glb{up}"))
    assert any("y of the file is up" in note for note in notes(check_study(copy))) == told


TABLE = Path(__file__).parents[1] / "support" / "defects.yaml"


@dataclass(frozen=True)
class Defect:
    """A planted defect, and the finding that it brings.

    Attributes:
        file: the file that is edited.
        old, new: a text in it, and what takes its place; without `old` the file is new.
        what, remedy: parts of the sentence and of the remedy.
        at: a text in the line that the finding names.
        severity, situation: of the finding.
    """

    file: str
    what: str
    old: str = ""
    new: str = ""
    remedy: str = ""
    at: str = ""
    severity: str = "error"
    situation: str = ""

    def plant(self, study: Path) -> None:
        path = study / self.file
        text = path.read_text() if self.old else ""
        assert self.old in text
        path.parent.mkdir(exist_ok=True)
        path.write_text(text.replace(self.old, self.new, 1) if self.old else self.new)

    def found_in(self, study: Path, finding: Finding) -> bool:
        if self.what not in finding.what or self.remedy not in finding.remedy:
            return False
        assert finding.severity == self.severity, finding
        assert finding.file == str(study / self.file), finding
        assert self.situation == finding.situation, finding
        if self.at:
            assert finding.line, finding
            assert self.at in (study / self.file).read_text().splitlines()[finding.line - 1], finding
        return True


DEFECTS = {name: Defect(**told) for name, told in yaml.safe_load(TABLE.read_text()).items()}
SEVERAL = (
    "an unknown seam",
    "an unknown key of a guideword",
    "an unknown role",
    "an unknown shape",
    "an unknown waypoint",
    "a number out of range",
    "a vehicle that is too heavy",
    "an unknown sensor",
    "an unknown kind of requirement",
    "an unknown signal",
    "a predicate over an unknown signal",
    "an axis without a name",
    "an unknown file",
)
"""Of eight files, several of some."""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """The reference study without its further grids and finds, which take most of the time."""
    return copied(tmp_path, "found.yaml", "grids")


@pytest.mark.parametrize("name", DEFECTS)
def test_a_defect_is_found_with_its_place_and_its_remedy(study: Path, name: str):
    defect = DEFECTS[name]
    defect.plant(study)
    check = check_study(study)
    found = [finding for finding in check.findings if defect.found_in(study, finding)]
    assert found, [str(finding) for finding in check.findings]
    others = [finding for finding in check.findings if finding.severity is Severity.ERROR and finding not in found]
    assert others == [], "one defect, one error"


def test_the_page_shows_what_is_found(study: Path):
    for name in ("a predicate that comes true in no flight", "a waypoint without room for the hull"):
        DEFECTS[name].plant(study)
    found = {str(finding).replace(str(study), "my_study") for finding in check_study(study).findings}
    shown = (ROOT / "docs" / "check.md").read_text().split("```")[1].strip().splitlines()
    assert len(shown) == 3
    assert set(shown) <= found


def test_several_defects_at_once_are_all_found(study: Path):
    for name in SEVERAL:
        DEFECTS[name].plant(study)
    found = check_study(study).findings
    lost = [name for name in SEVERAL if not any(DEFECTS[name].found_in(study, finding) for finding in found)]
    assert lost == [], [str(finding) for finding in found]


GRID = load_grid(Path(__file__).parents[2] / "sim")


def world_with(size: tuple[float, float, float], centre: tuple[float, float, float]) -> Any:
    """A world of one box in the open, far from the rock."""
    far = box((1.0, 1.0, 1.0)).moved((500.0, 500.0, 500.0))
    body = SimpleNamespace(name="box", mesh=box(size).moved(centre))
    return SimpleNamespace(mine=SimpleNamespace(wall=far, ground=far), present=[body])


@pytest.mark.parametrize(
    ("size", "centre", "gap_m"),
    [
        ((1.0, 1.0, 1.0), (0.9, 0.0, 1.0), 0.4),
        ((1.0, 1.0, 1.0), (0.9, 0.9, 1.0), 0.4 * 2**0.5),
        ((1.0, 1.0, 0.04), (0.8, 0.0, 1.03), 0.3),  # thinner than the hull is high
        ((1.0, 1.0, 0.1), (0.0, 0.0, 1.0), 0.0),  # all around the point
        ((1.0, 1.0, 0.2), (0.6, 0.0, 1.5), None),  # above the hull
        ((1.0, 1.0, 1.0), (2.0, 0.0, 1.0), None),  # too far away
    ],
)
def test_the_gap_of_a_place_is_level_and_counts_what_stands_at_the_height_of_the_hull(
    size: tuple[float, float, float], centre: tuple[float, float, float], gap_m: float | None
):
    found = dict(gaps(world_with(size, centre), [(0.0, 0.0, 1.0)], 0.055, 0.7))
    assert found == ({} if gap_m is None else {"box": pytest.approx(gap_m)})


def test_the_gap_of_a_leg_is_that_of_its_nearest_point():
    leg = [(-3.0, 0.0, 1.0), (3.0, 0.0, 1.0)]
    assert dict(gaps(world_with((0.2, 0.2, 1.0), (1.0, 0.4, 1.0)), leg, 0.055, 0.5)) == {"box": pytest.approx(0.3)}


def test_a_leg_that_climbs_passes_below_what_hangs_above_its_beginning():
    leg = [(-3.0, 0.0, 1.0), (3.0, 0.0, 3.0)]
    low, high = (world_with((0.2, 0.2, 0.2), (x, 0.0, 2.6)) for x in (-2.5, 1.8))
    assert dict(gaps(low, leg, 0.055, 0.5)) == {}
    assert dict(gaps(high, leg, 0.055, 0.5)) == {"box": pytest.approx(0.0)}


def test_the_wall_of_the_reference_mine_is_where_the_waypoint_near_it_says():
    world = GRID.world(GRID.situation("T0O0W1D0H0"))
    assert dict(gaps(world, [world.waypoints["corner"]], 0.055, 1.0))["wall"] == pytest.approx(0.635, abs=0.061)


def body_in(world: World, name: str, size: tuple[float, float, float], at: tuple[float, ...], yaw_deg: float) -> World:
    """The world with one more box."""
    made = Box(name, "structure", at, 0.3, True, "box", size, yaw_deg=yaw_deg)
    return replace(world, bodies={**world.bodies, name: made})


def overlaps_of(world: World, name: str) -> set[str]:
    """What a body reaches into."""
    return {other for other, _, _ in overlaps(world, world.bodies[name])}


WORLD = GRID.world(GRID.situation("T0O0W0D0H0"))


@pytest.mark.parametrize(
    ("size", "at", "yaw_deg", "into"),
    [
        ((0.4, 0.4, 1.0), (0.0, 1.0), 0.0, set()),  # on the floor
        ((0.4, 0.4, 1.0), (0.0, 1.0, 0.5), 0.0, set()),  # in the air
        ((0.4, 0.4, 1.0), (0.0, 1.0, -0.5), 0.0, {"ground"}),
        ((4.0, 0.4, 1.0), (0.0, 1.0), 0.0, {"wall"}),  # across the tunnel
        ((4.0, 0.4, 1.0), (0.0, 1.0), 90.0, set()),  # the same, turned along it
        ((0.4, 0.4, 1.0), (0.0, 1.0, 2.0), 0.0, {"wall"}),  # through the roof
    ],
)
def test_a_body_is_held_against_rock_as_it_stands_and_is_turned(
    size: tuple[float, float, float], at: tuple[float, ...], yaw_deg: float, into: set[str]
):
    assert overlaps_of(body_in(WORLD, "extra", size, at, yaw_deg), "extra") == into


@pytest.mark.parametrize(
    ("at", "yaw_deg", "touch"), [((0.45, 1.0), 0.0, False), ((0.45, 1.0), 45.0, True), ((0.0, 1.0, 1.0), 0.0, False)]
)
def test_two_bodies_overlap_unless_one_carries_the_other(at: tuple[float, ...], yaw_deg: float, touch: bool):
    world = body_in(body_in(WORLD, "a", (0.4, 0.4, 1.0), (0.0, 1.0), yaw_deg), "b", (0.4, 0.4, 1.0), at, yaw_deg=0.0)
    assert (overlaps_of(world, "a") | overlaps_of(world, "b")) == ({"a"} if touch else set())


@given(x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0))
def test_outlines_overlap_by_the_least_shift_that_parts_them(x: float, y: float):
    square = box((1.0, 1.0, 1.0)).vertices[[0, 4, 6, 2], :2]
    assert depth(square, np.add(square, (x, y))) == pytest.approx(1.0 - max(abs(x), abs(y)))


@pytest.mark.parametrize(
    ("stops", "into"),
    [([(0.0, 3.0)], set()), ([(0.0, 5.0)], {"a"}), ([(0.9, 2.0), (0.0, 1.0)], set()), ([(1.3, 2.0)], {"wall"})],
)
def test_what_a_body_sweeps_on_its_way_is_held_against_rock_and_bodies(
    stops: list[tuple[float, float]], into: set[str]
):
    world = body_in(body_in(WORLD, "a", (0.4, 0.4, 1.0), (0.3, 4.0), 45.0), "b", (0.6, 0.6, 1.0), (0.0, 1.0), 0.0)
    walk = SimpleNamespace(effect=SimpleNamespace(moved="b", path=tuple(stops)))
    assert overlaps_of(replace(world, happenings=(walk,)), "b") == into


@cases("first", "second", "at", "told")
def test_ways_of_two_bodies_that_cross_are_told_once(
    first: list[tuple[float, float]], second: list[tuple[float, float]], at: tuple[float, ...], told: bool
):
    world = body_in(body_in(WORLD, "a", (0.3, 0.3, 1.0), (0.0, 1.0), 30.0), "b", (0.3, 0.3, 1.0), at, 0.0)
    ways = (("a", first), ("b", second))
    walks = tuple(SimpleNamespace(effect=SimpleNamespace(moved=name, path=tuple(path))) for name, path in ways if path)
    world = replace(world, happenings=walks)
    assert [name for name, _ in crossed_ways(world, world.bodies["a"])] == ["b"] * told
    assert not list(crossed_ways(world, world.bodies["b"]))


@pytest.mark.parametrize("role", ["person", "obstacle", "structure"])
@pytest.mark.parametrize(("at", "into"), [((0.0, 2.0), set()), ((1.4, 2.0), {"wall"}), ((0.0, 2.0, -0.3), {"ground"})])
def test_persons_are_held_against_rock_as_any_other_body(role: str, at: tuple[float, ...], into: set[str]):
    made = Turned("extra", role, at, 0.3, True, "capsule", 0.25, 1.7)
    world = replace(WORLD, bodies={**WORLD.bodies, "extra": made})
    assert overlaps_of(world, "extra") == into
    walk = SimpleNamespace(effect=SimpleNamespace(moved="extra", path=((0.0, 3.0), (1.35, 3.0))))
    assert overlaps_of(replace(world, happenings=(walk,)), "extra") == {*into, "wall"}
