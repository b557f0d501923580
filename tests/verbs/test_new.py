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
    words = ("run", "--study", "study", "--situation", "O0H0", "--quiet", "--jobs", "1")
    screen = printed("-m", "scaloft_fi", *words, site=site, cwd=plugin)
    assert re.search(r"REVERSE-velocity .*SR1", screen), screen
    assert "it holds steadily SR1 in 1" in screen
