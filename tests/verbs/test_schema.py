"""`scaloft-fi schema`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scaloft_fi.cli import main
from scaloft_fi.verbs.documents.listed import DOCUMENTS

ROOT = Path(__file__).parents[2]


def run(*args: str | Path) -> int:
    with pytest.raises(SystemExit) as left:
        main([*map(str, args)])
    assert isinstance(left.value.code, int)
    return left.value.code


def test_without_a_name_the_documents_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("schema") == 0
    told = capsys.readouterr().out
    assert all(one.name in told and one.files in told for one in DOCUMENTS.values())


def test_a_name_prints_its_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("schema", "world") == 0
    assert json.loads(capsys.readouterr().out)["title"] == "sim/world.yaml"


def test_the_schema_of_the_matrix_knows_the_seams_of_the_study(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("schema", "matrix", "--study", ROOT) == 0
    cell = next(iter(json.loads(capsys.readouterr().out)["patternProperties"].values()))
    assert "velcmd" in cell["oneOf"][1]["properties"]["faults"]["items"]["properties"]["seam"]["enum"]


def test_a_study_whose_stack_cannot_be_read_has_schemas_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("hazop", "mutants", "sim"):
        (tmp_path / name).mkdir()
    assert run("schema", "stack", "--study", tmp_path) == 0
    told = capsys.readouterr()
    assert told.err.startswith("warning: without the names of seams: ")
    assert json.loads(told.out)["oneOf"]


def test_all_are_written_into_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("schema", "--write", tmp_path / "new" / "schemas") == 0
    assert {path.stem for path in (tmp_path / "new" / "schemas").iterdir()} == set(DOCUMENTS)
    assert capsys.readouterr().out == f"{tmp_path / 'new' / 'schemas'}: {len(DOCUMENTS)} schemas\n"


def test_bad_words_are_one_sentence_and_exit_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert run("schema", "wordl") == 2
    assert "no document 'wordl'; did you mean 'world'?" in capsys.readouterr().err
    assert run("schema", "--write", tmp_path / "file") == 2
    assert "cannot be written" in capsys.readouterr().err
    assert run("schema", "world", "--write", tmp_path) == 2
    assert "goes with no NAME" in capsys.readouterr().err
