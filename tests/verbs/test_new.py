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
from printed import of_form, run
from processes import install_project, printed

from scaloft_fi.document import load
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.study import Study
from scaloft_fi.verbs import new
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


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("--firmware", "px5", "--program", "{file}"),
            "--firmware='px5' must be a kind of firmware; did you mean 'px4'?",
        ),
        (("--firmware", "px4"), "--firmware='px4' needs --program"),
        (("--firmware", "px4", "--program", "{file}_"), "must be the path of a file"),
        (("--firmware", "px4", "--program", "{folder}"), "must be the path of a file"),
        (("--program", "{file}"), "give --firmware with it"),
        (("--plugin", "--firmware", "px4", "--program", "{file}"), "give one of them"),
    ],
)
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
