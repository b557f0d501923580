"""A known flight: a baseline of the packaged study with its published digest, to be flown again on any platform."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.store.fingerprint import differences, fingerprint
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.errors import GateError
from scaloft_fi.judge.status import Facts, facts_of
from scaloft_fi.study import PACKAGE, Study

_PUBLISHED = Path(__file__).with_suffix(".json")


@dataclass(frozen=True)
class KnownFlight:
    """A flight as it was published.

    Attributes:
        name: `MUTANT/SITUATION/SEED`.
        digest: published digest.
        facts: published facts.
        platform: fingerprint of the platform that flew it.
    """

    name: str
    digest: str
    facts: Facts
    platform: dict[str, str]


def published() -> KnownFlight:
    """The known flight, from the data file of the package."""
    entry = json.loads(_PUBLISHED.read_text(encoding="utf-8"))
    facts = Facts(entry["status"], entry["ending"], tuple(entry["violated"]))
    return KnownFlight(entry["flight"], entry["digest"], facts, entry["platform"])


def packaged_study() -> Study:
    """The study that the package ships; in a checkout, the checkout's."""
    shipped = PACKAGE / "_study"
    return Study(shipped if shipped.is_dir() else PACKAGE.parent)


def fly_again(say: Callable[[str], None], flyer: Flyer | None = None) -> str:
    """Fly the known flight and compare it with the published one; returns a sentence.

    Args:
        say: prints a line for the user.
        flyer: flies; PyBullet when None.

    Raises:
        GateError: status, ending or violations differ from the published ones.
        InputError: the study of the package cannot be flown.
    """
    known, study, flyer = published(), packaged_study(), flyer or Physics()
    mutant, situation, seed = known.name.split("/")
    flyer.prepare(study, say)
    outcome = flyer(study, flight_named(study, mutant, situation, int(seed)))
    if outcome.digest == known.digest:
        return f"{known.name} has its published digest on this platform"
    facts, changed = facts_of([outcome])[known.name], ", ".join(differences(fingerprint(), known.platform))
    where = f"it was published on another platform ({changed})" if changed else "it was published on this platform"
    told = f"{known.name} of the study in {study.folder} has the digest {outcome.digest[:12]}, not {known.digest[:12]}"
    if facts != known.facts:
        raise GateError(f"{told}, and other facts: {facts} here, {known.facts} published; {where}")
    return f"{told}, and the published status, ending and violations ({facts}); {where}"
