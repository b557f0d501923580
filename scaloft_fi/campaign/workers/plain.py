"""Flyers, batches and outcomes as plain JSON values, and back; what arrives is checked."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import Any

from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.store.checked import checked
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.campaign.store.record import to_row
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

Plain = Mapping[str, Any]


def flyer_to_plain(flyer: Flyer) -> Plain:
    """The name and the settings of a flyer."""
    names: list[str] = [field.name for field in fields(flyer)] if is_dataclass(flyer) else []
    settings = {name: getattr(flyer, name) for name in names}
    return {"name": f"{type(flyer).__module__}:{type(flyer).__qualname__}", "settings": settings}


def flyer_from_plain(plain: Plain) -> Flyer:
    """The flyer of a name and settings.

    Raises:
        ValueError: the name is not that of a flyer.
    """
    module, _, name = plain["name"].partition(":")
    kind = getattr(import_module(module), name, None)
    if not isinstance(kind, type) or not all(hasattr(kind, part) for part in ("prepare", "share")):
        raise ValueError(f"{plain['name']!r} is no flyer")
    flyer: Flyer = kind(**plain["settings"])
    return flyer


def batch_to_plain(batch: Batch) -> Plain:
    """The flights of a batch, each as mutant, situation and seed."""
    flights = [[flight.subject.id, flight.situation.key, flight.seed] for flight in batch.flights]
    return {"flights": flights, "shared": batch.shared}


def batch_from_plain(study: Study, plain: Plain) -> Batch:
    """The batch of the named flights of a study.

    Raises:
        InputError: a mutant or a situation is unknown.
    """
    return Batch(tuple(flight_named(study, *flight) for flight in plain["flights"]), shared=plain["shared"])


def outcome_to_plain(outcome: Outcome) -> Plain:
    """The columns of the store, and the track."""
    return {"row": list(to_row(outcome)), "track": base64.b64encode(outcome.track).decode()}


def outcome_from_plain(batch: Batch, plain: object) -> Outcome:
    """The outcome of a flight of `batch`.

    Raises:
        ValueError: a value is of another type or out of its range, or the flight is not in the batch.
    """
    if not isinstance(plain, dict) or plain.keys() != {"row", "track"} or not isinstance(plain["track"], str):
        raise ValueError("an outcome has a row and a track")
    outcome = checked(plain["row"], base64.b64decode(plain["track"], validate=True))
    flown = (outcome.subject, outcome.situation, outcome.seed)
    if flown not in [(flight.subject, flight.situation.key, flight.seed) for flight in batch.flights]:
        raise ValueError("the flight was not asked for")
    return outcome
