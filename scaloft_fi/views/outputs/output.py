"""What a verb prints with `--format json`: an object with a schema version and named values of declared shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from scaloft_fi.console import json_text
from scaloft_fi.views.outputs.shape import Shape, listing, record, text

DIALECT = "https://json-schema.org/draft/2020-12/schema"
VERSION = "of this form: the first number changes when a key goes or changes its meaning, the second when one is added"


@dataclass(frozen=True)
class Output:
    """A form of JSON.

    Attributes:
        verb: whose answer it is.
        version: of the form: MAJOR.MINOR, as `VERSION` says.
        about: what it says, in half a sentence.
        keys: the shape of each value, by its name.
        rows: name of the list that `--format csv` prints.
    """

    verb: str
    version: str
    about: str
    keys: Mapping[str, Shape]
    rows: str

    @property
    def schema(self) -> dict[str, Any]:
        """The JSON Schema (draft 2020-12) that every answer of the verb satisfies."""
        head = {"$schema": DIALECT, "$id": f"urn:scaloft-fi:output:{self.verb}:{self.version}", "title": self.verb}
        version = {**text(VERSION), "const": self.version}
        return {**head, **record(self.about, {"version": version, **self.keys})}

    def json(self, values: Mapping[str, Any]) -> str:
        """The JSON text of `record`."""
        return json_text(self.record(values), indent=2) + "\n"

    def record(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The whole as plain JSON values, its version first.

        Args:
            values: plain JSON values by the names of `keys`.

        Raises:
            ValueError: a name is missing or not declared.
        """
        if values.keys() != self.keys.keys():
            raise ValueError(f"{self.verb}: declared {sorted(self.keys)}, given {sorted(values)}")
        return {"version": self.version, **{name: values[name] for name in self.keys}}


@dataclass(frozen=True)
class Rows(Output):
    """A form that is a bare list of rows, without a version in it: what `export` prints.

    Attributes:
        keys: the shape of each column, by its name.
        named: the beginning of the names of further columns, one for each requirement of the study, and their shape.
    """

    named: tuple[str, Shape] = ("", {})

    @property
    def schema(self) -> dict[str, Any]:
        """The JSON Schema of the list."""
        head = {"$schema": DIALECT, "$id": f"urn:scaloft-fi:output:{self.verb}:{self.version}", "title": self.verb}
        beginning, shape = self.named
        row = {**record("a flight", self.keys), "patternProperties": {f"^{beginning}": shape}}
        return {**head, **listing(self.about, row)}
