"""`scaloft-fi example`: the list of examples, the copy of one, and what each README says to do next."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import pytest
from printed import no_terms, of_form, run
from processes import ROOT

from scaloft_fi.cli import command_of
from scaloft_fi.study import Study
from scaloft_fi.verbs import VERBS
from scaloft_fi.verbs.names import example_names
from scaloft_fi.verbs.new import BLOCK, example_files

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
