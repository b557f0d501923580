"""The reference page of the YAML documents of a study: every key, its type, unit, range and meaning."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from scaloft_fi.views.documents.build import Schema
from scaloft_fi.views.documents.declared import Declared
from scaloft_fi.views.documents.listed import DOCUMENTS, Document
from scaloft_fi.views.tables.literal import markdown

_RULES = """\
A study is a folder of YAML documents.  `?` behind a key says that it may be left out.  `*` stands for a name that the
study chooses, `[]` for each entry of a list.  Where a mapping has one of several forms, a key with one fixed value
tells which; what only one form has stands under it.  Numbers are finite and within 1e9 of zero where nothing else is
said.

An editor with a language server for YAML, such as Visual Studio Code with the extension YAML of Red Hat, completes
these keys and shows their texts.  `scaloft-fi schema --write schemas` in the folder of the study writes the JSON
Schemas, those of installed plugins included, and the first line of a document names its own:

```yaml
# yaml-language-server: $schema=../schemas/world.json
```

Or the settings of the editor name them for all documents at once:

```json
"""


MOST_FORMS = 10
"""More names than these are counted, and listed elsewhere."""


def yaml_keys_page() -> str:
    """The page, in Markdown, made from the JSON Schemas of what the package itself declares."""
    declared = Declared.everything(own=True)
    settings = {"yaml.schemas": {f"./schemas/{one.name}.json": one.files for one in DOCUMENTS.values()}}
    parts = ["# YAML keys", "", f"{_RULES}{json.dumps(settings, indent=2)}\n```", ""]
    for one in DOCUMENTS.values():
        parts += _document(one, declared)
    return "\n".join(parts)


def _document(one: Document, declared: Declared) -> Iterator[str]:
    schema = one.schema(declared)
    yield from (f"## `{one.files}`", "", _prose(schema["description"]), "")
    yield from ("| key | value | meaning |", "|---|---|---|")
    yield from dict.fromkeys(_keys("", schema))  # forms share keys
    yield ""


def _keys(name: str, schema: Schema) -> Iterator[str]:
    """A row for each key below a value."""
    for key, each in schema.get("properties", {}).items():
        optional = "" if key in schema.get("required", ()) else "?"
        yield from _row(f"{name}.{key}{optional}" if name else f"{key}{optional}", each)
    for each in _named(schema):
        yield from _row(f"{name}.*" if name else "*", each)
    if isinstance(schema.get("items"), dict):
        yield from _keys(f"{name}[]", schema["items"])
    for word in ("oneOf", "anyOf"):
        for each in schema.get(word, ()):
            yield from _keys(name, each)


def _named(schema: Schema) -> Iterator[Schema]:
    yield from schema.get("patternProperties", {}).values()
    if isinstance(schema.get("additionalProperties"), dict):
        yield schema["additionalProperties"]


def _row(name: str, schema: Schema) -> Iterator[str]:
    about = " ".join(schema.get("description", "").replace("\n- ", "; ").split())
    examples = ", ".join(f"`{_said(one)}`" for one in schema.get("examples", ()))
    meaning = _prose(about) + (f"  Such as {examples.replace('|', chr(92) + '|')}." if examples else "")
    yield f"| `{name}` | {markdown(_value(schema))} | {meaning} |"
    yield from _keys(name, schema)


def _literal(text: str) -> str:
    """The text with its marks escaped, and the blanks at its ends."""
    stripped = text.strip()
    return text.replace(stripped, markdown(stripped)) if stripped else text


def _prose(text: str) -> str:
    """The text as Markdown shows it in a table, with what stands between backticks as code."""
    pieces = text.split("`")
    if len(pieces) % 2 == 0:
        return markdown(text)
    return "`".join(piece.replace("|", "\\|") if place % 2 else _literal(piece) for place, piece in enumerate(pieces))


def _value(schema: Schema) -> str:
    """Type, range and default of a value in words."""
    words = _kind(schema)
    if "default" in schema:
        words += f"; left out: {_said(schema['default'])}"
    return words


def _kind(schema: Schema) -> str:
    if "const" in schema:
        return _said(schema["const"])
    if "enum" in schema:
        return "one of " + ", ".join(map(_said, schema["enum"]))
    if "oneOf" in schema or "anyOf" in schema:
        forms = tuple(dict.fromkeys(map(_kind, (*schema.get("oneOf", ()), *schema.get("anyOf", ())))))
        return " or ".join(forms) if len(forms) <= MOST_FORMS else f"one of {len(forms)} names"
    kind = schema.get("type", "any value")
    if isinstance(kind, list):
        return " or ".join(map(_TYPES.__getitem__, kind))
    if kind == "array":
        return _list(schema)
    bounds = (("minimum", "from"), ("exclusiveMinimum", "above"), ("maximum", "to"))
    limits = " ".join(f"{word} {schema[key]:g}" for key, word in bounds if key in schema)
    return f"{_TYPES.get(kind, kind)} {limits}".rstrip()


_TYPES = {
    "string": "text",
    "number": "number",
    "integer": "whole number",
    "boolean": "true or false",
    "object": "mapping",
}


def _list(schema: Schema) -> str:
    least, most = schema.get("minItems"), schema.get("maxItems")
    size = f"{least} " if least == most and least else ""
    each = _kind(schema["items"]) if isinstance(schema.get("items"), dict) else "values"
    return f"list of {size}{each}" if size or least is None else f"list of {least} or more: {each}"


def _said(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return (
        json.dumps(value)
        if isinstance(value, list | dict)
        else f"{value:g}"
        if isinstance(value, float)
        else str(value)
    )
