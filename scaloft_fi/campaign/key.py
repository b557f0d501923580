"""When a flight in the store is the flight that is asked for: a hash of everything that can change its outcome."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from scaloft_fi.campaign.plan import Flight
from scaloft_fi.study import Study


def flight_key(study: Study, flight: Flight) -> str:
    """The content hash of a flight: study data, mutant, situation, seed and the code that flies and judges it.

    An axis value that the situation does not have, another mutant, a comment in a file: none of them changes the key.
    """
    inputs = study.inputs
    content: dict[str, Any] = {
        "sim": inputs["sim"],
        "requirements": inputs["requirements"],
        "code": inputs["code"],
        "mutant": flight.mutant.to_json() if flight.mutant else None,
        "situation": [flight.situation.key, study.changes(flight.situation)],
        "seed": flight.seed,
    }
    if flight.mutant is None:
        content["realised"] = inputs["realised"]
    return digest(content)


def digest(content: Any) -> str:
    """A hash of plain JSON values that does not depend on the order of keys."""
    text = json.dumps(content, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()
