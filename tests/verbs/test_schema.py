"""`scaloft-fi schema`: the JSON Schemas of the documents of a study, and the documents that they hold for."""

from __future__ import annotations

import json
import re
from pathlib import Path, PurePath
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from printed import run
from processes import ROOT, install_project, printed
from studies import every_key_study, keys_of

from scaloft_fi.document import Item, load
from scaloft_fi.model import Schema
from scaloft_fi.verbs.schema import ANSWERS, DOCUMENTS, PUBLISHED, answer_form, declared_names, keys_table


def document_of(file: str) -> str:
    """The name of the document that a file is; "" for none."""
    fits = [name for name, one in DOCUMENTS.items() if PurePath(file).match(one.files)]
    return fits[0] if fits else ""


FILES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in ("hazop", "sim", "examples", "templates/study")
    for path in (ROOT / folder).rglob("*.yaml")
    if document_of(str(path))
)
PLUGINS = ("examples/own_stack/", "examples/testbed/")


@pytest.fixture(scope="module")
def schemas() -> dict[str, Schema]:
    return {name: one.schema(declared_names(own=True)) for name, one in DOCUMENTS.items()}


def _plain(item: Item) -> Any:
    """As `Item.plain`, infinite numbers included."""
    if isinstance(item.value, dict):
        return {key: _plain(entry) for key, entry in item.value.items()}
    return [_plain(entry) for entry in item.value] if isinstance(item.value, tuple) else item.value


def _faults(schema: Schema, path: Path) -> list[str]:
    errors = Draft202012Validator(schema).iter_errors(_plain(load(path)))
    return [f"{path}: {list(error.absolute_path)}: {error.message[:300]}" for error in errors]


def test_every_document_of_the_repository_and_the_study_with_every_key_are_valid(
    schemas: dict[str, Schema], tmp_path: Path
):
    paths = [ROOT / file for file in FILES if not file.startswith(PLUGINS)]
    paths += [path for path in every_key_study(tmp_path).rglob("*.yaml") if document_of(str(path))]
    assert len(paths) > 50
    assert [fault for path in paths for fault in _faults(schemas[document_of(str(path))], path)] == []


def test_every_key_says_what_it_is(schemas: dict[str, Schema]):
    for name, schema in schemas.items():
        Draft202012Validator.check_schema(schema)
        for pointer in keys_of(schema):
            part: Any = schema
            for step in pointer:
                part = part[step]
            assert part is False or part.get("description") or {"then", "allOf", "oneOf"} & {*pointer}, (name, pointer)


def test_a_terminal_shows_every_key_of_every_document(schemas: dict[str, Schema]):
    for name, schema in schemas.items():
        told = [str(row[0]) for row in keys_table(name, schema).rows]
        keys = {pointer[-1] for pointer in keys_of(schema) if "then" not in pointer}
        assert {re.sub(r"\[\]|\?", "", key).rpartition(".")[2] for key in told} - {"*"} == keys, name


def test_a_row_has_type_range_default_and_example(schemas: dict[str, Schema]):
    rows = keys_table("world", schemas["world"]).rows
    assert ("light", "number from 0 to 1", "brightness of visible light: 0 dark, 1 full  Such as 0.9, 0.003.") in rows
    assert (
        "mine.mesh_limits?.corners?",
        "whole number from 1 to 1e+06; left out: 1000",
        "most corners of one polygon",
    ) in rows
    assert ("name", "reference") in [row[:2] for row in keys_table("stack", schemas["stack"]).rows]


@pytest.mark.parametrize("verb", ANSWERS)
def test_a_terminal_shows_every_key_of_every_answer(verb: str):
    told = {str(row[0]).removeprefix("[].") for row in keys_table(verb, answer_form(verb).schema).rows}
    assert set(answer_form(verb).keys) <= told


def test_json_is_the_schema_and_an_unknown_verb_is_refused_with_the_nearest(capsys: pytest.CaptureFixture[str]):
    assert run("schema", "score", "--answer", "--format", "json") == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(answer_form("score").schema))
    assert run("schema", "world", "--format", "json") == 0
    assert json.loads(capsys.readouterr().out)["title"] == "sim/world.yaml"
    assert run("schema", "scorre", "--answer") == 2
    assert "no verb 'scorre' that answers in JSON; did you mean 'score'?" in capsys.readouterr().err
    assert run("schema", "--answer") == 2


VALIDATING = """
import sys
from pathlib import Path
from jsonschema import Draft202012Validator
from scaloft_fi.document import load
from scaloft_fi.registry import load_plugins
from scaloft_fi.verbs.schema import DOCUMENTS, declared_names

load_plugins()
for name, one in DOCUMENTS.items():
    for path in Path(sys.argv[1]).glob(one.files):
        instance = load(path).plain()
        assert not list(Draft202012Validator(one.schema(declared_names())).iter_errors(instance)), path
        if name in ("stack", "sensors"):
            assert list(Draft202012Validator(one.schema(declared_names(own=True))).iter_errors(instance)), path
sigma_m = DOCUMENTS["sensors"].schema(declared_names())["properties"]["altimeter"]["properties"]["sigma_m"]
assert sigma_m["type"] == "number" and sigma_m["minimum"] == 0.0, sigma_m
"""


def test_a_plugin_s_stack_sensor_and_operator_are_in_the_schemas_that_its_process_makes(tmp_path: Path):
    install_project(tmp_path / "site", ROOT / PLUGINS[0])
    printed("-c", VALIDATING, ROOT / PLUGINS[0] / "study", site=tmp_path / "site", cwd=tmp_path)


def test_the_published_schemas_are_those_of_the_code():
    published = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / PUBLISHED).iterdir()}
    # in a process of its own, because other tests declare stacks in this one
    program = (
        "import json; from scaloft_fi.verbs.schema import declared_names, schema_texts\n"
        "print(json.dumps(schema_texts(declared_names(own=True))))"
    )
    assert published == json.loads(printed("-c", program)), "run python docs/schemas/write.py"


def test_without_a_name_the_documents_are_listed(capsys: pytest.CaptureFixture[str]):
    assert run("schema") == 0
    told = capsys.readouterr().out
    assert all(one.name in told and one.files in told for one in DOCUMENTS.values())


def test_a_name_prints_its_schema(capsys: pytest.CaptureFixture[str]):
    assert run("schema", "world", "--format", "json") == 0
    assert json.loads(capsys.readouterr().out)["title"] == "sim/world.yaml"


def test_the_schema_of_the_matrix_knows_the_seams_of_the_study(capsys: pytest.CaptureFixture[str]):
    assert run("schema", "matrix", "--format", "json", "--study", ROOT) == 0
    cell = next(iter(json.loads(capsys.readouterr().out)["patternProperties"].values()))
    assert "velcmd" in cell["oneOf"][1]["properties"]["faults"]["items"]["properties"]["seam"]["enum"]


def test_a_study_whose_stack_cannot_be_read_has_schemas_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    for name in ("hazop", "mutants", "sim"):
        (tmp_path / name).mkdir()
    assert run("schema", "stack", "--format", "json", "--study", tmp_path) == 0
    told = capsys.readouterr()
    assert told.err.startswith("warning: without the names of seams: ")
    assert json.loads(told.out)["oneOf"]


def test_all_are_written_into_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert run("schema", "--write", tmp_path / "new" / "schemas") == 0
    assert {path.stem for path in (tmp_path / "new" / "schemas").iterdir()} == set(DOCUMENTS)
    assert capsys.readouterr().out == f"{tmp_path / 'new' / 'schemas'}: {len(DOCUMENTS)} schemas\n"
