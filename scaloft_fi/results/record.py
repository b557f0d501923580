"""An outcome as plain JSON values and back."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

from scaloft_fi.results.outcome import Outcome, Subject, Violation
from scaloft_fi.results.requirement import Kind, Reading


def to_json(outcome: Outcome) -> dict[str, Any]:
    """Plain JSON values."""
    return asdict(outcome) | {"track": base64.b64encode(outcome.track).decode()}


def from_json(values: Mapping[str, Any]) -> Outcome:
    """The outcome that `to_json` wrote; unknown keys are ignored."""
    known = {field.name: values[field.name] for field in fields(Outcome) if field.name in values}
    known["subject"] = Subject(**values["subject"])
    known["readings"] = tuple(Reading(**{**entry, "kind": Kind(entry["kind"])}) for entry in values["readings"])
    known["violations"] = tuple(Violation(**{**entry, "kind": Kind(entry["kind"])}) for entry in values["violations"])
    known["realised"] = tuple((str(axis), bool(came_true)) for axis, came_true in values["realised"])
    known["track"] = base64.b64decode(values.get("track", ""))
    return Outcome(**known)
