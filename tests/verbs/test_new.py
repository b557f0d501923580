"""`scaloft-fi new`: the study and the plugin package that it writes, and what it refuses."""

from __future__ import annotations

import json
import os
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from options import cases
from printed import no_terms, of_form, run
from processes import ROOT, called, install, install_project, printed
from studies import edit_in

from scaloft_fi.cli import command_of
from scaloft_fi.document import load
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.study import Study
from scaloft_fi.verbs import VERBS, new
from scaloft_fi.verbs.names import example_names
from scaloft_fi.verbs.new import BLOCK, example_files
from scaloft_fi.verbs.schema import DOCUMENTS

KEY = re.compile(r"^[ -]*([\w-]+):(?=\s|$)")
NAMES = {
    "NO",
    "REVERSE",
    "LATE",
    "OTHERTHAN",
    "human",
    "velcmd",
    "pose",
    "velocity",
    "cart",
    "miner",
    "SR2",
    "SR3",
    "H",
}
"""Keys that are names which the user gives; where they stand first, a comment says so."""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    assert run("new", tmp_path / "corridor") == 0
    return tmp_path / "corridor"


@pytest.fixture(scope="module")
def plugin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("work") / "rock-fall"
    assert run("new", folder, "--plugin") == 0
    return folder


@pytest.fixture(scope="module")
def site(plugin: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    install_project(folder, plugin)
    return folder


def _told(path: Path) -> tuple[set[str], set[str]]:
    """The keys of a YAML file that a comment tells of, on their line or above it; and those that none does."""
    told, keys, above = set[str](), set[str](), False
    for line in path.read_text().splitlines():
        if found := KEY.match(line):
            keys.add(found[1])
            told |= {found[1]} if "#" in line or above else set()
        above = line.lstrip().startswith("#")
    return told, keys - told - NAMES


def test_the_study_is_whole_and_its_catalogue_is_current(study: Path):
    assert run("mutants", "--check", "--study", study) == 0
    opened = Study.open(study)
    opened.check()
    cells = [cell.status for cell in opened.matrix]
    assert (len(cells), cells.count(CellStatus.CONTROL)) == (6, 1)
    assert (len(opened.grid.axes), len(opened.grid.situations), len(opened.requirements)) == (2, 6, 2)
    assert opened.stack.name == "reference"


@pytest.mark.parametrize("kind", [(), ("--plugin", "--name", "rock_fall")])
def test_each_key_of_a_study_is_told_of_in_a_comment(kind: tuple[str, ...], tmp_path: Path):
    assert run("new", tmp_path, *kind) == 0
    read: dict[str, set[str]] = {}
    for path in sorted(tmp_path.rglob("*.yaml")):
        told, untold = _told(path)
        read.setdefault(path.parent.name, set()).update(told)
        shared = read["matrix"] if path.parent.name == "matrix" else set()  # the first file tells of the cells' keys
        assert untold - shared == set(), path.name


def _schema_of(path: Path) -> Path:
    """The file of the schema that the first line of a document names."""
    named = re.fullmatch(r"# yaml-language-server: \$schema=(\S+)", path.read_text().splitlines()[0])
    assert named, path
    return (path.parent / named[1]).resolve()


def _schema_errors(path: Path, document: Any) -> list[str]:
    return [one.message for one in Draft202012Validator(json.loads(_schema_of(path).read_text())).iter_errors(document)]


def test_an_editor_finds_beside_the_study_a_schema_that_each_document_satisfies(study: Path):
    paths = sorted(study.rglob("*.yaml"))
    assert len(paths) == 10
    for path in paths:
        assert _schema_errors(path, load(path).plain()) == [], path
    cells = load(study / "hazop" / "matrix" / "human.yaml").plain()
    cells["NO"]["faults"][0]["seam"] = "persn"
    assert _schema_errors(study / "hazop" / "matrix" / "human.yaml", cells) != []


def test_the_documents_of_a_package_name_the_schemas_that_a_next_command_writes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert run("new", tmp_path / "fine", "--plugin") == 0
    *_, folder = next(line for line in capsys.readouterr().out.splitlines() if " --write " in line).split()
    named = {_schema_of(path) for path in (tmp_path / "fine").rglob("*.yaml")}
    assert named <= {Path(folder) / f"{name}.json" for name in DOCUMENTS}


@pytest.mark.parametrize("kind", [(), ("--plugin", "--name", "fine")])
def test_a_program_reads_what_was_written_and_what_to_do_next(
    kind: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert run("new", tmp_path / "made", *kind, "--format", "json") == 0
    told = of_form("new", capsys.readouterr().out)
    there = sorted(path for path in (tmp_path / "made").rglob("*") if path.is_file())
    assert told["files"] == [path.relative_to(tmp_path / "made").as_posix() for path in there]
    assert told["kind"] == ("plugin" if kind else "study")
    assert shlex.split(told["next"][-1])[:2] == ["scaloft-fi", "run"]


def test_it_prints_the_next_commands_without_a_way_where_one_stands_already(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    def commands(folder: Path | str) -> list[list[str]]:
        assert run("new", folder) == 0
        return [shlex.split(line) for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]

    way, *others = commands(tmp_path / "my mine")
    assert way == ["cd", str(tmp_path / "my mine")]
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert [words[:2] for words in commands(".")] == [words[:2] for words in others]
    assert [words[:2] for words in others] == [["scaloft-fi", "check"], ["scaloft-fi", "run"]]


def test_after_a_failure_nothing_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    whole = new.write_whole

    def fails_late(path: Path, content: bytes) -> None:
        if path.name == "world.yaml":
            raise OSError(28, os.strerror(28))
        whole(path, content)

    monkeypatch.setattr(new, "write_whole", fails_late)
    assert run("new", tmp_path / "a" / "b") == 2
    assert "No space left on device; nothing of it is left" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_package_has_the_name_of_its_folder_and_all_its_declarations_begin_with_it(plugin: Path):
    assert (plugin / "rock_fall" / "stack.py").is_file()
    texts = "".join(path.read_text() for path in plugin.rglob("*") if path.is_file())
    assert "your_plugin" not in texts
    assert set(re.findall(r'(?:operator|signal|declare)\(\s*"(\w+)"', texts)) == {
        "rock_fall_creep",
        "rock_fall_tilt_deg",
        "rock_fall_tracker",
    }


def test_two_packages_can_be_installed_together(plugin: Path, tmp_path: Path):
    assert run("new", tmp_path / "other", "--plugin") == 0
    install_project(tmp_path / "site", plugin)
    install_project(tmp_path / "site", tmp_path / "other")
    words = ("mutants", "--check", "--study", "other/study")
    printed("-m", "scaloft_fi", *words, site=tmp_path / "site", cwd=tmp_path)


@pytest.mark.release
@pytest.mark.flight
def test_the_tests_of_the_package_pass(site: Path, plugin: Path):
    printed("-m", "pytest", "-q", "-p", "no:cacheprovider", site=site, cwd=plugin)


@pytest.mark.release
@pytest.mark.flight
def test_a_run_of_its_study_is_green(site: Path, plugin: Path):
    words = ("run", "--study", "study", "--situation", "O0H0", "--quiet", "--jobs", "1", "--all")
    screen = printed("-m", "scaloft_fi", *words, site=site, cwd=plugin)
    assert re.search(r"REVERSE-velocity .*SR1", screen), screen
    assert "it holds steadily SR1 in 1" in screen


FIRMWARES = ("ardupilot", "betaflight", "lines", "px4")
OWN = ("gyro", "accelerometer", "position", "order", "motors")
"""The parameters of a firmware's seams; the cells of the other three are the reference study's."""


@pytest.fixture(scope="module", params=FIRMWARES)
def firmware(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Study:
    """The study of a firmware whose program is an empty file."""
    folder = tmp_path_factory.mktemp("mine") / request.param
    program = folder.with_name("pro gram: \u00fc")
    program.write_text("")
    assert run("new", folder, "--firmware", request.param, "--program", program) == 0
    return Study.open(folder)


def test_a_study_of_a_firmware_is_whole_and_its_catalogue_is_current(
    firmware: Study, capsys: pytest.CaptureFixture[str]
):
    assert run("check", "--study", firmware.folder, "--format", "json") == 0
    told = of_form("check", capsys.readouterr().out)
    assert [one["severity"] for one in told["findings"]] == ["note"]  # seams that the HAZOP leaves out on purpose
    assert run("mutants", "--check", "--study", firmware.folder) == 0
    settings = firmware.sim.stack.settings(firmware.stack).firmware
    assert settings.program == str(firmware.folder.with_name("pro gram: \u00fc"))
    assert all((firmware.folder / name).is_file() for name in settings.parameters)
    assert firmware.stack.version == f"{firmware.name} as built"


def test_a_study_of_a_firmware_asks_every_guideword_of_each_of_its_parameters(firmware: Study):
    cells = list(firmware.matrix)
    further = {"px4": ["barometer", "magnetometer"], "ardupilot": ["supply"]}.get(firmware.name, [])
    assert [one.id for one in firmware.matrix.parameters] == [*OWN, "imu", "pose", "velcmd", *further]
    assert len(cells) == (8 + len(further)) * 12
    assert {cell.status for cell in cells} == {CellStatus.CREDIBLE, CellStatus.CONTROL, CellStatus.NOT_MEANINGFUL}
    assert firmware.matrix.severities.keys() == {cell.name for cell in cells if cell.status is CellStatus.CREDIBLE}
    controls = {cell.name for cell in cells if cell.status is CellStatus.CONTROL}
    kept_up = ["imu"] * (firmware.name in ("betaflight", "lines"))  # the others estimate their attitude themselves
    assert controls == {f"REVERSE-{name}" for name in ("gyro", "order", "motors", *kept_up, "pose", "velcmd")}
    seams = {fault.seam for cell in cells if cell.parameter in (*OWN, *further) for fault in cell.faults}
    position = "fix" if firmware.name == "betaflight" else "position"
    assert seams == {"gyro", "accelerometer", "order", "motors", position, *further}


def test_no_two_cells_of_a_study_of_a_firmware_have_a_text_in_common_and_none_is_blank(firmware: Study):
    texts: list[str] = []
    for cell in firmware.matrix:
        blank = cell.status is CellStatus.NOT_MEANINGFUL
        texts += [cell.reason] if blank else [cell.deviation, cell.effect, *cell.causes]
    assert all(len(text) > 10 and text.endswith(".") for text in texts)
    assert len(set(texts)) == len(texts)


def test_the_vehicle_and_its_control_believe_the_layout_of_the_firmware(firmware: Study):
    assert list(firmware.sim.vehicle.spins) == [-1, -1, 1, 1]
    assert list(firmware.sim.stack.settings(firmware.stack).control.spins) == [-1, -1, 1, 1]


def test_an_editor_knows_the_seams_of_the_firmware(firmware: Study):
    for path in sorted(firmware.folder.rglob("*.yaml")):
        assert _schema_errors(path, load(path).plain()) == [], path
    cells = load(firmware.folder / "hazop" / "matrix" / "gyro.yaml").plain()
    cells["NO"]["faults"][0]["seam"] = "gyroscope"
    assert _schema_errors(firmware.folder / "hazop" / "matrix" / "gyro.yaml", cells) != []


def test_each_key_of_the_section_of_a_firmware_is_told_of_in_a_comment(firmware: Study):
    lines = (firmware.folder / "sim" / "stack.yaml").read_text().partition("\nfirmware:")[2].splitlines()
    assert len(lines) == 9
    assert all("#" in line for line in lines)


def test_a_study_of_a_firmware_says_which_fault_to_fly_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    program = tmp_path / "program"
    program.write_text("")
    words = ("new", tmp_path / "made", "--firmware", "px4", "--program", program)
    assert run(*words, "--format", "json") == 0
    told = of_form("new", capsys.readouterr().out)
    there = sorted(path for path in (tmp_path / "made").rglob("*") if path.is_file())
    assert told["files"] == [path.relative_to(tmp_path / "made").as_posix() for path in there]
    assert told["kind"] == "study"
    check, fly = told["next"][-2:]
    assert check == "scaloft-fi check"
    _, verb, *asked = shlex.split(fly)
    assert (verb, asked) == ("run", ["--situation", "T0O0W0D0*", "--mutant", "LATE-gyro"])
    assert "LATE-gyro" in Study.open(tmp_path / "made").matrix


@cases("words", "said")
def test_what_a_study_of_a_firmware_lacks_is_told_and_nothing_is_written(
    words: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    program = tmp_path / "program"
    program.write_text("")
    assert run("new", tmp_path / "study", *(word.format(file=program, folder=tmp_path) for word in words)) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "study").exists()


def test_a_changed_program_or_parameter_of_a_firmware_means_other_flights(tmp_path: Path):
    program, folder = tmp_path / "program", tmp_path / "study"
    program.write_text("one")
    assert run("new", folder, "--firmware", "px4", "--program", program) == 0
    inputs = [Study.open(folder).inputs]
    program.write_text("two")
    inputs.append(Study.open(folder).inputs)
    parameters = folder / "sim" / "firmware" / "parameters.txt"
    parameters.write_text(parameters.read_text() + "param set MPC_XY_P 1\n")
    inputs.append(Study.open(folder).inputs)
    assert len({one["sim"] for one in inputs}) == 3


STUDIES = ("own_simulator", "outside_planner")
"""The examples that are studies, which leave documents to the reference study."""
CALL = re.compile(r"scaloft-fi ([^&#\n]+)")


def test_every_folder_of_the_examples_is_one():
    assert example_names() == tuple(sorted(path.name for path in (ROOT / "examples").iterdir() if path.is_dir()))


def test_each_is_listed_with_one_sentence(capsys: pytest.CaptureFixture[str]):
    assert run("example", "--format", "json") == 0
    told = of_form("example", capsys.readouterr().out)["examples"]
    assert [one["name"] for one in told] == list(example_names())
    assert [one["about"] for one in told if not re.fullmatch(r"[^.]{20,140}\.", one["about"])] == []
    assert {one["folder"] for one in told} == {None}
    assert run("example") == 0
    listed = " ".join(capsys.readouterr().out.split())
    assert all(name in listed for name in example_names())
    assert run("example", "--format", "markdown") == 0
    assert no_terms(capsys.readouterr().out) == []


@pytest.mark.parametrize("name", example_names())
def test_a_copy_has_the_files_of_the_example_and_says_what_to_do_in_its_folder(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert run("example", name, "--format", "json") == 0
    (told,) = of_form("example", capsys.readouterr().out)["examples"]
    copy = tmp_path / name
    assert told["folder"] == name
    assert told["files"] == sorted(str(path.relative_to(copy)) for path in copy.rglob("*") if path.is_file())
    for path in (path for path in (ROOT / "examples" / name).rglob("*") if path.is_file()):
        if "__pycache__" not in path.parts:
            below = path.relative_to(ROOT / "examples" / name)
            assert (copy / below).read_bytes() == path.read_bytes()
            assert os.access(copy / below, os.X_OK) == os.access(path, os.X_OK), below
    assert told["next"][0] == f"cd {name}"
    assert len(told["next"]) > 1
    assert any(line.startswith(("scaloft-fi ", "pip ")) for line in told["next"][1:])


@pytest.mark.parametrize("name", example_names())
def test_its_readme_names_no_file_that_a_wheel_lacks_and_verbs_that_there_are(name: str):
    text = (ROOT / "examples" / name / "README.md").read_text()
    assert re.findall(r"(?:\.\./|docs/|examples/|scaloft_fi/\w+/)\S*", text) == []
    for block in BLOCK.findall(text):
        for call in CALL.findall(block):
            verb, *words = shlex.split(call)
            assert verb in VERBS
            command_of(verb).make_context(verb, words)


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_that_lacks_documents_gets_those_of_the_reference_study(name: str, tmp_path: Path):
    assert run("example", name, tmp_path / "copy") == 0
    assert run("mutants", "--check", "--study", tmp_path / "copy") == 0
    Study.open(tmp_path / "copy").check()
    files, own = example_files(name), ROOT / "examples" / name
    lent = [path for path in files if not (own / path).is_file()]
    assert "sim/world.yaml" in lent
    assert all(files[path] == (ROOT / path).read_bytes() for path in lent)
    assert not any(path.startswith("sim/grids") or path == "sim/found.yaml" for path in lent)


def test_what_is_in_the_folder_already_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "mine").write_text("mine")
    assert run("example", "own_tests", tmp_path) == 2
    assert "is not empty; only an empty or a new folder is written into" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_a_miss_is_told_the_nearest_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert run("example", "own_stck") == 2
    assert capsys.readouterr().err == "error: no example 'own_stck'; did you mean 'own_stack'?\n"
    assert list(tmp_path.iterdir()) == []


STACK = """
from dataclasses import replace

from scaloft_fi.api import declare_stack
from scaloft_fi.stack.reference.declaration import REFERENCE

def make(task, wire):
    raise LookupError("no licence")

declare_stack(replace(REFERENCE, name="dear", make=make))
"""
OPERATOR = """
from scaloft_fi.api import Example, messages, operator

@operator("break", example=Example(messages.Stamps, {}, (), ()))
def broken(context):
    '''Break.'''
    return lambda t_s, sample: sample.nothing
"""
SENSOR = """
from scaloft_fi.api import SENSORS, SensorKind, messages

class Blind:
    def __init__(self, config, flight): ...

    def measure(self, moment):
        raise LookupError("no light")

SENSORS.declare("blind", SensorKind(Blind, messages.Fix, required=True))
"""
FORMAT = """
from scaloft_fi.api import export_format

@export_format("broken", "nothing")
def broken(dossier):
    return dossier.nothing
"""
STACK_OF_BAD_OPERATORS = STACK.replace("make=make", "operators=('no_such_module',)")


def _plugins_told(tmp_path: Path, study: Path, source: str, *verbs: tuple[str, ...]) -> list[tuple[int, str]]:
    """Exit code and last line of each verb, with one module as the plugin 'odd' of package 'odd-ware'."""
    site = tmp_path / "site"
    install(site, "odd-ware", {"odd": "odd_ware"})
    (site / "odd_ware.py").write_text(source)
    done = called(site, *((*words, "--study", str(study)) for words in verbs), cwd=tmp_path)
    return [(code, said.strip().splitlines()[-1]) for code, said in done]


ODD = "error: plugin 'odd' of package 'odd-ware'"


@cases("source", "why")
def test_a_plugin_that_cannot_be_imported_is_named(source: str, why: str, tmp_path: Path, copy: Path):
    sentence = f"{ODD} cannot be loaded: {why}; mend or uninstall it"
    assert _plugins_told(tmp_path, copy, source, ("mutants", "--check")) == [(2, sentence)]


@pytest.mark.flight
@pytest.mark.parametrize(("source", "why"), [(STACK, "no licence"), (SENSOR, "no light")])
def test_a_stack_or_a_sensor_that_raises_is_named(source: str, why: str, tmp_path: Path, copy: Path):
    if source == STACK:
        edit_in(copy / "sim" / "stack.yaml", "name: reference", "name: dear")
    told = _plugins_told(tmp_path, copy, source, ("replay", "baseline/T0O0W0D0H0/0"))
    assert told == [(70, f"{ODD}: LookupError: {why} (SCALOFT_DEBUG=1 shows where)")]


def test_the_operators_of_a_stack_that_cannot_be_imported_are_named(tmp_path: Path, copy: Path):
    edit_in(copy / "sim" / "stack.yaml", "name: reference", "name: dear")
    ((code, line),) = _plugins_told(tmp_path, copy, STACK_OF_BAD_OPERATORS, ("mutants", "--check"))
    assert code == 2
    assert "stack 'dear': its operators in 'no_such_module' cannot be loaded: ModuleNotFoundError" in line


@pytest.mark.flight
@pytest.mark.release
def test_an_operator_that_raises_is_named(tmp_path: Path, copy: Path):
    cells = copy / "hazop" / "matrix" / "clock.yaml"
    cells.write_text(
        cells.read_text().replace("operator: scale\n      arguments: {field: all, factor: 0}", "operator: break")
    )
    here = ("--situation", "T0O0W0D0H0", "--baseline-seeds", "1", "--jobs", "1")
    verbs = (("mutants", "--write"), ("replay", "NO-clock/T0O0W0D0H0/0"), ("run", "--mutant", "NO-clock", *here))
    written, replayed, run = _plugins_told(tmp_path, copy, OPERATOR, *verbs)
    tapped = "tap on stamps at 0.000 s: AttributeError: 'Stamps' object has no attribute 'nothing'"
    assert written[0] == 0
    assert replayed == (70, f"{ODD}: {tapped}")
    assert run[0] == 4
    assert f"plugin 'odd' of package 'odd-ware': TapError: {tapped}" in run[1]


def test_an_export_format_that_raises_is_named(folder: Path, tmp_path: Path):
    words = ("export", "--format", "broken", "--campaign", str(folder))
    ((code, line),) = _plugins_told(tmp_path, ROOT, FORMAT, words)
    assert code == 70
    assert line.startswith(f"{ODD}: AttributeError: 'Dossier' object has no attribute 'nothing'")
