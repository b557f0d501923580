from __future__ import annotations

from pathlib import Path

import pytest
from forms import of_form
from jsonschema import Draft202012Validator

from scaloft_fi.cli import VERBS
from scaloft_fi.errors import ExitCode
from scaloft_fi.reference import OUTPUTS, output_of, outputs_page, schema_texts
from scaloft_fi.views.output import Shape, inner

SCORE = Path(__file__).parents[2] / "results" / "published" / "reference" / "score.json"
PUBLISHED = Path(__file__).parents[2] / "docs" / "schemas" / "output"


def test_the_published_schemas_are_those_of_the_code() -> None:
    published = {path.name: path.read_text(encoding="utf-8") for path in PUBLISHED.iterdir()}
    assert published == schema_texts(), "run python docs/schemas/write.py"


def test_the_published_score_has_the_form_of_today() -> None:
    of_form("score", SCORE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("verb", OUTPUTS)
def test_a_schema_is_one_and_every_key_says_what_it_is(verb: str) -> None:
    output = output_of(verb)
    assert verb in VERBS
    assert output.verb == verb
    Draft202012Validator.check_schema(output.schema)
    assert output.rows in outputs_page()
    for name, shape in _shapes(verb, output.schema):
        assert inner(shape).get("description"), name
        if inner(shape).get("type") == "object":
            assert inner(shape)["additionalProperties"] is not True, name


def _shapes(name: str, shape: Shape) -> list[tuple[str, Shape]]:
    """The shapes of a schema by key, those within lists too."""
    bare = inner(shape)
    below = list(bare.get("properties", {}).items())
    found = [(f"{name}.{key}", each) for key, each in below]
    for key, each in below:
        found += _shapes(f"{name}.{key}", each)
    if "properties" in bare.get("items", {}):
        found += _shapes(f"{name}[]", bare["items"])
    return found


def test_the_page_has_every_key_and_every_exit_code() -> None:
    page = outputs_page()
    for verb in OUTPUTS:
        assert f"## `{verb} --format json`" in page
        for key in output_of(verb).keys:
            assert f"| `{key}` |" in page or f"| `[].{key}` |" in page
    for code in ExitCode:
        assert f"| {code.value} | {code.meaning} |" in page
