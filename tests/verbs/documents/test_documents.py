"""The JSON Schemas of YAML documents against the loaders: every key, every bound, every choice, both ways."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from asked import Asked, Located, Pointer, Question, asking, document_of, keys_of
from every_key import every_key_study
from jsonschema import Draft202012Validator
from plugins import call, install_project

from scaloft_fi.document import LARGEST, Item, load
from scaloft_fi.outside.command import load_command
from scaloft_fi.outside.records.record_map import load_record_map
from scaloft_fi.sim.grids import WITH_FOUND, grid_names
from scaloft_fi.study import Study
from scaloft_fi.verbs.documents.listed import DOCUMENTS, PUBLISHED
from scaloft_fi.verbs.documents.schema import Declared, Schema

ROOT = Path(__file__).parents[3]
FILES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in ("hazop", "sim", "examples")
    for path in (ROOT / folder).rglob("*.yaml")
    if document_of(str(path))
)
PLUGIN = "examples/own_stack/"
COMPLETED = {"examples/testbed/study/sim/stack.yaml": "sim/stack.yaml"}
"""The example's script fills `inside` with the settings of this file."""


@pytest.fixture(scope="module")
def schemas() -> dict[str, Schema]:
    declared = Declared.everything(own=True)
    return {name: one.schema(declared) for name, one in DOCUMENTS.items()}


def _plain(item: Item) -> Any:
    """As `Item.plain`, infinite numbers included."""
    if isinstance(item.value, dict):
        return {key: _plain(entry) for key, entry in item.value.items()}
    return [_plain(entry) for entry in item.value] if isinstance(item.value, tuple) else item.value


@pytest.mark.parametrize("file", [file for file in FILES if not file.startswith(PLUGIN)])
def test_every_document_of_the_repository_is_valid(file: str, schemas: dict[str, Schema]) -> None:
    instance = _plain(load(ROOT / file))
    if file in COMPLETED:
        instance["inside"] = {
            key: value for key, value in _plain(load(ROOT / COMPLETED[file])).items() if key != "name"
        }
    errors = Draft202012Validator(schemas[document_of(file)]).iter_errors(instance)
    assert [f"{list(error.absolute_path)}: {error.message[:300]}" for error in errors] == []


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> Asked:
    """What loaders ask of the reference study and of one with every key."""
    with asking() as found:
        for folder in (ROOT, every_key_study(tmp_path_factory.mktemp("every_key"))):
            study = Study.open(folder)
            _ = study.matrix, study.alpha, study.dispositions, study.requirements, study.finds
            for name in grid_names(folder / "sim"):
                if not name.endswith(WITH_FOUND):
                    _ = Study.open(folder, name).sim
            for path in sorted(folder.glob("*/sim/flyer.yaml")):
                load_command(path)
            for path in sorted(folder.glob("*/sim/record.yaml")):
                load_record_map(path)
    return found


@pytest.fixture(scope="module")
def located(asked: Asked, schemas: dict[str, Schema]) -> dict[str, Located]:
    files = {file: document_of(file) for file in asked.documents}
    return {file: Located(schemas[name], asked.documents[file]) for file, name in files.items() if name}


def _questions(asked: Asked, *hows: str) -> Iterator[Question]:
    return (one for one in sorted(asked.questions, key=str) if one.how in hows and document_of(one.file))


def _has(schema: Schema, key: str) -> bool:
    named = any(re.search(pattern, key) for pattern in schema.get("patternProperties", {}))
    return named or key in schema.get("properties", {})


def _open(schema: Schema) -> bool:
    """Whether a part of a schema leaves the form to something else."""
    return schema.keys() <= {"description", "default", "examples"}


def test_the_study_with_every_key_is_valid(asked: Asked, schemas: dict[str, Schema]) -> None:
    for file, instance in asked.documents.items():
        if name := document_of(file):
            errors = Draft202012Validator(schemas[name]).iter_errors(instance)
            assert [f"{file}: {list(error.absolute_path)}: {error.message[:300]}" for error in errors] == []


def test_every_key_that_a_loader_asks_for_is_in_the_schema(asked: Asked, located: dict[str, Located]) -> None:
    lost = []
    for one in _questions(asked, "get"):
        (key,) = one.what
        nodes = located[one.file].at(one.path, every=True)
        if not any(_has(node, key) or _open(node) for _, node in nodes):
            lost.append((document_of(one.file), one.path, key))
    assert lost == []


def test_every_key_of_a_schema_is_asked_for_by_a_loader(
    asked: Asked, located: dict[str, Located], schemas: dict[str, Schema]
) -> None:
    found: dict[str, set[Pointer]] = defaultdict(set)
    for one in _questions(asked, "get"):
        for pointer, node in located[one.file].at(one.path, every=True):
            if one.what[0] in node.get("properties", {}):
                found[document_of(one.file)].add((*pointer, "properties", one.what[0]))
    unasked = {
        name: sorted(
            {".".join(map(str, pointer)) for pointer in keys_of(schema)} - {".".join(map(str, p)) for p in found[name]}
        )
        for name, schema in schemas.items()
    }
    built = {"stack": "oneOf", "matrix": "then", "grid": "properties.adds."}
    left = {name: [p for p in lost if built.get(name, "\0") not in p] for name, lost in unasked.items()}
    assert {name: lost for name, lost in left.items() if lost} == {}


BY_ANOTHER = {
    ("world", "roughness_m", "maximum"),
    ("world", "height_m", "minimum"),
    ("sensors", "max_m", "exclusiveMinimum"),
    ("sensors", "full_cell_v", "exclusiveMinimum"),
    ("situations", "mode", "minimum"),
    ("situations", "mode", "maximum"),
    ("grid", "mode", "minimum"),
    ("grid", "mode", "maximum"),
}
"""Bounds that follow from another value, so that a schema can at most state their loosest value."""
BY_HAND = {"bins", "id", "sd", "size_m", "hull_m", "inertia_kgm2", "size_bytes"}
"""Keys whose loaders compare the number themselves, for a sentence of their own; `size_bytes` may be above 1e9."""


def test_every_bound_that_a_loader_states_is_in_the_schema(asked: Asked, located: dict[str, Located]) -> None:
    wrong = set()
    for one in _questions(asked, "number", "whole"):
        least, most, *above = one.what
        bounds = {"minimum": least, "maximum": most, "exclusiveMinimum": above[0] if above else -math.inf}
        for pointer, node in located[one.file].at(one.path):
            if node.get("type") not in ("number", "integer") or "then" in pointer:  # those of an operator are its own
                continue
            assert node["type"] == ("integer" if one.how == "whole" else "number"), one
            name = document_of(one.file)
            key = next((key for key in reversed(one.path) if isinstance(key, str)), "")
            for word, bound in bounds.items():
                told = bound if abs(bound) < LARGEST else None
                if node.get(word) != told and (name, key, word) not in BY_ANOTHER and key not in BY_HAND:
                    wrong.add((name, key, word, told, node.get(word)))
    assert sorted(wrong, key=str) == []


def test_every_choice_that_a_loader_gives_is_in_the_schema(asked: Asked, located: dict[str, Located]) -> None:
    wrong = set()
    for one in _questions(asked, "choice"):
        nodes = [node for _, node in located[one.file].at(one.path, every=True)]
        listed = {
            str(value)
            for node in nodes
            for value in (*node.get("enum", ()), *([node["const"]] if "const" in node else []))
        }
        fixed = any("const" in node for node in nodes)
        if any(map(_open, nodes)) or one.path[-1] in STUDY_NAMES:
            continue
        (allowed,) = one.what
        if not (listed <= set(allowed) if fixed else listed == set(allowed)):
            wrong.add((document_of(one.file), one.path[-1], tuple(sorted(listed ^ set(allowed)))))
    assert sorted(wrong, key=str) == []


STUDY_NAMES = {"seam", "severity"}
"""Keys whose choices are names of the study."""


def test_every_value_has_the_type_that_its_loader_asks_for(asked: Asked, located: dict[str, Located]) -> None:
    types = {"text": "string", "flag": "boolean", "items": "array", "mapping": "object"}
    wrong = set()
    for one in _questions(asked, *types):
        nodes = [node for _, node in located[one.file].at(one.path)]
        told = {node["type"] for node in nodes if isinstance(node.get("type"), str)}
        if told and types[one.how] not in told:
            wrong.add((document_of(one.file), one.path, one.how, tuple(told)))
    assert sorted(wrong, key=str) == []


def test_every_key_says_what_it_is(schemas: dict[str, Schema]) -> None:
    for name, schema in schemas.items():
        Draft202012Validator.check_schema(schema)
        for pointer in keys_of(schema):
            part: Any = schema
            for step in pointer:
                part = part[step]
            assert part.get("description") or "then" in pointer, (name, pointer)


VALIDATING = """
import json, sys
from pathlib import Path
from jsonschema import Draft202012Validator
from scaloft_fi.document import load
from scaloft_fi.registry import load_plugins
from scaloft_fi.verbs.documents.schema import Declared
from scaloft_fi.verbs.documents.listed import DOCUMENTS

load_plugins()
every, own = Declared.everything(), Declared.everything(own=True)
for name, one in DOCUMENTS.items():
    for path in Path(sys.argv[1]).glob(one.files):
        instance = load(path).plain()
        assert not list(Draft202012Validator(one.schema(every)).iter_errors(instance)), path
        if name in ("stack", "sensors"):
            assert list(Draft202012Validator(one.schema(own)).iter_errors(instance)), path
sigma_m = DOCUMENTS["sensors"].schema(every)["properties"]["altimeter"]["properties"]["sigma_m"]
assert sigma_m["type"] == "number" and sigma_m["minimum"] == 0.0, sigma_m
"""


def test_a_plugin_s_stack_sensor_and_operator_are_in_the_schemas_that_its_process_makes(tmp_path: Path) -> None:
    install_project(tmp_path / "site", ROOT / PLUGIN)
    done = call(tmp_path / "site", "-c", VALIDATING, ROOT / PLUGIN / "study", cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_the_published_schemas_are_those_of_the_code() -> None:
    published = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / PUBLISHED).iterdir()}
    # in a process of its own, because other tests declare stacks in this one
    program = (
        "import json; from scaloft_fi.verbs.documents.schema import Declared\n"
        "from scaloft_fi.verbs.documents.listed import schema_texts\n"
        "print(json.dumps(schema_texts(Declared.everything(own=True))))"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert published == json.loads(done.stdout), "run python docs/schemas/write.py"
